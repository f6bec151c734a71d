//! Variables of the machine: order and time of assignments, and absent values.

use runtime::{Controller, FaultKind};

use super::host::Host;

/// Returns the value of a signal or variable; `None` if it is absent.
fn value(controller: &mut Controller, name: &str) -> Option<Vec<f64>> {
    let signals = controller.signals();
    let index = signals.interface().signal(name).expect("it is declared");
    signals.is_present(index).then(|| signals.value(index).to_vec())
}

#[test]
fn attempts_are_counted_and_triggers_see_them_at_the_next_tick() {
    let mut host = Host::new(
        "variable attempts : number = 0
         machine m { initial go  stack still  on fault(any) -> stopped
           state go { enter set(attempts, attempts + 1)  when attempts >= 3 -> stopped  after 30 ms -> go }
           final state stopped }",
    );
    let mut seen = Vec::new();
    for _ in 0..9 {
        let state = host.step().state;
        seen.push((state, value(&mut host.controller, "attempts").expect("never absent")[0]));
    }
    let counts: Vec<f64> = seen.iter().map(|s| s.1).collect();
    assert_eq!(counts, [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0]);
    let states: Vec<&str> = seen.iter().map(|s| s.0.as_str()).collect();
    assert_eq!(states, ["go", "go", "go", "go", "go", "go", "go", "stopped", "stopped"]);
    host.controller.restart();
    host.step();
    assert_eq!(value(&mut host.controller, "attempts"), Some(vec![1.0]), "a controller that starts again counts anew");
}

#[test]
fn sets_are_done_in_the_order_written_and_see_each_other() {
    let mut host = Host::new(
        "variable a : number = 1
         variable b : number = 10
         variable spent : duration = 0 s
         machine m { initial one  stack still  on fault(any) -> two
           state one { enter set(a, a + b)  enter set(b, a)  exit set(spent, t)  when a + b > 20 for 50 ms -> two }
           final state two { enter set(a, 0)  enter set(b, b + a) } }",
    );
    host.step();
    let both = |host: &mut Host| ["a", "b"].map(|v| value(&mut host.controller, v).expect("never absent")[0]);
    assert_eq!(both(&mut host), [11.0, 11.0]);
    assert_eq!(host.steps(6), "two");
    assert_eq!(both(&mut host), [0.0, 11.0]);
    let spent = value(&mut host.controller, "spent").expect("never absent")[0];
    assert!((spent - 0.06).abs() < 1e-9, "the time in the state that is left: {spent}");
}

/// The stack that is entered at the tick of the action uses the new value.
#[test]
fn stacks_see_a_value_at_the_tick_at_which_it_is_set() {
    let mut host = Host::new(
        "variable goal : point?
         task reach = frame_position(tool) { position goal  gain 2 /s }
         stack go from still { add motion { reach } }
         machine m { initial wait  blend 0.1 s  on fault(any) -> stopped
           state wait { stack still  after 20 ms -> move }
           state move { stack go  enter set(goal, frame(tool).position + [0, 0.1, 0] m)  after 10 s -> stopped }
           final state stopped }",
    );
    assert_eq!(host.steps(2), "wait");
    assert_eq!(value(&mut host.controller, "goal"), None);
    let there = host.step();
    assert_eq!((there.state.as_str(), there.fault), ("move", None));
    let evaluator = host.controller.evaluator();
    let member = evaluator.members().iter().find(|m| m.name == "reach").expect("it runs");
    let error = evaluator.measures()[member.measures.clone()].iter().map(|e| e * e).sum::<f64>().sqrt();
    assert!((error - 0.1).abs() < 1e-9, "{error}");
    let first = value(&mut host.controller, "goal");
    host.steps(200);
    assert_eq!(value(&mut host.controller, "goal"), first, "it was worked out once");
}

#[test]
fn what_has_no_value_is_absent_or_a_fault() {
    let text = |mark: &str| {
        format!(
            "signal x : number?  timeout 1 s
             variable kept : number{mark} = 7
             machine m {{ initial a  stack still  on fault(stale(x)) -> lost  on fault(value) -> bad  on fault(any) -> b
               state a {{ after 20 ms -> b }}
               state b {{ enter set(kept, 1/x)  after 10 s -> a }}
               state lost {{ after 20 ms -> a }}
               final state bad }}"
        )
    };
    let mut sure = Host::new(&text(""));
    assert_eq!(sure.steps(2), "a");
    let seen = sure.step();
    assert_eq!((seen.state.as_str(), seen.fault), ("b", Some(FaultKind::Stale)));
    assert_eq!(value(&mut sure.controller, "kept"), Some(vec![7.0]));
    assert_eq!(sure.step().state, "lost");
    sure.set("x", &[0.0]);
    assert_eq!(sure.steps(2), "a");
    sure.set("x", &[0.0]);
    let seen: Vec<_> = (0..3).map(|_| sure.step()).collect();
    assert!(seen.iter().any(|s| s.fault == Some(FaultKind::Value)), "1/0 is no value: {seen:?}");
    assert_eq!(sure.controller.state(), "bad");
    assert_eq!(value(&mut sure.controller, "kept"), Some(vec![7.0]));

    let mut may = Host::new(&text("?"));
    assert_eq!(may.steps(2), "a");
    assert_eq!(value(&mut may.controller, "kept"), Some(vec![7.0]));
    let seen = may.step();
    assert_eq!((seen.state.as_str(), seen.fault), ("b", None));
    assert_eq!(value(&mut may.controller, "kept"), None);
}

#[test]
fn the_host_reads_variables_and_cannot_set_them() {
    let mut host = Host::new(
        "variable on_time : flag = false
         variable turn : orientation = rpy(0, 0, 90 deg)
         machine m { initial a  stack still  on fault(any) -> b
           state a { enter set(on_time, not on_time)  enter set(turn, frame(tool).orientation)  when on_time -> b }
           final state b }",
    );
    let signals = host.controller.signals();
    assert!(signals.is_present(0) && signals.is_present(1));
    assert!(!signals.set(0, &[1.0], 0.0));
    signals.clear(0);
    assert_eq!(host.step().state, "a");
    assert_eq!(value(&mut host.controller, "on_time"), Some(vec![1.0]));
    let model = host.controller.evaluator().model().clone();
    let mut data = robot::Data::new(&model);
    model.forward(host.controller.reference(), &mut data);
    let q = data.pose(model.link("tool").expect("a link")).rotation;
    let held = value(&mut host.controller, "turn").expect("never absent");
    let same = held.iter().zip([q.w, q.i, q.j, q.k]).map(|(a, b)| a * b).sum::<f64>();
    assert!((same.abs() - 1.0).abs() < 1e-9);
    assert_eq!(host.step().state, "b");
}

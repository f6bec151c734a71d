//! Semantics of machines, one rule per test.

use runtime::FaultKind;

use super::host::{Host, Seen};

fn seen(state: &str, asked: &[&str]) -> Seen {
    Seen { state: state.to_string(), asked: asked.iter().map(|a| (*a).to_string()).collect(), fault: None }
}

#[test]
fn one_transition_a_tick_in_declared_order() {
    let mut host = Host::new(
        "signal go : event
         signal stop : event
         machine m {
           initial a  stack still
           on fault(any) -> end
           state a { on go -> b  on stop -> end }
           state b { on go -> c  on stop -> end }
           state c { on stop -> end  on go -> a }
           final state end
         }",
    );
    assert_eq!(host.step().state, "a");
    host.raise("go");
    // The event is processed once, and causes one transition.
    assert_eq!(host.step().state, "b");
    assert_eq!(host.step().state, "b");
    host.raise("stop");
    host.raise("go");
    assert_eq!(host.step().state, "c", "the first in the text counts");
    host.raise("stop");
    host.raise("go");
    assert_eq!(host.step().state, "end");
    assert!(host.controller.is_final());
}

#[test]
fn a_final_state_is_left_only_for_another_one() {
    let mut host = Host::new(
        "signal go : event
         signal halt : event
         machine m {
           initial a  stack still
           on go -> a
           on halt -> stopped
           on fault(stale) -> a
           on fault(any) -> stopped
           when t > 20 ms -> b
           state a { after 30 ms -> done }
           state b { after 10 ms -> done }
           final state done { initial first
             state first { on go -> second }
             state second {} }
           final state stopped
         }",
    );
    host.step();
    assert_eq!(host.steps(5), "done.first");
    assert!(host.controller.is_final());
    host.raise("go");
    assert_eq!(host.step().state, "done.second", "states inside a final state may change");
    host.raise("go");
    // The condition holds and the event arrives, but `a` and `b` are not final.
    assert_eq!(host.steps(3), "done.second");
    host.raise("halt");
    assert_eq!(host.step().state, "stopped");
    host.raise("go");
    assert_eq!(host.steps(3), "stopped");
    assert!(host.controller.is_final());
}

#[test]
fn a_fault_in_a_final_state_leads_only_to_another_one() {
    let mut host = Host::new(
        "machine m {
           initial done  stack still
           on fault(not_finite) -> again
           state again { after 10 ms -> done }
           final state done
         }",
    );
    assert_eq!(host.step().state, "done");
    let q = host.robot.measure().to_vec();
    let seen = host.step_at(f64::NAN, &q);
    assert_eq!((seen.state.as_str(), seen.fault), ("done", Some(FaultKind::NotFinite)));
    assert!(host.controller.is_halted(), "no transition answers the fault");
}

#[test]
fn an_event_that_nobody_waits_for_is_gone() {
    let mut host = Host::new(
        "signal go : event
         machine m { initial a  stack still  on fault(any) -> end
           state a { after 30 ms -> b }
           state b { on go -> end  after 1 s -> end }
           final state end }",
    );
    host.step();
    host.raise("go");
    assert_eq!(host.step().state, "a");
    assert_eq!(host.steps(3), "b");
}

#[test]
fn leaving_goes_outwards_and_entering_inwards() {
    let mut host = Host::new(
        "signal go : event
         machine m {
           initial a  stack still
           on fault(any) -> end
           state a {
             initial b  enter log \"a in\"  exit log \"a out\"
             on go -> d.e
             state b { initial c  enter log \"b in\"  exit log \"b out\"
               state c { enter log \"c in\"  do capture(camera)  exit log \"c out\" } }
           }
           state d { initial f  enter log \"d in\"  exit log \"d out\"
             on go -> e
             state e { enter log \"e in\"  exit log \"e out\" }
             state f { enter log \"f in\" } }
           final state end
         }",
    );
    assert_eq!(host.step(), seen("a.b.c", &["+log a in", "+log b in", "+log c in", "+capture camera"]));
    host.raise("go");
    let down = ["-capture camera", "+log c out", "+log b out", "+log a out", "+log d in", "+log e in"];
    assert_eq!(host.step(), seen("d.e", &down));
    // A state that contains source and target is not left; the target is entered again.
    host.raise("go");
    assert_eq!(host.step(), seen("d.e", &["+log e out", "+log e in"]));
}

#[test]
fn a_condition_has_to_hold_without_a_break() {
    let mut host = Host::new(
        "signal push : number
         machine m { initial a  stack still  on fault(any) -> end
           state a { when push > 2 for 50 ms -> end }
           final state end }",
    );
    // Without a value the condition is false.
    assert_eq!(host.steps(10), "a");
    host.set("push", &[3.0]);
    assert_eq!(host.steps(5), "a");
    host.set("push", &[1.0]);
    assert_eq!(host.step().state, "a");
    host.set("push", &[3.0]);
    assert_eq!(host.steps(5), "a");
    assert_eq!(host.step().state, "end", "it has held for 50 ms");
}

#[test]
fn an_event_of_the_machine_itself_comes_a_tick_later() {
    let mut host = Host::new(
        "machine m { initial a  stack still  on fault(any) -> end
           state a { enter emit tick  on tick -> b }
           state b { enter emit tock  on tick -> a  on tock -> end }
           final state end }",
    );
    assert_eq!(host.step().state, "a");
    assert_eq!(host.step().state, "b");
    assert_eq!(host.step().state, "end");
}

#[test]
fn the_time_of_a_state_begins_when_it_is_entered() {
    let mut host = Host::new(
        "machine m { initial a  stack still  on fault(any) -> end
           state a { after 100 ms -> b }
           state b { initial c  when t > 75 ms -> end
             state c { after 50 ms -> d }
             state d { when t > 75 ms -> c } }
           final state end }",
    );
    assert_eq!(host.steps(10), "a");
    assert_eq!(host.step().state, "b.c");
    assert_eq!(host.steps(5), "b.d", "100 ms and 50 ms later");
    // The condition of `b` counts from the entry of `b`, not from that of `d`.
    assert_eq!(host.steps(3), "end");
}

#[test]
fn reached_waits_for_a_target_that_stands() {
    let mut host = Host::new(
        "task reach = frame_position(tool) {
           position initial(position) + [0, 0.1, 0] m * smoothstep(t/(1 s))  gain 20 /s }
         stack move from still { add motion { reach } }
         machine m { initial a  on fault(any) -> end
           state a { stack move  on reached(reach, 1 mm) -> end }
           final state end { stack still } }",
    );
    // The tool is at its target from the first tick on, but the target is at rest only from 1 s on.
    assert_eq!(host.steps(100), "a");
    assert_eq!(host.steps(3), "end");
}

#[test]
fn substates_without_a_stack_go_on_with_that_around_them() {
    let mut host = Host::new(
        "signal go : event
         task wave = joint_position { target { joint_1 0.2 rad * sin(2*pi*t/(2 s)) }  gain 20 /s }
         stack move from still { add motion { wave } }
         machine m { initial a  on fault(any) -> end
           state a { stack move  initial b
             state b { on go -> c }
             state c { on go -> end } }
           final state end { stack still } }",
    );
    host.steps(60);
    let before = host.controller.velocity()[0];
    host.raise("go");
    assert_eq!(host.step().state, "a.c");
    // A wave that started again would have its maximum speed.
    assert!((host.controller.velocity()[0] - before).abs() < 0.05, "{before}");
}

#[test]
fn a_state_without_any_stack_stands() {
    let mut host = Host::new(
        "task turn = joint_velocity { velocity { joint_1 0.3 rad/s } }
         stack move from still { add motion { turn } }
         machine m { initial a  on fault(any) -> end
           state a { stack move  after 100 ms -> end }
           final state end }",
    );
    host.steps(5);
    assert!((host.controller.velocity()[0] - 0.3).abs() < 1e-9);
    assert_eq!(host.steps(6), "end");
    assert!(host.controller.velocity().iter().all(|v| *v == 0.0));
}

#[test]
fn a_value_that_is_too_old_is_absent() {
    let mut host = Host::new(
        "signal goal : point?  timeout 50 ms
         task reach = frame_position(tool) { position goal  gain 2 /s }
         stack go from still { add motion { reach } }
         machine m { initial wait
           on fault(stale(goal)) -> wait
           on fault(any) -> end
           state wait { stack still  when present(goal) -> move  after 10 s -> end }
           state move { stack go  after 10 s -> end }
           final state end }",
    );
    assert_eq!(host.steps(3), "wait");
    host.set("goal", &[0.4, 0.1, 0.5]);
    assert_eq!(host.steps(1), "move");
    for _ in 0..20 {
        host.set("goal", &[0.4, 0.1, 0.5]);
        assert_eq!(host.step(), seen("move", &[]));
    }
    // The last value arrived 10 ms before this tick.
    assert_eq!(host.steps(4), "move");
    let late = host.step();
    assert_eq!((late.fault, late.state.as_str()), (Some(FaultKind::Stale), "move"));
    assert_eq!(host.step().state, "wait");
    host.set("goal", &[f64::NAN, 0.0, 0.0]);
    assert_eq!(host.step().state, "wait", "what is no number is no value");
}

#[test]
fn quaternions_are_normalised_or_refused() {
    let mut host = Host::new(
        "signal turn : orientation
         machine m { initial a  stack still  on fault(any) -> end
           state a { when present(turn) -> end  after 10 s -> end }
           final state end }",
    );
    host.set("turn", &[0.5, 0.5, 0.5, 0.6]);
    assert_eq!(host.step().state, "a");
    host.set("turn", &[1.0005, 0.0, 0.0, 0.0]);
    assert_eq!(host.step().state, "end");
    assert_eq!(host.controller.signals().value(0), [1.0, 0.0, 0.0, 0.0]);
}

//! Faults of every kind at random ticks: the command stays finite and within limits, and the machine takes the
//! specified transition.

use proptest::prelude::*;
use runtime::FaultKind;

use super::host::Host;

const MACHINE: &str = "
signal goal : point  timeout 100 ms
param climb = 1 m/s
task reach = frame_position(tool) { position goal  gain 2 /s }
task slow = joint_velocity_limits { max 0.02 rad/s }
task rising = keep(dot(frame(tool).position, [0, 0, 1])) { min 0.2 m + climb * max(t - 0.5 s, 0 s)  gain 10 /s }
stack go from still { add motion { reach } }
stack rise from still { add fence hard { slow  rising } }
machine m {
  initial go
  blend 0.2 s
  on fault(stale(goal)) -> waiting
  on fault(infeasible(fence)) -> low
  on fault(deadline) -> late
  on fault(not_finite) -> blind
  on fault(jump) -> lost
  on fault(any) -> stopped
  state go { stack go  on climb_now -> rise }
  state rise { stack rise }
  final state waiting { stack still }
  final state low { stack still }
  final state late { stack still }
  final state blind
  final state lost { stack still }
  final state stopped
}
signal climb_now : event
";

/// A disturbance.
#[derive(Clone, Copy, Debug)]
enum Bad {
    Position(usize, f64),
    Time,
    Late(f64),
    Back,
    Silence,
    Wall,
    Kick(usize),
    Nothing,
}

fn bad() -> impl Strategy<Value = Bad> {
    prop_oneof![
        (0..7_usize, prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]))
            .prop_map(|(i, x)| Bad::Position(i, x)),
        Just(Bad::Time),
        (0.021..3.0_f64).prop_map(Bad::Late),
        Just(Bad::Back),
        Just(Bad::Silence),
        Just(Bad::Wall),
        (0..7_usize).prop_map(Bad::Kick),
        Just(Bad::Nothing),
    ]
}

fn ends(bad: Bad) -> (&'static str, Option<FaultKind>) {
    match bad {
        Bad::Position(..) | Bad::Time => ("blind", Some(FaultKind::NotFinite)),
        Bad::Late(_) | Bad::Back => ("late", Some(FaultKind::Deadline)),
        Bad::Silence => ("waiting", Some(FaultKind::Stale)),
        Bad::Wall => ("low", Some(FaultKind::Infeasible)),
        Bad::Kick(_) => ("lost", Some(FaultKind::Jump)),
        Bad::Nothing => ("go", None),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, ..ProptestConfig::default() })]

    #[test]
    fn every_fault_ends_where_the_machine_says(bad in bad(), tick in 1..150_usize) {
        let mut host = Host::new(MACHINE);
        let limits: Vec<f64> = host.controller.evaluator().model().dofs.iter().map(|d| d.velocity).collect();
        let (wanted, kind) = ends(bad);
        let mut faults = Vec::new();
        let mut offset = 0.0;
        let mut state = String::new();
        for k in 0..tick + 120 {
            let silent = matches!(bad, Bad::Silence) && k >= tick;
            if !silent {
                host.set("goal", &[0.4, 0.1, 0.5]);
            }
            let mut q = host.robot.measure().to_vec();
            let mut time = host.time() + offset;
            if k == tick {
                match bad {
                    Bad::Position(i, x) => q[i] = x,
                    Bad::Time => time = f64::NAN,
                    Bad::Late(by) => { offset = by; time += by }
                    Bad::Back => { offset = -0.015; time += offset }
                    Bad::Wall => host.raise("climb_now"),
                    Bad::Kick(i) => q[i] += 0.8,
                    Bad::Silence | Bad::Nothing => {}
                }
            }
            // A signal has the time of the host's clock.
            if offset != 0.0 {
                let index = host.controller.signals().interface().signal("goal").expect("a signal");
                host.controller.signals().set(index, &[0.4, 0.1, 0.5], time);
            }
            let seen = host.step_at(time, &q);
            faults.extend(seen.fault);
            let within = host.controller.velocity().iter().zip(&limits).all(|(v, l)| v.abs() <= l + 1e-9);
            prop_assert!(within, "tick {k}");
            state = seen.state;
        }
        prop_assert_eq!(&state, wanted, "{:?} at tick {}", bad, tick);
        prop_assert_eq!(faults.first().copied(), kind);
        // A reading that jumps there is not believed, so that it does not jump back.
        prop_assert_eq!(faults.len(), usize::from(kind.is_some()), "{:?}", faults);
    }
}

#[test]
fn a_machine_that_answers_nothing_stands_for_good() {
    let mut host = Host::new("machine m { initial a  state a { stack still  after 10 s -> b }  final state b }");
    host.steps(3);
    let mut q = host.robot.measure().to_vec();
    q[3] = f64::NAN;
    let seen = host.step_at(host.time(), &q);
    assert_eq!(seen.fault, Some(FaultKind::NotFinite));
    assert!(host.controller.is_halted());
    assert_eq!(host.steps(5), "a");
    assert!(host.controller.velocity().iter().all(|v| *v == 0.0));
}

#[test]
fn a_limit_that_is_passed_is_a_fault_where_a_transition_asks() {
    // The wall approaches faster than the robot can retreat on a soft level.
    let text = |answer: &str| {
        format!(
            "task wall = keep(dot(frame(tool).position, [0, 0, 1])) {{ min 0.2 m + 1 m/s * max(t - 0.3 s, 0 s)  gain 10 /s }}
             task slow = joint_velocity_limits {{ max 0.02 rad/s }}
             stack push {{ level limits hard {{ joint_position_limits  slow }}  level wall {{ wall }} }}
             machine m {{ initial a  on fault(any) -> b  {answer}
               state a {{ stack push  after 3 s -> b }}
               state touched {{ stack still  after 10 s -> b }}
               final state b }}"
        )
    };
    let mut host = Host::new(&text("on fault(limit(wall)) -> touched").replace(
        "on fault(any) -> b  on fault(limit(wall)) -> touched",
        "on fault(limit(wall)) -> touched  on fault(any) -> b",
    ));
    let seen: Vec<_> = (0..250).map(|_| host.step()).collect();
    assert_eq!(seen.iter().filter(|s| s.fault == Some(FaultKind::Limit)).count(), 1);
    assert_eq!(seen.last().expect("ticks").state, "touched");
    let mut host = Host::new(&text(""));
    assert_eq!(host.steps(250), "a", "nobody asks");
}

/// A machine whose fault leads to the state in which the robot works, as its own transition, that of a state around it, or that
/// of the machine.
fn into_itself(place: &str) -> String {
    let way = |at: &str| if at == place { "on fault(any) -> " } else { "" };
    let [machine, around, own] = ["machine", "around", "own"].map(|at| match way(at) {
        "" => String::new(),
        way => format!("{way}{}", if at == "machine" || at == "around" { "work.reach" } else { "reach" }),
    });
    format!(
        "signal resume : event
         signal next : event
         task reach = frame_position(tool) {{ position [0.5, 0.2, 0.4] m  gain 1 /s }}
         stack go from still {{ add motion {{ reach }} }}
         machine m {{ initial work  blend 0.5 s  {machine}
           state work {{ stack go  initial reach  {around}
             state reach {{ {own}  on resume -> reach  on next -> wait  after 20 s -> wait }}
             state wait {{ after 20 s -> end }} }}
           final state end }}"
    )
}

#[test]
fn a_fault_that_leads_into_its_own_state_leaves_the_robot_standing() {
    for place in ["own", "around", "machine"] {
        for mut host in super::host::in_both_syntaxes(&into_itself(place)) {
            let speed = |host: &Host| host.controller.velocity().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            host.steps(30);
            let before = speed(&host);
            assert!(before > 0.05, "{before}");
            let mut q = host.robot.measure().to_vec();
            q[2] = f64::NAN;
            let seen = host.step_at(host.time(), &q);
            assert_eq!(seen.fault, Some(FaultKind::NotFinite), "{place}");
            for _ in 0..300 {
                let seen = host.step();
                assert_eq!((seen.state.as_str(), seen.fault), ("work.reach", Some(FaultKind::NotFinite)), "{place}");
                assert_eq!(speed(&host), 0.0);
            }
            assert!(host.controller.stands() && !host.controller.is_halted());
            // An event leaves the state, and the blend begins at rest: x = 1/50 at its first tick.
            for event in ["resume", "next"] {
                host.raise(event);
                let seen = host.step();
                assert_eq!(seen.fault, None, "{place} {event}");
                assert!(!host.controller.stands());
                let first = speed(&host);
                host.steps(60);
                let later = speed(&host);
                assert!(later > 0.02 && first < 0.01 * later, "{place} {event}: {first} then {later}");
                // The same again, so that `next` also finds a robot that stands.
                let mut q = host.robot.measure().to_vec();
                q[0] = f64::INFINITY;
                host.step_at(host.time(), &q);
                host.steps(10);
                if event == "resume" {
                    assert_eq!((speed(&host), host.controller.stands()), (0.0, true));
                }
            }
        }
    }
}

/// A second fault, of another kind, does not end the standstill; a more specific transition does.
#[test]
fn a_robot_that_stands_answers_other_faults_as_the_machine_says() {
    let text =
        into_itself("own").replace("on fault(any) -> reach", "on fault(deadline) -> wait  on fault(any) -> reach");
    let mut host = Host::new(&text);
    host.steps(30);
    let mut q = host.robot.measure().to_vec();
    q[2] = f64::NAN;
    host.step_at(host.time(), &q);
    host.step_at(host.time(), &q);
    assert!(host.controller.stands());
    let q = host.robot.measure().to_vec();
    let seen = host.step_at(host.time() + 1.0, &q);
    assert_eq!((seen.fault, seen.state.as_str()), (Some(FaultKind::Deadline), "work.wait"));
    assert!(!host.controller.stands());
}

/// An observation of a robot that stands.
fn disturbed(bad: Bad, time: &mut f64, q: &mut [f64]) {
    match bad {
        Bad::Position(i, x) => q[i] = x,
        Bad::Time => *time = f64::NAN,
        Bad::Late(by) => *time += by,
        Bad::Back => *time -= 0.015,
        Bad::Kick(i) => q[i] += 0.8,
        Bad::Silence | Bad::Wall | Bad::Nothing => {}
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// No observation moves a robot that stands after a fault; it leaves its state by the event alone, and from rest.
    #[test]
    fn nothing_moves_a_robot_that_stands(bads in prop::collection::vec(bad(), 1..40)) {
        // Late ticks add up to more than 20 s, after which the time would lead out of the state, as it should.
        let text = into_itself("own").replace("on next -> wait  after 20 s -> wait", "on next -> wait");
        prop_assert!(!text.contains("after 20 s -> wait"));
        let mut host = Host::new(&text);
        host.steps(30);
        let mut q = host.robot.measure().to_vec();
        q[2] = f64::NAN;
        host.step_at(host.time(), &q);
        let mut clock = host.time();
        for (k, &bad) in bads.iter().enumerate() {
            clock += 0.01;
            let (mut time, mut q) = (clock, host.robot.measure().to_vec());
            disturbed(bad, &mut time, &mut q);
            let seen = host.step_at(time, &q);
            prop_assert_eq!(&seen.state, "work.reach", "{}: {:?}", k, bad);
            prop_assert!(seen.fault.is_some());
            prop_assert!(host.controller.stands() && host.controller.velocity().iter().all(|v| *v == 0.0));
            if time.is_finite() {
                clock = time;
            }
        }
        // Two good observations after the last disturbance.
        for _ in 0..2 {
            clock += 0.01;
            let q = host.robot.measure().to_vec();
            host.step_at(clock, &q);
        }
        host.raise("resume");
        clock += 0.01;
        let q = host.robot.measure().to_vec();
        let seen = host.step_at(clock, &q);
        prop_assert_eq!(seen.fault, None);
        let first = host.controller.velocity().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        prop_assert!(first < 1e-3, "{}", first);
    }
}

/// Without a stack nothing could resume: the fault is answered by the state.
#[test]
fn a_fault_in_a_state_without_a_stack_changes_nothing() {
    let mut host = Host::new(
        "signal go : event
         machine m { initial a  on fault(any) -> a  state a { on go -> b }  state b { stack still  on go -> end }  final state end }",
    );
    host.steps(3);
    let mut q = host.robot.measure().to_vec();
    q[2] = f64::NAN;
    assert_eq!(host.step_at(host.time(), &q).fault, Some(FaultKind::NotFinite));
    assert_eq!(host.step().fault, None);
    host.raise("go");
    assert_eq!(host.step().state, "b");
}

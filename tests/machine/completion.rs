//! Completion by several criteria: `reached` with tolerances and speeds, alone and in conditions, and `settled`.

use proptest::prelude::*;

use super::common::{example, program_of};
use super::host::{ARM, Host, in_both_syntaxes};

/// An arm with tasks that have parameters.
const TASKS: &str = "
robot with from arm { arms { only { tip tool } } }
task go(side: arm, away: vector, gain: rate = 3 /s) = frame_position(side) { position initial(position) + away  gain gain }
task rest = joint_velocity { velocity 0 rad/s }
stack moving(away: vector, gain: rate) from still { add motion { go(only, away, gain) } }
stack resting from still { add motion { rest } }
";

/// State after each tick, with the error (m) and the speed (m/s) of the tool at the tick.
struct Ticks {
    states: Vec<String>,
    errors: Vec<f64>,
    speeds: Vec<f64>,
}

/// Runs a machine whose first state moves the tool by `away`. The error and the speed of the tool are computed from the
/// kinematics of the reference, without the rows of the task.
fn run(host: &mut Host, away: [f64; 3], ticks: usize) -> Ticks {
    let mut out = Ticks { states: Vec::new(), errors: Vec::new(), speeds: Vec::new() };
    let model = host.controller.evaluator().model().clone();
    let (tool, mut data) = (model.link("tool").expect("the tool"), robot::Data::new(&model));
    let mut target = None;
    for _ in 0..ticks {
        let q = host.robot.q().to_vec();
        out.states.push(host.step().state);
        model.forward(&q, &mut data);
        let p = data.position(tool);
        let target = *target.get_or_insert(p + nalgebra::Vector3::from(away));
        out.errors.push((target - p).norm());
        out.speeds.push(data.point_velocity(&model, tool, p, host.controller.velocity()).norm());
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// The state is left at the first tick after one at which the error and the speed are within their bounds, and no
    /// earlier; a condition with the same criterion leaves it at the same tick.
    #[test]
    fn a_state_is_left_when_error_and_speed_are_small(
        away in prop::array::uniform3(-0.08..0.08_f64),
        gain in 2.0..8.0_f64,
        tolerance in 0.5..20.0_f64,
        speed in prop::option::of(0.5..40.0_f64),
    ) {
        let [x, y, z] = away;
        let bound = speed.map_or(String::new(), |s| format!(", {s} mm/s"));
        let criterion = format!("reached(go, {tolerance} mm{bound})");
        let text = |trigger: &str| format!(
            "{TASKS}machine m {{ initial first  blend 0.1 s  on fault(any) -> stopped
               state first {{ stack moving([{x}, {y}, {z}] m, {gain} /s)  {trigger} {criterion} -> second  after 20 s -> stopped }}
               state second {{ stack resting  after 60 s -> stopped }}
               final state stopped }}"
        );
        let mut host = Host::new(&text("on"));
        let on = run(&mut host, away, 600);
        let left = on.states.iter().position(|s| s == "second");
        let holds = |k: usize| on.errors[k] <= tolerance * 1e-3 && speed.is_none_or(|s| on.speeds[k] <= s * 1e-3);
        // A target counts from the second tick of its stack on.
        let first = (1..599).find(|k| holds(*k));
        prop_assert_eq!(left, first.map(|k| k + 1));
        let when = run(&mut Host::new(&text("when")), away, 600);
        prop_assert_eq!(&when.states, &on.states);
    }

    /// `settled` is the comparison of the fastest joint with its bound.
    #[test]
    fn joints_settle_when_the_fastest_is_slow(bound in 0.2..30.0_f64, hold in 0..4_usize, y in 0.05..0.15_f64) {
        let text = |condition: &str| format!(
            "{TASKS}machine m {{ initial first  blend 0.1 s  on fault(any) -> stopped
               state first {{ stack moving([0, {y}, 0] m, 3 /s)  after 150 ms -> second }}
               state second {{ when {condition} for {} ms -> third  after 20 s -> stopped }}
               state third {{ after 60 s -> stopped }}
               final state stopped  stack moving([0, {y}, 0] m, 3 /s) }}",
            10 * hold
        );
        let joints: Vec<String> = (1..8).map(|j| format!("speed(joint_{j}) <= {bound} deg/s")).collect();
        let all = [
            format!("settled(all, {bound} deg/s)"),
            format!("speed(all) <= {bound} deg/s"),
            format!("settled([joint_1, joint_2, joint_3, joint_4], {bound} deg/s) and settled([joint_5, joint_6, joint_7], {bound} deg/s)"),
            joints.join(" and "),
        ];
        let mut hosts = all.map(|condition| Host::new(&text(&condition)));
        let mut held = 0;
        let mut expected = None;
        for tick in 0..500 {
            let seen: Vec<String> = hosts.iter_mut().map(|h| h.step().state).collect();
            prop_assert!(seen.iter().all(|s| *s == seen[0]), "tick {tick}: {seen:?}");
            prop_assert_eq!(seen[0] == "third", expected.is_some_and(|e| tick >= e), "tick {}", tick);
            let fastest = hosts[0].controller.velocity().iter().fold(0.0_f64, |a, v| a.max(v.abs()));
            held = if seen[0] == "second" && fastest <= bound.to_radians() { held + 1 } else { 0 };
            if expected.is_none() && held > hold {
                expected = Some(tick + 1);
            }
        }
    }
}

#[test]
fn nothing_is_reached_while_its_stack_does_not_run() {
    let text = format!(
        "{TASKS}machine m {{ initial first  blend 0 s  on fault(any) -> stopped
           when reached(go, 10 cm) and t > 0.2 s -> third
           when not reached(go, 10 cm) and t > 0.3 s -> fourth
           state first {{ stack resting  after 0.1 s -> second }}
           state second {{ stack moving([0, 0, 0.01] m, 5 /s)  after 60 s -> stopped }}
           state third {{ stack resting  after 60 s -> stopped }}
           state fourth {{ stack resting  after 60 s -> stopped }}
           final state stopped }}"
    );
    for mut host in in_both_syntaxes(&text) {
        let states: Vec<String> = (0..40).map(|_| host.step().state).collect();
        let entered = |state: &str| states.iter().position(|s| s == state);
        assert_eq!(entered("second"), Some(10), "{states:?}");
        assert_eq!(entered("third"), Some(21), "it is reached long before, once its stack has run: {states:?}");
        assert_eq!(entered("fourth"), Some(31), "its stack has not run since: {states:?}");
    }
}

#[test]
fn a_use_of_a_task_is_named_by_its_arguments_or_alone() {
    let of = |task: &str| {
        let text = format!(
            "{TASKS}stack two from still {{ add one {{ go(only, [0, 0, 1] cm) }}  add other {{ go(only, [0, 0, 2] cm) }} }}
             machine m {{ initial a  blend 0.1 s  on fault(any) -> stopped
               state a {{ stack two  on reached({task}, 5 mm) -> stopped  after 60 s -> stopped }}
               final state stopped }}"
        );
        let program = program_of(&format!("{ARM}{text}"));
        let machine = program.machine.expect("a machine");
        match &machine.states[1].transitions[0].trigger {
            runtime::program::Trigger::Reached(criterion) => program.tasks[criterion.task].name.clone(),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(of("go(only, [0, 0, 1] cm)"), "go.only");
    assert_eq!(of("go(only, away: [0, 0, 2] cm)"), "go.only.2");
    assert_eq!(of("go.only"), "go.only");
}

#[test]
fn a_program_from_a_file_is_checked() {
    let program = program_of(&std::fs::read_to_string(example("completion.hq")).expect("the example"));
    let machine = program.machine.as_ref().expect("a machine");
    assert_eq!((machine.reached.len(), machine.measured.len()), (1, 1));
    let refused = |change: &dyn Fn(&mut runtime::program::ReachedProgram)| {
        let mut program = program.clone();
        change(&mut program.machine.as_mut().expect("a machine").reached[0]);
        program.check().expect_err("it cannot be executed").to_string()
    };
    assert!(refused(&|r| r.signal = 99).contains("machine.reached[0]"));
    assert!(refused(&|r| r.criterion.task = 99).contains("a task does not exist"));
    assert!(refused(&|r| r.criterion.tolerances[0] = -1.0).contains("a tolerance is negative"));
    let text = serde_json::to_string(&program).expect("it is data");
    assert_eq!(serde_json::from_str::<runtime::Program>(&text).expect("it is read back"), program);
}

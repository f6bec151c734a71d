//! Transitions during a blend: the next blend begins at the blended velocity, and does not jump.

use proptest::prelude::*;

use super::host::{Host, in_both_syntaxes};

/// Period of the robot (s).
const PERIOD: f64 = 0.01;

/// Tasks with different targets; those that do not depend on the entry of a stack can be shared by stacks.
const TASKS: &str = "
task turn = joint_velocity { velocity { joint_1 0.6 rad/s } }
task back = joint_velocity { velocity { joint_1 -0.5 rad/s  joint_6 0.3 rad/s } }
task up = frame_position(tool) { position [0.2, -0.3, 0.9] m  gain 2 /s }
task out = frame_position(tool) { position [0.5, 0.2, 0.5] m  gain 1.5 /s }
task wave = joint_position { target { joint_4 1.6 rad + 0.4 rad * sin(2*pi*t/(3 s)) }  gain 5 /s }
task level_tool = frame_orientation(tool) { orientation initial(orientation)  gain 5 /s }
";

const MOTIONS: [&str; 6] = ["turn", "back", "up", "out", "wave", "level_tool"];

/// A state: the motions of its stack, the duration of the blend to it (s), and the number of ticks in it.
#[derive(Clone, Debug)]
struct Visit {
    motions: Vec<usize>,
    blend: f64,
    ticks: usize,
}

fn visits(blend: std::ops::Range<f64>) -> impl Strategy<Value = Vec<Visit>> {
    // Few motions, so that stacks often begin with the same level.
    let motions = prop::sample::subsequence((0..MOTIONS.len()).collect::<Vec<_>>(), 1..3).prop_shuffle();
    let visit = (motions, blend, 1..40_usize).prop_map(|(motions, blend, ticks)| Visit { motions, blend, ticks });
    prop::collection::vec(visit, 3..7)
}

/// A machine that visits the states in their order.
fn machine(visits: &[Visit], limits: &str) -> String {
    let mut stacks = String::from(TASKS);
    let mut states = String::new();
    for (i, Visit { motions, blend, ticks }) in visits.iter().enumerate() {
        let levels: Vec<String> = motions.iter().map(|m| format!("level {0} {{ {0} }}", MOTIONS[*m])).collect();
        stacks.push_str(&format!("stack s{i} {{ level limits hard {{ {limits} }}  {} }}\n", levels.join("  ")));
        let blend = format!("{blend} s");
        let next = if i + 1 < visits.len() { format!("v{}", i + 1) } else { "stopped".to_string() };
        states.push_str(&format!("state v{i} {{ stack s{i}  after {} ms -> {next} blend {blend} }}\n", 10 * ticks));
    }
    format!("{stacks}machine m {{ initial v0  on fault(any) -> stopped\n{states} final state stopped }}")
}

fn jump(before: &[f64], after: &[f64]) -> f64 {
    before.iter().zip(after).fold(0.0, |d: f64, (a, b)| d.max((a - b).abs()))
}

/// Violation of the hard rows of the tick by a velocity.
fn broken_by(host: &Host, v: &[f64]) -> f64 {
    let hard = host.controller.problem().levels.iter().filter(|l| l.hard);
    hard.flat_map(|l| (0..l.rows()).map(move |i| l.slack(i, v).abs())).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    /// The first tick of a blend has the velocity of the tick before, also if that was a blended one, and even if the two
    /// stacks begin with the same soft level, which the blended velocity did not meet.
    #[test]
    fn a_blend_within_a_blend_begins_at_the_blended_velocity(visits in visits(0.2..0.6)) {
        let mut host = Host::new(&machine(&visits, "joint_position_limits  joint_velocity_limits"));
        let (mut last, mut state, mut blending) = (Vec::new(), String::new(), false);
        for tick in 0..visits.iter().map(|v| v.ticks).sum::<usize>() {
            let seen = host.step();
            prop_assert_eq!(seen.fault, None);
            let v = host.controller.velocity().to_vec();
            if seen.state != state && tick > 0 && blending && broken_by(&host, &last) < 1e-9 {
                prop_assert!(jump(&last, &v) < 1e-7, "tick {tick}, to {}: {}", seen.state, jump(&last, &v));
            }
            (last, state, blending) = (v, seen.state, host.controller.is_blending());
        }
    }

    /// Accelerations stay within the limits that all stacks share, whatever the durations of the blends.
    #[test]
    fn accelerations_hold_through_blends_within_blends(visits in visits(0.02..0.6)) {
        let most = 25.0;
        let limits = format!("joint_position_limits  joint_velocity_limits  joint_acceleration_limits {{ max {most} rad/s^2 }}");
        let mut host = Host::new(&machine(&visits, &limits));
        let mut last = vec![0.0; 7];
        for tick in 0..visits.iter().map(|v| v.ticks).sum::<usize>() {
            let seen = host.step();
            prop_assert_eq!(seen.fault, None);
            let v = host.controller.velocity().to_vec();
            prop_assert!(jump(&last, &v) <= most * PERIOD + 1e-8, "tick {tick}: {}", jump(&last, &v) / PERIOD);
            last = v;
        }
    }
}

/// Between two stacks that share their first soft level, a blend keeps that level. If a blend to the first of them is
/// interrupted, the velocity does not meet it yet, and the level joins the blend.
#[test]
fn a_shared_level_that_is_not_met_yet_does_not_make_the_velocity_jump() {
    let text = format!(
        "{TASKS}
         stack a from still {{ add one {{ turn }} }}
         stack b from still {{ add one {{ back }} }}
         stack c from still {{ add one {{ back }}  add two {{ level_tool }} }}
         machine m {{ initial first  blend 0.5 s  on fault(any) -> stopped
           state first {{ stack a  after 300 ms -> second }}
           state second {{ stack b  after 100 ms -> third }}
           state third {{ stack c  after 10 s -> stopped }}
           final state stopped }}"
    );
    for mut host in in_both_syntaxes(&text) {
        let mut last = vec![0.0; 7];
        for tick in 0..120 {
            let seen = host.step();
            assert_eq!(seen.fault, None);
            let v = host.controller.velocity().to_vec();
            // 1.1 rad/s vanish in 0.5 s with a slope of at most 3/2; the second blend begins with the rest of it.
            assert!(tick == 0 || jump(&last, &v) < 1.1 * 1.5 * PERIOD / 0.5 + 5e-3, "tick {tick}: {}", jump(&last, &v));
            last = v;
        }
        assert!((last[0] + 0.5).abs() < 1e-3, "the last stack has what it asks for: {}", last[0]);
    }
}

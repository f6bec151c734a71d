//! Hard motion: the specs of `examples/hard` at control rates from 50 Hz to 1 kHz, in both syntaxes. Their
//! expectations hold, no acceleration limit is violated, and the tool of an arm that cannot reach its target rests at
//! the nearest point.

use crate::common;

use common::{example, judged, program, program_of};
use runtime::expect::{Outcome, Verdict};
use runtime::program::Program;
use runtime::record::All;
use runtime::record::summary::Summary;
use runtime::{Recorder, Simulation, Tick};

/// Specs in `examples/hard`.
const EXAMPLES: [&str; 7] =
    ["out_of_reach", "through_singularities", "held_base", "two_wishes", "swapping_hands", "short_of_time", "cornered"];

/// Runs the first scenario; returns its outcomes and the summary.
fn run(program: &Program) -> (Vec<Outcome>, Summary) {
    let (summary, outcomes) = judged(program, &program.scenarios[0], &mut All(Vec::new()));
    (outcomes, summary)
}

#[test]
fn what_hard_motion_expects_holds() {
    for name in EXAMPLES {
        let (outcomes, summary) = run(&program(&format!("hard/{name}.hq")));
        assert!(outcomes.len() >= 3, "{name}");
        assert!(outcomes.iter().all(|o| o.verdict == Verdict::Holds), "{name}: {outcomes:?}");
        for (joint, motion) in &summary.joints {
            assert_eq!(motion.jumps, 0, "{name}: {joint} {motion:?}");
        }
    }
}

/// The whole range of rates, with lag and noise. A joint may reverse once whenever the target leaves the reach or comes
/// back, which it does six times.
#[test]
fn a_target_that_comes_and_goes_is_calm_at_every_rate() {
    let text = std::fs::read_to_string(example("hard/out_of_reach.hq")).expect("readable").replace("\"../", "\"");
    for rate in [50, 100, 200, 1000] {
        let (_, summary) = run(&program_of(&text.replace("rate 500 Hz", &format!("rate {rate} Hz"))));
        for (joint, motion) in &summary.joints {
            assert!(motion.jumps == 0 && motion.reversals <= 6, "{rate} Hz: {joint} {motion:?}");
        }
        assert!(summary.joints.len() == 7, "{rate} Hz");
    }
}

/// An infeasible soft limit, at the same rates: 277 reversals at 500 Hz without its damping.
#[test]
fn an_arm_that_is_cornered_is_calm_at_every_rate() {
    let text = std::fs::read_to_string(example("hard/cornered.hq")).expect("readable").replace("\"../", "\"");
    for rate in [50, 200, 1000] {
        let (outcomes, summary) = run(&program_of(&text.replace("rate 500 Hz", &format!("rate {rate} Hz"))));
        let sum: usize = summary.joints.values().map(|motion| motion.reversals).sum();
        assert!(sum <= 8 && summary.joints.values().all(|motion| motion.jumps == 0), "{rate} Hz: {sum}");
        assert!(outcomes.iter().all(|o| o.verdict == Verdict::Holds), "{rate} Hz: {outcomes:?}");
    }
}

/// Records the last position of a link.
struct Last(robot::Data, nalgebra::Vector3<f64>, f64);

impl Recorder for Last {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let model = tick.evaluator.model();
        model.forward(tick.q, &mut self.0);
        self.1 = *self.0.position(model.link("tool").expect("a link"));
        self.2 = tick.v.iter().fold(0.0, |most, v| v.abs().max(most));
        Ok(())
    }
}

/// Computes the distance of the tool from a target at a configuration.
fn distance(model: &robot::Model, data: &mut robot::Data, q: &[f64], target: &nalgebra::Vector3<f64>) -> f64 {
    model.forward(q, data);
    (data.position(model.link("tool").expect("a link")) - target).norm()
}

/// Minimum distance found by search: random configurations, then shrinking steps of single joints.
fn nearest(model: &robot::Model, target: &nalgebra::Vector3<f64>) -> f64 {
    let mut data = robot::Data::new(model);
    let mut seed = 7_u64;
    let mut dice = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let mut q = model.random_configuration(&mut dice);
        let mut now = distance(model, &mut data, &q, target);
        let mut step = 0.3;
        while step > 1e-6 {
            let before = now;
            for (j, dof) in model.dofs.iter().enumerate() {
                for way in [step, -step] {
                    let was = q[j];
                    q[j] = (was + way).clamp(dof.lower, dof.upper);
                    let there = distance(model, &mut data, &q, target);
                    if there < now {
                        now = there;
                    } else {
                        q[j] = was;
                    }
                }
            }
            if before - now < 1e-9 {
                step *= 0.5;
            }
        }
        best = best.min(now);
    }
    best
}

#[test]
fn a_tool_that_cannot_reach_rests_at_the_nearest_point() {
    for (target, rate) in
        [([1.5, 0.0, 0.4], 500), ([1.2, 0.3, 0.6], 100), ([-0.9, 0.8, 0.2], 50), ([0.2, 0.1, 1.9], 1000)]
    {
        let [x, y, z] = target;
        let program = program_of(&format!(
            "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate {rate} Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
stack s {{
  level limits hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}
  level motion {{ frame_position(tool) {{ position [{x}, {y}, {z}] m }} }}
  level posture {{ joint_position {{ target {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }} }}
}}
run {{ duration 15 s }}\n"
        ));
        let model = &program.robot.model;
        let mut last = Last(robot::Data::new(model), nalgebra::Vector3::zeros(), 0.0);
        let mut simulation = Simulation::new(&program).expect("it can be executed");
        simulation.run(&mut last, &mut || 0.0, &mut |_| true).expect("no recorder fails");
        let target = nalgebra::Vector3::from(target);
        let (least, is) = (nearest(model, &target), (last.1 - target).norm());
        assert!(is < least + 1e-3, "{target:?} at {rate} Hz: {is} m away, {least} m is possible");
        assert!(last.2 < 0.05, "{target:?} at {rate} Hz: joints still move, {} rad/s", last.2);
    }
}

/// A tool and a middle link with targets that exclude each other, and a posture below both. The tool's target is
/// feasible: it is opposed by equality rows, and not by a bound.
#[test]
fn a_level_below_one_that_is_met_does_not_chatter() {
    for (home, tool, middle, rate) in [
        ("-0.49, 0.17, -0.24, 1.66, -0.46, 0.22, 0.68", "-0.365, 0.774, -0.351", "-0.049, -0.056, 1.028", 50),
        ("0.11, 0.77, -0.14, 1.65, 0.42, -0.27, -0.98", "-0.146, -0.539, 0.024", "0.220, -0.180, 0.722", 500),
        ("-0.60, -0.43, -0.33, 0.70, -0.93, 0.02, 0.92", "0.263, 0.053, -0.039", "0.114, 0.173, 0.578", 1000),
    ] {
        let program = program_of(&format!(
            "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate {rate} Hz  home {{ all [{home}] rad }} }}
stack s {{
  level limits hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}
  level first {{ frame_position(tool) {{ position initial(position) + [{tool}] m }} }}
  level second {{ frame_position(link_4) {{ position [{middle}] m }} }}
  level posture {{ joint_position {{ target {{ all [{home}] rad }} }} }}
}}
run {{ duration 8 s }}
scenario \"it\" {{ duration 8 s  expect \"smooth\" always reversals(all) <= 2  expect never fault }}\n"
        ));
        let (outcomes, summary) = run(&program);
        assert!(outcomes.iter().all(|o| o.verdict == Verdict::Holds), "{rate} Hz: {outcomes:?}");
        assert!(summary.joints.iter().all(|(_, motion)| motion.jumps == 0), "{rate} Hz");
    }
}

#[test]
fn both_syntaxes_say_the_same() {
    for name in EXAMPLES {
        assert_eq!(program(&format!("hard/{name}.hq")), program(&format!("hard/{name}.yaml")), "{name}");
    }
}

/// A target out of reach, with a setting of the damping of its level.
fn out_of_reach(damping: &str) -> Program {
    program_of(&format!(
        "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate 500 Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
stack s {{
  level limits hard {{ joint_position_limits  joint_velocity_limits {{ max 1 rad/s }} }}
  level motion {damping} {{ frame_position(tool) {{ position [1.5, 0, 0.4] m }} }}
}}
scenario s {{ duration 6 s  expect always time >= 0 s }}\n"
    ))
}

#[test]
fn damping_is_on_by_default_and_off_by_a_word() {
    let reversals = |program: &Program| -> u64 { run(program).1.joints.values().map(|j| j.reversals as u64).sum() };
    let (default, auto, none) = (out_of_reach(""), out_of_reach("damping auto"), out_of_reach("damping none"));
    assert_eq!(default, auto);
    assert!(none.stacks[0].levels[1].exact && !auto.stacks[0].levels[1].exact);
    assert_eq!(reversals(&auto), 0);
    assert!(reversals(&none) > 1000, "{}", reversals(&none));
    let by_hand = out_of_reach("damping 0.5");
    assert_eq!(by_hand.stacks[0].levels[1].damping, 0.5);
    assert_eq!(reversals(&by_hand), 0);
}

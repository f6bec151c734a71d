//! A compiled program at another control period: the same as if its spec had been compiled for that rate, or rejected
//! with the gains that overshoot.

use crate::common;

use common::program_of;
use runtime::{Controller, ProgramError};
use runtime::{HighGain, PeriodError, Program};

/// An arm with gains of 80 /s and 60 /s, a variable one, and a low-level controller.
fn arm(rate: f64) -> Program {
    program_of(&format!(
        "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate {rate} Hz  tracking_gain 10 /s  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}
task reach = frame_position(tool) {{ position initial(position) + [0, 0.1, 0] m * sin(t/(1 s))  gain 80 /s }}
task floor = keep(frame(tool).position.z) {{ min 0.1 m  gain 60 /s }}
task posture = joint_position {{ target {{ all 0 rad }}  gain 20 /s + 10 /s * sin(t/(1 s)) }}
stack work {{ level limits hard {{ joint_position_limits  floor }}  level motion {{ reach }}  level rest {{ posture }} }}
stack home {{ level rest {{ posture }} }}
machine m {{ initial go  state go {{ stack work  after 1 s -> home }}  final state home {{ stack home }} }}
run {{ machine m  duration 2 s }}\n"
    ))
}

#[test]
fn another_period_is_as_compiled_for_it() {
    for (from, to) in [(200.0, 1000.0), (1000.0, 200.0), (125.0, 80.0)] {
        let (changed, compiled) = (arm(from).at_period(1.0 / to).expect("no gain overshoots"), arm(to));
        assert_eq!(changed, compiled, "from {from} Hz to {to} Hz");
        Controller::new(&changed).expect("it can be executed");
    }
}

#[test]
fn rows_and_scenarios_of_the_old_period_do_not_count() {
    let mut program = program_of(
        "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz }
task deep = virtual_wall(link_4) { through [[0, 0, -1], [1, 0, -1], [0, 1, -1]] m }
stack s { level limits hard { joint_position_limits  joint_velocity_limits  deep } }
run { duration 1 s }\n",
    );
    compiler::mark_idle_rows(&mut program);
    let idle =
        |p: &Program| p.stacks.iter().flat_map(|s| &s.levels).flat_map(|l| &l.members).any(|m| !m.idle.is_empty());
    assert!(idle(&program));
    assert!(!idle(&program.at_period(2.0 * program.robot.period).expect("its gains are low")));
    let tested = common::program("tested.hq");
    assert!(!tested.scenarios.is_empty());
    assert!(tested.at_period(0.5 * tested.robot.period).expect("shorter is safe").scenarios.is_empty());
}

#[test]
fn gains_that_overshoot_are_named() {
    let refused = arm(1000.0).at_period(0.02).expect_err("80 /s and 60 /s overshoot at 50 Hz");
    let gain = |task: &str, gain| HighGain { task: Some(task.to_string()), gain };
    assert_eq!(refused, PeriodError::HighGains { period: 0.02, gains: vec![gain("reach", 80.0), gain("floor", 60.0)] });
}

#[test]
fn the_robots_own_gain_counts_and_times_must_be_times() {
    let refused = arm(1000.0).at_period(0.2).expect_err("10 /s overshoots at 5 Hz");
    let PeriodError::HighGains { gains, .. } = &refused else { panic!("{refused:?}") };
    assert_eq!(gains[0], HighGain { task: None, gain: 10.0 });
    let said = refused.to_string();
    assert!(said.contains("at most 5 /s") && said.contains("10 /s of the robot's `tracking_gain`"), "{said}");
    for period in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        assert_eq!(arm(100.0).at_period(period), Err(PeriodError::NotATime));
    }
}

/// The check cannot be bypassed by writing the field, or the file of a program.
#[test]
fn no_controller_is_made_for_gains_that_overshoot() {
    let refused = |change: &dyn Fn(&mut Program)| -> ProgramError {
        let mut program = arm(1000.0);
        change(&mut program);
        match Controller::new(&program) {
            Err(e) => e,
            Ok(_) => panic!("it overshoots"),
        }
    };
    let slow = |program: &mut Program, period: f64| {
        program.robot.period = period;
        program.robot.deadline = 2.0 * period;
    };
    // A variable gain has a bound, which is that of the old period.
    let of_range = refused(&|p| slow(p, 0.02));
    assert_eq!(of_range.place, "values.ranges", "{of_range}");
    let of_task = refused(&|p| {
        slow(p, 0.02);
        p.values.ranges.iter_mut().filter(|r| r.gain).for_each(|r| r.max = Some(50.0));
    });
    assert!(of_task.message.contains("the gain 60 /s of `floor` overshoots"), "{of_task}");
    let of_robot = refused(&|p| p.robot.tracking_gain = 1001.0);
    assert_eq!(of_robot.place, "robot.tracking_gain", "{of_robot}");
}

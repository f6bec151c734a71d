//! The slowest ticks of a run, with their state and the rows that reached or left a bound.

use runtime::Simulation;
use runtime::record::summary::SummaryRecorder;

use super::common::program_of;

/// One joint must exceed its limit from 0.5 s on, in a state that is entered at 0.2 s.
const SPEC: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad } }
task caps = joint_velocity_limits { max 0.5 rad/s }
stack still { level motion { joint_velocity { velocity { all 0 rad/s } } } }
stack moves {
  level limits hard { caps }
  level motion { joint_velocity { velocity { joint_2 if(t > 0.495 s, 0.7 rad/s, 0.2 rad/s) } } }
}
machine m {
  initial wait
  state wait { stack still  after 0.2 s -> go }
  state go { stack moves }
}
run { machine m  duration 0.8 s }
";

#[test]
fn slow_ticks_tell_what_changed() {
    let program = program_of(SPEC);
    let mut simulation = Simulation::new(&program).expect("it can be executed");
    let mut recorder = SummaryRecorder::new(simulation.controller(), simulation.ticks());
    // The clock is read before and after each tick, which takes 1 ms, with some longer ticks.
    let (mut now, mut reads) = (0.0, 0);
    let mut clock = || {
        if reads % 2 == 1 {
            now += match reads / 2 {
                20 => 3e-3,
                30 => 2e-3,
                70 => 4e-3,
                _ => 1e-3,
            };
        }
        reads += 1;
        now
    };
    simulation.run(&mut recorder, &mut clock, &mut |_| true).expect("nothing is written");
    let summary = recorder.summary(&program, simulation.controller(), Vec::new());
    let told: Vec<_> = (summary.tick_us.slowest.iter())
        .map(|s| ((s.us * 1e-3).round(), (s.at_s * 1e2).round() as u32, s.state.as_deref(), s.first, s.changed))
        .collect();
    assert_eq!(
        told,
        [(4.0, 70, Some("go"), false, 2), (3.0, 20, Some("go"), true, 0), (2.0, 30, Some("go"), false, 0),]
    );
    assert_eq!(summary.tick_us.slowest[0].rows, ["caps joint_2", "motion.joint_velocity joint_2"]);
}

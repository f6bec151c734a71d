//! Limits of a state hold from its entry on: a height above a bin that only the later state requires.

use runtime::FaultKind;

use super::host::{Host, in_both_syntaxes};

/// A tool that rises by 0.15 m, and then works at least 0.1 m above its home height, above a bin. `rise` is the initial
/// rise, `level` the setting of the limit's level, `ways` are further transitions.
fn spec(home: f64, rise: f64, level: &str, ways: &str) -> String {
    format!(
        "task up = frame_position(tool) {{ position initial(position) + [0, 0, {rise}] m  gain 5 /s }}
         task across = frame_position(tool) {{ position initial(position) + [0, 0.1, -0.3] m * smoothstep(t/(2 s))  gain 5 /s }}
         task above = keep(frame(tool).position.z) {{ min {} m  gain 5 /s }}
         stack rising {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level motion {{ up }} }}
         stack working {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level bin {level} {{ above }}
           level motion {{ across }} }}
         machine m {{ initial rise  blend 0.3 s  {ways}  on fault(any) -> stopped
           state rise {{ stack rising  after 2 s -> work }}
           state work {{ stack working  after 4 s -> done }}
           final state done  final state stopped }}",
        home + 0.1,
    )
}

fn height(host: &Host) -> f64 {
    let evaluator = host.controller.evaluator();
    let link = evaluator.model().link("tool").expect("a link of the arm");
    evaluator.data().pose(link).translation.vector.z
}

fn home() -> f64 {
    let mut host = Host::new(
        "machine m { initial a  on fault(any) -> b  state a { stack still  after 1 s -> b }  final state b }",
    );
    host.step();
    height(&host)
}

#[test]
fn a_height_above_a_bin_holds_from_the_entry_of_its_state_on() {
    let least = home() + 0.1;
    for mut host in in_both_syntaxes(&spec(home(), 0.15, "hard", "")) {
        let mut lowest = f64::INFINITY;
        loop {
            let seen = host.step();
            assert_eq!(seen.fault, None);
            match seen.state.as_str() {
                "work" => lowest = lowest.min(height(&host)),
                "done" => break,
                _ => {}
            }
        }
        assert!(lowest > least - 1e-4, "{lowest} above {least}");
        assert!(lowest < least + 1e-2, "the limit is what stops it: {lowest}");
    }
}

/// The state is entered 0.3 m below its limit: the row requires 2 m/s upwards, which the joints cannot reach.
#[test]
fn a_hard_limit_that_cannot_be_met_at_the_entry_is_a_fault_with_state_and_limit() {
    for mut host in in_both_syntaxes(&spec(home(), -0.3, "hard", "")) {
        host.steps(200);
        let q = host.robot.measure().to_vec();
        let command = host.controller.step(&runtime::Observation { time: host.time(), q: &q });
        assert!(command.velocity.iter().all(|v| *v == 0.0), "it stands at that very tick");
        let fault = command.fault.expect("a fault");
        assert_eq!(fault.kind(), FaultKind::Infeasible);
        assert_eq!(host.controller.state(), "work");
        let text = host.controller.describe(&fault);
        for word in ["state `work`", "level `bin`", "`above`"] {
            assert!(text.contains(word), "{text}");
        }
        host.tick += 1;
        assert_eq!(host.steps(2), "stopped");
    }
}

/// A violation at the entry is a fault if a transition monitors the limit, although the robot could move back.
#[test]
fn a_limit_that_is_passed_at_the_entry_is_a_fault_where_a_transition_asks_for_it() {
    for (ways, ends) in [("on fault(limit(above)) -> stopped", "stopped"), ("", "work")] {
        for mut host in in_both_syntaxes(&spec(home(), 0.06, "hard", ways)) {
            assert_eq!(host.steps(200), "rise");
            let q = host.robot.measure().to_vec();
            let fault = host.controller.step(&runtime::Observation { time: host.time(), q: &q }).fault;
            assert_eq!(fault.map(|f| f.kind()), (!ways.is_empty()).then_some(FaultKind::Limit));
            if let Some(fault) = fault {
                let text = host.controller.describe(&fault);
                assert!(text.contains("state `work`") && text.contains("`above`"), "{text}");
            }
            host.tick += 1;
            assert_eq!(host.steps(2), ends);
        }
    }
}

/// A soft limit yields, and the robot moves back inside it.
#[test]
fn a_soft_limit_that_is_passed_at_the_entry_is_no_fault() {
    for mut host in in_both_syntaxes(&spec(home(), -0.02, "", "")) {
        for _ in 0..400 {
            assert_eq!(host.step().fault, None);
        }
        assert!(height(&host) > home() + 0.1 - 1e-2, "{}", height(&host) - home());
    }
}

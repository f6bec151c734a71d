//! Conditions on the motion: they measure the same as expectations, one tick later, and count from the entry of their
//! state.

use nalgebra::Vector3;
use runtime::program::{Measure, Program};
use runtime::{Controller, Recorder, Simulation, Tick};

use super::common::{example, program_of, velocity_by_differences};

/// A square wave of 10 Hz: five ticks in each direction.
const WAVE: &str = "if(sin(2*pi*t/(0.1 s) + 0.1) > 0, 0.5 rad/s, -0.5 rad/s)";

/// An arm whose second joint oscillates in the first state of a machine.
fn text(machine: &str) -> String {
    format!(
        "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}
stack swing {{ level motion {{ joint_velocity {{ velocity {{ joint_2 {WAVE} }} }} }} }}
stack calm {{ level motion {{ joint_velocity {{ velocity {{ all 0 rad/s }} }} }} }}
machine m {{ initial go  {machine} }}
run {{ machine m  duration 2 s }}\n"
    )
}

/// State, velocity, and an entry of the signal table at each tick.
#[derive(Default)]
struct Ticks {
    number: Option<usize>,
    all: Vec<(String, Vec<f64>, f64)>,
    /// Velocity of the tool in the world, by differences of positions.
    tool: Vec<Vector3<f64>>,
}

impl Recorder for Ticks {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let measured = self.number.map_or(f64::NAN, |at| tick.signals[at]);
        self.all.push((tick.state.to_string(), tick.v.to_vec(), measured));
        self.tool.push(velocity_by_differences(tick, "tool"));
        Ok(())
    }
}

/// Runs a machine, and records a measure.
fn run(program: &Program, measure: &str) -> Ticks {
    let signal = program.interface.signal(measure).unwrap_or_else(|| panic!("{measure}: {:?}", program.interface));
    let mut ticks = Ticks { number: Some(program.interface.signals[signal].at + 1), ..Ticks::default() };
    let mut simulation = Simulation::new(program).expect("it can be executed");
    simulation.run(&mut ticks, &mut || 0.0, &mut |_| true).expect("no recorder fails");
    ticks
}

fn left(ticks: &Ticks, state: &str) -> Option<usize> {
    ticks.all.iter().position(|t| t.0 != state)
}

#[test]
fn the_acceleration_of_a_group_is_the_largest_of_its_joints() {
    let machine = "state go { stack swing  when acceleration(some) > 1e9 rad/s^2 -> stopped }  final state stopped";
    let slow = "joint_4 if(sin(2*pi*t/(0.14 s)) > 0, 0.8 rad/s, -0.1 rad/s)";
    let text = text(machine)
        .replace("rate 100 Hz", "rate 100 Hz  joints { some [joint_2, joint_4] }")
        .replace(&format!("joint_2 {WAVE}"), &format!("joint_2 {WAVE}  {slow}"));
    let ticks = run(&program_of(&text), "acceleration(some)");
    let (mut second, mut fourth) = (0, 0);
    for k in 1..ticks.all.len() {
        let change = |joint: usize| (ticks.all[k].1[joint] - ticks.all[k - 1].1[joint]).abs() / 0.01;
        let measured = ticks.all[k].2;
        assert!((measured - change(1).max(change(3))).abs() < 1e-6, "{k}: {measured} {} {}", change(1), change(3));
        second += usize::from(change(1) > change(3));
        fourth += usize::from(change(3) > change(1));
    }
    assert!(second > 10 && fourth > 10, "{second} {fourth}");
}

#[test]
fn an_acceleration_is_seen_at_the_tick_after() {
    // 50 rad/s^2 at the first tick, 100 at the sixth, at which the wave reverses.
    let machine = |limit: u32| {
        text(&format!(
            "state go {{ stack swing  when acceleration(joint_2) > {limit} rad/s^2 -> stopped }}  final state stopped {{ stack calm }}"
        ))
    };
    for (limit, tick) in [(49, Some(1)), (51, Some(6)), (99, Some(6)), (101, None)] {
        let ticks = run(&program_of(&machine(limit)), "acceleration(joint_2)");
        assert_eq!(left(&ticks, "go"), tick, "{limit}");
    }
    let ticks = run(&program_of(&machine(101)), "acceleration(joint_2)");
    let mut before = 0.0;
    for (_, v, measured) in &ticks.all {
        assert!((measured - (v[1] - before).abs() / 0.01).abs() < 1e-9);
        before = v[1];
    }
}

#[test]
fn frames_are_measured_in_the_world() {
    let machine = "state go { stack swing  when acceleration(tool) > 1e9 m/s^2 or speed(tool) > 1e9 m/s -> stopped }  final state stopped";
    let program = program_of(&text(machine));
    let ticks = run(&program, "acceleration(tool)");
    let mut before = Vector3::zeros();
    for ((_, _, measured), v) in ticks.all.iter().zip(&ticks.tool) {
        assert!((measured - (v - before).norm() / 0.01).abs() < 1e-4, "{measured}");
        before = *v;
    }
    let ticks = run(&program, "speed(tool)");
    assert!(ticks.all.iter().zip(&ticks.tool).all(|((_, _, speed), v)| (speed - v.norm()).abs() < 1e-6));
}

#[test]
fn reversals_count_since_their_state_was_entered() {
    // The wave reverses for the second time at tick 10: the first reversal, and one more every five ticks.
    let program = program_of(&text(
        "state go { stack swing  when reversals(all) >= 3 -> rest }
         state rest { stack calm  after 0.3 s -> go }",
    ));
    let ticks = run(&program, "reversals(all) in go");
    let stays: Vec<(usize, usize)> = {
        let mut all = Vec::new();
        let mut from = 0;
        for k in 1..=ticks.all.len() {
            if k == ticks.all.len() || ticks.all[k].0 != ticks.all[from].0 {
                all.push((from, k - from));
                from = k;
            }
        }
        all
    };
    // Three reversals, at ticks 10, 15 and 20 of a stay, evaluated at the next tick.
    assert_eq!(stays[0], (0, 21));
    assert_eq!(stays[1].1, 30);
    assert!(stays[2].1 > 15 && stays[2].1 <= 21, "it counts anew: {stays:?}");
    // An outer state continues counting while its substates change.
    let program = program_of(&text(
        "state go { stack swing  initial a  when reversals(joint_2) >= 8 -> stopped
            state a { after 0.1 s -> b }  state b { after 0.1 s -> a } }
         final state stopped { stack calm }",
    ));
    let ticks = run(&program, "reversals(joint_2) in go");
    let stopped = ticks.all.iter().position(|t| t.0 == "stopped");
    assert_eq!(stopped, Some(10 + 7 * 5 + 1));
}

/// Application: a level without damping chatters at a target out of reach, and the machine stops it.
#[test]
fn a_machine_leaves_a_stack_that_chatters() {
    let spec = |damping: &str| {
        format!(
            "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate 500 Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
stack reach {{ level limits hard {{ joint_position_limits  joint_velocity_limits {{ max 1 rad/s }} }}
  level motion {damping} {{ frame_position(tool) {{ position [1.5, 0, 0.4] m }} }} }}
machine m {{ initial go  state go {{ stack reach  when reversals(all) > 20 -> stopped }}  final state stopped }}
run {{ machine m  duration 6 s }}\n"
        )
    };
    let chatters = run(&program_of(&spec("damping none")), "reversals(all) in go");
    let stopped = left(&chatters, "go").expect("it chatters");
    assert!(chatters.all[stopped..].iter().all(|t| t.0 == "stopped" && t.1.iter().all(|v| *v == 0.0)));
    assert!(chatters.all[stopped - 1].2 > 20.0);
    assert_eq!(left(&run(&program_of(&spec("")), "reversals(all) in go"), "go"), None);
}

#[test]
fn a_controller_that_starts_again_has_measured_nothing() {
    let program =
        program_of(&text("state go { stack swing  when reversals(all) >= 3 -> stopped }  final state stopped"));
    let mut controller = Controller::new(&program).expect("it can be executed");
    for _ in 0..2 {
        let mut robot = runtime::SimulatedRobot::new(&program);
        let mut ticks = 0;
        while controller.state() != "stopped" || ticks == 0 {
            let velocity = controller
                .step(&runtime::Observation { time: f64::from(ticks) * 0.01, q: robot.measure() })
                .velocity
                .to_vec();
            robot.apply(&velocity);
            ticks += 1;
            assert!(ticks < 100);
        }
        assert_eq!(ticks, 22, "at tick 21, counted from 0");
        controller.restart();
    }
}

#[test]
fn both_syntaxes_say_the_same_and_a_file_is_checked() {
    let hq = text(
        "state go { stack swing  when reversals(all) > 3 and speed(joint_2) < 1 rad/s -> stopped }  final state stopped",
    );
    let program = program_of(&hq);
    let (spec, _) = dsl::parse(dsl::SourceId(0), &hq, dsl::Syntax::Native);
    let yaml = dsl::print(&spec, dsl::Syntax::Yaml);
    assert_eq!(program, super::common::program_in(&yaml, dsl::Syntax::Yaml));
    let machine = program.machine.as_ref().expect("a machine");
    assert_eq!(machine.measured.len(), 2);
    assert_eq!(machine.measured[1].measure, Measure::Speed(1));
    let json = serde_json::to_string(&program).expect("it is data");
    assert_eq!(serde_json::from_str::<Program>(&json).expect("it can be read"), program);
    let refused = |change: &dyn Fn(&mut runtime::program::MeasuredProgram)| {
        let mut program = program.clone();
        change(&mut program.machine.as_mut().expect("a machine").measured[1]);
        Controller::new(&program).err().expect("it is refused").place
    };
    let place = "machine.measured[1]";
    assert_eq!(refused(&|m| m.signal = 99), place);
    assert_eq!(refused(&|m| m.measure = Measure::Acceleration(7)), place);
    assert_eq!(refused(&|m| m.measure = Measure::In(0)), place);
    assert_eq!(refused(&|m| m.since = Some(9)), place);
}

/// Returns the diagnostics of a spec as text.
fn said(text: &str) -> String {
    let folder = example("");
    let input = compiler::Input {
        name: "test.hq",
        text,
        syntax: dsl::Syntax::Native,
        folder: &folder,
        set: &[],
        package_paths: &[],
    };
    compiler::compile(&input).report.render(compiler::Style::Plain, 100)
}

#[test]
fn misuse_is_told() {
    let condition =
        |c: &str| said(&text(&format!("state go {{ stack swing  when {c} -> stopped }}  final state stopped")));
    for (written, code, word) in [
        ("reversals(joint_9) > 3", "HQ0201", "joint_9"),
        ("acceleration(joint_2) > 3 rad/s", "HQ0302", "do not go together"),
        ("speed(nowhere) > 3 m/s", "HQ0201", "nowhere"),
        ("reversals(joint_1, joint_2) > 3", "HQ0310", "takes one name, not 2 arguments"),
        ("speed(2 m) > 3 m/s", "HQ0304", "a name is needed here"),
        ("reversals(all)", "HQ0304", "a condition is true or false"),
        ("margin(swing) > 0", "HQ0312", "no controller knows it"),
        ("initial(speed(joint_2)) > 1 rad/s", "HQ0312", "after `when` in a machine"),
    ] {
        let said = condition(written);
        assert!(said.contains(code) && said.contains(word), "{written}\n{said}");
    }
    let task = text("final state go { stack swing }")
        .replace("stack calm", "task odd = keep(speed(joint_2)) { max 1 rad/s }\nstack calm");
    let said = said(&task);
    assert!(said.contains("HQ0312") && said.contains("after `when` in a machine"), "{said}");
}

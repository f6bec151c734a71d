//! Signals that arrive seldom or late: what follows them moves steadily, ages are values, and a run waits for the first
//! readings.

use crate::common;

use nalgebra::{UnitQuaternion, Vector3};
use robot::Data;
use runtime::program::Program;
use runtime::{Controller, Fault, Observation, Recorder, Tick};

const ARM: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 200 Hz  points { tip tool }  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
";

const LIMITS: &str = "level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }";

/// The program of a text, which is the same in both syntaxes.
fn both(text: &str) -> Program {
    let program = common::program_of(text);
    let (tree, diagnostics) = dsl::parse(dsl::SourceId(0), text, dsl::Syntax::Native);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let yaml = dsl::print(&tree, dsl::Syntax::Yaml);
    let other = common::program_in(&yaml, dsl::Syntax::Yaml);
    let plain = |p: &Program| format!("{:?} {:?} {:?}", p.interface, p.values, p.machine);
    assert_eq!(plain(&program), plain(&other), "{yaml}");
    program
}

/// A tool that follows a signal or a hand at 0.1 m/s.
fn follower(signal: &str, target: &str, class: &str, script: &str, least: f64, most: f64) -> String {
    format!(
        "{ARM}{signal}
task follow = frame_position(tool) {{ position {target}  gain 5 /s }}
stack s {{ {LIMITS}  level m {{ follow }} }}
run {{ stack s  duration 6 s }}
scenario steady {{
  stack s
  duration 6 s
  {class} {{ marker {{ {script} }} }}
  expect \"not too fast\" from 3 s : always speed(tool) < {most} mm/s
  expect \"not too slow\" from 3 s to 5.9 s : always speed(tool) > {least} mm/s
  expect never fault
}}"
    )
}

const WAY: &str = "path [{ at 0 s  value [0.45, -0.25, 0.40] m }, { at 6 s  value [0.45, 0.35, 0.40] m }]";

#[test]
fn a_tool_that_follows_slow_readings_moves_steadily() {
    for period in [
        "period 15 ms",
        "period 33 ms",
        "period 100 ms",
        "period 140 ms",
        "period 60 ms  drop 0.2",
        "period 100 ms  delay 40 ms",
    ] {
        for velocity in ["velocity estimated", "velocity measured", "velocity estimated  cutoff 2 Hz  low_pass 2 Hz"] {
            let signal = format!("signal marker : point {{ timeout 0.5 s  {velocity} }}");
            let script = format!("{WAY}  {period}");
            common::holds(&both(&follower(&signal, "marker", "signals", &script, 97.0, 103.0)));
        }
        let human = "human marker { points [hand]  timeout 0.5 s  between extrapolate }";
        let script = format!("points {{ hand {{ {WAY} }} }}  {period}");
        common::holds(&both(&follower(human, "marker.hand", "humans", &script, 97.0, 103.0)));
    }
}

/// Held, the position stands while its velocity is fed forward; a person is held unless they are to be extrapolated.
#[test]
fn what_is_held_stands_between_readings() {
    #[derive(Default)]
    struct Speeds(Vec<f64>);
    impl Recorder for Speeds {
        fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
            if (3.0..5.9).contains(&tick.time) {
                self.0.push(common::velocity_by_differences(tick, "tool").norm());
            }
            Ok(())
        }
    }
    let signal = "signal marker : point { timeout 0.5 s  velocity estimated  between hold }";
    let ageless = "signal marker : point { velocity estimated }";
    let script = format!("{WAY}  period 100 ms");
    let human = "human marker { points [hand]  timeout 0.5 s }";
    let of_human = format!("points {{ hand {{ {WAY} }} }}  period 100 ms");
    for (signal, target, class, script) in [
        (signal, "marker", "signals", &script),
        (ageless, "marker", "signals", &script),
        (human, "marker.hand", "humans", &of_human),
    ] {
        let text = follower(signal, target, class, script, 1.0, 900.0);
        let speeds = common::recorded::<Speeds>(&common::program_of(&text)).0;
        let most = speeds.iter().copied().fold(0.0, f64::max);
        assert!(most > 0.12 && common::least(&speeds) < 0.08, "{signal}: {} to {most}", common::least(&speeds));
    }
}

/// A controller whose signal 0 is read while the robot stands.
fn standing(signal: &str) -> (Controller, Vec<f64>) {
    let program = both(&format!(
        "{ARM}{signal}\ntask stay = hold(tool)\nstack s {{ level m {{ stay }} }}\nrun {{ stack s  duration 1 s }}"
    ));
    (Controller::new(&program).expect("it can be executed"), program.robot.home.clone())
}

/// Readings at irregular times, one of them lost: the place between is that of the motion, and its numbers and rates
/// belong together.
#[test]
fn a_pose_goes_on_as_it_moves() {
    let (mut controller, q) = standing("signal marker : pose { timeout 0.5 s  velocity estimated  cutoff 100 Hz }");
    let (v, w) = (Vector3::new(0.1, -0.05, 0.02), Vector3::new(0.2, 0.6, -0.3));
    let start = UnitQuaternion::from_euler_angles(0.4, -0.2, 1.0);
    let pose = |time: f64| {
        let (x, q) = (Vector3::new(0.5, 0.1, 0.3) + v * time, UnitQuaternion::from_scaled_axis(w * time) * start);
        [x.x, x.y, x.z, q.w, q.i, q.j, q.k]
    };
    let due = [0.0, 0.098, 0.203, 0.297, 0.501, 0.605, 0.7, 0.93];
    let mut next = 0;
    for k in 0..280 {
        let time = f64::from(k) * 0.005;
        while next < due.len() && due[next] <= time {
            assert!(controller.signals().set(0, &pose(due[next]), due[next]));
            next += 1;
        }
        controller.step(&Observation { time, q: &q });
        let signals = controller.signals();
        assert!(signals.is_present(0));
        if next > 1 {
            let worst = signals.value(0).iter().zip(pose(time)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{time}: {worst}");
            assert!((Vector3::from_column_slice(signals.velocity(0)) - v).norm() < 1e-9);
        }
    }
    // It goes on until it is stale, and no longer.
    for k in 280..300 {
        let time = f64::from(k) * 0.005;
        controller.step(&Observation { time, q: &q });
        assert_eq!(controller.signals().is_present(0), time <= 0.93 + 0.5, "{time}");
    }
}

/// Only the times of arrival are known, and they vary by 10 ms.
#[test]
fn filters_smooth_times_of_arrival_that_vary() {
    let swing = |settings: &str| {
        let text = format!(
            "{ARM}signal marker : point {{ timeout 0.5 s  velocity estimated  {settings} }}
task follow = frame_position(tool) {{ position marker  gain 5 /s }}
stack s {{ {LIMITS}  level m {{ follow }} }}
run {{ stack s  duration 8 s }}"
        );
        let program = both(&text);
        let model = &program.robot.model;
        let (tool, mut data) = (model.link("tool").expect("a tool"), Data::new(model));
        let mut controller = Controller::new(&program).expect("it can be executed");
        let (mut q, mut sent, mut last) = (program.robot.home.clone(), 0, None::<Vector3<f64>>);
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for k in 0..1600 {
            let time = f64::from(k) * 0.005;
            let (measured, late) = (f64::from(sent) * 0.1, 0.01 * f64::from(sent * 7919 % 11) / 10.0);
            if measured + late <= time {
                controller.signals().set(0, &[0.45, -0.4 + 0.1 * measured, 0.4], measured + late);
                sent += 1;
            }
            let velocity = controller.step(&Observation { time, q: &q }).velocity.to_vec();
            model.integrate(&mut q, &velocity, 0.005);
            model.forward(&q, &mut data);
            let now = data.pose(tool).translation.vector;
            if let (Some(before), true) = (last, time > 5.0) {
                let speed = (now - before).norm() / 0.005;
                (least, most) = (least.min(speed), most.max(speed));
            }
            last = Some(now);
        }
        most.max(0.2 - least) / 0.1 - 1.0
    };
    let (plain, held) = (swing(""), swing("between hold"));
    let smooth = swing("cutoff 0.3 Hz  low_pass 0.3 Hz");
    assert!(smooth < 0.03, "{smooth} {plain} {held}");
    assert!(smooth < plain && plain < held, "{smooth} {plain} {held}");
}

#[test]
fn wrong_words_between_readings_are_told() {
    let of = |declared: &str| {
        let text = format!(
            "{ARM}{declared}\ntask stay = hold(tool)\nstack s {{ level m {{ stay }} }}\nrun {{ stack s  duration 1 s }}"
        );
        let folder = common::example("");
        let input = compiler::Input {
            name: "t",
            text: &text,
            syntax: dsl::Syntax::Native,
            folder: &folder,
            set: &[],
            package_paths: &[],
        };
        let all = compiler::compile(&input).report.diagnostics;
        let errors: Vec<_> = all.iter().filter(|d| d.severity == dsl::Severity::Error).collect();
        assert_eq!(errors.len(), 1, "{declared}: {all:?}");
        let at = errors[0].primary.span;
        (errors[0].code, text[at.range()].to_string())
    };
    assert_eq!(of("signal p : point { velocity estimated  between extrapolate }"), ("HQ0206", "extrapolate".into()));
    assert_eq!(of("signal p : point { timeout 1 s  between hold }"), ("HQ0205", "between".into()));
    assert_eq!(of("signal p : pose { timeout 1 s  low_pass 3 Hz }"), ("HQ0205", "low_pass".into()));
    assert_eq!(of("human p { points [chest]  velocity none  between extrapolate }"), ("HQ0205", "between".into()));
    assert_eq!(of("signal e : event\nlet old = age(e) > 1 s"), ("HQ0304", "e".into()));
    assert_eq!(of("let old = age(nobody) > 1 s").0, "HQ0201");
    assert_eq!(of("signal p : point\nlet old = age(p + p) > 1 s"), ("HQ0310", "p + p".into()));
    assert_eq!(of("signal p : point\nlet old = age() > 1 s").0, "HQ0310");
    assert_eq!(of("param k = 3\nlet old = age(k) > 1 s"), ("HQ0304", "k".into()));
}

/// The age in a condition, a task, and expectations, of a signal and of people.
#[test]
fn the_age_of_a_reading_is_a_value() {
    let text = format!(
        "{ARM}signal marker : point? {{ timeout 2 s }}
human p {{ points [chest, hand]  lost hold }}
task stay = track(frame(tool).position.z) {{ target 0.4 m + 0.1 m * min(age(marker), 1 s) / (1 s) }}
stack s {{ {LIMITS}  level m {{ stay }} }}
machine m {{
  initial fresh
  state fresh {{ stack s  when age(marker) > 0.3 s -> old }}
  state old {{ stack s  when age(marker) < 0.1 s -> fresh }}
  on fault(any) -> end
  final state end {{ stack s }}
}}
run {{ machine m  duration 3 s }}
scenario ages {{
  machine m
  duration 3 s
  signals {{ marker {{ value [0.4, 0, 0.4] m  from 0.5 s  to 1 s  period 50 ms }} }}
  humans {{ p {{ points {{ chest {{ value [2, 0, 1] m }}  hand {{ value [2, 0, 1.2] m }} }}  period 100 ms  lost {{ from 1 s  to 1.4 s }} }} }}
  expect \"infinite before the first reading\" to 0.49 s : always age(marker) > 1000 s
  expect \"old at once\" eventually within 0.02 s : in(old)
  expect \"young while it comes\" from 0.51 s to 0.99 s : always age(marker) < 51 ms and age(marker) >= 0 s
  expect \"a number of the clock\" from 1 s to 1.9 s : always age(marker) < time - 0.949 s and age(marker) > time - 0.951 s
  expect \"grows though the signal is absent\" from 2.98 s : always age(marker) > 2 s
  expect \"people too\" from 1.31 s to 1.34 s : always age(p) > 0.4 s and age(p.chest) > 0.4 s and age(p.hand) > 0.4 s
  expect from 1.41 s : always age(p) < 0.11 s
  expect \"the state follows\" from 0.6 s to 1.2 s : always in(fresh)
  expect from 1.3 s : always in(old)
  expect never fault
}}"
    );
    common::holds(&both(&text));
}

/// An age without a bound is infinite at home, which is an error; with one it is a value of a task.
#[test]
fn an_infinite_age_has_no_place_in_a_task() {
    let text = |target: &str| {
        format!(
            "{ARM}signal marker : point? {{ timeout 2 s }}
task stay = track(frame(tool).position.z) {{ target 0.4 m + 0.1 m/s * {target} }}
stack s {{ level m {{ stay }} }}
run {{ stack s  duration 1 s }}"
        )
    };
    let (folder, unbounded) = (common::example(""), text("age(marker)"));
    let syntax = dsl::Syntax::Native;
    let input = compiler::Input { name: "t", text: &unbounded, syntax, folder: &folder, set: &[], package_paths: &[] };
    let found = compiler::compile(&input).report.diagnostics;
    assert!(found.iter().any(|d| d.code == "HQ0502"), "{found:?}");
    let program = both(&text("min(age(marker), 0.3 s)"));
    let q = program.robot.home.clone();
    let mut controller = Controller::new(&program).expect("it can be executed");
    controller.signals().set(0, &[0.1, 0.0, 0.0], 0.25);
    for k in 0..50 {
        let time = 0.25 + f64::from(k) * 0.005;
        assert_eq!(controller.step(&Observation { time, q: &q }).fault, None);
    }
    // A reading that is no number does not count; a signal that is cleared has no readings.
    let age = |c: &mut Controller| c.signals().value(1)[0];
    controller.signals().set(0, &[f64::NAN; 3], 0.5);
    controller.step(&Observation { time: 0.5, q: &q });
    assert!((age(&mut controller) - 0.25).abs() < 1e-12);
    controller.signals().clear(0);
    controller.step(&Observation { time: 0.505, q: &q });
    assert_eq!(age(&mut controller), f64::INFINITY);
}

/// A person with a delay, in front of a robot that starts.
fn with_delay(machine: &str, script: &str, expect: &str) -> Program {
    let run = if machine.is_empty() { "stack s" } else { "machine m" };
    both(&format!(
        "{ARM}human p {{ points [chest]  velocity estimated  lost hold }}
task slow = speed_separation(tip) {{ from p.chest  human measured  reaction 80 ms  deceleration 4 m/s^2  intrusion 8 cm  human_uncertainty uncertainty(p) }}
task go = frame_position(tool) {{ position initial(position) + [0, 0.2, 0] m * sin(pi*t/(4 s)) }}
stack s {{ {LIMITS}  level people hard {{ slow }}  level motion {{ go }} }}
{machine}
run {{ {run}  duration 5 s }}
scenario late {{ {run}  duration 5 s  humans {{ p {{ value [1.5, 0, 0.5] m  {script} }} }}  {expect} }}"
    ))
}

/// Commands, faults and what is waited for.
#[derive(Default)]
struct Seen {
    speeds: Vec<f64>,
    faults: Vec<Option<Fault>>,
    awaited: Vec<bool>,
    errors: Vec<f64>,
}

impl Recorder for Seen {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.speeds.push(tick.command.iter().fold(0.0, |most: f64, v| most.max(v.abs())));
        self.faults.push(tick.fault);
        self.awaited.push(tick.controller.awaited().is_some());
        let member = tick.evaluator.members().iter().find(|m| m.name == "go").expect("it runs");
        self.errors.push(tick.evaluator.measures()[member.measures.start]);
        Ok(())
    }
}

#[test]
fn a_run_waits_for_the_first_readings() {
    let expect = "expect never fault  expect \"it moves\" eventually norm(frame(tool).position - initial(frame(tool).position)) > 15 cm";
    for machine in ["", "machine m { initial a  on fault(any) -> b  state a { stack s }  final state b }"] {
        let program = with_delay(machine, "period 33 ms  delay 40 ms", expect);
        common::holds(&program);
        let mut seen = Seen::default();
        let (summary, _) = common::judged(&program, &program.scenarios[0], &mut seen);
        assert!(summary.ok && summary.faults.is_empty());
        let waited = summary.waited.expect("it is told");
        assert_eq!((waited.signal.as_str(), waited.from_s, waited.ticks), ("p.chest", 0.0, 8));
        assert!(seen.awaited[..8].iter().all(|a| *a) && !seen.awaited[8..].iter().any(|a| *a));
        assert!(seen.speeds[..8].iter().all(|v| *v == 0.0) && seen.speeds[20] > 0.0);
        // Its time begins with its entry: the target is where the robot is then.
        assert!(seen.errors[8].abs() < 1e-9, "{}", seen.errors[8]);
    }
}

#[test]
fn who_is_awaited_for_too_long_is_stale() {
    let program = with_delay("", "from 1 s", "expect eventually fault(stale)");
    let mut seen = Seen::default();
    let (summary, _) = common::judged(&program, &program.scenarios[0], &mut seen);
    // The timeout of a person is 0.2 s.
    let at = seen.faults.iter().position(Option::is_some).expect("a fault");
    assert_eq!(at, 41);
    assert!(matches!(seen.faults[at], Some(Fault::Stale { signal: 0 })));
    assert!(!summary.ok && summary.faults.len() == 1);
    // A machine handles it as any fault, and comes back when the person is there.
    let machine = "machine m { initial a  on fault(stale(p)) -> w  on fault(any) -> b
      state a { stack s }  state w { when present(p) -> a }  final state b }";
    let expect = "expect eventually in(w)  expect from 1.1 s : always in(a)  expect never in(b)";
    common::holds(&with_delay(machine, "from 1 s", expect));
}

/// A signal that may be absent, and one without a timeout, are faults at once, as a task that needs them is.
#[test]
fn what_has_no_time_to_be_late_is_a_fault_at_once() {
    for (declared, awaited) in [("point  timeout 0.1 s", true), ("point?  timeout 0.1 s", false), ("point", false)] {
        let text = format!(
            "{ARM}signal goal : {declared}\ntask go = frame_position(tool) {{ position goal }}\nstack s {{ level m {{ go }} }}\nrun {{ stack s  duration 1 s }}"
        );
        let program = common::program_of(&text);
        let q = program.robot.home.clone();
        let mut controller = Controller::new(&program).expect("it can be executed");
        for _ in 0..2 {
            let fault = controller.step(&Observation { time: 3.0, q: &q }).fault;
            assert_eq!(fault.is_none(), awaited, "{declared}");
            assert_eq!(controller.awaited(), awaited.then_some(0));
            assert_eq!(controller.reference(), q, "monitors see the robot where it is");
            controller.restart();
        }
    }
}

/// A feed override that goes down to zero and up again, in every kind of trajectory of a tool.
#[test]
fn an_override_of_zero_is_a_pause() {
    let tilt = "rpy(0, 90 deg, 0)";
    for (task, target) in [
        ("frame_position(tool)", "position waypoints([0.55, 0.3, 0.4] m, [0.55, -0.3, 0.4] m, speed: 0.3 m/s * override, acceleration: 1 m/s^2)".to_string()),
        ("frame_position(tool)", "position trapezoid([0.55, -0.3, 0.4] m, speed: 0.2 m/s * override, acceleration: 1 m/s^2)".to_string()),
        ("frame_position(tool)", "position s_curve([0.55, -0.3, 0.4] m, speed: 0.2 m/s * override, acceleration: 1 m/s^2, jerk: 10 m/s^3)".to_string()),
        ("track(frame(tool).position.z)", "target trapezoid(0.55 m, speed: 0.06 m/s * override, acceleration: 1 m/s^2)".to_string()),
        ("frame_orientation(tool)", format!("orientation trapezoid({tilt}, speed: 0.2 rad/s * override, acceleration: 2 rad/s^2)")),
    ] {
        let text = format!(
            "{ARM}signal override : number {{ timeout 1 s }}
task move = {task} {{ {target}  gain 20 /s }}
stack s {{ {LIMITS}  level m {{ move }} }}
machine m {{ initial w  on fault(any) -> stopped  state w {{ stack s  on reached(move, 2 mm, 1 deg) -> done }}  final state done {{ stack s }}  final state stopped }}
run {{ machine m  duration 16 s }}
scenario \"down to 0 for two seconds\" {{
  machine m  duration 16 s
  signals {{ override [{{ path [{{ at 0 s  value 1 }}, {{ at 1 s  value 1 }}, {{ at 1.5 s  value 0 }}, {{ at 3.5 s  value 0 }}, {{ at 4 s  value 1 }}] }}] }}
  expect \"it stands\" from 2.2 s to 3.4 s : always speed(tool) < 1 mm/s
  expect \"not there yet\" to 3.4 s : never in(done)
  expect eventually in(done)
  expect never fault
}}"
        );
        let text = if task.starts_with("frame_p") { text } else { text.replace("2 mm, 1 deg", if task.starts_with("track") { "2 mm" } else { "1 deg" }) };
        let text = text.replace("reached(move, 2 mm, 1 deg)", "reached(move, 2 mm)");
        common::holds(&both(&text));
    }
}

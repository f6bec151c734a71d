//! People near the robot: it moves away as fast as they come, lost people cause a fault or are held, and expectations
//! use their true positions.

use crate::common;
use crate::common::least;

use compiler::{Input, compile};
use runtime::program::{Lost, Program, Velocity};
use runtime::{Controller, Fault, Observation, Recorder, SimulatedRobot, Tick};

const ROBOT: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 200 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
task limits = joint_velocity_limits
task stay = hold(tool)
stack work { level limits hard { limits }  level people hard { away }  level motion { stay } }
task away = keep(norm(frame(tool).position - walker.hand)) { min 0.3 m  gain 10 /s }
";

/// A hand that comes from 1.4 m away on the line through the tool, at 0.25 m/s, and stops before the robot runs out of
/// space.
fn coming(human: &str, script: &str) -> Program {
    common::program_of(&format!(
        "{ROBOT}human walker {{ points [hand]  {human} }}
scenario s {{ duration 4.6 s  humans {{ walker {{ path [{{ at 0 s  value [1.7, 0, 0.34] m }}, {{ at 4.4 s  value [0.6, 0, 0.34] m }}]  {script} }} }} }}"
    ))
}

/// True values at each tick: the margin, and the table of signals.
#[derive(Default)]
struct Seen {
    margins: Vec<f64>,
    signals: Vec<Vec<f64>>,
    commands: Vec<Vec<f64>>,
    faults: Vec<Option<Fault>>,
}

impl Recorder for Seen {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let member = tick.evaluator.members().iter().find(|m| m.name == "away");
        self.margins.push(member.map_or(f64::NAN, |m| tick.evaluator.margins()[m.margins.start]));
        self.signals.push(tick.signals.to_vec());
        self.commands.push(tick.command.to_vec());
        self.faults.push(tick.fault);
        Ok(())
    }
}

fn run(program: &Program) -> Seen {
    common::recorded(program)
}

/// The barrier of a moving obstacle includes its velocity. Without it, a person who comes at `v` is `v / gain` inside
/// the limit before the robot is as fast: the steady state of `h' = -gain h - v`.
#[test]
fn the_robot_goes_out_of_the_way_as_fast_as_the_person_comes() {
    let measured = least(&run(&coming("velocity measured", "")).margins);
    assert!(measured > -1e-3, "{measured}");
    let estimated = least(&run(&coming("", "")).margins);
    assert!(estimated > -1e-3, "an estimate of a steady walk is as good: {estimated}");
    let blind = least(&run(&coming("velocity none", "")).margins);
    assert!((blind + 0.25 / 10.0).abs() < 0.002, "{blind} and {}", -0.25 / 10.0);
}

/// A speed beyond `max_speed` is limited: of 0.25 m/s only 0.1 m/s counts.
#[test]
fn a_speed_that_is_not_believed_is_cut() {
    let cut = least(&run(&coming("velocity measured  max_speed 0.1 m/s", "")).margins);
    assert!((cut + 0.15 / 10.0).abs() < 0.002, "{cut}");
}

#[test]
fn a_lost_person_is_a_fault_or_is_held() {
    let lost = run(&coming("timeout 52 ms", "lost { from 1 s  to 2 s }"));
    let at = lost.faults.iter().position(|f| matches!(f, Some(Fault::Stale { signal: 0 }))).expect("it is stale");
    // The last reading arrived at 0.995 s.
    assert_eq!(at, 210, "1.05 s");
    assert!(lost.commands[at..].iter().flatten().all(|v| *v == 0.0), "nobody answers, so the robot stands");
    assert!(lost.margins.iter().all(|h| h.is_finite()), "what is true is known all the same");
    let held = run(&coming("timeout 52 ms  lost hold  growth 0.5 m/s", "lost { from 1 s  to 2 s }"));
    assert!(held.faults.iter().all(Option::is_none));
    let never = run(&coming("lost hold", "from 1 s"));
    // The robot stands and waits for them until the timeout of 0.2 s.
    assert!(never.faults[..41].iter().all(Option::is_none) && never.commands[..41].iter().flatten().all(|v| *v == 0.0));
    assert!(matches!(never.faults[41], Some(Fault::Stale { .. })), "who was never seen is nowhere");
}

/// Noise, loss and delay affect the controller's input, but not the truth.
#[test]
fn recorders_see_where_people_truly_are() {
    let program = coming(
        "velocity measured  lost hold",
        "noise 5 cm  drop 0.3  delay 20 ms  period 40 ms  lost { from 1 s  to 2 s }",
    );
    let s = program.interface.signals[0].clone();
    // The first reading is in transit, and a fault ends the run of the robot, not of the person.
    for (k, table) in run(&program).signals.iter().enumerate() {
        let t = k as f64 * 0.005;
        let x = 1.7 - 0.25 * t.min(4.4);
        assert!((table[s.at + 1] - x).abs() < 1e-9, "{t}: {} and {x}", table[s.at + 1]);
        let speed = if t < 4.4 - 1e-9 { -0.25 } else { 0.0 };
        assert!((table[s.velocity_at()] - speed).abs() < 1e-9, "{t}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_one_others() {
    let world = "noise 1 cm  drop 0.1";
    let (a, b) = (coming("", world), coming("", world));
    let mut c = a.clone();
    c.scenarios[0].run.simulator.seed = 1;
    let bits = |p: &Program| format!("{:?}", run(p).commands);
    assert_eq!(bits(&a), bits(&b));
    assert_ne!(bits(&a), bits(&c));
}

/// The controller's estimate follows its equation, reading by reading, independent of the ticks.
#[test]
fn the_controller_has_the_estimate_of_the_equation() {
    let program = coming("cutoff 3 Hz", "");
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    let q = robot.measure().to_vec();
    let (mut v, mut last) = (0.0, None::<(f64, f64)>);
    for k in 0..400 {
        let time = f64::from(k) * 0.005;
        if k % 3 == 0 {
            let x = 1.5 - 0.2 * (2.0 * time).sin();
            assert!(controller.signals().set(0, &[x, 0.0, 0.6], time));
            if let Some((before, from)) = last {
                let dt: f64 = time - before;
                v += (1.0 - (-2.0 * std::f64::consts::PI * 3.0 * dt).exp()) * ((x - from) / dt - v);
            }
            last = Some((time, x));
        }
        controller.step(&Observation { time, q: &q });
        let seen = controller.signals().velocity(0)[0];
        assert!((seen - v).abs() < 1e-12, "{time}: {seen} and {v}");
    }
    assert!(!controller.signals().set(0, &[0.0; 6], 2.0), "this one is not measured");
}

/// A limit may add `uncertainty`: the required distance grows with it, without a jump when the person is lost.
#[test]
fn a_limit_that_adds_the_uncertainty_keeps_further_away() {
    let text = ROBOT.replace("min 0.3 m", "min 0.3 m + uncertainty(walker)");
    let program = common::program_of(&format!(
        "{text}human walker {{ points [hand]  lost hold  growth 0.4 m/s  timeout 52 ms }}
scenario s {{ duration 1.4 s  humans {{ walker {{ value [0.85, 0, 0.34] m  lost {{ from 0.5 s  to 1 s }} }} }}
  expect always norm(frame(tool).position - walker.hand) > 0.3 m + uncertainty(walker) - 2 mm
  expect eventually uncertainty(walker) > 0.17 m
  expect eventually not present(walker)
  expect always norm(walker.hand.velocity) < 1 mm/s
  expect always from 1.01 s : (present(walker.hand) and uncertainty(walker.hand) < 1 mm) }}"
    ));
    common::holds(&program);
    let margins = run(&program).margins;
    assert!(
        margins.windows(2).all(|w| (w[1] - w[0]).abs() < 0.01 || w[1] > w[0]),
        "only seeing the person again jumps"
    );
}

#[test]
fn what_is_said_of_a_human_stands_in_the_program() {
    let program = common::program("bystander.hq");
    let human = &program.interface.humans[0];
    assert_eq!((human.name.as_str(), &human.points, &human.links), ("walker", &vec![0, 1, 2], &vec![(0, 1), (0, 2)]));
    let names: Vec<&str> = program.interface.signals.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["walker.chest", "walker.left_wrist", "walker.right_wrist"]);
    let motion = program.interface.signals[2].motion.expect("it moves");
    assert_eq!(
        (motion.velocity, motion.lost, motion.max_speed),
        (Velocity::Estimated(5.0), Lost::Hold(0.5), Some(4.0))
    );
    // A recording is embedded: the program runs without the file.
    let recorded = &program.scenarios[1].world.humans[0].tracks;
    assert_eq!((recorded.len(), recorded[0].0.len()), (3, 161));
    let json = serde_json::to_string(&program).expect("plain data");
    assert_eq!(serde_json::from_str::<Program>(&json).expect("the same"), program);
}

/// A modification of a program.
type Damage = fn(&mut Program);

#[test]
fn a_program_that_was_damaged_is_refused() {
    let good = common::program("bystander.hq");
    let damages: [(&str, Damage); 9] = [
        ("a point that is none", |p| p.interface.humans[0].points[1] = 7),
        ("a link beyond", |p| p.interface.humans[0].links[0] = (0, 9)),
        ("no cutoff", |p| {
            p.interface.signals[0].motion.as_mut().expect("it moves").velocity = Velocity::Estimated(0.0)
        }),
        ("shrinking", |p| p.interface.signals[0].motion.as_mut().expect("it moves").lost = Lost::Hold(-1.0)),
        ("for ever", |p| p.interface.signals[0].timeout = None),
        ("overlapping", |p| p.interface.signals[1].at -= 1),
        ("nowhere", |p| p.scenarios[0].world.humans[0].tracks[0].0.clear()),
        ("back in time", |p| p.scenarios[1].world.humans[0].tracks[0].0[1].0 = 0.0),
        ("in two places", |p| {
            let twin = p.scenarios[0].world.humans[0].clone();
            p.scenarios[0].world.humans.push(twin);
        }),
    ];
    assert!(good.check().is_ok());
    for (what, damage) in damages {
        let mut program = good.clone();
        damage(&mut program);
        assert!(program.check().is_err(), "{what}");
    }
}

/// A recording that is far too long is rejected at once, with its place in the spec.
#[test]
fn a_recording_that_is_too_long_is_refused() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("humans");
    std::fs::create_dir_all(folder.join("robots")).expect("a folder");
    std::fs::copy(common::example("robots/arm7.urdf"), folder.join("robots/arm7.urdf")).expect("a URDF");
    let mut text = "time,hand.x,hand.y,hand.z\n".to_string();
    for k in 0..100_002 {
        text.push_str(&format!("{k},1,1,1\n"));
    }
    std::fs::write(folder.join("long.csv"), text).expect("a file");
    let gentle = ROBOT.replace("hard { limits }", "hard { limits  joint_acceleration_limits }");
    let text = format!(
        "{gentle}human walker {{ points [hand] }}\nscenario s {{ humans {{ walker {{ file \"long.csv\" }} }} }}"
    );
    let syntax = dsl::Syntax::Native;
    let compiled = compile(&Input { name: "s", text: &text, syntax, folder: &folder, set: &[], package_paths: &[] });
    let d = &compiled.report.diagnostics;
    assert_eq!((d.len(), d[0].code), (1, "HQ0805"), "{d:?}");
    assert!(d[0].message.contains("more than 100000 lines"), "{}", d[0].message);
    assert_eq!(compiled.report.sources.line_column(d[0].primary.span.source, d[0].primary.span.start).0, 100_002);
    assert!(
        compiler::files(&Input { name: "s", text: &text, syntax, folder: &folder, set: &[], package_paths: &[] })
            .contains(&folder.join("long.csv"))
    );
}

/// Testing `present` of a held person does not replace knowing the position.
#[test]
fn who_asks_whether_a_held_person_is_seen_still_needs_them() {
    let text = ROBOT.replace("min 0.3 m", "min if(present(walker), 0.3 m, 0.35 m)");
    let program = common::program_of(&format!("{text}human walker {{ points [hand]  lost hold }}"));
    let mut controller = Controller::new(&program).expect("it can be executed");
    let q = program.robot.home.clone();
    for k in 0..41 {
        assert_eq!(controller.step(&Observation { time: f64::from(k) * 0.005, q: &q }).fault, None);
        assert_eq!(controller.awaited(), Some(0));
    }
    assert!(matches!(controller.step(&Observation { time: 0.205, q: &q }).fault, Some(Fault::Stale { signal: 0 })));
    let mut controller = Controller::new(&program).expect("it can be executed");
    controller.signals().set(0, &[1.0, 0.0, 0.3], 0.0);
    for k in 0..200 {
        let time = f64::from(k) * 0.005;
        assert_eq!(controller.step(&Observation { time, q: &q }).fault, None, "{time}");
        assert_eq!(controller.signals().is_present(0), time <= 0.2, "{time}");
    }
}

/// The distance to a point of a person equals the `norm` of the difference, and so does its row: the same commands.
#[test]
fn a_distance_to_a_point_is_that_of_two_positions() {
    let by_norm = coming("velocity measured", "");
    let text = ROBOT
        .replace("home {", "points { tip tool }  home {")
        .replace("norm(frame(tool).position - walker.hand)", "distance(tip, walker)");
    let by_distance = common::program_of(&format!(
        "{text}human walker {{ points [hand]  velocity measured }}
scenario s {{ duration 4.6 s  humans {{ walker {{ path [{{ at 0 s  value [1.7, 0, 0.34] m }}, {{ at 4.4 s  value [0.6, 0, 0.34] m }}] }} }} }}"
    ));
    let (a, b) = (run(&by_norm), run(&by_distance));
    let apart = a.commands.iter().flatten().zip(b.commands.iter().flatten()).map(|(x, y)| (x - y).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-9);
}

/// A fixed pedestal is always nearest and cannot move away: it does not weaken the limit of the moving parts.
#[test]
fn a_part_that_stands_does_not_hide_those_that_move() {
    let of = |parts: &str| {
        let program = common::program_of(
            &format!(
                "{ROBOT}human walker {{ points [hand, foot]  velocity measured }}
scenario s {{ duration 4.6 s  humans {{ walker {{ points {{
  hand {{ path [{{ at 0 s  value [1.7, 0, 0.34] m }}, {{ at 4.4 s  value [0.6, 0, 0.34] m }}] }}
  foot {{ value [0, 0.25, 0.05] m }} }} }} }} }}"
            )
            .replace("home {", "points { tip tool }  home {")
            .replace("norm(frame(tool).position - walker.hand)", &format!("distance({parts}, walker)")),
        );
        let seen = run(&program);
        assert!(seen.faults.iter().all(Option::is_none), "{parts}");
        seen
    };
    let (alone, beside) = (of("tip"), of("[base_link, tip]"));
    assert!(least(&alone.margins).abs() < 1e-3, "the limit acts: {}", least(&alone.margins));
    assert_eq!(alone.commands, beside.commands);
    assert_eq!(alone.margins, beside.margins);
}

/// A forearm sweeps towards the tool, nearest at a point between wrist and elbow: the velocity of that point counts.
/// Without the velocities of its ends, the distance drops by the speed over the gain.
#[test]
fn a_segment_of_a_person_is_kept_away_as_fast_as_it_comes() {
    let least_of = |velocity: &str| {
        let program = common::program_of(&format!(
            "{ROBOT}human walker {{ points [hand, elbow]  links [[hand, elbow]]  velocity {velocity} }}
scenario s {{ duration 4.6 s  humans {{ walker {{ path [{{ at 0 s  value [1.7, 0, 0.34] m }}, {{ at 4.4 s  value [0.6, 0, 0.34] m }}]
  shape {{ hand [0, 0.1, 0.1] m  elbow [0, -0.2, -0.2] m }} }} }} }}"
        )
        .replace("home {", "points { tip tool }  home {")
        .replace("norm(frame(tool).position - walker.hand)", "distance(tip, walker)"));
        let seen = run(&program);
        assert!(seen.faults.iter().all(Option::is_none));
        least(&seen.margins)
    };
    let measured = least_of("measured");
    assert!(measured > -1e-3, "{measured}");
    let blind = least_of("none");
    assert!((blind + 0.25 / 10.0).abs() < 0.002, "{blind}");
}

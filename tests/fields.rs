//! Safety fields: the value is the mean of the distances, a limit on it is kept for all sources of measurements, and
//! both syntaxes have the same meaning.

use crate::common;
use crate::common::{holds, least};

use compiler::{Input, compile};
use runtime::program::Program;
use runtime::{Recorder, Tick};
use std::path::Path;
use stdlib_tasks::field::{DistanceProgram, Over};

const ROBOT: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 200 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
human walker { points [chest, hand]  velocity measured }
task limits = joint_velocity_limits
task places = joint_position_limits
task stay = hold(tool)
stack work { level limits hard { limits  places }  level people { apart }  level motion damping none { stay } }
";

/// A person who comes near, stops and leaves.
fn coming(field: &str, least: &str) -> Program {
    common::program_of(&format!(
        "{ROBOT}safety_field nearness {{ of walker  {field} }}
task apart = keep(field(nearness)) {{ min {least}  gain 10 /s }}
scenario s {{ duration 6 s
  humans {{ walker {{
    path [{{ at 0 s  value [1.6, 0.2, 0] m }}, {{ at 3 s  value [0.7, 0, 0] m }}, {{ at 4 s  value [0.7, 0, 0] m }}, {{ at 6 s  value [1.6, 0.2, 0] m }}]
    shape {{ chest [0, 0, 1] m  hand [-0.1, 0.2, 0.7] m }}
  }} }}
  expect always field(nearness) > 0.1 m
}}"
    ))
}

/// Values of the field at each tick, in the task and in the expectation.
#[derive(Default)]
struct Seen {
    margins: Vec<f64>,
    places: Vec<Vec<f64>>,
    q: Vec<Vec<f64>>,
}

impl Recorder for Seen {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let member = tick.evaluator.members().iter().find(|m| m.name == "apart").expect("it runs");
        self.margins.push(tick.evaluator.margins()[member.margins.start]);
        self.places.push(tick.signals.to_vec());
        self.q.push(tick.q.to_vec());
        assert!(tick.fault.is_none(), "{:?}", tick.fault);
        Ok(())
    }
}

fn run(program: &Program) -> Seen {
    common::recorded(program)
}

/// Bound on the drop of the field below its minimum between two ticks, from the speeds of the joints, of the links'
/// origins and of the person.
fn sampled_loss(program: &Program, seen: &Seen) -> f64 {
    let model = &program.robot.model;
    let mut speed = vec![0.0_f64; model.nv()];
    let (mut data, mut before, mut fastest) = (robot::Data::new(model), robot::Data::new(model), 0.0_f64);
    for pair in seen.q.windows(2) {
        speed.iter_mut().zip(&pair[0]).zip(&pair[1]).for_each(|((s, a), b)| *s = s.max((b - a).abs() / 0.005));
        model.forward(&pair[0], &mut before);
        model.forward(&pair[1], &mut data);
        let links = (0..model.links.len() as u32).map(robot::LinkId);
        fastest = links.fold(fastest, |f, l| f.max((data.position(l) - before.position(l)).norm() / 0.005));
    }
    let walks = f64::hypot(0.9, 0.2) / 2.0;
    let field = program.fields[0].field(model).expect("it can be built");
    stdlib_tasks::clearance::loss(field.curvature_bound(model, &speed, fastest + walks), 0.005, 10.0)
}

#[test]
fn the_field_is_kept_while_a_person_comes_and_goes() {
    for (field, min) in [
        ("", "0.8 m"),
        ("points soft_minimum(10 /m)", "0.65 m"),
        ("distance saturating(1.5 m)  points soft_minimum(10 /m)", "0.45 m"),
        ("distance saturating(1 m)", "0.5 m"),
    ] {
        let program = coming(field, min);
        let seen = run(&program);
        let (least, loss) = (least(&seen.margins), sampled_loss(&program, &seen));
        assert!(least > -loss && least < 0.02, "`{field}`: {least}, and {loss} may be lost");
    }
}

/// By brute force: the mean of the distance at many points of the segments between the joints.
#[test]
fn the_number_is_the_mean_of_the_distances() {
    let program = coming("", "0.8 m");
    let seen = run(&program);
    let model = &program.robot.model;
    let field = &program.fields[0];
    let names: Vec<&str> = field.links.iter().map(|l| model.link_ref(*l).name.as_str()).collect();
    assert_eq!(names, ["link_1", "link_2", "link_3", "link_4", "link_5", "link_6", "link_7"], "those that joints move");
    let mut data = robot::Data::new(model);
    for k in (0..seen.q.len()).step_by(97) {
        model.forward(&seen.q[k], &mut data);
        let mut sum = 0.0;
        for link in &field.links {
            let ends: Vec<_> =
                model.joints.iter().filter(|j| j.parent == *link).map(|j| *data.position(j.child)).collect();
            let start = *data.position(*link);
            let ends = if ends.is_empty() { vec![start] } else { ends };
            for signal in &program.interface.signals {
                let at = signal.at + 1;
                let p = nalgebra::Vector3::from_column_slice(&seen.places[k][at..at + 3]);
                for end in &ends {
                    let n = 4000;
                    let mean =
                        (0..n).map(|i| (start + (end - start) * ((f64::from(i) + 0.5) / f64::from(n)) - p).norm());
                    sum += mean.sum::<f64>() / f64::from(n) / ends.len() as f64;
                }
            }
        }
        let expected = sum / (field.links.len() * program.interface.signals.len()) as f64 - 0.8;
        assert!((seen.margins[k] - expected).abs() < 1e-6, "{} {expected}", seen.margins[k]);
    }
}

#[test]
fn one_s_own_function_is_the_built_in_one() {
    let built_in = run(&coming("distance saturating(1 m)", "0.5 m")).margins;
    let own = run(&coming("distance 1 m * (1 - exp(-d/(1 m)))", "0.5 m")).margins;
    assert!(built_in.iter().zip(&own).all(|(a, b)| (a - b).abs() < 1e-9));
    let program = coming("distance min(2 m, d)  points minimum", "0.5 m");
    assert_eq!((&program.fields[0].distance, program.fields[0].over), (&DistanceProgram::Clamped(2.0), Over::Least));
    assert_eq!(coming("distance d", "0.5 m").fields[0].distance, DistanceProgram::Identity);
}

#[test]
fn links_arms_and_parts_name_links() {
    let program = common::program_of(
        "hierarq 1
robot canopies { urdf \"robots/canopies.urdf\"  base unicycle  rate 100 Hz
  arms { left { shoulder arm_left_1_link  tip left_tool }  right { shoulder arm_right_1_link  tip right_tool } }
  points { nose { link head_link  offset [0.1, 0, 0] m } }
}
safety_field all { of [3, 0, 1] m }
safety_field arms_alone { of [3, 0, 1] m  links [arms.left, right] }
safety_field part { of [3, 0, 1] m  links [nose, arm_left_3_link] }
task a = keep(field(all)) { min 0.1 m }
task b = keep(field(arms_alone)) { min 0.1 m }
task c = keep(field(part)) { min 0.1 m }
stack s { level people { a  b  c } }",
    );
    let names = |i: usize| -> Vec<&str> {
        program.fields[i].links.iter().map(|l| program.robot.model.link_ref(*l).name.as_str()).collect()
    };
    assert_eq!(program.fields.len(), 3);
    assert!(names(0).len() > names(1).len() && names(0).contains(&"arm_left_7_link"));
    let arms = names(1);
    assert_eq!(arms.iter().filter(|n| n.starts_with("arm_left")).count(), 7);
    assert_eq!(arms.iter().filter(|n| n.starts_with("arm_right")).count(), 7);
    assert_eq!(arms.len(), 14);
    assert_eq!(names(2), ["head_link", "arm_left_3_link"]);
}

#[test]
fn a_program_is_data_and_a_damaged_one_is_refused() {
    let good = coming("distance 1 m * (1 - exp(-d/(1 m)))", "0.5 m");
    assert!(good.check().is_ok());
    let json = serde_json::to_string(&good).expect("plain data");
    assert_eq!(serde_json::from_str::<Program>(&json).expect("the same"), good);
    let damages: [fn(&mut Program); 4] = [
        |p| p.fields[0].points[0][1] = usize::MAX,
        |p| p.fields[0].links.push(robot::LinkId(900)),
        |p| p.fields[0].points.clear(),
        |p| p.fields[0].distance = DistanceProgram::Saturating(-1.0),
    ];
    for (i, damage) in damages.into_iter().enumerate() {
        let mut bad = good.clone();
        damage(&mut bad);
        assert!(bad.check().is_err(), "{i}");
    }
}

#[test]
fn a_person_whom_nobody_sees_is_a_fault() {
    let program = common::program_of(&format!(
        "{ROBOT}safety_field nearness {{ of walker }}
task apart = keep(field(nearness)) {{ min 0.5 m }}
scenario s {{ duration 1 s
  humans {{ walker {{ value [1, 0, 0] m  shape {{ chest [0, 0, 1] m  hand [0, 0.2, 0.7] m }}  lost {{ from 0.3 s  to 0.8 s }} }} }}
  expect eventually fault(stale)
}}"
    ));
    holds(&program);
}

#[test]
fn separation_slows_the_tool_and_the_person_who_comes_is_never_met_at_speed() {
    let program = common::program_of(
        "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 200 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }  points { tip tool } }
human walker { points [hand] }
task limits = joint_velocity_limits
task places = joint_position_limits
task go = frame_position(tool) { position [0.75, 0, 0.5] m  gain 5 /s }
task slow = speed_separation(tip) { from walker.hand  human measured  reaction 50 ms  deceleration 3 m/s^2  intrusion 0.1 m }
stack work { level limits hard { limits  slow }  level motion { go } }
scenario s { duration 4 s
  humans { walker { path [{ at 0 s  value [1.6, 0, 0.5] m }, { at 3 s  value [1, 0, 0.5] m }]  shape { hand [0, 0, 0] m } } }
  expect always margin(slow) > -1 mm
  expect always norm(frame(tool).position - walker.hand) > 0.1 m
  expect always ((speed(tool) < 1 cm/s) or (norm(frame(tool).position - walker.hand) > 0.1 m + 0.2 m/s * 55 ms))
  expect never fault
}",
    );
    holds(&program);
}

#[test]
fn both_syntaxes_say_the_same() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let read = |name: &str, syntax| {
        let text = std::fs::read_to_string(folder.join(name)).expect("an example");
        let input = Input { name: "nearness", text: &text, syntax, folder: &folder, set: &[], package_paths: &[] };
        compile(&input).program.expect("it compiles")
    };
    assert_eq!(read("nearness.hq", dsl::Syntax::Native), read("nearness.yaml", dsl::Syntax::Yaml));
}

/// A monitoring task does not restrict the robot's speed until the distance of the standard is reached; the machine
/// then stops it. With the specified deceleration the robot stops before a person with the specified speed arrives.
#[test]
fn what_only_watches_stops_in_time_and_not_before() {
    let program = common::program_of(
        "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 200 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }  points { tip tool } }
human walker { points [hand]  velocity measured }
task limits = joint_velocity_limits
task places = joint_position_limits
task go = frame_position(tool) { position initial(position) + [0.3, 0, 0] m * smoothstep((t - 0.5 s)/(1.5 s))  gain 5 /s }
task still = joint_velocity { velocity { all 0 rad/s } }
task separation = speed_separation(tip) {
  method watch  from walker.hand  human_speed 0.5 m/s  reaction 20 ms  stopping 0.3 s  intrusion 0.1 m
}
stack standing { level limits hard { limits  separation }  level motion { still } }
stack work from standing { replace motion { go } }
machine m {
  initial moving
  on fault(any) -> failed
  state moving { stack work  when separation.distance < separation.required -> stop blend 0.25 s }
  state stop { stack standing  when separation.room > 0.2 m for 0.2 s -> moving blend 0 s }
  final state failed
}
scenario s { machine m  duration 3 s
  humans { walker { path [{ at 0 s  value [1.7, 0, 0.34] m }, { at 2 s  value [0.7, 0, 0.34] m }]  shape { hand [0, 0, 0] m } } }
  expect \"at full speed\" eventually (in(moving) and speed(tool) > 0.15 m/s and separation.distance > separation.required - 5 mm)
  expect \"it tells no more than there is\" always (separation.distance - norm(frame(tool).position - walker.hand) < 1 mm)
  expect \"it is stopped\" eventually in(stop)
  expect \"and stands in time\" always (speed(tool) < 1 mm/s or norm(frame(tool).position - walker.hand) > 0.1 m)
  expect never fault
}",
    );
    holds(&program);
}

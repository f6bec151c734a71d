//! Specs with imports, parameters and repetitions compile to the same program as specs without them.

use crate::common;

use common::examples;
use dsl::Syntax;
use hierarq_compiler::{Compiled, Input, Style, compile};
use proptest::prelude::*;
use runtime::program::{Program, Times};
use std::path::{Path, PathBuf};

const ROBOT: &str = r#"
robot arm {
  urdf "ROBOTS/arm7.urdf"
  rate 100 Hz
  arms { only { shoulder link_2  elbow link_4  wrist link_6  tip tool  points [elbow, wrist] } }
  points { elbow link_4  wrist link_6 }
  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }
}
"#;

/// Creates a folder with these files and the robot's URDF.
fn folder(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reuse").join(name);
    let urdf = std::fs::read_to_string(examples().join("robots/arm7.urdf")).expect("a URDF");
    for (file, text) in files.iter().copied().chain([("robots/arm7.urdf", urdf.as_str())]) {
        let path = folder.join(file);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text.replace("ROBOTS", "../robots")).expect("a file");
    }
    folder
}

fn compiled(text: &str, syntax: Syntax, folder: &Path, set: &[(String, String)]) -> Compiled {
    let text = text.replace("ROBOTS", "robots");
    compile(&Input { name: "spec", text: &text, syntax, folder, set, package_paths: &[] })
}

/// Program of a spec without mistakes.
fn program(text: &str, folder: &Path) -> Program {
    let c = compiled(text, Syntax::Native, folder, &[]);
    assert!(c.report.diagnostics.is_empty(), "{text}\n{}", c.report.render(Style::Plain, 100));
    c.program.expect("no error, so a program")
}

/// The program without the names of its tasks and robot.
fn nameless(mut p: Program) -> Program {
    for (i, t) in p.tasks.iter_mut().enumerate() {
        t.name = format!("{i}");
    }
    p.robot.name = String::new();
    // The layout of the tape is irrelevant; its results are compared.
    let v = &mut p.values;
    for t in [0.0, 0.7, 3.1] {
        let inputs: Vec<f64> = (0..v.tape.inputs).map(|i| 0.1 * i as f64).collect();
        let (mut values, mut rates) = (v.initial.clone(), vec![0.0; v.initial.len()]);
        let mut registers = vec![0.0; v.tape.ops.len()];
        v.tape.evaluate(Times { t, time: t }, &inputs, &[], &mut registers, &mut values, &mut rates);
        v.initial.extend(values.into_iter().chain(rates));
    }
    v.tape.ops.clear();
    v.tape.outputs.clear();
    p
}

/// Both texts, with the robot added, compile to the same program; so does the first one after a translation to YAML.
fn same(name: &str, files: &[(&str, &str)], short: &str, long: &str) {
    let folder = folder(name, files);
    let robot = if short.contains("robot") { "" } else { ROBOT };
    let short = format!("hierarq 1\n{robot}{short}");
    let expected = nameless(program(&format!("hierarq 1\n{ROBOT}{long}"), &folder));
    let found = program(&short, &folder);
    assert_eq!(nameless(found.clone()), expected, "{name}");
    let (tree, _) = dsl::parse(dsl::SourceId(0), &short.replace("ROBOTS", "robots"), Syntax::Native);
    let yaml = dsl::print(&tree, Syntax::Yaml);
    let c = compiled(&yaml, Syntax::Yaml, &folder, &[]);
    assert_eq!(c.program.as_ref(), Some(&found), "{yaml}\n{}", c.report.render(Style::Plain, 100));
}

#[test]
fn a_file_keeps_its_names_to_itself() {
    // Both files declare `gap` and `speed`, and a link of the robot has the name of a param of the library.
    let library = "hierarq 1\nimport \"more.yaml\" { speed as pace }\nparam gap = 0.25 m\nparam tool = 1 /s\nlet speed = 2*pace\n\
        task deck = virtual_wall(elbow) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m  d_min gap  gain tool }\n\
        task limits = joint_velocity_limits { max speed }\ntask reach = hold(tool) { gain tool }\n\
        stack safe { level limits { limits }  level deck { deck } }\n";
    let more = "hierarq: 1\nparams: { speed: { value: 0.2 rad/s, max: 1 rad/s }, unused: 1 }\n";
    same(
        "hygiene",
        &[("lib/library.hq", library), ("lib/more.yaml", more)],
        "import \"lib/library.hq\" { deck as table, limits, reach }\nparam gap = 0.1 m\n\
         task wall = virtual_wall(wrist) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m  d_min gap }\n\
         stack s { level a { limits }  level b { table  wall }  level c { reach } }\n",
        "param gap = 0.1 m\ntask table = virtual_wall(elbow) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m  d_min 0.25 m  gain 1 /s }\n\
         task limits = joint_velocity_limits { max 0.4 rad/s }\ntask reach = hold(tool) { gain 1 /s }\n\
         task wall = virtual_wall(wrist) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m  d_min gap }\n\
         stack s { level a { limits }  level b { table  wall }  level c { reach } }\n",
    );
}

#[test]
fn an_imported_stack_and_robot() {
    let library = format!(
        "hierarq 1\n{ROBOT}\nparam speed = 1 rad/s {{ min 0 rad/s }}\ntask limits = joint_velocity_limits {{ max speed }}\n\
         stack safe {{ level limits hard {{ limits }} }}\n"
    );
    let files = [("lib/library.hq", library.as_str())];
    let short = "import \"lib/library.hq\" { arm, safe, speed }\nrobot quick from arm { rate 200 Hz }\n\
        stack s from safe { add motion { hold(tool) } }\nrun { stack s }\n";
    let folder = folder("imported", &files);
    let p = program(&format!("hierarq 1\n{short}"), &folder);
    assert_eq!((p.robot.name.as_str(), p.robot.urdf.as_str(), p.robot.period), ("quick", "robots/arm7.urdf", 0.005));
    assert_eq!(p.stacks.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["safe", "s"]);
    let set = [("speed".to_string(), "0.5 rad/s".to_string())];
    let changed = compiled(&format!("hierarq 1\n{short}"), Syntax::Native, &folder, &set).program.expect("a program");
    assert_ne!(changed, p);
    let set = [("speed".to_string(), "-0.5 rad/s".to_string())];
    let refused = compiled(&format!("hierarq 1\n{short}"), Syntax::Native, &folder, &set);
    assert_eq!(refused.report.diagnostics.iter().map(|d| d.code).collect::<Vec<_>>(), ["HQ0315"]);
}

#[test]
fn parameters_of_every_type() {
    same(
        "types",
        &[],
        "task a(side: arm, at: frame, what: geometry, name: name) = virtual_wall(what) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m }\n\
         task turn(side: arm, angle: angle, gain: rate = 2 /s) = swivel_angle { angle { ${side} angle } gain gain }\n\
         task near(at: frame, goal: point, by: length = 0.01 m, wait: duration = 2 s) = frame_position(at) { position goal + [by, 0, 0]*(t/wait) }\n\
         task aim(at: frame, to: orientation) = frame_orientation(at) { orientation to }\n\
         task slow(which: joints, v: angular_speed, share: number = 0.5) = joint_velocity_limits { joints which  max share*v }\n\
         stack base(extra: task, name: name, w: number) { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level ${name}_limits { slow([joint_1, joint_2], v: 1 rad/s) }  level b { extra weight w } }\n\
         stack s from base(near(tool, [0.5, 0, 0.5] m), first, 2) {\n\
           add walls { a(only, tool, [elbow, wrist], x) } before first_limits\n\
           add c { turn(only, 10 deg) } before b\n add d { aim(link_6, rpy(0, 0, 0.1 rad)) } before c }\n",
        "task near = frame_position(tool) { position [0.5, 0, 0.5] m + [0.01 m, 0, 0]*(t/(2 s)) }\n\
         task slow = joint_velocity_limits { joints [joint_1, joint_2]  max 0.5 rad/s }\n\
         task a = virtual_wall(elbow, wrist) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m }\n\
         task turn = swivel_angle { angle { only 10 deg } gain 2 /s }\n\
         task aim = frame_orientation(link_6) { orientation rpy(0, 0, 0.1 rad) }\n\
         stack s { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level walls { a }  level first_limits { slow }  level d { aim }  level c { turn }  level b { near weight 2 } }\n",
    );
}

#[test]
fn repetition_in_all_places() {
    same(
        "repetition",
        &[],
        "for link in [link_6, tool] {\n  param speed_${link} = 0.01 m/s\n  let goal_${link} = [0.5 m, speed_${link}*t, 0.5 m]\n\
           \x20 task go_${link} = frame_position(${link}) { position goal_${link} }\n  for i in 1..2 {\n\
             \x20   stack s_${link}_${i} { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level a { go_${link}  for j in [i, 3] { joint_velocity { velocity { joint_${j} 0.01*j rad/s } } } } }\n  }\n}\n\
         run { stack s_tool_2 }\n"
            .replace("0.01*j rad/s", "j*(0.01 rad/s)")
            .as_str(),
        "param a = 0.01 m/s\nparam b = 0.01 m/s\n\
         task go_a = frame_position(link_6) { position [0.5 m, a*t, 0.5 m] }\ntask go_b = frame_position(tool) { position [0.5 m, b*t, 0.5 m] }\n\
         stack s_link_6_1 { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level a { go_a  joint_velocity { velocity { joint_1 1*(0.01 rad/s) } }  joint_velocity { velocity { joint_3 3*(0.01 rad/s) } } } }\n\
         stack s_link_6_2 { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level a { go_a  joint_velocity { velocity { joint_2 2*(0.01 rad/s) } }  joint_velocity { velocity { joint_3 3*(0.01 rad/s) } } } }\n\
         stack s_tool_1 { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level a { go_b  joint_velocity { velocity { joint_1 1*(0.01 rad/s) } }  joint_velocity { velocity { joint_3 3*(0.01 rad/s) } } } }\n\
         stack s_tool_2 { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level a { go_b  joint_velocity { velocity { joint_2 2*(0.01 rad/s) } }  joint_velocity { velocity { joint_3 3*(0.01 rad/s) } } } }\n\
         run { stack s_tool_2 }\n",
    );
}

#[test]
fn equal_uses_share_a_task() {
    let folder = folder("shared", &[]);
    let p = program(
        &format!(
            "hierarq 1\n{ROBOT}\ntask near(at: frame, by: length = 0.1 m) = frame_position(at) {{ position [0.5, 0, 0.5] m + [by, 0, 0] }}\n\
             stack a {{ level gentle hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}  level l {{ near(tool) }} }}\nstack b {{ level gentle hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}  level l {{ near(tool, by: 0.1 m)  near(tool, by: 0.2 m) weight 2 }} }}\nstack c {{ level gentle hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}  level l {{ near(link_6) }} }}\nrun {{ stack a }}\n"
        ),
        &folder,
    );
    let names: Vec<&str> = p.tasks.iter().filter(|t| t.kind == "frame_position").map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["near.tool", "near.tool.2", "near.link_6"]);
}

/// Values that use each other, in any order, are evaluated as in the right order.
fn values() -> impl Strategy<Value = (Vec<(usize, Vec<usize>)>, Vec<usize>)> {
    (2usize..9).prop_flat_map(|n| {
        let uses = (0..n).map(|i| (Just(i), proptest::collection::vec(0..i.max(1), 0..3))).collect::<Vec<_>>();
        (uses, Just((0..n).collect::<Vec<_>>()).prop_shuffle())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn the_order_of_values_does_not_matter((uses, order) in values()) {
        let folder = folder("order", &[]);
        let line = |i: usize, by_let: bool| {
            let (_, of) = &uses[i];
            let sum: String = of.iter().filter(|k| **k < i).map(|k| format!(" + v{k}")).collect();
            format!("{} v{i} = {}.5{sum}\n", if by_let && i % 2 == 1 { "let" } else { "param" }, i + 1)
        };
        let last = uses.len() - 1;
        let all: String = (0..last).map(|i| format!(" + v{i}")).collect();
        let task = format!("task a = joint_velocity {{ velocity (v{last}{all}) * (0.0001 rad/s) }}\nstack s {{ level gentle hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}  level l {{ a }} }}\n");
        let sorted: String = (0..=last).map(|i| line(i, false)).collect();
        let shuffled: String = order.iter().map(|i| line(*i, true)).collect();
        let expected = program(&format!("hierarq 1\n{ROBOT}{sorted}{task}"), &folder);
        let found = program(&format!("hierarq 1\n{ROBOT}{task}{shuffled}"), &folder);
        prop_assert_eq!(found, expected, "{}", shuffled);
    }

    /// A chain of derived stacks has the levels of a list to which the same changes are applied.
    #[test]
    fn changes_are_those_of_a_list(changes in proptest::collection::vec((0..4usize, 0..6usize, 0..6usize), 0..6)) {
        let folder = folder("changes", &[]);
        let level = |name: &str, speed: usize| format!("{name} {{ joint_velocity {{ velocity {speed}*(0.01 rad/s) }} }}");
        let mut list: Vec<(String, usize)> = vec![("l0".into(), 1), ("l1".into(), 2), ("l2".into(), 3)];
        let mut text = format!("hierarq 1\n{ROBOT}stack s0 {{ {} }}\n", list.iter().map(|(n, s)| format!("level {}\n", level(n, *s))).collect::<String>());
        let mut made = 0;
        for (k, (what, at, speed)) in changes.iter().enumerate() {
            let at = at % list.len();
            let name = list[at].0.clone();
            let change = match what {
                0 => { list[at].1 = *speed; format!("replace {}", level(&name, *speed)) }
                1 if list.len() > 1 => { list.remove(at); format!("remove {name}") }
                2 => { list.insert(at, (format!("n{k}"), *speed)); format!("add {} before {name}", level(&format!("n{k}"), *speed)) }
                3 => { list.insert(at + 1, (format!("n{k}"), *speed)); format!("add {} after {name}", level(&format!("n{k}"), *speed)) }
                _ => continue,
            };
            text.push_str(&format!("stack s{} from s{made} {{ {change} }}\n", made + 1));
            made += 1;
        }
        text.push_str(&format!("run {{ stack s{made} }}\n"));
        let p = compiled(&text, Syntax::Native, &folder, &[]).program.expect("a program");
        let found: Vec<&str> = p.stacks[made].levels.iter().map(|l| l.name.as_str()).collect();
        let expected: Vec<&str> = list.iter().map(|(n, _)| n.as_str()).collect();
        prop_assert_eq!(found, expected, "{}", text);
    }
}

/// Exponential growth of any kind is rejected soon.
#[test]
fn bombs_are_refused_quickly() {
    let folder = folder("bombs", &[]);
    let chain = |n: usize, line: &dyn Fn(usize) -> String| (0..n).map(line).collect::<String>();
    let nested = chain(60, &|i| format!("task a{i}(x: rate) = a{}(x + x)\n", i + 1));
    let stacks = chain(5000, &|i| format!("stack s{i} from s{} {{ }}\n", i + 1));
    let lets = chain(20_000, &|i| format!("let v{i} = v{} + v{}\n", i + 1, i + 1));
    let tasks = chain(5000, &|i| format!("task a{i}(x: rate) = a{}(x)\n", i + 1));
    let loops = "stack s { level l { ".to_string() + &"for i in 1..50 { ".repeat(40) + "hold(tool)" + &" }".repeat(42);
    let texts = [
        format!("{nested}task a60(x: rate) = hold(tool) {{ gain x }}\nstack s {{ level l {{ a0(1 /s) }} }}\n"),
        format!("{stacks}stack s5000 {{ level l {{ hold(tool) }} }}\nrun {{ stack s0 }}\n"),
        format!("{lets}let v20000 = 1 /s\nstack s {{ level l {{ hold(tool) {{ gain v0 }} }} }}\n"),
        format!("{tasks}task a5000(x: rate) = hold(tool) {{ gain x }}\nstack s {{ level l {{ a0(1 /s) }} }}\n"),
        loops,
    ];
    for text in texts {
        let start = std::time::Instant::now();
        let c = compiled(&format!("hierarq 1\n{ROBOT}{text}"), Syntax::Native, &folder, &[]);
        let codes: Vec<&str> = c.report.diagnostics.iter().map(|d| d.code).collect();
        let limit = if cfg!(debug_assertions) { 20 } else { 3 };
        assert!(start.elapsed().as_secs() < limit, "{:?}: {:?}", start.elapsed(), &text[..60.min(text.len())]);
        assert!(!codes.is_empty(), "{}", &text[..60.min(text.len())]);
    }
}

/// Outputs of a task are read by its name in the file, whatever its name in the program.
#[test]
fn what_tasks_tell_has_the_name_of_its_file() {
    let library = r#"hierarq 1
human walker { points [chest] }
safety_field nearness { of walker }
task reach = frame_position(tool) { position initial(position) + [0, 0.1, 0] m * sin(t/(1 s)) }
task guard = safety_planner(reach) { field nearness  min 0.5 m }
let slowness = 1 - guard.scaling
stack work { level gentle hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits }  level motion { reach }  level internal { guard } }
machine m {
  initial a
  on fault(any) -> c
  state a { stack work  when guard.scaling < 0.5 -> c  when slowness > 0.7 -> c }
  final state c
}
"#;
    let (spec, _) = dsl::parse(dsl::Sources::default().add("library", library), library, Syntax::Native);
    let yaml = dsl::print(&spec, Syntax::Yaml);
    let folder = folder("told", &[("hands.hq", library), ("arms.yaml", &yaml)]);
    for (import, name) in [
        ("import \"hands.hq\" { m }", "hands.guard.scaling"),
        ("import \"hands.hq\" { m, guard }", "guard.scaling"),
        ("import \"hands.hq\" { m, guard as keeper }", "keeper.scaling"),
        ("import \"arms.yaml\" { m, reach as guard, guard as reach }", "reach.scaling"),
    ] {
        let p = program(&format!("hierarq 1\n{import}\n{ROBOT}"), &folder);
        let machine = p.machine.as_ref().expect("a machine");
        for t in &machine.states[1].transitions {
            let runtime::program::Trigger::When { condition, .. } = &t.trigger else { panic!("{t:?}") };
            let read = p.values.tape.only(&condition.inputs.iter().copied().collect()).signals();
            let signals = read.into_iter().filter_map(|at| p.interface.signal_of(at));
            let names: Vec<&str> = signals.map(|s| p.interface.signals[s].name.as_str()).collect();
            assert_eq!(names, [name], "{import}: {}", t.text);
            assert!(!t.text.contains('@'), "{}", t.text);
        }
    }
}

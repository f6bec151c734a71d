//! The table of coverage against what the controller does: joints that move, rows that bound one joint, and the pairs and
//! parts that rows name.

use crate::common;

use common::{compile_text, examples, whole};
use dsl::Syntax;
use hierarq_compiler::JointQuantity;
use hierarq_compiler::coverage::{Firmness, KeptFrom, StackCoverage};
use robot::LinkId;
use runtime::program::Program;
use runtime::{Controller, Observation, build_tasks};
use std::collections::BTreeSet;
use stdlib_tasks::bound::Bound;

/// Ticks that each stack is run for.
const TICKS: u32 = 40;

/// Velocity (rad/s or m/s) above which a joint moves.
const STILL: f64 = 1e-6;

/// The programs of all examples with a robot, with their names.
fn programs() -> Vec<(String, Program)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(examples()).expect("examples") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|e| e != "hq") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a text");
        let compiled = compile_text(&text, Syntax::Native, &examples(), &[]);
        if let Some(program) = compiled.program {
            all.push((path.file_stem().expect("a name").to_string_lossy().into_owned(), program));
        }
    }
    assert!(all.len() > 15, "{} examples with a robot", all.len());
    all
}

#[test]
fn no_joint_moves_that_the_table_leaves_out() {
    for (name, program) in programs() {
        for table in StackCoverage::of_runs(&program) {
            let listed: BTreeSet<usize> = table.joints.iter().map(|j| j.dof).collect();
            let mut controller = Controller::for_stack(&program, table.stack).expect("a controller");
            let mut q = program.robot.home.clone();
            let mut v = vec![0.0; program.robot.model.nv()];
            for tick in 0..TICKS {
                let time = f64::from(tick) * program.robot.period;
                let command = controller.step(&Observation { time, q: &q });
                if command.fault.is_some() {
                    break;
                }
                v.copy_from_slice(command.velocity);
                program.robot.model.integrate(&mut q, &v, program.robot.period);
                let moving = (0..v.len()).filter(|&dof| v[dof].abs() > STILL);
                for dof in moving {
                    let joint = &program.robot.model.dofs[dof].name;
                    assert!(listed.contains(&dof), "{name}: `{joint}` moves in stack {}", table.stack);
                }
            }
        }
    }
}

/// The firmest of the levels of a stack with a limit of a type whose rows are of one joint each, by the names of rows.
fn by_rows(program: &Program, stack: usize, kind: &str, joint: &str) -> Option<Firmness> {
    let levels = &program.stacks[stack].levels;
    let is_target = |task: usize| {
        let kind = stdlib_tasks::find(&program.tasks[task].kind).expect("a type");
        kind.row_kind == stdlib_tasks::task::RowKind::Equality
    };
    let first = levels.iter().position(|l| l.members.iter().any(|m| is_target(m.task))).unwrap_or(levels.len());
    let built = build_tasks(program, &program.stacks[stack]);
    let members = levels.iter().enumerate().flat_map(|(k, l)| l.members.iter().map(move |m| (k, l.hard, m.task)));
    let found = members.zip(&built).filter(|((_, _, task), built)| {
        let rows = built.task.as_ref().expect("a task").rows();
        program.tasks[*task].kind == kind && rows.iter().any(|r| r.name == joint)
    });
    let firmness = |(k, hard, _): (usize, bool, usize)| match hard {
        true => Firmness::Hard,
        false if k < first => Firmness::Soft,
        false => Firmness::Remaining,
    };
    found.map(|(member, _)| firmness(member)).max()
}

#[test]
fn limits_of_joints_are_those_whose_rows_name_the_joint() {
    let mut compared = 0;
    for (name, program) in programs() {
        for table in StackCoverage::of_runs(&program) {
            for j in &table.joints {
                let joint = program.robot.model.dofs[j.dof].name.as_str();
                for (quantity, kind) in [
                    (JointQuantity::Velocity, "joint_velocity_limits"),
                    (JointQuantity::Acceleration, "joint_acceleration_limits"),
                    (JointQuantity::Position, "joint_position_limits"),
                ] {
                    let is = j.limit(quantity).map(|h| h.firmness);
                    let by_keep = program.tasks.iter().any(|t| t.kind == "keep") && quantity == JointQuantity::Position;
                    let expected = by_rows(&program, table.stack, kind, joint);
                    assert!(is == expected || (by_keep && is >= expected), "{name}: {quantity:?} of `{joint}`");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 500, "{compared} comparisons");
}

/// Links of the geometries of a parameter.
fn links(program: &Program, task: usize, param: &str) -> BTreeSet<LinkId> {
    match program.tasks[task].params.get(param) {
        Some(Bound::Geometries(all)) => all.iter().map(|g| g.link).collect(),
        _ => panic!("no parts"),
    }
}

#[test]
fn walls_and_pairs_are_those_of_the_members() {
    let (mut walls, mut pairs) = (0, 0);
    for (name, program) in programs() {
        for table in StackCoverage::of_runs(&program) {
            let members =
                program.stacks[table.stack].levels.iter().flat_map(|l| l.members.iter().map(move |m| (l, m.task)));
            for (level, task) in members {
                let own: Vec<_> = table.guards.iter().filter(|g| g.hold.task == task).collect();
                let all_hard = own.iter().all(|g| (g.hold.firmness == Firmness::Hard) == level.hard);
                match program.tasks[task].kind.as_str() {
                    "virtual_wall" => {
                        let found: BTreeSet<LinkId> = own.iter().flat_map(|g| g.links.iter().copied()).collect();
                        assert_eq!(found, links(&program, task, "points"), "{name}");
                        assert!(all_hard && own.iter().all(|g| g.from == KeptFrom::Plane), "{name}");
                        walls += 1;
                    }
                    "self_collision" => {
                        let mut expected = BTreeSet::new();
                        let (model, params) = (&program.robot.model, &program.tasks[task].params);
                        let excepted: BTreeSet<[LinkId; 2]> = match params.get("except") {
                            Some(Bound::Pairs(all)) => all.iter().map(|pair| pair.links).collect(),
                            _ => BTreeSet::new(),
                        };
                        let one_side = !params.contains_key("and");
                        let others = links(&program, task, if one_side { "between" } else { "and" });
                        for a in links(&program, task, "between") {
                            for &b in &others {
                                let apart = match one_side {
                                    true => !robot::contacts::are_neighbours(model, a, b),
                                    false => model.moves_between(a, b),
                                };
                                let pair = [a.min(b), a.max(b)];
                                if apart && !excepted.contains(&pair) {
                                    expected.insert(pair);
                                }
                            }
                        }
                        let found: BTreeSet<[LinkId; 2]> = own
                            .iter()
                            .flat_map(|g| g.links.iter().map(move |a| (*a, &g.from)))
                            .map(|(a, from)| match from {
                                KeptFrom::Link(b) => [a.min(*b), a.max(*b)],
                                other => panic!("{name}: {other:?}"),
                            })
                            .collect();
                        assert_eq!(found, expected, "{name}");
                        assert!(all_hard, "{name}");
                        pairs += found.len();
                    }
                    _ => {}
                }
            }
        }
    }
    assert!(walls > 3 && pairs > 10, "{walls} walls, {pairs} pairs");
}

fn program(body: &str) -> Program {
    let compiled = compile_text(&whole(body, Syntax::Native, true, true), Syntax::Native, &examples(), &[]);
    let said = common::annotated(&compiled);
    compiled.program.unwrap_or_else(|| panic!("{said}"))
}

/// Points of people from which a link is kept, with the firmness, by a value that is kept at least 0.3 m large.
fn kept_from(value: &str, bound: &str) -> Vec<String> {
    let program = program(&format!(
        "human worker {{ points [chest, hand] }}\n\
         task away = keep({value}) {{ {bound}  gain 5 /s }}\n\
         task all_points = keep(distance(elbow, worker)) {{ min 0.3 m }}\n\
         task reach = frame_position(tool) {{ position [0.4, 0.2, 0.3] m }}\n\
         stack work {{\n  level limits hard {{ joint_acceleration_limits  away  all_points }}\n\
         level motion {{ reach }}\n}}\n"
    ));
    let table = StackCoverage::of(&program, 0);
    let mut all: Vec<String> = Vec::new();
    for g in table.guards.iter().filter(|g| program.tasks[g.hold.task].name == "away") {
        let links: Vec<&str> = g.links.iter().map(|l| program.robot.model.link_ref(*l).name.as_str()).collect();
        if let KeptFrom::People(points) = &g.from {
            let points: Vec<&str> = points.iter().map(|p| program.interface.signals[p.signal].name.as_str()).collect();
            all.push(format!("{} from {}", links.join(" "), points.join(" ")));
        }
    }
    all
}

#[test]
fn people_are_those_whom_the_bound_keeps_away() {
    let cases: [(&str, &str, &[&str]); 7] = [
        ("distance(wrist, worker.hand)", "min 0.3 m", &["link_6 from worker.hand"]),
        ("distance(wrist, worker.hand)", "max 2 m", &[]),
        ("-distance(wrist, worker.hand)", "max -0.3 m", &["link_6 from worker.hand"]),
        ("norm(frame(link_6).position - worker.hand)", "min 0.3 m", &["link_6 from worker.hand"]),
        ("norm(frame(link_6).position - worker.hand)", "max 2 m", &[]),
        (
            "distance([elbow, wrist], worker)",
            "min 0.3 m",
            &[
                "link_4 from worker.chest",
                "link_4 from worker.hand",
                "link_6 from worker.chest",
                "link_6 from worker.hand",
            ],
        ),
        ("max(distance(wrist, worker.hand), distance(elbow, worker.chest))", "min 0.3 m", &[]),
    ];
    for (value, bound, expected) in cases {
        assert_eq!(kept_from(value, bound), expected, "{value} {bound}");
    }
}

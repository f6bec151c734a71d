//! Table of coverage of `hierarq check --coverage`: the limits that each stack keeps, and what nothing limits.

use std::collections::{BTreeMap, BTreeSet};

use compiler::JointQuantity;
use compiler::coverage::{Guard, Hold, JointCoverage, KeptFrom, StackCoverage};
use compiler::names::list;
use robot::LinkId;
use runtime::program::Program;
use serde_json::{Value, json};

use super::table::wide_table;

/// Maximum number of names in a cell.
const NAMES: usize = 8;

/// Returns the tables of a program, for people.
pub fn text(program: &Program) -> String {
    let all = StackCoverage::of_runs(program);
    let mut joints = wide_table(&["stack", "states", "moves", "velocity", "position", "acceleration"]);
    let mut guards = wide_table(&["stack", "limit", "level", "keeps", "from"]);
    for of in &all {
        let name = &program.stacks[of.stack].name;
        for (i, (dofs, cells)) in alike(program, of).into_iter().enumerate() {
            let first = |text: String| if i == 0 { text } else { String::new() };
            let [velocity, position, acceleration] = cells;
            let dofs = list_of(dofs);
            joints.add_row([
                first(name.clone()),
                first(list_of(states(program, of))),
                dofs,
                velocity,
                position,
                acceleration,
            ]);
        }
        if of.joints.is_empty() {
            let states = list_of(states(program, of));
            joints.add_row([name.clone(), states, "nothing".into(), String::new(), String::new(), String::new()]);
            continue;
        }
        let rows: Vec<[String; 4]> = kept(program, of).into_iter().chain(open(program, of)).collect();
        for (i, [limit, level, keeps, from]) in rows.into_iter().enumerate() {
            guards.add_row([if i == 0 { name.clone() } else { String::new() }, limit, level, keeps, from]);
        }
    }
    format!("{joints}\n{guards}\n")
}

/// Returns the coverage of a program as data.
pub fn data(program: &Program) -> Value {
    let link = |l: &LinkId| program.robot.model.link_ref(*l).name.clone();
    let hold = |h: Option<Hold>, of: &StackCoverage| match h {
        Some(h) => json!({
            "firmness": h.firmness.word(),
            "level": program.stacks[of.stack].levels[h.level].name,
            "task": program.tasks[h.task].name,
        }),
        None => Value::Null,
    };
    let joint = |j: &JointCoverage, of: &StackCoverage| {
        let mut one = json!({ "name": program.robot.model.dofs[j.dof].name, "needs_position": j.needs_position });
        for quantity in JointQuantity::ALL {
            one[quantity.word()] = hold(j.limit(quantity), of);
        }
        one
    };
    let guard = |g: &Guard, of: &StackCoverage| {
        let mut one = hold(Some(g.hold), of);
        one["links"] = g.links.iter().map(link).collect();
        one["from"] = match &g.from {
            KeptFrom::Plane => json!({ "kind": "plane" }),
            KeptFrom::Link(other) => json!({ "kind": "link", "link": link(other) }),
            KeptFrom::People(points) => {
                let points: Vec<&str> =
                    points.iter().map(|p| program.interface.signals[p.signal].name.as_str()).collect();
                json!({ "kind": "people", "points": points })
            }
            KeptFrom::Obstacle(o) => json!({ "kind": "obstacle", "obstacle": program.obstacles[*o].name }),
            KeptFrom::Place => json!({ "kind": "place" }),
            KeptFrom::Value => json!({ "kind": "value" }),
        };
        one
    };
    let stack = |of: &StackCoverage| {
        json!({
            "stack": program.stacks[of.stack].name,
            "states": states(program, of),
            "moves": of.moves,
            "joints": of.joints.iter().map(|j| joint(j, of)).collect::<Vec<_>>(),
            "guards": of.guards.iter().map(|g| guard(g, of)).collect::<Vec<_>>(),
            "unguarded_points": open_points(program, of),
        })
    };
    StackCoverage::of_runs(program).iter().map(stack).collect()
}

/// Names in a cell; empty for none.
fn list_of(names: Vec<&str>) -> String {
    if names.is_empty() {
        return String::new();
    }
    list(names, NAMES).replace('`', "")
}

fn states<'p>(program: &'p Program, of: &StackCoverage) -> Vec<&'p str> {
    let names = |m: &'p runtime::program::MachineProgram| of.states.iter().map(|&s| m.states[s].name.as_str());
    program.machine.iter().flat_map(names).collect()
}

/// Joints with the same limits, with the cells of velocity, position and acceleration.
fn alike<'p>(program: &'p Program, of: &StackCoverage) -> Vec<(Vec<&'p str>, [String; 3])> {
    let mut groups: Vec<(Vec<&str>, [String; 3])> = Vec::new();
    for j in &of.joints {
        let cells = JointQuantity::ALL.map(|quantity| match j.limit(quantity) {
            Some(h) => format!("{}: {}", h.firmness.word(), program.stacks[of.stack].levels[h.level].name),
            None if !j.needs(quantity) => "needs none".to_string(),
            None => "NONE".to_string(),
        });
        let name = program.robot.model.dofs[j.dof].name.as_str();
        match groups.iter_mut().find(|g| g.1 == cells) {
            Some(group) => group.0.push(name),
            None => groups.push((vec![name], cells)),
        }
    }
    groups
}

/// Rows of the limits that guard links: the limit, its level, the links, and what they are kept from.
fn kept(program: &Program, of: &StackCoverage) -> Vec<[String; 4]> {
    let link = |l: &LinkId| program.robot.model.link_ref(*l).name.as_str();
    let mut rows: BTreeMap<(Hold, String), BTreeSet<&str>> = BTreeMap::new();
    for g in &of.guards {
        let from = match &g.from {
            KeptFrom::Plane => "a plane".to_string(),
            KeptFrom::Link(other) => link(other).to_string(),
            KeptFrom::People(points) => {
                list_of(points.iter().map(|p| program.interface.signals[p.signal].name.as_str()).collect())
            }
            KeptFrom::Obstacle(o) => program.obstacles[*o].name.clone(),
            KeptFrom::Place => "a place".to_string(),
            KeptFrom::Value => "a bound of its value".to_string(),
        };
        rows.entry((g.hold, from)).or_default().extend(g.links.iter().map(link));
    }
    // Limits that keep the same links from several things are one row.
    let mut merged: Vec<(Hold, BTreeSet<&str>, Vec<String>)> = Vec::new();
    for ((hold, from), links) in rows {
        match merged.iter_mut().find(|m| m.0 == hold && m.1 == links) {
            Some(same) => same.2.push(from),
            None => merged.push((hold, links, vec![from])),
        }
    }
    merged.sort_by_key(|m| m.0.level);
    let mut shown = None;
    let row = |(hold, links, from): (Hold, BTreeSet<&str>, Vec<String>)| {
        let links = if links.is_empty() { "the whole robot".into() } else { list_of(links.into_iter().collect()) };
        let level = format!("{}: {}", hold.firmness.word(), program.stacks[of.stack].levels[hold.level].name);
        let from = list_of(from.iter().map(String::as_str).collect());
        // Further rows of a limit leave out its name.
        let again = shown.replace(hold) == Some(hold);
        let [name, level] =
            [program.tasks[hold.task].name.clone(), level].map(|x| if again { String::new() } else { x });
        [name, level, links, from]
    };
    merged.into_iter().map(row).collect()
}

/// Rows of hazards that nothing is kept from: points of people, and the robot itself.
fn open(program: &Program, of: &StackCoverage) -> Vec<[String; 4]> {
    let row = |from: &str| ["NONE".to_string(), String::new(), "nothing".to_string(), from.to_string()];
    let mut rows = Vec::new();
    if !of.guards.iter().any(|g| matches!(g.from, KeptFrom::Link(_))) {
        rows.push(row("its own links"));
    }
    let points = open_points(program, of);
    if !points.is_empty() {
        rows.push(row(&list_of(points)));
    }
    rows
}

/// Points of people from which no limit of a stack keeps anything.
fn open_points<'p>(program: &'p Program, of: &StackCoverage) -> Vec<&'p str> {
    let guarded: BTreeSet<usize> = of
        .guards
        .iter()
        .filter_map(|g| if let KeptFrom::People(points) = &g.from { Some(points) } else { None })
        .flat_map(|points| points.iter().map(|p| p.signal))
        .collect();
    let points = program.interface.humans.iter().flat_map(|h| &h.points);
    points.filter(|s| !guarded.contains(s)).map(|&s| program.interface.signals[s].name.as_str()).collect()
}

//! A mission of layers from its declaration.

use std::collections::BTreeMap;
use std::ops::Range;

use blocks::{Block, ByName, Located};

use super::blocks::{HumanBlock, LayersBlock, ObjectBlock, RobotBlock, TaskBlock};
use super::check::{ACTION, Item};
use super::json::{FaultKind, Mode, Position, import};
use super::mission::{Layers, members};
use super::problem::{Agent, Body, Object, Problem, Skill, Task};
use super::{refusals, warnings};
use crate::declare::common::{PlaceBlock, check_batch};
use crate::declare::{DeclaredMember, DeclaredMission, Origins, Remark, Remarks, labels, mistaken};

/// Number of mistakes of a file that are reported at once.
const MOST: usize = 20;

/// Builds the mission.
pub(super) fn build(declared: &DeclaredMission, remarks: &mut Remarks) -> Layers {
    let mut places = Origins::new(declared, Item::Mission);
    let settings = LayersBlock::read(&declared.settings);
    let mut problem = Problem {
        agents: Vec::new(),
        objects: Vec::new(),
        places: BTreeMap::new(),
        layers: Vec::new(),
        tasks: Vec::new(),
        labels: Default::default(),
        weights: settings.weights,
        returns: settings.returns,
        start: 0.0,
        begun: Vec::new(),
    };
    for member in declared.of("place") {
        problem.places.insert(member.name.clone(), PlaceBlock::read(&member.settings).at);
    }
    for member in declared.of("robot").chain(declared.of("human")) {
        let item = Item::Agent(problem.agents.len());
        places.add(item, &member.settings);
        problem.agents.push(if member.role == "robot" {
            robot(member)
        } else {
            human(member, item, &mut places, remarks)
        });
    }
    for member in declared.of("object") {
        places.add(Item::Object(problem.objects.len()), &member.settings);
        let ObjectBlock { place, mass, features, .. } = ObjectBlock::read(&member.settings);
        problem.objects.push(Object { name: member.name.clone(), place, mass, features });
    }
    layers(declared, &mut problem, &mut places);
    problem.labels = labels(declared, problem.tasks.iter().map(|task| &task.name), remarks);
    mistaken(declared, members(&problem).iter().map(|member| member.name), &problem.labels, remarks);
    check_batch(declared, settings.batch, remarks);
    if let Some(at) = declared.settings.key_origin("layers_from")
        && let Some(layer) = declared.of("layer").next()
    {
        let remark = Remark::error("HQ0912", at, "the layers are defined here and in a file");
        remarks.push(remark.label(layer.at, "written here").help("keep one of the two"));
    } else if declared.settings.is_wrong("layers_from") {
        // Nothing is known of the layers.
    } else if let Some(file) = &settings.layers_from {
        // The file is checked against the team, which must be good for that.
        if !remarks.has_error() && !places.any_wrong() {
            problem = imported(file, problem, remarks);
        }
    } else {
        let waits = settings.instruction.is_some() && problem.layers.is_empty();
        refusals::add(declared, &problem, &places, waits, remarks);
    }
    if !remarks.has_error() && !places.any_wrong() {
        warnings::add(&problem, &places, remarks);
    }
    let LayersBlock { batch, reallocate_above, instruction, directives, .. } = settings;
    Layers { problem, batch, reallocate_above, instruction, directives }
}

fn robot(member: &DeclaredMember) -> Agent {
    let block = RobotBlock::read(&member.settings);
    Agent {
        name: member.name.clone(),
        place: block.place,
        body: Body::Robot { speed: block.speed, energy: block.energy.of_factor(block.factor) },
        skills: skills(&block.skills),
        reach: block.reach,
        payload: block.payload,
        cannot: block.cannot,
        spread: block.spread,
        lost: false,
    }
}

fn human(member: &DeclaredMember, item: Item, places: &mut Origins<Item>, remarks: &mut Remarks) -> Agent {
    let block = HumanBlock::read(&member.settings);
    let mut skills = skills(&block.skills);
    for pace in &block.paces {
        match skills.iter_mut().find(|skill| skill.action == pace.name.value) {
            Some(skill) => skill.pace = pace.value.value,
            None if places.is_wrong(item, &["skills"]) => {}
            None => {
                let known: Vec<&str> = skills.iter().map(|skill| skill.action.as_str()).collect();
                remarks.push(Remark::unknown("skill of this agent", &pace.name.value, pace.name.at, &known));
                places.mark_wrong(item, "paces");
            }
        }
    }
    Agent {
        name: member.name.clone(),
        place: block.place,
        body: Body::Human { speed: block.speed, slowing: block.slowing },
        skills,
        reach: block.reach,
        payload: block.payload,
        cannot: block.cannot,
        spread: block.spread,
        lost: false,
    }
}

fn skills(written: &[ByName<f64>]) -> Vec<Skill> {
    let one = |e: &ByName<f64>| Skill { action: e.name.value.clone(), duration: e.value.value, pace: 1.0 };
    written.iter().map(one).collect()
}

/// Adds the layers and all tasks in their order. A task is named after its layer too if another one has its name.
fn layers<'m>(declared: &'m DeclaredMission, problem: &mut Problem, places: &mut Origins<'m, Item>) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for task in declared.of("layer").flat_map(|layer| &layer.members) {
        *counts.entry(&task.name).or_default() += 1;
    }
    for layer in declared.of("layer") {
        let index = problem.layers.len();
        places.add(Item::Layer(index), &layer.settings);
        for member in &layer.members {
            let item = Item::Task(problem.tasks.len());
            places.add(item, &member.settings);
            match &member.action {
                Some(action) => places.add_part(item, ACTION, action.at),
                // The reader has reported it.
                None => places.mark_wrong(item, ACTION),
            }
            let several = counts.get(member.name.as_str()).is_some_and(|count| *count > 1);
            let block = TaskBlock::read(&member.settings);
            problem.tasks.push(Task {
                name: if several { format!("{}.{}", layer.name, member.name) } else { member.name.clone() },
                layer: index,
                action: member.action.as_ref().map_or_else(String::new, |action| action.value.clone()),
                features: block.features,
                path: block.via.into_iter().chain(block.to).collect(),
                object: block.object.map(|object| object.0),
                agent: block.agent.map(|agent| agent.0),
            });
        }
        problem.layers.push(layer.name.clone());
    }
}

/// The problem with the layers and tasks of a file.
fn imported(file: &Located<String>, problem: Problem, remarks: &mut Remarks) -> Problem {
    let faults = match import(&file.value, &problem, Mode::Context) {
        Ok(imported) => return imported.problem,
        Err(faults) => faults,
    };
    for fault in faults.iter().take(MOST) {
        let remark = Remark::error("HQ0912", file.at, fault.what.clone()).inside(token(&file.value, fault.at));
        let remark = match fault.kind {
            FaultKind::Syntax | FaultKind::Truncated => remark.note("the file is invalid from here on"),
            _ => remark,
        };
        remarks.push(remark.label(file.at, "the file is named here").help(fault.fix.clone()));
    }
    problem
}

/// Returns the bytes of the token at a position: a text in quotes, a word or number, or one character.
fn token(text: &str, at: Position) -> Range<usize> {
    let line: usize = text.split_inclusive('\n').take(at.line.saturating_sub(1)).map(str::len).sum();
    let rest = text.get(line..).unwrap_or_default();
    let column = rest.char_indices().nth(at.column.saturating_sub(1)).map_or(rest.len(), |(i, _)| i);
    let start = line + column;
    let here = text.get(start..).unwrap_or_default();
    let mut characters = here.char_indices();
    let length = match characters.next() {
        None => 0,
        Some((_, '"')) => here[1..].find(['"', '\n']).map_or(1, |i| i + 2),
        Some((_, c)) if c.is_alphanumeric() || c == '-' => characters
            .find(|(_, c)| !c.is_alphanumeric() && !matches!(c, '.' | '_' | '-'))
            .map_or(here.len(), |(i, _)| i),
        Some((_, c)) => c.len_utf8(),
    };
    start..(start + length).min(text.len())
}

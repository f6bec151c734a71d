//! Diagnostics of demands that are not met.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use names::list;
use robot::LinkId;
use runtime::program::Program;
use stdlib_tasks::kinds::{joint_acceleration_limits, joint_position_limits, joint_velocity_limits, self_collision};

use super::Tables;
use super::atoms::Atom;
use super::table::{Firmness, Hold, KeptFrom};
use crate::checks::Checked;
use crate::demands::{CoverageDemands, Demand, Demanded, DemandedStack, JointQuantity};

/// Maximum number of names in a list.
const NAMES: usize = 4;

/// Maximum number of stacks with a label.
const LABELS: usize = 3;

/// The parts of a demand that some stacks do not meet.
pub(super) struct Gap {
    /// The stacks.
    pub stacks: Vec<usize>,
    /// Parts that no limit meets.
    pub missing: Vec<Atom>,
    /// Parts that only a weaker limit meets.
    pub weak: Vec<(Atom, Hold)>,
}

impl Gap {
    /// True if another stack lacks the same.
    pub(super) fn is_like(&self, missing: &[Atom], weak: &[(Atom, Hold)]) -> bool {
        let same = |(a, b): (&(Atom, Hold), &(Atom, Hold))| a.0 == b.0 && a.1.firmness == b.1.firmness;
        self.missing == missing && self.weak.len() == weak.len() && self.weak.iter().zip(weak).all(same)
    }

    /// The parts of which the message speaks: the missing ones, or else the weak ones.
    fn subject(&self) -> Vec<Atom> {
        match self.missing.is_empty() {
            true => self.weak.iter().map(|w| w.0).collect(),
            false => self.missing.clone(),
        }
    }
}

/// Error of a demand that is not met.
pub(super) fn unmet(c: &Checked, demand: &Demand, gap: &Gap, tables: &Tables) -> Diagnostic {
    let program = c.program;
    let atoms = gap.subject();
    let within = stacks(program, gap, tables);
    let is_missing = !gap.missing.is_empty();
    let (code, text, moving) = match &demand.of {
        Demanded::Joints(quantity, _) => {
            let dofs = atoms.iter().filter_map(|a| if let Atom::Joint(_, dof) = a { Some(*dof) } else { None });
            let dofs: Vec<usize> = dofs.collect();
            let names = list(dofs.iter().map(|&d| program.robot.model.dofs[d].name.as_str()), NAMES);
            let sides = if *quantity == JointQuantity::Position { " on both sides" } else { "" };
            let quantity = quantity.word();
            let text = match is_missing {
                true => format!("no limit bounds the {quantity} of {names}{sides} {within}"),
                false => format!("the {quantity} of {names} is bounded, but not {} {within}", firm(demand)),
            };
            ("HQ0570", text, format!("{} moved here", if dofs.len() == 1 { "it is" } else { "they are" }))
        }
        Demanded::Apart(_) => {
            let pairs = atoms.iter().filter_map(|a| if let Atom::Pair(pair) = a { Some(pair) } else { None });
            let pairs: Vec<String> =
                pairs.map(|[a, b]| format!("{} and {}", link(program, *a), link(program, *b))).collect();
            let (first, more) = (pairs.first().map_or("", String::as_str), pairs.len().saturating_sub(1));
            let others = match more {
                0 => String::new(),
                1 => ", and one other pair,".to_string(),
                n => format!(", and {n} other pairs,"),
            };
            let text = match is_missing {
                true => format!("no limit keeps {first}{others} apart {within}"),
                false => format!("a limit keeps {first}{others} apart, but not {} {within}", firm(demand)),
            };
            ("HQ0571", text, "they move against each other here".to_string())
        }
        Demanded::Person { human, .. } => {
            let names = links(program, &atoms);
            let who = from_whom(program, *human, demand, &atoms);
            let text = match is_missing {
                true => format!("no limit keeps {names} from {who} {within}"),
                false => format!("a limit keeps {names} from {who}, but not {} {within}", firm(demand)),
            };
            ("HQ0572", text, "the robot moves here".to_string())
        }
        Demanded::Limit { task, links: demanded } => {
            let name = &program.tasks[*task].name;
            let absent = gap
                .stacks
                .iter()
                .all(|s| tables.0.get(s).is_none_or(|t| !t.limits.iter().any(|h| program.same_task(h.task, *task))));
            let text = match (is_missing, absent || demanded.is_empty()) {
                (true, true) => format!("the limit `{name}` is missing {within}"),
                (true, false) => format!("the limit `{name}` does not guard {} {within}", links(program, &atoms)),
                (false, _) => format!("the limit `{name}` is there, but not {} {within}", firm(demand)),
            };
            ("HQ0573", text, "the robot moves here".to_string())
        }
    };
    let mut d = Diagnostic::error(code, demand.span, text);
    for &stack in gap.stacks.iter().take(LABELS) {
        d = d.label(c.places.stacks[stack].0, moving.clone());
    }
    if let (Some((_, weak)), Some(&stack)) = (gap.weak.first(), gap.stacks.first()) {
        let why = match weak.firmness {
            Firmness::Remaining => "soft and not above the targets: it bounds only the freedom that they leave",
            _ if program.stacks[stack].levels[weak.level].hard => "this task gives way where it has to",
            _ => "this level is soft and may be violated",
        };
        d = d.label(c.places.stacks[stack].1[weak.level], why);
    }
    if let Some(partial) = partial(program, demand, gap, tables) {
        d = d.note(partial);
    }
    d.help(help(program, demand, gap, tables))
}

/// The demanded firmness in words.
fn firm(demand: &Demand) -> &'static str {
    if demand.hard { "on a hard level" } else { "above the targets" }
}

fn link(program: &Program, link: LinkId) -> String {
    format!("`{}`", program.robot.model.link_ref(link).name)
}

/// Name of a link as a part with a distance: that of a point, a segment or a shape declared on it, if there is one.
fn part(program: &Program, link: LinkId) -> &str {
    let declared = program.robot.geometries.iter().find(|g| g.link == link);
    declared.map_or(program.robot.model.link_ref(link).name.as_str(), |g| g.name.as_str())
}

/// Help to declare points on links that have no shape of their own: a distance needs one.
fn shapeless(program: &Program, links: impl Iterator<Item = LinkId>) -> Option<String> {
    let has_part = |link: LinkId| {
        let declared = program.robot.geometries.iter().any(|g| g.link == link);
        declared || !program.robot.model.link_ref(link).collision.is_empty()
    };
    let names: BTreeSet<&str> =
        links.filter(|l| !has_part(*l)).map(|l| program.robot.model.link_ref(l).name.as_str()).collect();
    (!names.is_empty()).then(|| format!("declare a point on {} in the robot, then ", list(names, NAMES)))
}

/// Links of parts of a demand, each once.
fn links(program: &Program, atoms: &[Atom]) -> String {
    let mut all: Vec<LinkId> = Vec::new();
    for atom in atoms {
        if let Atom::Person(link, _) | Atom::Guard(_, link) = atom
            && !all.contains(link)
        {
            all.push(*link);
        }
    }
    let names: Vec<&str> = all.iter().map(|l| program.robot.model.link_ref(*l).name.as_str()).collect();
    list(names, NAMES)
}

/// The person, or those of the demanded points from which links are not kept.
fn from_whom(program: &Program, human: usize, demand: &Demand, atoms: &[Atom]) -> String {
    let name = &program.interface.humans[human].name;
    let points = match &demand.of {
        Demanded::Person { points, .. } => points.len(),
        _ => 0,
    };
    let open: BTreeSet<usize> =
        atoms.iter().filter_map(|a| if let Atom::Person(_, p) = a { Some(p.signal) } else { None }).collect();
    if open.len() == points {
        return format!("`{name}`");
    }
    list(open.iter().map(|&s| program.interface.signals[s].name.as_str()), NAMES)
}

/// `in stack `work` (state `carry`)`
fn stacks(program: &Program, gap: &Gap, tables: &Tables) -> String {
    let name = |stack: usize| program.stacks[stack].name.as_str();
    let [one] = gap.stacks.as_slice() else {
        return format!("in the stacks {}", list(gap.stacks.iter().map(|&s| name(s)), NAMES));
    };
    let states = tables.0.get(one).zip(program.machine.as_ref());
    let states: Vec<&str> =
        states.iter().flat_map(|(t, m)| t.states.iter().map(|&s| m.states[s].name.as_str())).collect();
    match states.len() {
        0 => format!("in stack `{}`", name(*one)),
        1 => format!("in stack `{}`, state `{}`", name(*one), states[0]),
        _ => format!("in stack `{}`, states {}", name(*one), list(states, NAMES)),
    }
}

/// The limits of the person that the stack has, where they are too few.
fn partial(program: &Program, demand: &Demand, gap: &Gap, tables: &Tables) -> Option<String> {
    let table = tables.0.get(gap.stacks.first()?)?;
    let Demanded::Person { human, .. } = demand.of else { return None };
    let own = table.guards.iter().filter(|g| match &g.from {
        KeptFrom::People(points) => points.iter().any(|p| p.human == human),
        _ => false,
    });
    let tasks: BTreeSet<&str> = own.map(|g| program.tasks[g.hold.task].name.as_str()).collect();
    (!tasks.is_empty() && !gap.missing.is_empty())
        .then(|| format!("limits of this person here: {}", list(tasks.iter().copied(), NAMES)))
}

/// Code that would meet the demand.
fn help(program: &Program, demand: &Demand, gap: &Gap, tables: &Tables) -> Help {
    if gap.missing.is_empty() {
        return match demand.hard {
            true => Help::each(
                "write `hard` behind the name of its level, move it to a hard level, or demand `soft`",
                "write `hard: true` into its level, move it to a hard level, or demand `soft`",
            ),
            false => "move it to a level above the targets".into(),
        };
    }
    let stack = gap.stacks.first().map(|&s| &program.stacks[s]);
    let hard = stack.and_then(|s| s.levels.iter().find(|l| l.hard)).map(|l| l.name.as_str());
    let level = match (demand.hard, hard) {
        (_, Some(level)) => format!("level `{level}`"),
        (true, None) => "a hard level at the top of the stack".to_string(),
        (false, None) => "a level above the targets".to_string(),
    };
    let named = gap.missing.iter().flat_map(|atom| match atom {
        Atom::Pair(pair) => pair.to_vec(),
        Atom::Person(link, _) => vec![*link],
        _ => Vec::new(),
    });
    let first = shapeless(program, named).unwrap_or_default();
    let task = |written: Snippet| Help::with(&format!("{first}declare {{}} and add it to {level}"), [written]);
    match &demand.of {
        Demanded::Joints(quantity, _) => joints_help(program, *quantity, gap, tables, &level),
        Demanded::Apart(_) => {
            let pair = gap.missing.iter().find_map(|a| if let Atom::Pair(pair) = a { Some(pair) } else { None });
            let side = |i: usize| pair.map_or("", |p| part(program, p[i]));
            let sides =
                [Snippet::entry("between", side(0)), Snippet::entry("and", side(1)), Snippet::entry("d_min", "0.05 m")];
            task(Snippet::typed("task", "apart", self_collision::KIND.name, sides))
        }
        Demanded::Person { human, .. } => {
            let link = |atom: &Atom| match atom {
                Atom::Person(link, _) => Some(part(program, *link)),
                _ => None,
            };
            let names: BTreeSet<&str> = gap.missing.iter().filter_map(link).collect();
            let names: Vec<&str> = names.into_iter().collect();
            let points: BTreeSet<usize> = gap
                .missing
                .iter()
                .filter_map(|a| if let Atom::Person(_, p) = a { Some(p.signal) } else { None })
                .collect();
            let person = &program.interface.humans[*human];
            let points: Vec<&str> = points.iter().map(|&s| program.interface.signals[s].name.as_str()).collect();
            let who = match points.as_slice() {
                all if all.len() == person.points.len() => person.name.clone(),
                [one] => (*one).to_string(),
                several => format!("[{}]", several.join(", ")),
            };
            let value = format!("keep(distance([{}], {who}))", names.join(", "));
            task(Snippet::each(
                format!("task away = {value} {{ min 0.5 m }}"),
                format!("tasks: {{ away: {{ \"{value}\": {{ min: 0.5 m }} }} }}"),
            ))
        }
        Demanded::Limit { task, .. } => {
            let name = &program.tasks[*task].name;
            let is_there = gap
                .stacks
                .iter()
                .any(|s| tables.0.get(s).is_some_and(|t| t.limits.iter().any(|h| program.same_task(h.task, *task))));
            match is_there {
                true => format!("name the links in `{name}`").into(),
                false => format!("add `{name}` to {level}").into(),
            }
        }
    }
}

fn joints_help(program: &Program, quantity: JointQuantity, gap: &Gap, tables: &Tables, level: &str) -> Help {
    let kind = match quantity {
        JointQuantity::Velocity => joint_velocity_limits::KIND.name,
        JointQuantity::Position => joint_position_limits::KIND.name,
        JointQuantity::Acceleration => joint_acceleration_limits::KIND.name,
    };
    let table = gap.stacks.first().and_then(|s| tables.0.get(s));
    let there = table.and_then(|t| t.limits.iter().find(|h| program.tasks[h.task].kind == kind));
    let first = gap.missing.iter().find_map(|a| if let Atom::Joint(_, dof) = a { Some(*dof) } else { None });
    let dof = first.and_then(|dof| program.robot.model.dofs.get(dof));
    match (there, dof) {
        (Some(there), Some(dof)) => {
            let named = program.tasks[there.task].params.contains_key("joints");
            let name = &program.tasks[there.task].name;
            match named {
                true => format!("`{name}` names its joints: add `{}` there, or leave `joints` out", dof.name).into(),
                false => Help::with(
                    &format!(
                        "the robot has no such limit of `{}`: give it one under {{}} of the robot, or in `{name}`",
                        dof.name
                    ),
                    [Snippet::same("limits")],
                ),
            }
        }
        _ => Help::with(&format!("add {{}} to {level}"), [Snippet::same(kind)]),
    }
}

/// Error of a demand for a limit that names a target.
pub(super) fn no_limit(c: &Checked, demand: &Demand, task: usize) -> Diagnostic {
    let name = &c.program.tasks[task].name;
    Diagnostic::error("HQ0573", demand.span, format!("`{name}` is a target, and limits nothing"))
        .label(c.places.tasks[task].span, "declared here")
        .help("name a limit, such as a wall or a distance that is kept")
}

/// Warning of a demand that concerns none of the covered stacks.
pub(super) fn vacuous(demand: &Demand, coverage: &CoverageDemands) -> Diagnostic {
    let (what, help) = match demand.of {
        Demanded::Joints(JointQuantity::Position, _) => {
            ("joints with an end", "name other joints or stacks, or remove it")
        }
        Demanded::Joints(..) => ("these joints", "name other joints or stacks, or remove it"),
        _ => ("these links", "name other links or stacks, or remove it"),
    };
    Diagnostic::warning("HQ0576", demand.span, format!("this demand covers nothing: no covered stack moves {what}"))
        .label(coverage.span, "of this coverage")
        .help(help)
}

/// Warning of a coverage of all stacks that move, in a spec in which none does.
pub(super) fn nothing_moves(coverage: &CoverageDemands) -> Diagnostic {
    Diagnostic::warning("HQ0576", coverage.span, "this coverage covers nothing: no stack that runs moves the robot")
        .help("name stacks with `stacks`, or remove it")
}

/// Warning of a state without a stack.
pub(super) fn no_stack(of: &DemandedStack) -> Diagnostic {
    Diagnostic::warning("HQ0576", of.span, "no stack runs in this state, so nothing is covered in it")
        .note("the robot stands still in it")
        .help("leave the state out")
}

/// Warning of a demand that another one contains.
pub(super) fn repeated(demand: &Demand, other: &Demand) -> Diagnostic {
    Diagnostic::warning("HQ0575", demand.span, "this is demanded already")
        .label(other.span, "here")
        .note("the other demand asks for all of this, at least as firmly, in the same stacks")
        .help("remove one of the two demands")
}

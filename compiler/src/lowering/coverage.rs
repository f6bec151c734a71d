//! Lowers `coverage` blocks: names of states, stacks, links, people and tasks, and lists that say nothing or repeat
//! themselves.

use std::collections::BTreeSet;

use blocks::{Block as _, ByName, Located, Unbound};
use dsl::tree::{Coverage, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use robot::LinkId;
use runtime::program::MachineProgram;

use super::Lowerer;
use super::declared::Declared;
use super::states;
use crate::block_binding::Scope;
use crate::demands::{CoverageDemands, Demand, Demanded, DemandedStack, JointQuantity};
use crate::expand::Expanded;
use crate::robot_binding::{BoundRobot, joints};
use crate::sections::{ApartBlock, COVERAGE, CoverageBlock, NamedLimitBlock, PersonBlock, ValueType};

/// Keys that say where the demands hold, and demand nothing by themselves.
const WHERE: [&str; 3] = ["states", "stacks", "joints"];

/// Parts of the program that demands name.
pub(super) struct Nameable<'n> {
    /// Declarations.
    pub declared: &'n Declared<'n>,
    /// Names of the tasks, in the order of the program.
    pub tasks: Vec<&'n str>,
    /// The robot.
    pub robot: &'n BoundRobot,
    /// The machine; `None` if the spec has none, or if it has a mistake.
    pub machine: Option<&'n MachineProgram>,
}

impl Lowerer<'_> {
    /// Lowers all `coverage` blocks.
    pub(super) fn coverage(&mut self, expanded: &Expanded, names: &Nameable) -> Vec<CoverageDemands> {
        expanded.coverage.iter().map(|(it, span)| self.one_coverage(it, *span, names)).collect()
    }

    fn one_coverage(&mut self, it: &Coverage, whole: Span, names: &Nameable) -> CoverageDemands {
        let start = whole.range().start;
        let span = Span::new(whole.source, start, start + "coverage".len());
        let bound = self.block_binder(&Scope::default()).block(&it.body, &COVERAGE, span);
        let block = CoverageBlock::read(&bound);
        let demanded = || it.body.entries.iter().filter(|e| !WHERE.contains(&e.key.value.as_str()));
        // A block that could not be read was reported.
        let is_read = !it.body.entries.is_empty() || self.sources.snippet(it.body.span).starts_with('{');
        if demanded().next().is_none() && is_read {
            self.push(Diagnostic::error("HQ0574", span, "this coverage demands nothing").help(Help::with(
                "write for instance {} and {}",
                [
                    Snippet::entry("velocity", "hard"),
                    Snippet::block("people", [Snippet::block("NAME", [Snippet::entry("links", "[LINK]")])]),
                ],
            )));
        }
        let stacks = self.demanded_stacks(&block, names);
        let named = block.joints.as_ref().and_then(|at| self.joints_of(at, names));
        let levels = [
            (JointQuantity::Velocity, &block.velocity),
            (JointQuantity::Position, &block.position),
            (JointQuantity::Acceleration, &block.acceleration),
        ];
        if let Some(e) = it.body.get("joints")
            && JointQuantity::ALL.iter().all(|q| it.body.get(q.word()).is_none())
        {
            let d = Diagnostic::error("HQ0574", e.key.span, "joints are named, and nothing is demanded of them");
            self.push(d.help(Help::with("add for instance {}", [Snippet::entry("velocity", "hard")])));
        }
        let mut demands = Vec::new();
        for (quantity, level) in levels {
            let Some((e, level)) = it.body.get(quantity.word()).zip(level.as_ref()) else { continue };
            let of = Demanded::Joints(quantity, named.clone());
            demands.push(Demand { span: e.key.span.to(e.value.span), hard: level.value == "hard", of });
        }
        for e in demanded() {
            let is_by_name = COVERAGE.entry(&e.key.value).is_some_and(|key| matches!(key.value, ValueType::Of(..)));
            let is_empty = match &e.value.kind {
                ValueKind::List(items) => items.is_empty(),
                ValueKind::Block(b) => is_by_name && b.entries.is_empty(),
                _ => false,
            };
            if is_empty {
                self.says_nothing(e.value.span, &format!("`{}` demands nothing", e.key.value));
            }
        }
        demands.extend(block.self_collision.iter().filter_map(|b| self.apart(b, names)));
        demands.extend(block.people.iter().filter_map(|b| self.person(b, names)));
        demands.extend(block.limits.iter().filter_map(|b| self.named_limit(b, names)));
        CoverageDemands { span, stacks, demands }
    }

    /// Stacks of the states and stacks that a block names.
    fn demanded_stacks(&mut self, block: &CoverageBlock, names: &Nameable) -> Option<Vec<DemandedStack>> {
        if block.states.is_none() && block.stacks.is_none() {
            return None;
        }
        let mut all = Vec::new();
        if let Some(states) = &block.states {
            self.repeated(states, "state");
            for name in &states.value {
                let span = self.origins.span(name.at);
                match names.machine.map(|machine| (machine, states::state(machine, &name.value, span))) {
                    Some((machine, Ok(state))) => {
                        let inside = (0..machine.states.len()).filter(|&s| {
                            machine.states[s].initial.is_none() && machine.path(s).any(|outer| outer == state)
                        });
                        let mut stacks: Vec<usize> = inside.filter_map(|s| machine.stack(s)).collect();
                        stacks.sort_unstable();
                        stacks.dedup();
                        all.push(DemandedStack { span, stacks });
                    }
                    Some((_, Err(d))) => self.push(*d),
                    // A machine with a mistake was reported.
                    None if names.declared.machine.is_some() => {}
                    None => {
                        let d = Diagnostic::undeclared("state", &name.value, span);
                        let help = "this spec has no machine: name its stacks, {}, or leave `states` out";
                        self.push(d.help(Help::with(help, [Snippet::entry("stacks", "[NAME]")])));
                    }
                }
            }
        }
        if let Some(stacks) = &block.stacks {
            self.repeated(stacks, "stack");
            for name in &stacks.value {
                let span = self.origins.span(name.at);
                let known = || names.declared.stacks.iter().map(|s| s.name.value.as_str());
                let pattern = names.declared.patterns.get(&name.value);
                match (known().position(|s| s == name.value), pattern) {
                    (Some(stack), _) => all.push(DemandedStack { span, stacks: vec![stack] }),
                    (None, Some(pattern)) => {
                        let text = format!("stack `{}` has parameters, and no arguments are given", name.value);
                        let d = Diagnostic::error("HQ0214", span, text).label(*pattern, "declared here");
                        self.push(d.help("name a stack that is made from it, or the states in which it runs"));
                    }
                    // The stack may be one that failed to expand.
                    (None, None) if names.declared.stacks.is_empty() && !names.declared.whole => {}
                    (None, None) => {
                        let d = Diagnostic::undeclared("stack", &name.value, span);
                        // Stacks of other files have names that users cannot write.
                        let names = known().filter(|n| !n.contains('.'));
                        self.push(d.help("leave it out").one_of("declared are", &name.value, names));
                    }
                }
            }
        }
        Some(all)
    }

    fn apart(&mut self, block: &Located<ApartBlock>, names: &Nameable) -> Option<Demand> {
        let span = self.origins.span(block.at);
        let ApartBlock { between, and, level } = &block.value;
        let model = &names.robot.model;
        let one = between.as_ref().and_then(|at| self.links_at(at, names.robot));
        let other = match and {
            Some(at) => self.links_at(at, names.robot),
            None => one.clone(),
        };
        let (one, other) = (one?, other?);
        let mut pairs: Vec<[LinkId; 2]> = Vec::new();
        for &a in &one {
            for &b in &other {
                let pair = if a <= b { [a, b] } else { [b, a] };
                if model.moves_between(a, b) && !pairs.contains(&pair) {
                    pairs.push(pair);
                }
            }
        }
        if pairs.is_empty() {
            let d = Diagnostic::error("HQ0574", span, "these links cannot move against each other");
            self.push(d.help("name links on both sides of a joint that moves, or remove the demand"));
            return None;
        }
        Some(Demand { span, hard: *level == "hard", of: Demanded::Apart(pairs) })
    }

    fn person(&mut self, block: &ByName<PersonBlock>, names: &Nameable) -> Option<Demand> {
        let span = self.origins.span(block.name.at);
        let PersonBlock { links, points, level } = &block.value.value;
        let links = links.as_ref().and_then(|at| self.links_at(at, names.robot));
        let name = &block.name.value;
        let Some(human) = self.interface.humans.iter().position(|h| h.name == *name) else {
            if !self.params.failed.contains(name) {
                let known: Vec<String> = self.interface.humans.iter().map(|h| h.name.clone()).collect();
                let d = Diagnostic::undeclared("human", name, span);
                let example = Snippet::declared("human", name, [Snippet::entry("points", "[chest]")]);
                self.push(d.help(Help::with("declare it: {}", [example])).one_of(
                    "declared are",
                    name,
                    known.iter().map(String::as_str),
                ));
            }
            return None;
        };
        let all = self.interface.humans[human].points.clone();
        let points = match points {
            Some(points) => self.points_among(points, name, &all)?,
            None => all,
        };
        let of = Demanded::Person { human, points, links: links? };
        Some(Demand { span, hard: *level == "hard", of })
    }

    /// Signals of the points of a person that a demand names.
    fn points_among(&mut self, written: &Located<Vec<Located<String>>>, of: &str, all: &[usize]) -> Option<Vec<usize>> {
        self.repeated(written, "point");
        let name = |signal: usize| {
            let name = self.interface.signals.get(signal).map_or("", |s| s.name.as_str());
            name.rsplit('.').next().unwrap_or_default().to_string()
        };
        let known: Vec<String> = all.iter().map(|&s| name(s)).collect();
        let mut found = Vec::new();
        let mut good = true;
        for point in &written.value {
            match known.iter().position(|k| *k == point.value) {
                Some(i) => found.push(all[i]),
                None => {
                    good = false;
                    let text = format!("`{of}` has no point `{}`", point.value);
                    let d = Diagnostic::unknown_name(self.origins.span(point.at), text);
                    let known = known.iter().map(String::as_str);
                    self.push(d.help("leave it out").one_of("its points are", &point.value, known));
                }
            }
        }
        good.then_some(found)
    }

    fn named_limit(&mut self, block: &ByName<NamedLimitBlock>, names: &Nameable) -> Option<Demand> {
        let span = self.origins.span(block.name.at);
        let NamedLimitBlock { links, level } = &block.value.value;
        let links = match links {
            Some(at) => self.links_at(at, names.robot),
            None => Some(Vec::new()),
        };
        let name = &block.name.value;
        if names.declared.failed.contains(name) {
            return None;
        }
        let Some(task) = names.tasks.iter().position(|t| t == name) else {
            let d = Diagnostic::undeclared("task", name, span);
            let known = names.tasks.iter().copied().filter(|n| !n.contains('.'));
            let d = d.help("declare the limit as a task with this name").one_of("declared are", name, known);
            self.push(d);
            return None;
        };
        // The demand says itself that the task is in no stack.
        self.used_tasks.insert(name.clone());
        Some(Demand { span, hard: *level == "hard", of: Demanded::Limit { task, links: links? } })
    }

    /// Joints that a block names.
    fn joints_of(&mut self, at: &Located<Unbound>, names: &Nameable) -> Option<Vec<usize>> {
        let value = self.origins.unbound(at)?;
        let (items, span) = (value.items().to_vec(), value.span);
        if items.is_empty() {
            self.says_nothing(span, "no joint is named here");
        }
        self.repeated_values(&items, "joint");
        joints(&items, &names.robot.model, &names.robot.joint_groups, self.diagnostics)
    }

    /// Links that a demand names.
    fn links_at(&mut self, at: &Located<Unbound>, robot: &BoundRobot) -> Option<Vec<LinkId>> {
        let value = self.origins.unbound(at)?.clone();
        if matches!(&value.kind, ValueKind::List(items) if items.is_empty()) {
            self.says_nothing(value.span, "no link is named here");
            return None;
        }
        self.repeated_values(value.items(), "link");
        self.links_named(&value, robot)
    }

    fn says_nothing(&mut self, at: Span, text: &str) {
        self.push(Diagnostic::error("HQ0574", at, text).help("name what is demanded, or remove the entry"));
    }

    /// Reports an empty list, and names that are in it twice.
    fn repeated(&mut self, all: &Located<Vec<Located<String>>>, noun: &str) {
        let at = self.origins.span(all.at);
        // A list of wrong names is not empty.
        if all.value.is_empty() && self.sources.snippet(at).chars().all(|c| "[] \n\r\t".contains(c)) {
            self.says_nothing(at, &format!("no {noun} is named here"));
        }
        let written = all.value.iter().map(|name| (name.value.clone(), self.origins.span(name.at))).collect();
        self.twice(written, noun);
    }

    fn repeated_values(&mut self, items: &[dsl::tree::Value], noun: &str) {
        let written = items.iter().filter_map(|item| Some((crate::forms::path_of(item)?, item.span))).collect();
        self.twice(written, noun);
    }

    fn twice(&mut self, written: Vec<(String, Span)>, noun: &str) {
        let mut seen = BTreeSet::new();
        for (i, (name, span)) in written.iter().enumerate() {
            if !seen.insert(name) {
                let first = written[..i].iter().find(|(other, _)| other == name).map_or(*span, |(_, span)| *span);
                let d = Diagnostic::warning("HQ0575", *span, format!("the {noun} `{name}` is named twice"));
                self.push(d.label(first, "first here").help("remove one of the two"));
            }
        }
    }
}

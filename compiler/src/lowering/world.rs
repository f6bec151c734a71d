//! Behaviour of the world in a scenario, bound to signals, events, actions and joints.

use std::collections::BTreeSet;

use blocks::{Block as BlockOf, ByName, Located, OneOrEach};
use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::program::{
    Force, LostReading, OutcomeProgram, OutcomeScript, Program, PushScript, SignalProgram, SignalScript,
};
use stdlib_tasks::dimension::{Dimension, FORCE, NONE};

use super::Lowerer;
use crate::block_binding::Scope;
use crate::expand::quantity;
use crate::expr::Kind;
use crate::expr::constants::Constants;
use crate::forms::{block_of, text_of};
use crate::robot_binding::{BoundRobot, joints, unknown_link};
use crate::sections::{LostBlock, OutcomeBlock, PushBlock, SignalScriptBlock, WRENCH, WaypointBlock, WrenchBlock};

/// Word for an action without an end.
const NEVER: &str = "never";

/// True if the values of a signal can be interpolated linearly.
fn is_straight(signal: &SignalProgram) -> bool {
    signal.kind != "flag" && !matches!(quantity(&signal.kind), Some((Kind::Rotation | Kind::Pose | Kind::Truth, _)))
}

impl Lowerer<'_> {
    /// Reads the blocks of a key: one, or a list of them. Those with a mistake are left out.
    pub(super) fn read_all<'v, B: BlockOf>(&mut self, value: &'v Value) -> Vec<(&'v Block, B)> {
        let mut all = Vec::new();
        for item in value.items() {
            if let Some(block) = block_of(item, B::schema().name, self.diagnostics) {
                let bound = self.block_binder(&Scope::default()).block(block, B::schema(), item.span);
                all.extend((!bound.has_wrong()).then(|| (block, B::read(&bound))));
            }
        }
        all
    }

    /// Entries of the block under a key of the scenario.
    pub(super) fn named_entries<'b>(&mut self, body: &'b Block, key: &str) -> &'b [Entry] {
        let block = body.get(key).and_then(|e| block_of(&e.value, &format!("`{key}`"), self.diagnostics));
        block.map_or(&[], |b| &b.entries)
    }

    /// Reports an end that is not after the beginning.
    pub(super) fn ends_after(&mut self, from: f64, to: Option<&Located<f64>>) {
        if let Some(Located { at, value: to }) = to.filter(|to| to.value <= from) {
            let text = format!("this ends at {to} s, before it begins at {from} s");
            let d = Diagnostic::error("HQ0804", self.origins.span(*at), text);
            self.push(d.help("write a later end, or an earlier beginning"));
        }
    }

    /// Index of a name among `names`; reports an unknown one.
    pub(super) fn one_of(&mut self, what: &str, name: &str, at: Span, names: &[&str]) -> Option<usize> {
        let found = names.iter().position(|n| *n == name);
        if found.is_none() {
            let text = match what.split_once(" of ") {
                Some((what, whole)) => format!("there is no {what} `{name}` of {whole}"),
                None => format!("there is no {what} `{name}`"),
            };
            let d = Diagnostic::unknown_name(at, text);
            self.push(d.help(format!("this spec declares no {what}")).one_of(
                "declared are",
                name,
                names.iter().copied(),
            ));
        }
        found
    }

    fn signal_named(&mut self, key: &dsl::Spanned<String>, program: &Program) -> Option<usize> {
        let signals = || program.interface.signals.iter().enumerate();
        if signals().any(|(_, s)| s.is_variable() && s.name == key.value) {
            let text = format!("`{}` is a variable, which the machine sets itself", key.value);
            self.push(Diagnostic::error("HQ0804", key.span, text).help("send a signal on which the machine sets it"));
            return None;
        }
        // The script of `humans` sends the points of people.
        let sent = || signals().filter(|(_, s)| !s.is_of_person() && !s.is_variable());
        let names: Vec<&str> = sent().map(|(_, s)| s.name.as_str()).collect();
        let found = self.one_of("signal", &key.value, key.span, &names)?;
        sent().nth(found).map(|(i, _)| i)
    }

    /// Numbers of a signal's value.
    pub(super) fn signal_value(&mut self, signal: &SignalProgram, value: &Value) -> Option<Vec<f64>> {
        if signal.kind == "wrench" {
            let block = block_of(value, "a wrench", self.diagnostics)?;
            let bound = self.block_binder(&Scope::default()).block(block, &WRENCH, value.span);
            return (!bound.has_wrong()).then(|| WrenchBlock::read(&bound).numbers().to_vec());
        }
        self.constant_of(signal, value, &format!("a value of signal `{}`", signal.name))
    }

    /// Numbers of a constant value for a signal or variable.
    pub(super) fn constant_of(&mut self, signal: &SignalProgram, value: &Value, what: &str) -> Option<Vec<f64>> {
        let (kind, dimension) = match quantity(&signal.kind) {
            _ if signal.kind == "flag" => (Kind::Truth, NONE),
            Some((kind, dimension)) => (kind, dimension?),
            None => return None,
        };
        self.constant_value((kind, dimension), value, what)
    }

    /// Numbers of a constant of a kind and dimension.
    pub(super) fn constant_value(
        &mut self,
        (kind, dimension): (Kind, Dimension),
        value: &Value,
        what: &str,
    ) -> Option<Vec<f64>> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let typed = constants.constant(value, self.diagnostics)?;
        if typed.kind != kind {
            let (is, needed) = (typed.kind.describe(), kind.describe());
            let d = Diagnostic::error("HQ0304", value.span, format!("{what} is {needed}, and this is {is}"));
            self.push(d.here(is).help(format!("write {needed}")));
            return None;
        }
        if let Some(d) = crate::expr::constants::check_dimension(&self.graph, &typed, dimension, what) {
            let wrong = d.severity == dsl::Severity::Error;
            self.push(d);
            if wrong {
                return None;
            }
        }
        typed.nodes.iter().map(|&n| self.graph.constant(n)).collect()
    }

    /// Dimension of a signal's numbers, for its noise; for a wrench, that of the force.
    fn signal_dimension(signal: &SignalProgram) -> Dimension {
        match signal.kind.as_str() {
            "wrench" => FORCE,
            kind => quantity(kind).and_then(|q| q.1).unwrap_or(NONE),
        }
    }

    pub(super) fn signal_scripts(&mut self, body: &Block, program: &Program) -> Vec<SignalScript> {
        let mut all = Vec::new();
        for e in self.named_entries(body, "signals") {
            let Some(signal) = self.signal_named(&e.key, program) else { continue };
            for (tree, block) in self.read_all(&e.value) {
                all.extend(self.signal_script(signal, &program.interface.signals[signal], tree, &block));
            }
        }
        all
    }

    fn signal_script(
        &mut self,
        signal: usize,
        of: &SignalProgram,
        tree: &Block,
        block: &SignalScriptBlock,
    ) -> Option<SignalScript> {
        let path = match (tree.get("value"), tree.get("path")) {
            (Some(e), None) => self.signal_value(of, &e.value).map(|value| vec![(0.0, value)]),
            (None, Some(e)) => self.path(of, &e.value),
            (first, second) => {
                let at = first.zip(second).map_or(tree.span, |(_, path)| path.key.span);
                let d = Diagnostic::error("HQ0804", at, "a signal is sent a `value`, or values along a `path`");
                self.push(d.help(Help::with(
                    "write one of the two, such as {}",
                    [Snippet::entry("value", "[0.6, 0, 1.2] m")],
                )));
                None
            }
        };
        let noise = tree.get("noise");
        if let Some(e) = noise.filter(|_| !is_straight(of)) {
            let text = format!("noise cannot be added to the numbers of signal `{}`", of.name);
            let d = Diagnostic::error("HQ0804", e.key.span, text);
            self.push(d.note("with noise on each number it would no longer be one").help("leave the noise out"));
        }
        let noise = noise.and_then(|e| self.scenario_number(&e.value, Self::signal_dimension(of)));
        let SignalScriptBlock { from, delay, drop, period, .. } = *block;
        self.ends_after(from, block.to.as_ref());
        Some(SignalScript {
            signal,
            from,
            to: block.to.as_ref().map(|to| to.value),
            path: path?,
            noise: noise.unwrap_or(0.0),
            delay,
            drop,
            period,
            nan: numbers(block.nan.as_ref()),
        })
    }

    pub(super) fn path(&mut self, of: &SignalProgram, value: &Value) -> Option<Vec<(f64, Vec<f64>)>> {
        if !is_straight(of) {
            let d = Diagnostic::error(
                "HQ0804",
                value.span,
                format!("signal `{}` cannot be interpolated linearly", of.name),
            );
            self.push(
                d.note("a path is interpolated linearly between its values").help("write a script for each value"),
            );
            return None;
        }
        let mut all: Vec<(f64, Vec<f64>)> = Vec::new();
        for (tree, WaypointBlock { at, .. }) in self.read_all(value) {
            let value = tree.get("value").and_then(|e| self.signal_value(of, &e.value))?;
            if all.last().is_some_and(|last| last.0 >= at.value) {
                let text = "this waypoint does not come after the one before it";
                let d = Diagnostic::error("HQ0804", self.origins.span(at.at), text);
                self.push(d.help("write the waypoints of a path in the order of their times"));
                return None;
            }
            all.push((at.value, value));
        }
        (!all.is_empty()).then_some(all)
    }

    pub(super) fn scenario_events(
        &mut self,
        events: &[ByName<OneOrEach>],
        program: &Program,
    ) -> Vec<(usize, Vec<f64>)> {
        let names: Vec<&str> = program.interface.events.iter().map(String::as_str).collect();
        let mut all = Vec::new();
        for ByName { name, value, .. } in events {
            let event = self.one_of("event", &name.value, self.origins.span(name.at), &names);
            all.extend(event.map(|event| (event, value.value.numbers().to_vec())));
        }
        all
    }

    pub(super) fn outcome_scripts(&mut self, body: &Block, program: &Program) -> Vec<OutcomeScript> {
        let with_outcomes = program.machine.iter().flat_map(|m| &m.actions).filter(|a| !a.outcomes.is_empty());
        let keys: BTreeSet<&str> = with_outcomes
            .clone()
            .flat_map(|a| a.arguments.first().into_iter().chain([&a.verb]))
            .map(String::as_str)
            .collect();
        let keys: Vec<&str> = keys.into_iter().collect();
        let mut all = Vec::new();
        for e in self.named_entries(body, "outcomes") {
            let key = &e.key.value;
            if self.one_of("action", key, e.key.span, &keys).is_none() {
                continue;
            }
            let of = with_outcomes.clone().filter(|a| a.verb == *key || a.arguments.first() == Some(key));
            let words: BTreeSet<&str> = of.flat_map(|a| &a.outcomes).map(|o| o.0.as_str()).collect();
            let words: Vec<&str> = words.into_iter().chain([NEVER]).collect();
            let blocks = self.read_all(&e.value);
            let requests: Vec<OutcomeProgram> =
                blocks.iter().filter_map(|(tree, block)| self.outcome(tree, block, &words, program)).collect();
            if !requests.is_empty() {
                all.push(OutcomeScript { key: key.clone(), requests });
            }
        }
        all
    }

    fn outcome(
        &mut self,
        tree: &Block,
        OutcomeBlock { outcome, after, .. }: &OutcomeBlock,
        words: &[&str],
        program: &Program,
    ) -> Option<OutcomeProgram> {
        let word = outcome.value.as_str();
        let known = self.one_of("outcome", word, self.origins.span(outcome.at), words);
        let mut sets = Vec::new();
        for e in self.named_entries(tree, "sets") {
            let Some(signal) = self.signal_named(&e.key, program) else { continue };
            let value = self.signal_value(&program.interface.signals[signal], &e.value);
            sets.extend(value.map(|value| (signal, value)));
        }
        known?;
        Some(OutcomeProgram { outcome: (word != NEVER).then(|| word.to_string()), after: *after, sets })
    }

    pub(super) fn push_scripts(&mut self, body: &Block, program: &Program, robot: &BoundRobot) -> Vec<PushScript> {
        let mut all = Vec::new();
        for e in self.named_entries(body, "push") {
            let Some(signal) = self.signal_named(&e.key, program) else { continue };
            if program.interface.signals[signal].kind != "wrench" {
                let d = Diagnostic::error("HQ0804", e.key.span, format!("signal `{}` is no wrench", e.key.value));
                self.push(d.help("name a signal of the type `wrench`"));
                continue;
            }
            for (tree, block) in self.read_all::<PushBlock>(&e.value) {
                self.ends_after(block.from, block.to.as_ref());
                let to = block.to.as_ref().map(|to| to.value);
                let force = self.force(tree, &block, robot);
                all.extend(force.map(|force| PushScript { signal, from: block.from, to, force }));
            }
        }
        all
    }

    pub(super) fn vector_of(&mut self, e: &Entry, dimension: Dimension) -> Option<[f64; 3]> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        constants.vector(&e.value, dimension, self.diagnostics)
    }

    fn force(&mut self, tree: &Block, block: &PushBlock, robot: &BoundRobot) -> Option<Force> {
        let of_hand = ["towards", "link", "stiffness", "damping", "most"].map(|k| tree.get(k));
        let (force, moment) = (tree.get("force"), tree.get("moment"));
        if let (Some(hand), Some(other)) = (of_hand.into_iter().flatten().next(), force.or(moment)) {
            let d = Diagnostic::error("HQ0804", other.key.span, "a push is a force, or a hand that pulls, not both");
            self.push(d.label(hand.key.span, "this belongs to a hand").help("write two pushes, in a list"));
            return None;
        }
        if of_hand.iter().all(Option::is_none) {
            if force.is_none() && moment.is_none() {
                let d = Diagnostic::missing_keys(["force", "link"], tree.span, "this push has no force");
                self.push(d.help(Help::with(
                    "write {}, or {}",
                    [
                        Snippet::entry("force", "[0, 0, -20] N"),
                        Snippet::parts([Snippet::entry("link", "LINK"), Snippet::entry("towards", "[x, y, z] m")]),
                    ],
                )));
                return None;
            }
            let part = |part: &Option<[f64; 3]>| part.unwrap_or([0.0; 3]);
            let ([fx, fy, fz], [mx, my, mz]) = (part(&block.force), part(&block.moment));
            return Some(Force::Constant([fx, fy, fz, mx, my, mz]));
        }
        if block.towards.is_none() || tree.get("link").is_none() {
            let missing = if block.towards.is_none() { "towards" } else { "link" };
            let d = Diagnostic::missing_keys([missing], tree.span, format!("a hand that pulls needs `{missing}`"));
            let examples = [Snippet::entry("link", "right_hand"), Snippet::entry("towards", "[0.6, 0, 1.2] m")];
            self.push(d.help(Help::write_for_instance(Snippet::parts(examples))));
            return None;
        }
        let link = tree.get("link").and_then(|e| {
            let name = text_of(&e.value).unwrap_or_default();
            let arm = robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
            let found = robot.model.link(name).or(arm);
            if found.is_none() {
                self.push(*Box::new(unknown_link(&robot.model, name, e.value.span, &robot.arms)));
            }
            found
        });
        let PushBlock { stiffness, damping, most, .. } = *block;
        Some(Force::Towards { link: link?, point: block.towards?, stiffness, damping, most })
    }

    pub(super) fn lost_readings(&mut self, lost: &[ByName<Vec<LostBlock>>], robot: &BoundRobot) -> Vec<LostReading> {
        let mut all = Vec::new();
        for ByName { name, value, .. } in lost {
            let span = self.origins.span(name.at);
            let key = Value { kind: ValueKind::Text(name.value.clone()), span };
            let model = &robot.model;
            let dofs = joints(std::slice::from_ref(&key), model, &robot.joint_groups, self.diagnostics);
            for LostBlock { from, to } in &value.value {
                self.ends_after(*from, Some(to));
                let measured = dofs.iter().flatten().filter(|d| model.dofs[**d].q_index.is_some());
                all.extend(measured.map(|&dof| LostReading { dof, from: *from, to: to.value }));
            }
        }
        all
    }
}

/// The numbers of a key that may be left out.
pub(super) fn numbers(of: Option<&OneOrEach>) -> Vec<f64> {
    of.map_or_else(Vec::new, |of| of.numbers().to_vec())
}

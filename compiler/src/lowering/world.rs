//! Behaviour of the world in a scenario, bound to signals, events, actions and joints.

use std::collections::BTreeSet;

use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use names::{list, suggest};
use runtime::program::{
    Force, LostReading, OutcomeProgram, OutcomeScript, Program, PushScript, Sending, SignalProgram, SignalScript,
};
use stdlib_tasks::dimension::{Dimension, FORCE, LENGTH, MOMENT, NONE, TIME};

use super::Lowerer;
use crate::expand::quantity;
use crate::expr::Kind;
use crate::expr::constants::Constants;
use crate::forms::{block_of, check_keys, text_of};
use crate::robot_binding::{BoundRobot, joints, unknown_link};
use crate::sections::{BlockSchema, LATE, LOST, OUTCOME, PUSH, SIGNAL_SCRIPT, WAYPOINT};

const STIFFNESS: Dimension = Dimension { m: 0, kg: 1, s: -2, rad: 0 };
const DAMPING: Dimension = Dimension { m: 0, kg: 1, s: -1, rad: 0 };

/// Word for an action without an end.
const NEVER: &str = "never";

/// True if the values of a signal can be interpolated linearly.
fn is_straight(signal: &SignalProgram) -> bool {
    signal.kind != "flag" && !matches!(quantity(&signal.kind), Some((Kind::Rotation | Kind::Pose | Kind::Truth, _)))
}

impl Lowerer<'_> {
    /// A required key of a block.
    pub(super) fn needed<'b>(&mut self, block: &'b Block, key: &str, example: &str) -> Option<&'b Entry> {
        let found = block.get(key);
        if found.is_none() {
            let d = Diagnostic::missing_keys([key], block.span, format!("`{key}` is missing here"));
            self.push(d.help(Help::write_for_instance(Snippet::entry(key, example))));
        }
        found
    }

    /// Blocks of a key: one, or a list of them.
    pub(super) fn blocks<'v>(&mut self, value: &'v Value, what: &str, section: &BlockSchema) -> Vec<&'v Block> {
        let mut all = Vec::new();
        for item in value.items() {
            if let Some(block) = block_of(item, what, self.diagnostics) {
                check_keys(block, section, self.diagnostics);
                all.push(block);
            }
        }
        all
    }

    /// Entries of the block under a key of the scenario.
    pub(super) fn named_entries<'b>(&mut self, body: &'b Block, key: &str) -> &'b [Entry] {
        let block = body.get(key).and_then(|e| block_of(&e.value, &format!("`{key}`"), self.diagnostics));
        block.map_or(&[], |b| &b.entries)
    }

    /// A non-negative number of a block, or the default.
    pub(super) fn number_of(&mut self, block: &Block, key: &str, dimension: Dimension, default: f64) -> f64 {
        let found = block.get(key).and_then(|e| self.scenario_number(&e.value, dimension));
        found.unwrap_or(default)
    }

    /// One time or a list of times.
    pub(super) fn times(&mut self, value: &Value) -> Vec<f64> {
        let items = crate::expr::constants::with_units(value).unwrap_or_else(|| vec![value.clone()]);
        items.iter().filter_map(|v| self.scenario_number(v, TIME)).collect()
    }

    /// Keys `from` and `to` of a block.
    pub(super) fn span_of_time(&mut self, block: &Block) -> (f64, Option<f64>) {
        let from = self.number_of(block, "from", TIME, 0.0);
        let to = block.get("to").and_then(|e| Some((e.value.span, self.scenario_number(&e.value, TIME)?)));
        if let Some((at, to)) = to.filter(|(_, to)| *to <= from) {
            let d = Diagnostic::error("HQ0804", at, format!("this ends at {to} s, before it begins at {from} s"));
            self.push(d.help("write a later end, or an earlier beginning"));
        }
        (from, to.map(|t| t.1))
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
            self.push(match suggest(name, names.iter().copied()) {
                Some(near) => d.meant(near),
                None if names.is_empty() => d.help(format!("this spec declares no {what}")),
                None => d.help(format!("declared are {}", list(names.iter().copied(), 12))),
            });
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
        let sent = || signals().filter(|(_, s)| s.motion.is_none() && !s.is_variable());
        let names: Vec<&str> = sent().map(|(_, s)| s.name.as_str()).collect();
        let found = self.one_of("signal", &key.value, key.span, &names)?;
        sent().nth(found).map(|(i, _)| i)
    }

    /// Numbers of a signal's value.
    pub(super) fn signal_value(&mut self, signal: &SignalProgram, value: &Value) -> Option<Vec<f64>> {
        if signal.kind == "wrench" {
            let block = block_of(value, "a wrench", self.diagnostics)?;
            let keys = ["force", "moment"];
            if let Some(i) = block.entries.iter().position(|e| !keys.contains(&e.key.value.as_str())) {
                self.push(crate::forms::unknown_key(self.diagnostics.len(), block, i, &keys, "a wrench"));
                return None;
            }
            let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
            let mut part = |key: &str, dimension| match block.get(key) {
                Some(e) => constants.vector(&e.value, dimension, self.diagnostics),
                None => Some([0.0; 3]),
            };
            let (force, moment) = (part("force", FORCE), part("moment", MOMENT));
            return Some(force?.into_iter().chain(moment?).collect());
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
            for block in self.blocks(&e.value, "the script of a signal", &SIGNAL_SCRIPT) {
                all.extend(self.signal_script(signal, &program.interface.signals[signal], block));
            }
        }
        all
    }

    fn signal_script(&mut self, signal: usize, of: &SignalProgram, block: &Block) -> Option<SignalScript> {
        let path = match (block.get("value"), block.get("path")) {
            (Some(e), None) => self.signal_value(of, &e.value).map(|value| vec![(0.0, value)]),
            (None, Some(e)) => self.path(of, &e.value),
            (first, second) => {
                let at = first.zip(second).map_or(block.span, |(_, path)| path.key.span);
                let d = Diagnostic::error("HQ0804", at, "a signal is sent a `value`, or values along a `path`");
                self.push(d.help(Help::with(
                    "write one of the two, such as {}",
                    [Snippet::entry("value", "[0.6, 0, 1.2] m")],
                )));
                None
            }
        };
        if let Some(e) = block.get("noise").filter(|_| !is_straight(of)) {
            let text = format!("noise cannot be added to the numbers of signal `{}`", of.name);
            let d = Diagnostic::error("HQ0804", e.key.span, text);
            self.push(d.note("with noise on each number it would no longer be one").help("leave the noise out"));
        }
        let Sending { from, to, noise, delay, drop, period, nan, .. } = self.sending(block, Self::signal_dimension(of));
        Some(SignalScript { signal, from, to, path: path?, noise, delay, drop, period, nan })
    }

    /// Lowers the transmission of values; `dimension` is that of their noise.
    pub(super) fn sending(&mut self, block: &Block, dimension: Dimension) -> Sending {
        let (from, to) = self.span_of_time(block);
        let drop = self.number_of(block, "drop", NONE, 0.0);
        if let Some(e) = block.get("drop").filter(|_| drop > 1.0) {
            let d =
                Diagnostic::error("HQ0308", e.value.span, format!("a share lies between 0 and 1, and this is {drop}"));
            self.push(
                d.help(Help::with("write for instance {} for one value in twenty", [Snippet::entry("drop", "0.05")])),
            );
        }
        Sending {
            from,
            to,
            noise: self.number_of(block, "noise", dimension, 0.0),
            delay: self.number_of(block, "delay", TIME, 0.0),
            drop: drop.min(1.0),
            period: self.number_of(block, "period", TIME, 0.0),
            nan: block.get("nan").map(|e| self.times(&e.value)).unwrap_or_default(),
            gaps: Vec::new(),
        }
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
        for block in self.blocks(value, "a waypoint", &WAYPOINT) {
            let at = self.needed(block, "at", "3 s").and_then(|e| Some((self.scenario_number(&e.value, TIME)?, e)));
            let value = self.needed(block, "value", "[0, 0, 1] m").and_then(|e| self.signal_value(of, &e.value));
            let ((at, e), value) = (at?, value?);
            if all.last().is_some_and(|l| l.0 >= at) {
                let d =
                    Diagnostic::error("HQ0804", e.value.span, "this waypoint does not come after the one before it");
                self.push(d.help("write the waypoints of a path in the order of their times"));
                return None;
            }
            all.push((at, value));
        }
        (!all.is_empty()).then_some(all)
    }

    pub(super) fn scenario_events(&mut self, body: &Block, program: &Program) -> Vec<(usize, Vec<f64>)> {
        let names: Vec<&str> = program.interface.events.iter().map(String::as_str).collect();
        let mut all = Vec::new();
        for e in self.named_entries(body, "events") {
            let times = self.times(&e.value);
            all.extend(self.one_of("event", &e.key.value, e.key.span, &names).map(|event| (event, times)));
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
            let blocks = self.blocks(&e.value, "an outcome", &OUTCOME);
            let requests: Vec<OutcomeProgram> =
                blocks.into_iter().filter_map(|b| self.outcome(b, &words, program)).collect();
            if !requests.is_empty() {
                all.push(OutcomeScript { key: key.clone(), requests });
            }
        }
        all
    }

    fn outcome(&mut self, block: &Block, words: &[&str], program: &Program) -> Option<OutcomeProgram> {
        let e = self.needed(block, "outcome", words[0])?;
        let word = text_of(&e.value).unwrap_or_default();
        let known = self.one_of("outcome", word, e.value.span, words);
        let after = self.number_of(block, "after", TIME, 0.0);
        let mut sets = Vec::new();
        for e in self.named_entries(block, "sets") {
            let Some(signal) = self.signal_named(&e.key, program) else { continue };
            let value = self.signal_value(&program.interface.signals[signal], &e.value);
            sets.extend(value.map(|value| (signal, value)));
        }
        known?;
        Some(OutcomeProgram { outcome: (word != NEVER).then(|| word.to_string()), after, sets })
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
            for block in self.blocks(&e.value, "a push", &PUSH) {
                let (from, to) = self.span_of_time(block);
                let force = self.force(block, robot);
                all.extend(force.map(|force| PushScript { signal, from, to, force }));
            }
        }
        all
    }

    pub(super) fn vector_of(&mut self, e: &Entry, dimension: Dimension) -> Option<[f64; 3]> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        constants.vector(&e.value, dimension, self.diagnostics)
    }

    fn force(&mut self, block: &Block, robot: &BoundRobot) -> Option<Force> {
        let of_hand = ["towards", "link", "stiffness", "damping", "most"].map(|k| block.get(k));
        let (force, moment) = (block.get("force"), block.get("moment"));
        if let (Some(hand), Some(other)) = (of_hand.into_iter().flatten().next(), force.or(moment)) {
            let d = Diagnostic::error("HQ0804", other.key.span, "a push is a force, or a hand that pulls, not both");
            self.push(d.label(hand.key.span, "this belongs to a hand").help("write two pushes, in a list"));
            return None;
        }
        if of_hand.iter().all(Option::is_none) {
            if force.is_none() && moment.is_none() {
                let d = Diagnostic::missing_keys(["force", "link"], block.span, "this push has no force");
                self.push(d.help(Help::with(
                    "write {}, or {}",
                    [
                        Snippet::entry("force", "[0, 0, -20] N"),
                        Snippet::parts([Snippet::entry("link", "LINK"), Snippet::entry("towards", "[x, y, z] m")]),
                    ],
                )));
                return None;
            }
            let (f, m) = (force.map(|e| self.vector_of(e, FORCE)), moment.map(|e| self.vector_of(e, MOMENT)));
            let (f, m) = (f.unwrap_or(Some([0.0; 3]))?, m.unwrap_or(Some([0.0; 3]))?);
            return Some(Force::Constant([f[0], f[1], f[2], m[0], m[1], m[2]]));
        }
        let point = self.needed(block, "towards", "[0.6, 0, 1.2] m").and_then(|e| self.vector_of(e, LENGTH));
        let link = self.needed(block, "link", "right_hand").and_then(|e| {
            let name = text_of(&e.value).unwrap_or_default();
            let arm = robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
            let found = robot.model.link(name).or(arm);
            if found.is_none() {
                self.push(*Box::new(unknown_link(&robot.model, name, e.value.span, &robot.arms)));
            }
            found
        });
        let stiffness = self.number_of(block, "stiffness", STIFFNESS, 200.0);
        let damping = self.number_of(block, "damping", DAMPING, 20.0);
        let most = self.number_of(block, "most", FORCE, 30.0);
        Some(Force::Towards { link: link?, point: point?, stiffness, damping, most })
    }

    pub(super) fn late_ticks(&mut self, body: &Block) -> Vec<(f64, f64)> {
        let Some(e) = body.get("late") else { return Vec::new() };
        let mut all = Vec::new();
        for block in self.blocks(&e.value, "a late tick", &LATE) {
            let at = self.needed(block, "at", "3 s").and_then(|e| self.scenario_number(&e.value, TIME));
            let by = self.needed(block, "by", "30 ms").and_then(|e| self.scenario_number(&e.value, TIME));
            all.extend(at.zip(by));
        }
        all
    }

    pub(super) fn lost_readings(&mut self, body: &Block, robot: &BoundRobot) -> Vec<LostReading> {
        let mut all = Vec::new();
        for e in self.named_entries(body, "lost") {
            let key = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
            let model = &robot.model;
            let dofs = joints(std::slice::from_ref(&key), model, &robot.joint_groups, self.diagnostics);
            for block in self.blocks(&e.value, "a lost reading", &LOST) {
                let (from, to) = self.span_of_time(block);
                let there = (self.needed(block, "from", "3 s"), self.needed(block, "to", "3.02 s"));
                let (Some(_), Some(_), Some(to)) = (there.0, there.1, to) else { continue };
                let measured = dofs.iter().flatten().filter(|d| model.dofs[**d].q_index.is_some());
                all.extend(measured.map(|&dof| LostReading { dof, from, to }));
            }
        }
        all
    }
}

//! Copies trees: substitutes arguments for parameters, fills holes such as `${side}`, and renames values to their names
//! in the program.

use std::collections::BTreeMap;

use dsl::holes::{self, Factor, Part};
use dsl::tree::{Block, Comments, Entry, Number, TaskDefinition, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, SourceId, Span, Spanned};
use names::suggest;

use super::{Class, Expander};
use crate::diagnostics::refused::Refused;
use crate::forms::{KEY_SEPARATOR, text_of, written};
use crate::units::as_written;

/// Meaning of a parameter, or of the variable of a repetition.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Bound {
    /// A value, already copied.
    Value(Value),
    /// Names of joints, already copied; used as keys, they stay names.
    Joints(Value),
    /// A task, already copied.
    Task(dsl::tree::MemberTask),
}

/// Maximum height of a tree that is substituted for a name.
const MAX_HEIGHT: usize = 128;

/// Meaning of parameters, by name.
pub(super) type Bindings = BTreeMap<String, Bound>;

/// Context of a copy.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Module whose names are in scope.
    pub module: usize,
    /// Parameters in scope.
    pub bound: Bindings,
    /// Span and description of the use for which the copy is made.
    used: Option<(Span, &'static str)>,
    /// Instances of texts for this use.
    instances: BTreeMap<SourceId, SourceId>,
    /// False while repetitions are unrolled and names are not resolved yet.
    resolve: bool,
}

impl Frame {
    /// Frame of declarations that are taken unchanged from a module.
    pub fn of(module: usize) -> Frame {
        Frame { module, bound: Bindings::new(), used: None, instances: BTreeMap::new(), resolve: true }
    }

    /// Frame of a declaration of a module that is used with arguments.
    pub fn used(module: usize, bound: Bindings, at: Span) -> Frame {
        Frame { bound, used: Some((at, "used here")), ..Frame::of(module) }
    }

    /// Frame before names are resolved.
    pub fn unresolved(module: usize) -> Frame {
        Frame { resolve: false, ..Frame::of(module) }
    }

    /// True if the tree is copied for a use.
    pub fn copies(&self) -> bool {
        self.used.is_some()
    }

    /// Returns the frame with one more name, for one value of a repetition.
    pub fn with(&self, name: &str, value: Value, at: Span) -> Frame {
        let mut bound = self.bound.clone();
        bound.insert(name.to_string(), Bound::Value(value));
        Frame { bound, used: Some((at, "for this value")), instances: BTreeMap::new(), ..self.clone() }
    }
}

impl Expander<'_> {
    /// Maps a span to the copy.
    pub(super) fn at(&mut self, span: Span, frame: &mut Frame) -> Span {
        let Some((used, what)) = frame.used else { return span };
        let sources = &mut *self.sources;
        let source = frame.instances.entry(span.source).or_insert_with(|| sources.instance(span.source, used, what));
        Span { source: *source, ..span }
    }

    /// Copies a name and fills its holes.
    pub(super) fn name(&mut self, name: &Spanned<String>, frame: &mut Frame) -> Spanned<String> {
        let span = self.at(name.span, frame);
        Spanned::new(self.filled(&name.value, true, span, frame), span)
    }

    /// Fills the holes of a text. A hole in a name accepts only parts of identifiers.
    fn filled(&mut self, text: &str, name: bool, span: Span, frame: &Frame) -> String {
        let mut out = String::with_capacity(text.len());
        for part in holes::parts(text) {
            let hole = match part {
                Part::Text(text) => {
                    out.push_str(text);
                    continue;
                }
                Part::Hole(hole) => hole,
            };
            let plain = frame.bound.contains_key(hole);
            let found = if plain { self.hole(hole, name, span, frame) } else { self.sum(hole, name, span, frame) };
            match found {
                Ok(text) => out.push_str(&text),
                // Before names are resolved, parameters of the enclosing declaration stay in place.
                Err(None) if !frame.resolve => out.push_str(&format!("${{{}}}", partly(hole, frame))),
                Err(None) => {
                    let unknown = |f: &Factor| matches!(f, Factor::Name(n) if !frame.bound.contains_key(*n));
                    let sum = holes::sum(hole).unwrap_or_default();
                    let name = match sum.iter().flat_map(|p| &p.1).find(|f| unknown(f)) {
                        Some(Factor::Name(name)) => name,
                        _ => hole,
                    };
                    let d = Diagnostic::error("HQ0219", span, format!("there is no `{name}` in `${{{hole}}}`"));
                    let near = suggest(name, frame.bound.keys().map(String::as_str)).map(str::to_string);
                    self.fail(match near {
                        Some(near) => d.meant(format!("${{{}}}", hole.replace(name, &near))),
                        None => d.help("use the variable of an enclosing `for`, or a parameter of the declaration"),
                    });
                    out.push_str("missing");
                }
                Err(Some(d)) => {
                    self.fail(*d);
                    out.push_str("missing");
                }
            }
        }
        out
    }

    /// Text of a hole that is a sum; `Err(None)` if a name in it is unknown.
    fn sum(&self, hole: &str, name: bool, span: Span, frame: &Frame) -> Result<String, Refused> {
        let Some(sum) = holes::sum(hole) else { return Err(None) };
        let names =
            || sum.iter().flat_map(|p| &p.1).filter_map(|f| if let Factor::Name(n) = f { Some(*n) } else { None });
        if names().any(|n| !frame.bound.contains_key(n)) {
            return Err(None);
        }
        let whole = |n: &str| frame.bound.get(n).and_then(whole_number);
        if let Some(bad) = names().find(|n| whole(n).is_none()) {
            let text = format!("`{bad}` in `${{{hole}}}` is no whole number");
            let mut d = Diagnostic::error("HQ0219", span, text);
            if let Some(Bound::Value(value) | Bound::Joints(value)) = frame.bound.get(bad) {
                d = d.label(value.span, "this");
            }
            return Err(Some(Box::new(d.help(Help::with(
                "only the variable of a range of whole numbers can be used in arithmetic: {}",
                [Snippet::each("for i in 1..4", "for: [ { name: i, in: 1..4, .. } ]")],
            )))));
        }
        match holes::number(&sum, whole).filter(|n| !name || *n >= 0) {
            Some(n) => Ok(n.to_string()),
            None => {
                let text = format!("`${{{hole}}}` is negative or too large, and no part of a name");
                let d = Diagnostic::error("HQ0219", span, text);
                Err(Some(Box::new(d.help("change the range, or the number that is added"))))
            }
        }
    }

    /// Text of a hole; `Err(None)` if its name is unknown.
    fn hole(&self, hole: &str, name: bool, span: Span, frame: &Frame) -> Result<String, Refused> {
        let text = match frame.bound.get(hole) {
            None => return Err(None),
            Some(Bound::Value(value) | Bound::Joints(value)) => match &as_written(value).kind {
                ValueKind::Number(n) => Some(n.text.clone()),
                ValueKind::Missing => return Ok("missing".to_string()),
                _ => text_of(as_written(value)).map(str::to_string),
            },
            Some(Bound::Task(dsl::tree::MemberTask::Name(task))) => Some(written(&task.value).to_string()),
            Some(Bound::Task(_)) => None,
        };
        let part = |t: &String| !name || (!t.is_empty() && t.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_'));
        text.filter(part).ok_or_else(|| {
            let d = Diagnostic::error("HQ0219", span, format!("`${{{hole}}}` does not give a part of a name"));
            let d = match frame.bound.get(hole) {
                Some(Bound::Value(value) | Bound::Joints(value)) => d.label(value.span, "this"),
                _ => d,
            };
            Some(Box::new(d.help("give a name or a whole number there")))
        })
    }

    /// Copies a value.
    pub(super) fn value(&mut self, value: &Value, frame: &mut Frame) -> Value {
        // A tree that is not copied for a use does not count as a copy.
        if frame.copies() && !self.count(value.span) {
            return Value { kind: ValueKind::Missing, span: value.span };
        }
        let span = self.at(value.span, frame);
        let one = |e: &mut Self, v: &Value, frame: &mut Frame| Box::new(e.value(v, frame));
        let kind = match &value.kind {
            ValueKind::Number(_) | ValueKind::Missing => value.kind.clone(),
            ValueKind::Text(text) => ValueKind::Text(self.filled(text, false, span, frame)),
            ValueKind::Name(name) => return self.named(name, span, frame),
            ValueKind::Unit(of, unit) => {
                let unit = dsl::tree::Unit { span: self.at(unit.span, frame), ..unit.clone() };
                ValueKind::Unit(one(self, of, frame), unit)
            }
            ValueKind::Call(function, args) => {
                let function = self.name(function, frame);
                ValueKind::Call(function, args.iter().map(|a| self.value(a, frame)).collect())
            }
            ValueKind::Named(name, of) => {
                let of = one(self, of, frame);
                ValueKind::Named(self.name(name, frame), of)
            }
            ValueKind::Field(of, field) => {
                let of = one(self, of, frame);
                ValueKind::Field(of, self.name(field, frame))
            }
            ValueKind::List(items) => ValueKind::List(items.iter().map(|i| self.value(i, frame)).collect()),
            ValueKind::Block(block) => {
                let mut block = self.block(block, frame);
                for key in block.entries.iter_mut().map(|e| &mut e.key) {
                    if let Some(Bound::Joints(joints)) = frame.bound.get(&key.value) {
                        *key = Spanned::new(joint_key(joints), joints.span);
                    }
                }
                ValueKind::Block(block)
            }
            ValueKind::In(of, axes) => {
                let of = one(self, of, frame);
                let at = self.at(axes.span, frame);
                let named = self.named(&axes.value, at, frame);
                ValueKind::In(of, Spanned::new(text_of(&named).unwrap_or(&axes.value).to_string(), at))
            }
            ValueKind::Negate(of) => ValueKind::Negate(one(self, of, frame)),
            ValueKind::Not(of) => ValueKind::Not(one(self, of, frame)),
            ValueKind::Binary(op, left, right) => {
                let op = Spanned::new(op.value, self.at(op.span, frame));
                let left = one(self, left, frame);
                ValueKind::Binary(op, left, one(self, right, frame))
            }
        };
        Value { kind, span }
    }

    /// Resolves a name: to an argument, or to the name of a value or a task in the program.
    fn named(&mut self, name: &str, span: Span, frame: &mut Frame) -> Value {
        match frame.bound.get(name) {
            Some(Bound::Value(value) | Bound::Joints(value)) => {
                // Counted before the copy, because copies of copies grow exponentially.
                let kind = if self.count_copy(value) { value.kind.clone() } else { ValueKind::Missing };
                return Value { kind, span: value.span };
            }
            Some(Bound::Task(_)) => {
                let d = Diagnostic::error("HQ0215", span, format!("`{name}` is a task, and a value is needed here"));
                self.fail(d.help("add a task to a level"));
                return Value { kind: ValueKind::Missing, span };
            }
            None => {}
        }
        let written = name;
        let name = self.filled(written, true, span, frame);
        // `${i}` and `${i + 1}` alone are numbers.
        if written.starts_with("${")
            && let Ok(value) = name.parse::<u32>()
        {
            return Value { kind: ValueKind::Number(Number { value: f64::from(value), text: name }), span };
        }
        let target = match frame.resolve {
            true => self.value_name(frame.module, &name, span).or_else(|| self.task_name(frame.module, &name)),
            false => None,
        };
        let kind = match target {
            Some(target) if target != name => ValueKind::Name(format!("{name}@{target}")),
            _ => ValueKind::Name(name),
        };
        Value { kind, span }
    }

    /// Counts the nodes of an argument before it is copied; returns false if there are too many.
    fn count_copy(&mut self, value: &Value) -> bool {
        let mut open = vec![value];
        while let Some(value) = open.pop() {
            if !self.count(value.span) {
                return false;
            }
            open.extend(value.parts());
        }
        true
    }

    /// Returns true if a value is shallow enough to be nested in others; reports it otherwise.
    pub(super) fn shallow(&mut self, value: &Value) -> bool {
        let mut open = vec![(value, 1)];
        while let Some((part, depth)) = open.pop() {
            if depth > MAX_HEIGHT {
                let text = format!("more than {MAX_HEIGHT} nested operations");
                self.fail(Diagnostic::error("HQ0218", value.span, text).help("name a part of it with `let`"));
                return false;
            }
            open.extend(part.parts().into_iter().map(|p| (p, depth + 1)));
        }
        true
    }

    /// Copies a block.
    pub(super) fn block(&mut self, block: &Block, frame: &mut Frame) -> Block {
        let entries = self.entries(&block.entries, frame);
        Block { entries, span: self.at(block.span, frame), ..Block::default() }
    }

    /// Copies entries and fills the holes of their keys.
    pub(super) fn entries(&mut self, entries: &[Entry], frame: &mut Frame) -> Vec<Entry> {
        let mut out: Vec<Entry> = Vec::with_capacity(entries.len());
        // The parser compared the keys without holes.
        let is_pattern = |e: &Entry| e.key.value.contains("${");
        let compared = entries.iter().any(is_pattern);
        let mut seen: BTreeMap<String, Span> = BTreeMap::new();
        for e in entries {
            let span = self.at(e.key.span, frame);
            // A key may be a pattern.
            let key = Spanned::new(self.filled(&e.key.value, true, span, frame), span);
            if let Some(first) = seen.get(&key.value).filter(|_| is_pattern(e)) {
                let d = Diagnostic::error("HQ0207", key.span, format!("`{}` is given twice", key.value));
                let d = d.label(*first, "first here");
                self.fail(d.help("keep one of them"));
                continue;
            }
            if compared {
                seen.entry(key.value.clone()).or_insert(key.span);
            }
            let value = self.value(&e.value, frame);
            out.push(Entry { key, value, comments: Comments::default() });
        }
        out
    }

    /// Copies the definition of a task, without a look at its type.
    pub(super) fn copied(&mut self, d: &TaskDefinition, frame: &mut Frame) -> TaskDefinition {
        TaskDefinition {
            kind: self.name(&d.kind, frame),
            args: d.args.iter().map(|a| self.value(a, frame)).collect(),
            named: self.entries(&d.named, frame),
            body: self.block(&d.body, frame),
            span: self.at(d.span, frame),
        }
    }

    /// Name of a value in the program, if the name is that of a value.
    fn value_name(&mut self, module: usize, name: &str, at: Span) -> Option<String> {
        match self.find(module, Class::Value, name) {
            Ok(found) => self.emit_value(found, at),
            Err(_) => None,
        }
    }
}

/// Integer value of a binding.
fn whole_number(bound: &Bound) -> Option<i64> {
    let Bound::Value(value) = bound else { return None };
    let (minus, of) = match &as_written(value).kind {
        ValueKind::Negate(of) => (true, &of.kind),
        kind => (false, kind),
    };
    match of {
        ValueKind::Number(n) if n.value.fract() == 0.0 && n.value.abs() < 1e9 => {
            Some(if minus { -(n.value as i64) } else { n.value as i64 })
        }
        _ => None,
    }
}

/// Replaces the known names in a hole by numbers; the others are resolved later.
fn partly(hole: &str, frame: &Frame) -> String {
    let Some(sum) = holes::sum(hole).filter(|s| s.len() > 1 || s.iter().any(|p| p.0 || p.1.len() > 1)) else {
        return hole.to_string();
    };
    let known = |f: &Factor| match f {
        Factor::Number(n) => Some(*n),
        Factor::Name(name) => frame.bound.get(*name).and_then(whole_number),
    };
    let product = |(minus, factors): &holes::Product| {
        let minus = factors.iter().filter_map(known).fold(*minus, |minus, n| minus ^ (n < 0));
        let word = |f: &Factor| match (f, known(f)) {
            (_, Some(n)) => n.unsigned_abs().to_string(),
            (Factor::Name(name), None) => (*name).to_string(),
            (Factor::Number(n), None) => n.to_string(),
        };
        let sign = if minus { "-" } else { "+" };
        format!("{sign}{}", factors.iter().map(word).collect::<Vec<_>>().join("*"))
    };
    let text: String = sum.iter().map(product).collect();
    text.strip_prefix('+').map_or(text.clone(), str::to_string)
}

/// Joins the names of joints to one key; see [`crate::forms::names_of_key`].
fn joint_key(joints: &Value) -> String {
    joints.items().iter().filter_map(text_of).collect::<Vec<_>>().join(KEY_SEPARATOR)
}

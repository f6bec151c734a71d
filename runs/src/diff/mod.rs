//! Differences in behaviour between two specs: what a reviewer has to know, whatever moved in the text.
//!
//! Both are described by [`facts`], each a subject (a level, a task, a state) with attributes; the differences are those of
//! the facts. Names identify subjects: one that is renamed is removed and added.

mod facts;
mod render;
mod values;

use compiler::Compiled;
use dsl::Severity;
use serde::Serialize;

pub use render::{Form, render};

/// Something that is declared, with its attributes.
#[derive(Clone, Debug, PartialEq)]
struct Subject {
    name: String,
    facts: Vec<Fact>,
}

/// An attribute of a subject.
#[derive(Clone, Debug, PartialEq)]
struct Fact {
    attribute: String,
    text: String,
}

/// A difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The subject: `level safety of stack work`.
    pub subject: String,
    /// The attribute; empty for a subject that is added or removed as a whole.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub attribute: String,
    /// Text of the attribute before; none: it was not there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<String>,
    /// Text of the attribute after; none: it is gone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
}

/// A warning of the compiler that only one of the two has.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Finding {
    /// Its code.
    pub code: String,
    /// Its message.
    pub message: String,
}

/// All differences of two compiled specs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Differences {
    /// Differences in behaviour.
    pub behaviour: Vec<Difference>,
    /// Warnings that are new.
    pub gained: Vec<Finding>,
    /// Warnings that are gone.
    pub lost: Vec<Finding>,
    /// True if one of the two was compiled before, so that its warnings are not known.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub findings_unknown: bool,
}

impl Differences {
    /// Compares two compiled specs; `compiled` says which of them are compiled programs, whose warnings are not known.
    pub fn new(before: &Compiled, after: &Compiled, compiled: [bool; 2]) -> Differences {
        let behaviour = compare(&facts::of(before), &facts::of(after));
        let findings_unknown = compiled.contains(&true);
        let (mut gained, mut lost) = (Vec::new(), Vec::new());
        if !findings_unknown {
            (lost, gained) = (findings(before), findings(after));
            let both: Vec<Finding> = lost.iter().filter(|of| gained.contains(of)).cloned().collect();
            lost.retain(|of| !both.contains(of));
            gained.retain(|of| !both.contains(of));
        }
        Differences { behaviour, gained, lost, findings_unknown }
    }

    /// Returns true if there is none.
    pub fn is_empty(&self) -> bool {
        self.behaviour.is_empty() && self.gained.is_empty() && self.lost.is_empty()
    }
}

fn findings(of: &Compiled) -> Vec<Finding> {
    let warnings = of.report.diagnostics.iter().filter(|d| d.severity == Severity::Warning);
    let mut all: Vec<Finding> =
        warnings.map(|d| Finding { code: d.code.to_string(), message: d.message.clone() }).collect();
    all.sort();
    all.dedup();
    all
}

/// Compares subjects by name, in the order of the first list, with new ones behind.
fn compare(before: &[Subject], after: &[Subject]) -> Vec<Difference> {
    let mut all = Vec::new();
    let whole = |subject: &Subject, is_new: bool| {
        let (old, new) = if is_new { (None, Some(String::new())) } else { (Some(String::new()), None) };
        Difference { subject: subject.name.clone(), attribute: String::new(), before: old, after: new }
    };
    for old in before {
        match after.iter().find(|new| new.name == old.name) {
            None => all.push(whole(old, false)),
            Some(new) => attributes(old, new, &mut all),
        }
    }
    all.extend(after.iter().filter(|new| before.iter().all(|old| old.name != new.name)).map(|new| whole(new, true)));
    // The levels of a stack come and go with it.
    let stacks: Vec<String> = all.iter().filter(|d| d.attribute.is_empty()).map(|d| d.subject.clone()).collect();
    let with_stack = |d: &Difference| {
        let stack = d.subject.split_once(" of stack ").map(|(_, stack)| format!("stack {stack}"));
        d.attribute.is_empty() && stack.is_some_and(|stack| stacks.contains(&stack))
    };
    all.retain(|d| !with_stack(d));
    all
}

fn attributes(before: &Subject, after: &Subject, all: &mut Vec<Difference>) {
    let start = all.len();
    let text = |of: &Subject, attribute: &str| {
        of.facts.iter().find(|fact| fact.attribute == attribute).map(|fact| fact.text.clone())
    };
    let added = after.facts.iter().filter(|fact| text(before, &fact.attribute).is_none());
    for fact in before.facts.iter().chain(added) {
        let [old, new] = [text(before, &fact.attribute), text(after, &fact.attribute)];
        if old != new {
            let (subject, attribute) = (before.name.clone(), fact.attribute.clone());
            all.push(Difference { subject, attribute, before: old, after: new });
        }
    }
    // An order has changed on its own only if its parts are the same.
    if all.len() > start + 1 {
        let mut index = 0;
        all.retain(|difference| {
            index += 1;
            index <= start || difference.attribute != facts::ORDER
        });
    }
}

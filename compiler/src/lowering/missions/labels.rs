//! Labels of a mission: what people read in place of names, checked so that pages and terminals can show them.

use dsl::tree::{Mission, MissionMember};
use dsl::{Diagnostic, Span};
use mission::kinds::layers::problem::Task;
use mission::labels::{Labels, Unfit, check};

use super::super::Lowerer;
use crate::forms::text_of;

impl Lowerer<'_> {
    /// The labels that a mission gives its members and layers, and to these tasks, which stand in the order of the text.
    pub(super) fn labels(&mut self, m: &Mission, tasks: &[Task]) -> Labels {
        let mut labels = Labels::default();
        let mut names = tasks.iter().map(|task| &task.name);
        for member in &m.members {
            let text = self.label(member);
            let of = if member.role.value == "layer" { &mut labels.layers } else { &mut labels.members };
            of.extend(text.map(|text| (member.name.value.clone(), text)));
            for task in member.members.iter().filter(|inner| inner.role.value == "task") {
                let (name, text) = (names.next(), self.label(task));
                labels.tasks.extend(name.cloned().zip(text));
            }
        }
        labels
    }

    /// The label of a member, if it has one that can be shown.
    fn label(&mut self, member: &MissionMember) -> Option<String> {
        let value = &member.settings.get("label")?.value;
        let Some(text) = text_of(value) else {
            let d = Diagnostic::error("HQ0304", value.span, "`label` is one text, in quotes");
            self.push(d.help("write for instance `label \"Łukasz\"`"));
            return None;
        };
        match check(text) {
            Ok(()) => Some(text.to_string()),
            Err(why) => {
                self.push(unfit(text, why, value.span));
                None
            }
        }
    }

    /// Reports the first of these agents whom people cannot tell from one before.
    pub(super) fn mistaken_labels<'n>(
        &mut self,
        m: &Mission,
        agents: impl Iterator<Item = &'n String>,
        labels: &Labels,
    ) {
        let names: Vec<&str> = agents.map(String::as_str).collect();
        let Some((first, second)) = labels.mistaken(names.iter().copied()) else { return };
        let label = |index: usize| {
            let name = names.get(index).copied().unwrap_or_default();
            let member = m.members.iter().find(|member| member.name.value == name && member.role.value != "layer");
            let at = member.map_or(m.name.span, |member| {
                member.settings.get("label").map_or(member.name.span, |entry| entry.value.span)
            });
            (name, at)
        };
        let ((one, first), (other, second)) = (label(first), label(second));
        let text =
            format!("people cannot tell `{one}` and `{other}` apart: both are shown as \"{}\"", labels.member(other));
        let d = Diagnostic::error("HQ0916", second, text).label(first, "the other one");
        self.push(
            d.note("case, wide spaces and characters without a form of their own make no difference to a reader")
                .help("give one of them a label of its own, with a surname or a number"),
        );
    }
}

fn unfit(text: &str, why: Unfit, at: Span) -> Diagnostic {
    let d = Diagnostic::error("HQ0915", at, format!("this label cannot be shown: {why}"));
    match why {
        Unfit::Empty => d.help("write a text, or leave `label` out: then the name is shown"),
        Unfit::Edge => d.help(format!("write `label \"{}\"`", text.trim())),
        Unfit::Command(_) => {
            d.help("write letters, digits and signs that are seen; the direction of a script needs no mark")
        }
        Unfit::Long(_) => d.help("write the name by which people call it"),
    }
}

//! Labels of a declared mission, checked so that pages and terminals can show them.

use blocks::{Bound, Origin, Snippet};

use super::{DeclaredMember, DeclaredMission, Remark, Remarks};
use crate::labels::{Labels, Unfit, check};

/// Reads the labels of members, of those that hold members, and of the members inside these, whose names are `inner` in
/// the order written.
pub fn labels<'n>(
    declared: &DeclaredMission,
    inner: impl IntoIterator<Item = &'n String>,
    remarks: &mut Remarks,
) -> Labels {
    let mut labels = Labels::default();
    let mut names = inner.into_iter();
    for member in &declared.members {
        let text = label(member, remarks);
        let holds_members = member.settings.schema.roles().next().is_some();
        let of = if holds_members { &mut labels.layers } else { &mut labels.members };
        of.extend(text.map(|text| (member.name.clone(), text)));
        for task in &member.members {
            let (name, text) = (names.next(), label(task, remarks));
            labels.tasks.extend(name.cloned().zip(text));
        }
    }
    labels
}

/// Reads the label of a member, if it has one that can be shown.
fn label(member: &DeclaredMember, remarks: &mut Remarks) -> Option<String> {
    let value = member.settings.get("label")?;
    let Bound::Text(text) = &value.value else { return None };
    match check(text.as_str()) {
        Ok(()) => Some(text.clone()),
        Err(why) => {
            remarks.push(unfit(text.as_str(), why, value.at));
            None
        }
    }
}

/// Reports the first of these members whom people cannot tell from one before.
pub fn mistaken<'n>(
    declared: &DeclaredMission,
    members: impl Iterator<Item = &'n str>,
    labels: &Labels,
    remarks: &mut Remarks,
) {
    let names: Vec<&str> = members.collect();
    let Some((first, second)) = labels.mistaken(names.iter().copied()) else { return };
    let name = |index: usize| names.get(index).copied().unwrap_or_default();
    let place = |name: &str| {
        let flat = |member: &&DeclaredMember| member.name == name && member.settings.schema.roles().next().is_none();
        let member = declared.members.iter().find(flat);
        member.map_or(declared.at, |member| member.settings.origin("label").unwrap_or(member.at))
    };
    let (one, other) = (name(first), name(second));
    let text = format!("`{one}` and `{other}` have the same label, \"{}\"", labels.member(other));
    remarks.push(
        Remark::error("HQ0916", place(other), text)
            .label(place(one), "the other one")
            .note("letter case, wide spaces and invisible characters do not distinguish labels")
            .help("give one of them a label of its own, with a surname or a number"),
    );
}

fn unfit(text: &str, why: Unfit, at: Origin) -> Remark {
    let remark = Remark::error("HQ0915", at, format!("this label cannot be shown: {why}"));
    match why {
        Unfit::Empty => remark.help("write a text, or remove `label` to show the name"),
        Unfit::Edge => remark.help(Snippet::entry("label", format!("\"{}\"", text.trim()))),
        Unfit::Command(_) => remark.help("write visible characters; the direction of a script needs no mark"),
        Unfit::Long(_) => remark.help("write the name that people use"),
    }
}

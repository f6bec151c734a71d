//! Labels: texts in any script that are displayed instead of the names of the language.
//!
//! A name is an identifier in the letters of the language; a label is only displayed. Nothing is looked up by its
//! label, so that similar letters of two scripts confuse no program. Agents (robots, people, working robots), objects
//! and places share one namespace, and tasks and layers have their own; labels are stored in the same manner.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::characters::commands;

/// Maximum length of a label, in characters.
pub const LONGEST: usize = 60;

/// Labels of a mission by name; an item without a label is displayed by its name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Labels {
    /// Labels of agents, objects and places.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub members: BTreeMap<String, String>,
    /// Labels of tasks.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tasks: BTreeMap<String, String>,
    /// Labels of layers.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub layers: BTreeMap<String, String>,
}

/// Reason why a text is not valid as a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unfit {
    /// No character of it is visible.
    #[error("it has no visible character")]
    Empty,
    /// It begins or ends with space.
    #[error("it begins or ends with space")]
    Edge,
    /// It contains a control character for terminals or pages, or one that changes the direction of writing.
    #[error("U+{:04X} is a control character", u32::from(*.0))]
    Command(char),
    /// It is longer than [`LONGEST`].
    #[error("it has {0} characters, and the maximum is {LONGEST}")]
    Long(usize),
}

/// Checks that a text is valid as a label.
///
/// # Errors
/// The first reason against it.
pub fn check(text: &str) -> Result<(), Unfit> {
    if let Some(c) = text.chars().find(|c| commands(*c)) {
        return Err(Unfit::Command(c));
    }
    if folded(text).is_empty() {
        return Err(Unfit::Empty);
    }
    if text.trim() != text {
        return Err(Unfit::Edge);
    }
    let length = text.chars().count();
    if length > LONGEST { Err(Unfit::Long(length)) } else { Ok(()) }
}

/// Returns true if people cannot distinguish two texts: case, width of spaces and invisible characters are ignored.
pub fn alike(a: &str, b: &str) -> bool {
    folded(a) == folded(b)
}

fn folded(text: &str) -> String {
    let seen: String = text.chars().filter(|c| !unseen(*c)).collect();
    seen.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase()
}

/// Returns true for invisible characters: soft hyphens, joiners, fillers, variation selectors.
fn unseen(c: char) -> bool {
    matches!(c, '\u{ad}' | '\u{34f}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}' | '\u{180b}'..='\u{180f}')
        || matches!(c, '\u{200b}'..='\u{200d}' | '\u{2060}'..='\u{2065}' | '\u{2800}' | '\u{3164}' | '\u{fe00}'..='\u{fe0f}')
        || matches!(c, '\u{feff}' | '\u{ffa0}' | '\u{e0000}'..='\u{e0fff}')
}

impl Labels {
    /// Returns true if there are no labels.
    pub fn is_empty(&self) -> bool {
        self.members.is_empty() && self.tasks.is_empty() && self.layers.is_empty()
    }

    /// Returns the displayed text of an agent, an object or a place.
    pub fn member<'a>(&'a self, name: &'a str) -> &'a str {
        self.members.get(name).map_or(name, String::as_str)
    }

    /// Returns the displayed text of a task.
    pub fn task<'a>(&'a self, name: &'a str) -> &'a str {
        self.tasks.get(name).map_or(name, String::as_str)
    }

    /// Returns the displayed text of a layer.
    pub fn layer<'a>(&'a self, name: &'a str) -> &'a str {
        self.layers.get(name).map_or(name, String::as_str)
    }

    /// Checks each label by itself.
    ///
    /// # Errors
    /// The name of the first invalid label, and the reason.
    pub fn check(&self) -> Result<(), (String, Unfit)> {
        let mut all = self.members.iter().chain(&self.tasks).chain(&self.layers);
        all.try_for_each(|(name, text)| check(text).map_err(|why| (name.clone(), why)))
    }

    /// Returns the first agent of this list whose displayed text people cannot distinguish from an earlier one, with
    /// that earlier one: both as indices into the list. At least one of the two has a label; names alone are distinct
    /// in the language.
    pub fn mistaken<'n>(&self, agents: impl Iterator<Item = &'n str>) -> Option<(usize, usize)> {
        let mut shown: BTreeMap<String, (usize, bool)> = BTreeMap::new();
        for (index, name) in agents.enumerate() {
            let labelled = self.members.contains_key(name);
            match shown.get(&folded(self.member(name))) {
                Some((first, other)) if labelled || *other => return Some((*first, index)),
                Some(_) => {}
                None => drop(shown.insert(folded(self.member(name)), (index, labelled))),
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_people_in_many_scripts_are_labels() {
        let all = [
            "Łukasz",
            "Ann-Marie",
            "O'Brien",
            "李小龙",
            "שרה",
            "محمد",
            "Ёлка",
            "José María",
            "नेहा",
            "👩‍🌾 Ana",
            "می‌خواهم",
        ];
        for text in all {
            assert_eq!(check(text), Ok(()), "{text}");
        }
        assert_eq!(check(&"ł".repeat(LONGEST)), Ok(()));
    }

    #[test]
    fn texts_that_cannot_be_shown_are_none() {
        assert_eq!(check("a\u{1b}[2J"), Err(Unfit::Command('\u{1b}')));
        assert_eq!(check("a\nb"), Err(Unfit::Command('\n')));
        assert_eq!(check("Ana\u{202e}"), Err(Unfit::Command('\u{202e}')));
        for text in ["", " ", "\u{a0}", "\u{200b}", "\u{feff}\u{3164}"] {
            assert_eq!(check(text), Err(Unfit::Empty), "{text:?}");
        }
        assert_eq!(check(" Ana"), Err(Unfit::Edge));
        assert_eq!(check(&"ł".repeat(LONGEST + 1)), Err(Unfit::Long(LONGEST + 1)));
    }

    #[test]
    fn case_space_and_the_unseen_tell_nobody_apart() {
        assert!(alike("Anna Maria", "anna\u{2003}maria"));
        assert!(alike("Łukasz", "łu\u{200b}kasz"));
        assert!(!alike("Łukasz", "Lukasz"));
        let members = [("h2", "Ana"), ("h3", "ANA")].map(|(name, text)| (name.to_string(), text.to_string()));
        let mut labels = Labels { members: BTreeMap::from(members), ..Labels::default() };
        assert_eq!(labels.mistaken(["h1", "H1", "h2", "h3"].into_iter()), Some((2, 3)));
        labels.members.insert("h3".into(), "H1".into());
        assert_eq!(labels.mistaken(["h1", "H1", "h2", "h3"].into_iter()), Some((0, 3)));
        labels.members.remove("h3");
        assert_eq!(labels.mistaken(["h1", "H1", "h2", "h3"].into_iter()), None);
    }
}

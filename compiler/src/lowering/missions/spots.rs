//! Places with names in a mission of layers: tasks go there, agents and objects stand there.

use std::collections::BTreeMap;

use dsl::tree::{MissionMember, Value, ValueKind};
use dsl::{Diagnostic, Span};
use names::{list, suggest};
use stdlib_tasks::dimension::LENGTH;

use super::super::Lowerer;
use super::reading::Keys;
use crate::expr::constants::Constants;
use crate::forms::check_keys;
use crate::sections::LAYERS_PLACE;

/// Positions (m) by the names of their places.
pub(super) type Spots = BTreeMap<String, [f64; 3]>;

impl Lowerer<'_> {
    /// The places that are declared. One whose position is wrong was reported, and stands at the origin.
    pub(super) fn spots(&mut self, declared: &[&MissionMember]) -> Spots {
        let mut all = Spots::new();
        for member in declared {
            check_keys(&member.settings, &LAYERS_PLACE, self.diagnostics);
            let keys = Keys { block: &member.settings, section: &LAYERS_PLACE, at: member.name.span };
            let at = match keys.entry("at") {
                Some(e) => self.own_position(&e.value, declared),
                None => {
                    self.lacks(keys, "at");
                    None
                }
            };
            all.insert(member.name.value.clone(), at.unwrap_or_default());
        }
        all
    }

    /// The position of a place, which is not that of another one.
    fn own_position(&mut self, value: &Value, declared: &[&MissionMember]) -> Option<[f64; 3]> {
        let ValueKind::Name(name) = &value.kind else { return self.constant_position(value) };
        if self.params.knows(name) || !declared.iter().any(|other| other.name.value == *name) {
            return self.constant_position(value);
        }
        let d = Diagnostic::error("HQ0304", value.span, format!("`{name}` is a place, and a place has a position"));
        self.push(d.help("write the position itself, for instance `at [0.4, 0, 0.1] m`"));
        None
    }

    /// A position (m): that of a place, or one that is written out.
    pub(super) fn position(&mut self, value: &Value, spots: &Spots) -> Option<[f64; 3]> {
        let ValueKind::Name(name) = &value.kind else { return self.constant_position(value) };
        if let Some(spot) = spots.get(name) {
            return Some(*spot);
        }
        if self.params.knows(name) {
            return self.constant_position(value);
        }
        self.unknown_place(name, value.span, spots);
        None
    }

    fn unknown_place(&mut self, name: &str, at: Span, spots: &Spots) {
        let d = Diagnostic::error("HQ0201", at, format!("there is no place `{name}`"));
        let names = || spots.keys().map(String::as_str);
        self.push(match suggest(name, names()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None if spots.is_empty() => {
                d.help(format!("declare it, `place {name} {{ at [0.4, 0, 0.1] m }}`, or write a position"))
            }
            None => d.help(format!("declared are {}; or write a position", list(names(), 12))),
        });
    }

    fn constant_position(&mut self, value: &Value) -> Option<[f64; 3]> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        constants.vector(value, LENGTH, self.diagnostics)
    }
}

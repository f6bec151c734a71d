//! Chosen axes of a frame task: some of x, y and z.

use dsl::Diagnostic;
use dsl::tree::{Value, ValueKind};
use names::suggest;
use stdlib_tasks::axis_rows::AXES;
use stdlib_tasks::params::ParamInfo;

use super::Binder;
use crate::forms::text_of;

impl Binder<'_> {
    /// Binds a list of axes; one axis needs no brackets.
    pub(super) fn axes_chosen(&mut self, value: &Value, info: &ParamInfo) -> Option<[bool; 3]> {
        let mut chosen = [false; 3];
        for item in value.items() {
            let word = match &item.kind {
                ValueKind::Missing => return None,
                _ => text_of(item),
            };
            let Some(axis) = AXES.iter().position(|axis| Some(*axis) == word) else {
                let d = Diagnostic::error("HQ0304", item.span, format!("`{}` are some of `x`, `y` and `z`", info.name));
                let letters = word.unwrap_or_default();
                let several = letters.len() > 1 && letters.chars().all(|c| "xyz".contains(c));
                self.diagnostics.push(match suggest(letters, AXES.iter().copied()) {
                    _ if several => {
                        let listed: Vec<String> = letters.chars().map(String::from).collect();
                        d.help(format!("write `[{}]`", listed.join(", ")))
                    }
                    Some(near) => d.meant(near),
                    None => d.help("write for instance `[x, y]`; weights of the axes are `axis_weights [1, 1, 0.1]`"),
                });
                return None;
            };
            if std::mem::replace(&mut chosen[axis], true) {
                let d = Diagnostic::error("HQ0308", item.span, format!("axis `{}` is named twice", AXES[axis]));
                self.diagnostics.push(d.help("name each axis once"));
                return None;
            }
        }
        if !chosen.contains(&true) {
            let d = Diagnostic::error(
                "HQ0308",
                value.span,
                format!("`{}` names no axis, and nothing is controlled", info.name),
            );
            self.diagnostics.push(d.help("name one to three of `x`, `y` and `z`, or remove the task"));
            return None;
        }
        Some(chosen)
    }
}

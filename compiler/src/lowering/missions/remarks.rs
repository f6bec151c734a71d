//! Remarks of a kind of mission as diagnostics at the texts that they are about.

use dsl::{Diagnostic, Span, Topic};
use mission::declare::{About, Advice, Remark, Remarks};

use super::super::Lowerer;

impl Lowerer<'_> {
    /// Reports the errors; and the warnings, unless there are more errors than `before` the mission was read.
    pub(super) fn remarks(&mut self, remarks: Remarks, before: usize) {
        let good = self.errors() == before;
        for remark in remarks.all.into_iter().filter(|remark| good || remark.is_error) {
            let d = self.diagnostic(remark);
            self.push(d);
        }
    }

    fn diagnostic(&self, remark: Remark) -> Diagnostic {
        let at = match (remark.within, self.origins.file(remark.at)) {
            (Some(within), Some(file)) => Span::new(file, within.start, within.end),
            _ => self.origins.span(remark.at),
        };
        let d = match remark.is_error {
            true => Diagnostic::error(remark.code, at, remark.text),
            false => Diagnostic::warning(remark.code, at, remark.text),
        };
        let d = remark.labels.into_iter().fold(d, |d, label| d.label(self.origins.span(label.at), label.text));
        let d = remark.notes.into_iter().fold(d, |d, note| d.note(note));
        let d = match remark.about {
            About::UnknownName => d.about(Topic::UnknownName),
            About::Nothing => d.about(Topic::MissingDeclaration),
            About::Other => d,
        };
        match remark.help {
            Some(Advice::Meant(name)) => d.meant(name),
            Some(Advice::Text(text)) => d.help(text),
            None => d,
        }
    }
}

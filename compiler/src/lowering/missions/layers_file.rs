//! Layers that stand in a file of their own, as JSON. What is wrong with it is shown in the file itself.

use dsl::tree::{Entry, Mission};
use dsl::{Diagnostic, SourceId, Span};
use mission::kinds::layers::json::{Fault, FaultKind, Mode, Position, import};
use mission::kinds::layers::problem::Problem;

use super::super::Lowerer;
use crate::forms::text_of;
use crate::paths::instead_of;

/// Largest file that is read, in bytes.
const MAX_BYTES: u64 = 4 << 20;
/// Most mistakes of a file that are told at once.
const MOST: usize = 20;

impl Lowerer<'_> {
    /// The problem with the layers and tasks of the file that `layers_from` names. `None` where it cannot be had; the
    /// diagnostics say why.
    pub(super) fn layers_from(&mut self, m: &Mission, e: &Entry, problem: Problem) -> Option<Problem> {
        if let Some(layer) = m.members.iter().find(|member| member.role.value == "layer") {
            let d = Diagnostic::error("HQ0912", e.key.span, "the layers are written here and in a file");
            self.push(d.label(layer.role.span, "written here").help("keep one of the two"));
            return None;
        }
        let Some(path) = text_of(&e.value) else {
            let d = Diagnostic::error("HQ0304", e.value.span, "the path of a file, in quotes, is needed here");
            self.push(d.help("write for instance `layers_from \"layers.json\"`"));
            return None;
        };
        let text = match self.file(path) {
            Ok(text) => text,
            Err((why, help)) => {
                let d = Diagnostic::error("HQ0912", e.value.span, format!("cannot read `{path}`: {why}"));
                self.push(d.note("paths are relative to the file that names them").help(help));
                return None;
            }
        };
        let source = self.sources.add(path, text.clone());
        match import(&text, &problem, Mode::Context) {
            Ok(imported) => Some(imported.problem),
            Err(faults) => {
                for fault in faults.iter().take(MOST) {
                    let d = told(fault, source, &text);
                    self.push(d.label(e.value.span, "the file is named here"));
                }
                None
            }
        }
    }

    /// The text of a file; or why it cannot be read, and what to do.
    fn file(&self, path: &str) -> Result<String, (String, String)> {
        let on_disk = self.input.folder.join(path);
        let cannot = |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::FileTooLarge => {
                (format!("it has more than {} MB", MAX_BYTES >> 20), "split the mission into several".to_string())
            }
            _ => (files::reason(&e).to_string(), instead_of(&on_disk)),
        };
        let bytes = files::read(&on_disk, MAX_BYTES).map_err(cannot)?;
        String::from_utf8(bytes).map_err(|_| ("it is no UTF-8 text".to_string(), "save it as JSON".to_string()))
    }
}

/// A mistake of the file as the reader of the spec is told of it.
fn told(fault: &Fault, source: SourceId, text: &str) -> Diagnostic {
    let (start, end) = token(text, fault.at);
    let d = Diagnostic::error("HQ0912", Span::new(source, start, end), fault.what.clone());
    let d = match fault.kind {
        FaultKind::Syntax | FaultKind::Truncated => d.note("from here on the file is not read"),
        _ => d,
    };
    d.help(fault.fix.clone())
}

/// The bytes of what stands at a place: a text in quotes, a word or number, or one character.
fn token(text: &str, at: Position) -> (usize, usize) {
    let line: usize = text.split_inclusive('\n').take(at.line.saturating_sub(1)).map(str::len).sum();
    let rest = text.get(line..).unwrap_or_default();
    let column = rest.char_indices().nth(at.column.saturating_sub(1)).map_or(rest.len(), |(i, _)| i);
    let start = line + column;
    let here = text.get(start..).unwrap_or_default();
    let mut characters = here.char_indices();
    let length = match characters.next() {
        None => 0,
        Some((_, '"')) => here[1..].find(['"', '\n']).map_or(1, |i| i + 2),
        Some((_, c)) if c.is_alphanumeric() || c == '-' => characters
            .find(|(_, c)| !c.is_alphanumeric() && !matches!(c, '.' | '_' | '-'))
            .map_or(here.len(), |(i, _)| i),
        Some((_, c)) => c.len_utf8(),
    };
    (start, (start + length).min(text.len()))
}

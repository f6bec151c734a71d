//! Values that are paths of files, which the compiler reads.

use std::path::Path;

use blocks::{BinaryFile, BinaryFormat, Bound, Companion, FileWith, Located};
use dsl::Diagnostic;
use dsl::tree::Value;

use super::BlockBinder;
use super::files::Unreadable;
use super::values::Asked;
use crate::forms::text_of;
use crate::paths::{instead_of, made_by, tidy};

impl BlockBinder<'_> {
    /// A text file.
    pub(super) fn file(&mut self, value: &Value, asked: Asked) -> Option<Located<Bound>> {
        let Some(path) = text_of(value) else {
            return self.wrong_form(value, "the path of a file is needed here".to_string(), asked);
        };
        match self.files.read(path) {
            Ok(text) => {
                let source = self.files.sources.add(path, text.clone());
                Some(Located { at: self.origins.add_file(value.span, source), value: Bound::File(text) })
            }
            Err(e) => {
                let d = Diagnostic::error("HQ0912", value.span, format!("cannot read `{path}`: {}", e.why));
                let d = d.note("paths are relative to the file that names them");
                self.diagnostics.push(match e.help {
                    Some(help) => d.help(help),
                    None => instead_of(d, path, &self.files.folder.join(path)),
                });
                None
            }
        }
    }

    /// A text file, and the file that it names.
    pub(super) fn file_with(&mut self, value: &Value, asked: Asked, with: &Companion) -> Option<Located<Bound>> {
        let Some(path) = text_of(value) else {
            return self.wrong_form(value, "the path of a file, in quotes, is needed here".to_string(), asked);
        };
        let mut refuse = |text: String, e: Unreadable, written: &str, on_disk: &std::path::Path, note: &str| {
            let d = Diagnostic::error(with.code, value.span, text).note(note);
            self.diagnostics.push(match e.help {
                Some(help) => d.help(help),
                None if written == path => instead_of(d, written, on_disk),
                None => d.help(format!("looked for {}", on_disk.display())),
            });
            None
        };
        let on_disk = self.files.folder.join(path);
        let text = match self.files.read_with(path, with.if_no_text) {
            Ok(text) => text,
            Err(e) => {
                let text = format!("cannot read `{path}`: {}", e.why);
                return refuse(text, e, path, &on_disk, "paths are relative to the file that names them");
            }
        };
        let companion = match (with.path)(&text) {
            None => None,
            Some(other) => {
                let on_disk = on_disk.parent().unwrap_or(std::path::Path::new("")).join(&other);
                match self.files.read_bytes(&on_disk, with.most, with.if_larger) {
                    Ok(bytes) => Some(bytes.into()),
                    Err(e) => {
                        let text = format!("cannot read `{other}`, which `{path}` names: {}", e.why);
                        let note = format!("the path in `{path}` is relative to the folder of that file");
                        return refuse(text, e, &other, &on_disk, &note);
                    }
                }
            }
        };
        let file = FileWith { path: path.to_string(), text, companion };
        Some(Located { at: self.origins.add(value.span), value: Bound::FileWith(file) })
    }

    /// A file of bytes.
    pub(super) fn binary(&mut self, value: &Value, asked: Asked, format: &BinaryFormat) -> Option<Located<Bound>> {
        let Some(path) = text_of(value) else {
            return self.wrong_form(value, "the path of a file, in quotes, is needed here".to_string(), asked);
        };
        let on_disk = self.files.folder.join(tidy(Path::new(path), self.files.folder));
        let words =
            [("{spec}", self.files.spec), ("{mission}", &self.scope.mission), ("{file}", &on_disk.to_string_lossy())];
        let command =
            words.iter().fold(format.command.to_string(), |c, (hole, word)| c.replace(hole, &files::quoted(word)));
        let read = match self.files.reads_bytes {
            true => self.files.read_bytes(&on_disk, format.most, format.if_larger).map(|bytes| Some(bytes.into())),
            false => Ok(None),
        };
        match read {
            Ok(bytes) => {
                let file = BinaryFile { path: path.to_string(), command, bytes };
                Some(Located { at: self.origins.add(value.span), value: Bound::Binary(file) })
            }
            Err(e) => {
                let d = Diagnostic::error(format.code, value.span, format!("cannot read `{path}`: {}", e.why));
                let d = d.note("paths are relative to the file that names them");
                self.diagnostics.push(match e.help {
                    Some(help) => d.help(help),
                    None => made_by(d, path, &on_disk, &command),
                });
                None
            }
        }
    }
}

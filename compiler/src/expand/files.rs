//! Reads the files of a spec, each once, with all that they import.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use dsl::tree::{Import, ItemKind, Spec};
use dsl::{Diagnostic, SourceId, Spanned, Syntax};

use super::module::Module;
use super::{Expander, MAX_DEPTH, allowances};
use crate::paths::{instead_of, tidy};

/// Maximum number of files that a spec may import.
const MAX_FILES: usize = 200;

/// A file that was read.
struct FileText {
    /// Path, relative to the folder of the spec.
    path: PathBuf,
    /// Its text.
    source: SourceId,
    /// Syntax.
    syntax: Syntax,
}

impl Expander<'_> {
    /// Reads the spec and all imported files. The spec is module 0.
    pub(super) fn read(&mut self, source: SourceId, spec: Spec) {
        // A spec that is stored in a file may not import itself.
        let own = Path::new(self.input.name).canonicalize().ok().filter(|p| p.is_file());
        if let Some(own) = &own {
            self.files.insert(own.clone(), None);
        }
        self.out.syntaxes.insert(source, self.input.syntax);
        let file = FileText { path: PathBuf::new(), source, syntax: self.input.syntax };
        self.module(String::new(), file, spec, 0);
        if let Some(own) = own {
            self.files.insert(own, Some(0));
        }
    }

    /// Adds a module for a tree, after the modules that it imports; returns its index.
    fn module(&mut self, stem: String, file: FileText, mut spec: Spec, depth: usize) -> usize {
        let m = self.modules.len();
        self.out.allowances.extend(allowances::take(&mut spec, file.syntax, self.diagnostics));
        let spec = Rc::new(spec);
        self.modules.push(Module {
            stem,
            folder: file.path.parent().map(Path::to_path_buf).unwrap_or_default(),
            path: file.path,
            source: file.source,
            syntax: file.syntax,
            spec: spec.clone(),
            imports: Vec::new(),
            items: Vec::new(),
            scope: Default::default(),
            missing: Vec::new(),
        });
        let mut imports: Vec<(Import, Option<usize>)> = Vec::new();
        for item in &spec.items {
            let ItemKind::Import(import) = &item.kind else { continue };
            if let Some((first, _)) = imports.iter().find(|(i, _)| i.path == import.path) {
                let text = format!("`{}` is imported twice", import.path.value);
                let d = Diagnostic::error("HQ0202", import.path.span, text).label(first.path.span, "first here");
                self.fail(d.help("write all its names in one import"));
            }
            let from = self.import(m, &import.path, depth);
            self.modules[m].imports.push((import.path.value.clone(), from));
            imports.push((import.clone(), from));
        }
        self.modules[m].items = self.unrolled(m, &spec.items);
        self.scope(m, &imports);
        m
    }

    /// Module that an import names. Returns `None` if it cannot be read, with diagnostics.
    fn import(&mut self, importer: usize, path: &Spanned<String>, depth: usize) -> Option<usize> {
        let at = path.span;
        let refuse = |e: &mut Self, d: Diagnostic| {
            e.out.usable = false;
            e.fail(d);
            None
        };
        let from_spec = tidy(&self.modules[importer].folder.join(&path.value), self.input.folder);
        let on_disk = self.input.folder.join(&from_spec);
        let Some(syntax) = Syntax::of_path(&from_spec) else {
            let text = format!("`{}` is not a spec: its name must end in .hq or .yaml", path.value);
            return refuse(self, Diagnostic::error("HQ0211", at, text).help("import a spec"));
        };
        let cannot = |e: &std::io::Error| {
            let d = Diagnostic::error("HQ0211", at, format!("cannot read `{}`: {}", path.value, files::reason(e)))
                .note("paths are relative to the file that names them");
            instead_of(d, &path.value, &on_disk)
        };
        let canonical = match on_disk.canonicalize() {
            Ok(canonical) => canonical,
            Err(e) => {
                self.modules[importer].missing.push(on_disk.clone());
                return refuse(self, cannot(&e));
            }
        };
        match self.files.get(&canonical) {
            Some(Some(known)) => return Some(*known),
            Some(None) => {
                let d =
                    Diagnostic::error("HQ0212", at, format!("`{}` imports itself, directly or indirectly", path.value));
                let d = d.note("imports must not form a cycle");
                return refuse(self, d.help("move the shared declarations to a file of their own"));
            }
            None => {}
        }
        if self.files.len() >= MAX_FILES || depth >= MAX_DEPTH {
            let text = format!("more than {MAX_FILES} files are imported, or {MAX_DEPTH} through each other");
            return refuse(self, Diagnostic::error("HQ0218", at, text).help("merge some of them into one file"));
        }
        let instead = self.texts.get(&canonical).map(|text| Ok(text.clone().into_bytes()));
        let bytes = match instead.unwrap_or_else(|| read_file(&on_disk)) {
            Ok(bytes) => bytes,
            Err(e) => return refuse(self, cannot(&e)),
        };
        let name = from_spec.to_string_lossy().into_owned();
        let text = match dsl::limits::decode(SourceId::default(), &bytes) {
            Ok(text) => text.to_string(),
            // The parser reports that the text is too large.
            Err(_) if bytes.len() > dsl::limits::MAX_BYTES => String::from_utf8_lossy(&bytes).into_owned(),
            Err(d) => {
                let text = format!("`{}` cannot be read: {}", path.value, d.message);
                return refuse(self, Diagnostic::error("HQ0211", at, text).help("save the file as UTF-8"));
            }
        };
        self.files.insert(canonical.clone(), None);
        let real = self.sources.add(name, text.clone());
        self.out.syntaxes.insert(real, syntax);
        let source = self.sources.instance(real, at, "imported here");
        let (spec, diagnostics) = dsl::parse(source, &text, syntax);
        if diagnostics.iter().any(|d| d.severity == dsl::Severity::Error) {
            self.out.whole = false;
        }
        self.diagnostics.extend(diagnostics);
        let stem = self.stem(&from_spec);
        let module = self.module(stem, FileText { path: from_spec, source: real, syntax }, spec, depth + 1);
        self.files.insert(canonical, Some(module));
        Some(module)
    }

    /// Prefix of the names of a file that are not visible in the spec; unique for each file.
    fn stem(&self, path: &Path) -> String {
        let own = path.file_stem().map_or_else(|| "file".to_string(), |s| s.to_string_lossy().replace(['.', '@'], "_"));
        let taken = |s: &str| self.modules.iter().any(|m| m.stem == s);
        if !taken(&own) {
            return own;
        }
        (2..=MAX_FILES + 1).map(|i| format!("{own}_{i}")).find(|s| !taken(s)).unwrap_or(own)
    }
}

/// Reads a file, up to one byte more than the maximum length of a text.
pub(crate) fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    files::read_up_to(path, dsl::limits::MAX_BYTES as u64 + 1)
}

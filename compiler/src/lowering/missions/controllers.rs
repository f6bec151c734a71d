//! The specs that members of a mission run: read and compiled once each, what is wrong with them shown in their own
//! files.
//!
//! Of such a spec only its controller counts, and the scenarios of that, in whose worlds it may run: its missions are left
//! out, so that no two specs run each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use dsl::{Diagnostic, SourceId, Span, Syntax, Topic};
use runtime::Program;
use runtime::program::{MAX_RUNNING, Subject};

use super::super::{Context, Lowerer};
use crate::diagnostics::report::Report;
use crate::expand::read_file;
use crate::input::{CompilePart, Input, Part, Texts};
use crate::paths::{instead_of, tidy};

/// The specs that were compiled for working robots.
pub(in crate::lowering) struct Controllers<'a> {
    /// The driver.
    compile: CompilePart,
    /// Texts that stand for those of files.
    texts: &'a Texts,
    /// By the place of the file; none where something is wrong with one, which was reported.
    known: BTreeMap<PathBuf, Option<Program>>,
    /// There were too many, which was reported.
    full: bool,
    /// Specs without a machine that runs, which was reported.
    without_machine: BTreeSet<String>,
    /// Their texts: what is said of them was said in their own syntax.
    pub foreign: BTreeSet<SourceId>,
}

impl<'a> Controllers<'a> {
    /// None so far.
    pub fn new(context: &Context<'a>) -> Self {
        Controllers {
            compile: context.compile,
            texts: context.texts,
            known: BTreeMap::new(),
            full: false,
            without_machine: BTreeSet::new(),
            foreign: BTreeSet::new(),
        }
    }
}

impl Lowerer<'_> {
    /// The controller of a spec, which somebody runs; `None` where it cannot be had, and the diagnostics say why.
    pub(super) fn controller_of(&mut self, path: &str, at: Span, who: &str) -> Option<Program> {
        let from_spec = tidy(Path::new(path), self.input.folder);
        let on_disk = self.input.folder.join(&from_spec);
        let refused = |text: String| Diagnostic::error("HQ0931", at, text);
        let Some(syntax) = Syntax::of_path(&from_spec) else {
            let text = format!("`{path}` is not a spec: its name must end in .hq or .yaml");
            self.push(refused(text).help("name the spec of a robot's controller"));
            return None;
        };
        let cannot = |e: &std::io::Error| {
            let d = refused(format!("cannot read `{path}`: {}", files::reason(e)))
                .note("paths are relative to the file that names them");
            instead_of(d, path, &on_disk)
        };
        let canonical = match on_disk.canonicalize() {
            Ok(canonical) => canonical,
            Err(e) => {
                self.push(cannot(&e));
                return None;
            }
        };
        if let Some(known) = self.controllers.known.get(&canonical) {
            return known.clone();
        }
        if self.controllers.known.len() >= MAX_RUNNING {
            if !std::mem::replace(&mut self.controllers.full, true) {
                let d = Diagnostic::error(
                    "HQ0933",
                    at,
                    format!("the workers of this spec run more than {MAX_RUNNING} specs"),
                );
                self.push(d.help("let several workers run the same one, or leave `runs` out of some"));
            }
            return None;
        }
        let instead = self.controllers.texts.get(&canonical);
        let bytes = match instead.map_or_else(|| read_file(&on_disk), |text| Ok(text.clone().into_bytes())) {
            Ok(bytes) => bytes,
            Err(e) => {
                self.push(cannot(&e));
                return None;
            }
        };
        let text = match dsl::limits::decode(SourceId::default(), &bytes) {
            Ok(text) => text.to_string(),
            Err(d) => {
                self.push(refused(format!("`{path}` cannot be read: {}", d.message)).help("name another file"));
                return None;
            }
        };
        let program = self.compiled((&from_spec, &text, syntax), at, who);
        self.controllers.known.insert(canonical, program.clone());
        program
    }

    /// Compiles a spec; its diagnostics become ours.
    fn compiled(&mut self, (path, text, syntax): (&Path, &str, Syntax), at: Span, who: &str) -> Option<Program> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let input = Input {
            name: &name,
            text,
            syntax,
            folder: &self.input.folder.join(folder),
            set: &[],
            package_paths: self.input.package_paths,
        };
        let compiled = (self.controllers.compile)(&input, self.controllers.texts, Part::Controller);
        self.adopt(compiled.report, folder, at, who);
        compiled.program
    }

    /// Refuses a spec whose machine does not run, once.
    pub(super) fn runs_machine(&mut self, name: &str, program: &Program, at: Span) -> bool {
        let runs = program.run.subject == Subject::Machine;
        if !runs && self.controllers.without_machine.insert(name.to_string()) {
            let text = match &program.machine {
                None => format!("`{name}` has no machine to begin and end operations"),
                Some(_) => format!("`{name}` runs a stack, and not its machine"),
            };
            let d = Diagnostic::error("HQ0931", at, text).note("an operation ends when a machine enters a state").help(
                "name a spec with a `machine` that runs, or leave `runs` out: operations then take their `duration`",
            );
            self.push(d);
        }
        runs
    }

    /// Takes back that nothing uses a signal of a spec, where more is said of that.
    pub(super) fn unused_is_told(&mut self, spec: &str, signal: &str) {
        let place = tidy(Path::new(spec), self.input.folder);
        let (sources, foreign) = (&self.sources, &self.controllers.foreign);
        self.diagnostics.retain(|d| {
            let at = d.primary.span;
            let there =
                foreign.contains(&at.source) && sources.get(at.source).is_some_and(|s| Path::new(&s.name) == place);
            !(d.topic == Topic::Unused && there && sources.snippet(at) == signal)
        });
    }

    /// Takes over what was said of another spec, which lies in a folder and is named at a place.
    fn adopt(&mut self, report: Report, folder: &Path, at: Span, who: &str) {
        let mut ours: Vec<SourceId> = Vec::new();
        for (_, source) in report.sources.iter() {
            let there = tidy(&folder.join(&source.name), self.input.folder);
            let name = match self.input.folder.join(&there).is_file() {
                true => there.to_string_lossy().into_owned(),
                false => source.name.clone(),
            };
            ours.push(self.sources.add(name, source.text.clone()));
        }
        self.controllers.foreign.extend(&ours);
        let place = |span: Span| match ours.get(span.source.0 as usize) {
            Some(source) => Span { source: *source, ..span },
            None => at,
        };
        for mut d in report.diagnostics {
            d.primary.span = place(d.primary.span);
            for label in &mut d.labels {
                label.span = place(label.span);
            }
            // They would change another spec than the one that is checked.
            d.fixes.clear();
            self.push(d.label(at, format!("{who} runs this spec")));
        }
    }
}

//! A file of a spec, with the scope of its names.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::rc::Rc;

use dsl::tree::{Import, Item, ItemKind, MissionMember, MissionRepeat, Parameter, Spec, ValueKind};
use dsl::{Diagnostic, SourceId, Span, Spanned, Syntax};
use names::list;

use super::{Class, Expander, TYPES};
use crate::expr::constants::is_word;
use crate::forms::text_of;

/// Meaning of a name in a file.
#[derive(Clone, Debug)]
pub(crate) enum Target {
    /// A declaration of the file.
    Own(usize),
    /// A declaration of another file, with its name there.
    Imported { module: usize, name: String, at: Span },
    /// An import that failed and was reported.
    Failed,
}

/// A file.
#[derive(Debug)]
pub(crate) struct Module {
    /// Prefix of names that come from the file and are not visible in the spec: `safety` for `common/safety.hq`.
    pub stem: String,
    /// Folder of the file, relative to that of the spec.
    pub folder: PathBuf,
    /// Path, relative to the folder of the spec; empty for the spec itself.
    pub path: PathBuf,
    /// Its text.
    pub source: SourceId,
    /// Syntax.
    pub syntax: Syntax,
    /// Its tree, as written.
    pub spec: Rc<Spec>,
    /// Paths of its imports as written, each with the module; `None` for a file that cannot be read.
    pub imports: Vec<(String, Option<usize>)>,
    /// Declarations, with repetitions unrolled.
    pub items: Vec<Item>,
    /// Meaning of the names.
    pub scope: BTreeMap<(Class, String), Target>,
    /// Imported files that were not found.
    pub missing: Vec<PathBuf>,
}

impl Module {
    /// URDFs that the file's robots name.
    pub fn urdfs(&self) -> impl Iterator<Item = &str> {
        self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Robot(robot) => text_of(&robot.body.get("urdf")?.value),
            _ => None,
        })
    }

    /// SRDFs that the file's robots name.
    pub fn srdfs(&self) -> impl Iterator<Item = &str> {
        self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Robot(robot) => text_of(&robot.body.get("srdf")?.value),
            _ => None,
        })
    }

    /// Files of layers that the file's missions name.
    pub fn layers(&self) -> impl Iterator<Item = &str> {
        self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Mission(mission) => text_of(&mission.settings.get("layers_from")?.value),
            _ => None,
        })
    }

    /// Files of maps that the file's missions name.
    pub fn maps(&self) -> impl Iterator<Item = &str> {
        self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Mission(mission) => text_of(&mission.settings.get("map")?.value),
            _ => None,
        })
    }

    /// Specs that workers of the file's missions run.
    pub fn workers(&self) -> Vec<&str> {
        fn below<'m>(members: &'m [MissionMember], repeats: &'m [MissionRepeat], out: &mut Vec<&'m str>) {
            for m in members {
                let runs = m.settings.get("runs").map_or(&[][..], |e| e.value.entries());
                out.extend(runs.iter().find(|e| e.key.value == "spec").and_then(|e| text_of(&e.value)));
            }
            repeats.iter().for_each(|r| below(&r.members, &r.repeats, out));
        }
        let mut out = Vec::new();
        for item in &self.items {
            if let ItemKind::Mission(m) = &item.kind {
                below(&m.members, &m.repeats, &mut out);
            }
        }
        out
    }

    /// Recordings of people that the file's scenarios name.
    pub fn recordings(&self) -> impl Iterator<Item = &str> {
        let scenarios = self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Scenario(scenario) => scenario.body.get("humans"),
            _ => None,
        });
        scenarios.flat_map(|e| e.value.entries()).filter_map(|e| {
            let file = e.value.entries().iter().find(|e| e.key.value == "file")?;
            text_of(&file.value)
        })
    }
}

/// Class and name of a declaration, if it has a name.
pub(crate) fn declared(kind: &ItemKind) -> Option<(Class, &Spanned<String>)> {
    match kind {
        ItemKind::Param(p) => Some((Class::Value, &p.name)),
        ItemKind::Let(l) => Some((Class::Value, &l.name)),
        ItemKind::Robot(r) => Some((Class::Robot, &r.name)),
        ItemKind::Task(t) => Some((Class::Task, &t.name)),
        ItemKind::Stack(s) => Some((Class::Stack, &s.name)),
        ItemKind::Import(_)
        | ItemKind::Allow(_)
        | ItemKind::For(_)
        | ItemKind::Coverage(_)
        | ItemKind::Run(_)
        | ItemKind::Scenario(_) => None,
        ItemKind::Signal(s) => Some((Class::Value, &s.name)),
        ItemKind::Block(b) => Some((Class::Value, &b.name)),
        ItemKind::Variable(v) => Some((Class::Value, &v.name)),
        ItemKind::Machine(m) => Some((Class::Machine, &m.name)),
        ItemKind::Mission(m) => Some((Class::Mission, &m.name)),
    }
}

/// Parameters of a task or stack.
pub(super) fn parameters(kind: &ItemKind) -> &[Parameter] {
    match kind {
        ItemKind::Task(t) => &t.parameters,
        ItemKind::Stack(s) => &s.parameters,
        _ => &[],
    }
}

pub(crate) const CLASSES: [Class; 6] =
    [Class::Value, Class::Robot, Class::Task, Class::Stack, Class::Machine, Class::Mission];

impl Expander<'_> {
    /// Computes the scope of a module. `imports` has the module of each import, or `None` if the file is unreadable.
    pub(super) fn scope(&mut self, m: usize, imports: &[(Import, Option<usize>)]) {
        let mut scope: BTreeMap<(Class, String), (Target, Span)> = BTreeMap::new();
        let items = std::mem::take(&mut self.modules[m].items);
        for (i, item) in items.iter().enumerate() {
            let Some((class, name)) = declared(&item.kind) else { continue };
            // The first of several robots counts; a later stage reports the others.
            match scope.get(&(class, name.value.clone())) {
                // An unfilled hole is one mistake; its copies have the same name.
                Some(_) if name.value.contains("${") => {}
                Some((_, first)) if class != Class::Robot => {
                    let first = *first;
                    self.fail(twice(name, first));
                }
                Some(_) => {}
                None => {
                    scope.insert((class, name.value.clone()), (Target::Own(i), name.span));
                    self.parameters(&item.kind);
                }
            }
        }
        self.modules[m].items = items;
        for (import, from) in imports {
            for wanted in &import.names {
                let visible = wanted.visible();
                let found = match from {
                    Some(from) => self.exports(*from, &wanted.name, import),
                    None => CLASSES.map(|class| (class, Target::Failed)).to_vec(),
                };
                for (class, target) in found {
                    let key = (class, visible.value.clone());
                    let failed = matches!(target, Target::Failed);
                    match scope.get(&key) {
                        Some((_, first)) if !failed => {
                            let first = *first;
                            let help = format!("import it under another name: `{} as NAME`", wanted.name.value);
                            self.fail(twice(visible, first).help(help));
                        }
                        Some(_) => {}
                        None => {
                            scope.insert(key, (target, visible.span));
                        }
                    }
                }
            }
        }
        self.modules[m].scope = scope.into_iter().map(|(key, (target, _))| (key, target)).collect();
    }

    /// Declarations of a module under a name, in all classes.
    fn exports(&mut self, from: usize, name: &Spanned<String>, import: &Import) -> Vec<(Class, Target)> {
        let scope = &self.modules[from].scope;
        let mut found = Vec::new();
        for class in CLASSES {
            match scope.get(&(class, name.value.clone())) {
                Some(Target::Failed) => found.push((class, Target::Failed)),
                Some(_) => {
                    found.push((class, Target::Imported { module: from, name: name.value.clone(), at: name.span }));
                }
                None => {}
            }
        }
        if found.is_empty() {
            let names: Vec<&str> = scope.keys().map(|k| k.1.as_str()).collect();
            let text = format!("`{}` declares no `{}`", import.path.value, name.value);
            let d = Diagnostic::error("HQ0213", name.span, text);
            let d = d.help("it declares nothing that could be imported").one_of(
                "it has",
                &name.value,
                names.iter().copied(),
            );
            self.out.usable = false;
            self.fail(d);
            found = CLASSES.map(|class| (class, Target::Failed)).to_vec();
        }
        found
    }

    /// Checks the parameters of a declaration: their names are not words of the language, and their types exist.
    fn parameters(&mut self, kind: &ItemKind) {
        for p in parameters(kind) {
            if is_word(&p.name.value) {
                let d =
                    Diagnostic::error("HQ0202", p.name.span, format!("`{}` is a word of the language", p.name.value));
                self.fail(d.help("choose another name"));
            }
            if p.name.value.contains("${") {
                let d = Diagnostic::error("HQ0219", p.name.span, "the name of a parameter cannot have a hole");
                self.fail(d.help("write the name out"));
            }
            if !TYPES.iter().any(|t| t.name == p.ty.value) {
                let d = Diagnostic::undeclared("type", &p.ty.value, p.ty.span);
                let names = || TYPES.iter().map(|t| t.name);
                self.fail(d.help(format!("types are {}", list(names(), 30))).nearest(&p.ty.value, names()));
            }
        }
        if let ItemKind::Task(t) = kind
            && !t.parameters.is_empty()
            && stdlib_tasks::find(&t.name.value).is_some()
        {
            let text = format!("`{}` is a type of the task library", t.name.value);
            self.fail(Diagnostic::error("HQ0202", t.name.span, text).help("choose another name"));
        }
    }

    /// Resolves a name in a module to a declaration, by its module and index. Returns `Err(true)` if the declaration
    /// failed, and `Err(false)` if there is none.
    pub(super) fn find(&self, module: usize, class: Class, name: &str) -> Result<(usize, usize), bool> {
        let (mut module, mut name) = (module, name);
        // Imports are acyclic, so this terminates.
        loop {
            match self.modules[module].scope.get(&(class, name.to_string())) {
                None => return Err(false),
                Some(Target::Failed) => return Err(true),
                Some(Target::Own(item)) => return Ok((module, *item)),
                Some(Target::Imported { module: next, name: there, .. }) => (module, name) = (*next, there.as_str()),
            }
        }
    }

    /// Name of a task in the program, if `name` is a task without parameters.
    pub(super) fn task_name(&self, module: usize, name: &str) -> Option<String> {
        let (m, i) = self.find(module, Class::Task, name).ok()?;
        let kind = &self.modules[m].items[i].kind;
        let (_, own) = declared(kind).filter(|_| parameters(kind).is_empty())?;
        Some(self.program_name(m, Class::Task, &own.value))
    }

    /// Names of a class that a module sees, either with parameters (`takes`) or without.
    pub(super) fn names(&self, module: usize, class: Class, takes: bool) -> Vec<String> {
        let all = self.modules[module].scope.keys().filter(|k| k.0 == class);
        all.filter(|k| {
            let found = self.find(module, class, &k.1).ok();
            found.is_some_and(|(m, i)| parameters(&self.modules[m].items[i].kind).is_empty() != takes)
        })
        .map(|k| k.1.clone())
        .collect()
    }
}

/// Diagnostic for a duplicate declaration.
pub(super) fn twice(name: &Spanned<String>, first: Span) -> Diagnostic {
    Diagnostic::error("HQ0202", name.span, format!("`{}` is declared twice", name.value))
        .label(first, "first here")
        .help("choose another name for one of them")
}

/// True for a placeholder of a value whose error was reported.
pub(super) fn missing(kind: &ValueKind) -> bool {
    matches!(kind, ValueKind::Missing)
}

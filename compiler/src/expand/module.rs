//! A file with what its names mean.

use std::collections::BTreeMap;
use std::path::PathBuf;

use dsl::tree::{Entry, Import, Item, ItemKind, MissionMember, MissionRepeat, Parameter, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use names::{list, suggest};

use super::{Class, Expander, TYPES};
use crate::expr::constants::is_word;
use crate::forms::text_of;

/// What a name means in a file.
#[derive(Clone, Debug)]
pub(super) enum Target {
    /// A declaration of the file.
    Own(usize),
    /// A declaration of another file, under its name there.
    Imported { module: usize, name: String, at: Span },
    /// An import that failed, and was reported.
    Failed,
}

/// A file.
#[derive(Debug)]
pub(super) struct Module {
    /// What names begin with that come from it and are not visible: `safety` for `common/safety.hq`.
    pub stem: String,
    /// Its folder, from that of the spec.
    pub folder: PathBuf,
    /// Its declarations, repetitions unrolled.
    pub items: Vec<Item>,
    /// What its names mean.
    pub scope: BTreeMap<(Class, String), Target>,
    /// Files that it imports and that could not be found.
    pub missing: Vec<PathBuf>,
}

impl Module {
    /// The URDFs that its robots name.
    pub fn urdfs(&self) -> impl Iterator<Item = &str> {
        self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Robot(robot) => text_of(&robot.body.get("urdf")?.value),
            _ => None,
        })
    }

    /// The files of layers that its missions name.
    pub fn layers(&self) -> impl Iterator<Item = &str> {
        self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Mission(mission) => text_of(&mission.settings.get("layers_from")?.value),
            _ => None,
        })
    }

    /// The specs that workers of its missions run.
    pub fn workers(&self) -> Vec<&str> {
        fn below<'m>(members: &'m [MissionMember], repeats: &'m [MissionRepeat], out: &mut Vec<&'m str>) {
            for m in members {
                let runs = m.settings.get("runs").map_or(&[][..], |e| entries(&e.value));
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

    /// The recordings of people that its scenarios name.
    pub fn recordings(&self) -> impl Iterator<Item = &str> {
        let scenarios = self.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Scenario(scenario) => scenario.body.get("humans"),
            _ => None,
        });
        scenarios.flat_map(|e| entries(&e.value)).filter_map(|e| {
            let file = entries(&e.value).iter().find(|e| e.key.value == "file")?;
            text_of(&file.value)
        })
    }
}

/// The entries of a block.
fn entries(value: &Value) -> &[Entry] {
    match &value.kind {
        ValueKind::Block(block) => &block.entries,
        _ => &[],
    }
}

/// The class and name of a declaration that has one.
pub(super) fn declared(kind: &ItemKind) -> Option<(Class, &Spanned<String>)> {
    match kind {
        ItemKind::Param(p) => Some((Class::Value, &p.name)),
        ItemKind::Let(l) => Some((Class::Value, &l.name)),
        ItemKind::Robot(r) => Some((Class::Robot, &r.name)),
        ItemKind::Task(t) => Some((Class::Task, &t.name)),
        ItemKind::Stack(s) => Some((Class::Stack, &s.name)),
        ItemKind::Import(_) | ItemKind::For(_) | ItemKind::Run(_) | ItemKind::Scenario(_) => None,
        ItemKind::Signal(s) => Some((Class::Value, &s.name)),
        ItemKind::Human(h) => Some((Class::Value, &h.name)),
        ItemKind::SafetyField(f) => Some((Class::Value, &f.name)),
        ItemKind::Variable(v) => Some((Class::Value, &v.name)),
        ItemKind::Machine(m) => Some((Class::Machine, &m.name)),
        ItemKind::Mission(m) => Some((Class::Mission, &m.name)),
    }
}

/// What a task or stack takes.
pub(super) fn parameters(kind: &ItemKind) -> &[Parameter] {
    match kind {
        ItemKind::Task(t) => &t.parameters,
        ItemKind::Stack(s) => &s.parameters,
        _ => &[],
    }
}

const CLASSES: [Class; 6] = [Class::Value, Class::Robot, Class::Task, Class::Stack, Class::Machine, Class::Mission];

impl Expander<'_> {
    /// Finds out what the names of a module mean. What it imports is known already: `imports` has each import with its
    /// module, or `None` where that could not be read.
    pub(super) fn scope(&mut self, m: usize, imports: &[(Import, Option<usize>)]) {
        let mut scope: BTreeMap<(Class, String), (Target, Span)> = BTreeMap::new();
        let items = std::mem::take(&mut self.modules[m].items);
        for (i, item) in items.iter().enumerate() {
            let Some((class, name)) = declared(&item.kind) else { continue };
            // Of several robots the first is meant; that there are several is said elsewhere.
            match scope.get(&(class, name.value.clone())) {
                // A hole that nothing fills is one mistake, and not another for each copy of it.
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

    /// What a module has under a name, in all classes.
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
            let d = match suggest(&name.value, names.iter().copied()) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None if names.is_empty() => d.help("it declares nothing that could be imported"),
                None => d.help(format!("it has {}", list(names.iter().copied(), 12))),
            };
            self.out.usable = false;
            self.fail(d);
            found = CLASSES.map(|class| (class, Target::Failed)).to_vec();
        }
        found
    }

    /// Parameters of a declaration: words of the language cannot be their names, and their types are known.
    fn parameters(&mut self, kind: &ItemKind) {
        for p in parameters(kind) {
            if is_word(&p.name.value) {
                let d =
                    Diagnostic::error("HQ0202", p.name.span, format!("`{}` is a word of the language", p.name.value));
                self.fail(d.help("choose another name"));
            }
            if p.name.value.contains("${") {
                let d = Diagnostic::error("HQ0219", p.name.span, "nothing fills this hole in the name of a parameter");
                self.fail(d.help("write the name out"));
            }
            if !TYPES.iter().any(|t| t.name == p.ty.value) {
                let d = Diagnostic::error("HQ0201", p.ty.span, format!("there is no type `{}`", p.ty.value));
                let names = || TYPES.iter().map(|t| t.name);
                self.fail(match suggest(&p.ty.value, names()) {
                    Some(near) => d.help(format!("did you mean `{near}`?")),
                    None => d.help(format!("types are {}", list(names(), 30))),
                });
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

    /// The declaration that a name means in a module: its module and place there. `Err(true)` for one that failed,
    /// `Err(false)` where there is none.
    pub(super) fn find(&self, module: usize, class: Class, name: &str) -> Result<(usize, usize), bool> {
        let (mut module, mut name) = (module, name);
        // Imports form no circle, so this ends.
        loop {
            match self.modules[module].scope.get(&(class, name.to_string())) {
                None => return Err(false),
                Some(Target::Failed) => return Err(true),
                Some(Target::Own(item)) => return Ok((module, *item)),
                Some(Target::Imported { module: next, name: there, .. }) => (module, name) = (*next, there.as_str()),
            }
        }
    }

    /// The name that a task has in the program, if the name is that of a task without parameters.
    pub(super) fn task_name(&self, module: usize, name: &str) -> Option<String> {
        let (m, i) = self.find(module, Class::Task, name).ok()?;
        let kind = &self.modules[m].items[i].kind;
        let (_, own) = declared(kind).filter(|_| parameters(kind).is_empty())?;
        Some(self.program_name(m, Class::Task, &own.value))
    }

    /// The names of a class that a module sees, those with parameters or those without.
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

/// The diagnostic for a name that was declared before.
pub(super) fn twice(name: &Spanned<String>, first: Span) -> Diagnostic {
    Diagnostic::error("HQ0202", name.span, format!("`{}` is declared twice", name.value))
        .label(first, "first here")
        .help("choose another name for one of them")
}

/// True for a value that can be missing without a word: it was reported.
pub(super) fn missing(kind: &ValueKind) -> bool {
    matches!(kind, ValueKind::Missing)
}

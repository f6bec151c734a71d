//! Indexes references between declarations: imports, parameters, repetitions, changes of a stack.

use dsl::Spanned;
use dsl::tree::{Change, Entry, Import, Level, Parameter, Repeat, Stack, Value, Values};

use super::library::File;
use super::mentions::{Class, Declaration, Slot, Taken, Walker, What};
use super::origin::Elsewhere;
use super::walk::word;

/// Classes of symbols that a spec can import.
pub(super) const VISIBLE: [Class; 11] = [
    Class::Param,
    Class::Let,
    Class::Robot,
    Class::Task,
    Class::Stack,
    Class::Signal,
    Class::Human,
    Class::Field,
    Class::Event,
    Class::Machine,
    Class::Mission,
];

/// Classes of symbols that are imported together with a robot.
pub(super) const PARTS: [Class; 5] = [Class::Arm, Class::Point, Class::Segment, Class::Group, Class::JointGroup];

/// Looks up a symbol that a file declares or imports, with the place of its declaration.
pub(super) fn brought<'f>(file: &'f File, key: &(Class, String)) -> Option<(&'f Declaration, Elsewhere)> {
    let there = file.mentions.declared.get(key)?;
    let chosen = || Some((file.source.path.clone(), key.1.clone()));
    let elsewhere = match &there.elsewhere {
        Some(further) => Elsewhere { word: further.word.clone().or_else(chosen), ..further.clone() },
        None => Elsewhere {
            source: file.source.clone(),
            name: key.1.clone(),
            place: there.name.clone(),
            whole: there.whole.clone(),
            word: chosen(),
        },
    };
    Some((there, elsewhere))
}

/// Converts the parameters of a declaration.
pub(super) fn taken(parameters: &[Parameter]) -> Vec<Taken> {
    let one =
        |p: &Parameter| Taken { name: p.name.value.clone(), ty: p.ty.value.clone(), optional: p.default.is_some() };
    parameters.iter().map(one).collect()
}

/// Levels that a stack adds to its base.
pub(super) fn added(stack: &Stack) -> impl Iterator<Item = &Level> {
    stack.changes.iter().filter_map(|change| match change {
        Change::Add(level, _) => Some(level),
        _ => None,
    })
}

/// Levels that a stack replaces in its base.
pub(super) fn replaced(stack: &Stack) -> impl Iterator<Item = &Level> {
    stack.changes.iter().filter_map(|change| match change {
        Change::Replace(level) => Some(level),
        _ => None,
    })
}

impl Walker<'_> {
    /// Indexes the names of an import, and declares the imported symbols.
    pub(super) fn imported(&mut self, import: &Import) {
        let path = &import.path;
        self.note(&path.value, path.span, What::Spec(path.value.clone()));
        let file = self.imports.iter().find(|f| f.written == path.value).and_then(|f| f.file.clone());
        for wanted in &import.names {
            let offered = || {
                let there = file.iter().flat_map(|f| f.mentions.declared.keys());
                let there = there.filter(|(class, name)| VISIBLE.contains(class) && !name.contains("${"));
                let new = there.filter(|(_, name)| import.names.iter().all(|n| n.name.value != *name));
                Slot::Offered(new.map(|(class, name)| (name.clone(), class.word())).collect())
            };
            if self.marked(&wanted.name.value, offered) {
                continue;
            }
            let visible = wanted.visible();
            if wanted.alias.is_some() && self.marked(&visible.value, || Slot::Nothing) {
                continue;
            }
            let Some(file) = &file else { continue };
            for class in VISIBLE {
                let there = (class, wanted.name.value.clone());
                let Some((declared, mut elsewhere)) = brought(file, &there) else { continue };
                if wanted.alias.is_some() {
                    let what = What::Brought(class, Box::new(elsewhere.clone()));
                    self.note(&wanted.name.value, wanted.name.span, what);
                    elsewhere.word = None;
                }
                self.note(&visible.value, visible.span, What::Declared(class, visible.value.clone()));
                let (name, _) = self.place(&visible.value, visible.span);
                let whole = wanted.name.span.to(visible.span).range();
                let comments = declared.comments.clone();
                let declaration = Declaration { name, whole, comments, elsewhere: Some(elsewhere) };
                self.found.declared.entry((class, visible.value.clone())).or_insert(declaration);
                self.inner(file, class, &wanted.name.value, &visible.value);
            }
        }
    }

    /// Declares the parts of an imported declaration: arms, points and so on of a robot, levels of a stack, parameters.
    fn inner(&mut self, file: &File, class: Class, there: &str, here: &str) {
        let word = class.word();
        let owner = format!("{word} {there}");
        if let Some(takes) = file.mentions.takes.get(&owner) {
            self.found.takes.entry(format!("{word} {here}")).or_insert_with(|| takes.clone());
        }
        if let Some(ty) = file.mentions.types.get(there).filter(|_| class == Class::Signal) {
            self.found.types.entry(here.to_string()).or_insert_with(|| ty.clone());
        }
        if let Some(kind) = file.mentions.kinds.get(there).filter(|_| class == Class::Task) {
            self.found.kinds.entry(here.to_string()).or_insert_with(|| kind.clone());
        }
        for key in file.mentions.declared.keys() {
            let own = |before: &str| Some(key.1.strip_prefix(before)?.strip_prefix('.')?.to_string());
            let name = match (class, key.0) {
                (Class::Robot, part) if PARTS.contains(&part) => Some(key.1.clone()),
                (Class::Stack, Class::Level)
                | (Class::Machine, Class::State)
                | (Class::Human, Class::Tracked)
                | (Class::Mission, Class::Member) => own(there).map(|level| format!("{here}.{level}")),
                (Class::Task | Class::Stack, Class::Argument) => own(&owner).map(|p| format!("{word} {here}.{p}")),
                _ => None,
            };
            let Some((name, (declared, elsewhere))) = name.zip(brought(file, key)) else { continue };
            let comments = declared.comments.clone();
            let declaration = Declaration { name: 0..0, whole: 0..0, comments, elsewhere: Some(elsewhere) };
            self.found.declared.entry((key.0, name)).or_insert(declaration);
        }
    }

    /// Indexes the robot from which another one is derived.
    pub(super) fn robot_base(&mut self, base: &Spanned<String>) {
        let robots = self.found.names(Class::Robot).map(|n| (n.to_string(), Class::Robot.word())).collect();
        if !self.marked(&base.value, || Slot::Offered(robots)) {
            self.note(&base.value, base.span, What::Declared(Class::Robot, base.value.clone()));
        }
    }

    /// Indexes the parameters of a declaration, and adds them to the scope; the caller truncates the scope.
    pub(super) fn formals(&mut self, owner: &str, all: &[Parameter]) {
        for p in all {
            let types = || Slot::Offered(compiler::parameter_types().map(|t| (t.0.to_string(), t.1)).collect());
            self.marked(&p.ty.value, types);
            if let Some(default) = &p.default {
                self.given(Some(&p.ty.value), default);
            }
            self.argument(owner, &p.name, p.span);
        }
    }

    fn argument(&mut self, owner: &str, name: &Spanned<String>, whole: dsl::Span) {
        let key = format!("{owner}.{}", name.value);
        self.declare((Class::Argument, key.clone()), name, whole, &[]);
        self.scope.push((name.value.clone(), key));
    }

    /// Indexes the arguments of `owner`, a declaration with parameters.
    pub(super) fn arguments(&mut self, owner: &str, args: &[Value], named: &[Entry]) {
        let takes = self.found.takes.get(owner).cloned().unwrap_or_default();
        // Parameters that are not given yet, after this number of positional arguments.
        let left = |before: usize| {
            let given = |t: &Taken| named.iter().any(|e| e.key.value == t.name);
            takes.iter().skip(before).filter(|t| !given(t)).cloned().collect()
        };
        for (i, value) in args.iter().enumerate() {
            let ty = takes.get(i).map(|t| t.ty.as_str());
            if !self.marked(word(value).unwrap_or(""), || Slot::Given(ty.map(str::to_string), left(i))) {
                self.given(ty, value);
            }
        }
        for e in named {
            if self.marked(&e.key.value, || Slot::Given(None, left(args.len()))) {
                continue;
            }
            let what = What::Declared(Class::Argument, format!("{owner}.{}", e.key.value));
            self.note(&e.key.value, e.key.span, what);
            let ty = takes.iter().find(|t| t.name == e.key.value).map(|t| t.ty.as_str());
            if !self.marked(word(&e.value).unwrap_or(""), || Slot::Given(ty.map(str::to_string), Vec::new())) {
                self.given(ty, &e.value);
            }
        }
    }

    /// Indexes the argument for a parameter of type `ty`.
    fn given(&mut self, ty: Option<&str>, value: &Value) {
        match ty {
            Some("arm") => self.arm(value),
            Some("frame") => self.frame(value),
            Some("joints") => self.joints(value),
            Some("geometry") => self.geometries(value),
            Some("task") => match word(value) {
                Some(name) if self.scoped(name, value.span) => {}
                Some(name) if self.has(Class::Task, name) => {
                    self.note(name, value.span, What::Declared(Class::Task, name.to_string()));
                }
                _ => self.anything(value),
            },
            _ => self.anything(value),
        }
    }

    /// Indexes a repetition; `f` indexes each part of it.
    pub(super) fn repeat<T>(&mut self, repeat: &Repeat<T>, mut f: impl FnMut(&mut Self, &T)) {
        let outer = self.scope.len();
        self.repeated_over(&repeat.variable, &repeat.values);
        for part in &repeat.body {
            f(self, part);
        }
        self.scope.truncate(outer);
    }

    /// Indexes the values of a repetition, and adds its variable to the scope; the caller truncates the scope.
    pub(super) fn repeated_over(&mut self, variable: &Spanned<String>, values: &Values) {
        match values {
            Values::List(list) => self.anything(list),
            Values::Range(first, last) => {
                self.anything(first);
                self.anything(last);
            }
        }
        let at = variable.span;
        self.argument(&format!("for {}", at.start), variable, at);
    }

    /// Indexes the levels that changes name, which are those of the base.
    pub(super) fn changed(&mut self, stack: &Stack) {
        let Some(base) = &stack.base else { return };
        let prefix = format!("{}.", base.name.value);
        let known = self.found.names(Class::Level).filter_map(|n| n.strip_prefix(&prefix));
        let known: Vec<_> = known.map(|n| (n.to_string(), Class::Level.word())).collect();
        for change in &stack.changes {
            let level = match change {
                Change::Replace(level) => &level.name,
                Change::Add(_, Some(beside)) => &beside.level,
                Change::Add(_, None) => continue,
                Change::Remove(removal) => &removal.level,
            };
            if self.marked(&level.value, || Slot::Offered(known.clone())) {
                continue;
            }
            let own = format!("{}.{}", stack.name.value, level.value);
            let key = if self.has(Class::Level, &own) { own } else { format!("{prefix}{}", level.value) };
            self.note(&level.value, level.span, What::Declared(Class::Level, key));
        }
    }
}

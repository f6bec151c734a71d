//! What declarations take from others, word by word: imports, parameters, repetitions, changes of a stack.

use dsl::Spanned;
use dsl::tree::{Change, Import, Level, Parameter, Repeat, Stack, Values};

use super::imports::{PARTS, VISIBLE};
use super::mentions::{Class, Declaration, Slot, Walker, What};

/// The levels that a stack adds to another one.
pub(super) fn added(stack: &Stack) -> impl Iterator<Item = &Level> {
    stack.changes.iter().filter_map(|change| match change {
        Change::Add(level, _) => Some(level),
        _ => None,
    })
}

/// The levels that a stack replaces in another one.
pub(super) fn replaced(stack: &Stack) -> impl Iterator<Item = &Level> {
    stack.changes.iter().filter_map(|change| match change {
        Change::Replace(level) => Some(level),
        _ => None,
    })
}

impl Walker<'_> {
    /// The names that an import brings. What the file declares stands there.
    pub(super) fn imported(&mut self, import: &Import) {
        let path = &import.path;
        self.note(&path.value, path.span, What::Spec(path.value.clone()));
        let file = self.imports.iter().find(|f| f.written == path.value);
        for wanted in &import.names {
            let offered = || {
                let all = file.iter().flat_map(|f| VISIBLE.into_iter().flat_map(|class| f.mentions.names(class)));
                Slot::Offered(all.map(str::to_string).collect())
            };
            if self.marked(&wanted.name.value, offered) {
                continue;
            }
            let visible = wanted.visible();
            let Some(file) = file else { continue };
            for class in VISIBLE {
                let Some(there) = file.mentions.declared.get(&(class, wanted.name.value.clone())) else { continue };
                let whole = wanted.name.span.to(visible.span);
                self.declare((class, visible.value.clone()), visible, whole, &there.comments);
                let key = (class, visible.value.clone());
                if let Some(declaration) = self.found.declared.get_mut(&key) {
                    declaration.elsewhere = Some((path.value.clone(), there.name.clone(), there.whole.clone()));
                }
                if class == Class::Robot {
                    self.parts(&path.value);
                }
            }
        }
    }

    /// Arms, points and so on that come with an imported robot.
    fn parts(&mut self, path: &str) {
        let Some(file) = self.imports.iter().find(|f| f.written == path) else { return };
        for ((class, name), there) in file.mentions.declared.iter().filter(|((class, _), _)| PARTS.contains(class)) {
            let elsewhere = Some((path.to_string(), there.name.clone(), there.whole.clone()));
            let declaration = Declaration { name: 0..0, whole: 0..0, comments: there.comments.clone(), elsewhere };
            self.found.declared.entry((*class, name.clone())).or_insert(declaration);
        }
    }

    /// The robot that another is made from.
    pub(super) fn robot_base(&mut self, base: &Spanned<String>) {
        let robots: Vec<String> = self.found.names(Class::Robot).map(str::to_string).collect();
        if !self.marked(&base.value, || Slot::Offered(robots)) {
            self.note(&base.value, base.span, What::Declared(Class::Robot, base.value.clone()));
        }
    }

    /// Parameters of a declaration; they are known until the scope is cut back.
    pub(super) fn formals(&mut self, owner: &str, all: &[Parameter]) {
        for p in all {
            let types = || Slot::Offered(compiler::parameter_types().map(|t| t.0.to_string()).collect());
            self.marked(&p.ty.value, types);
            if let Some(default) = &p.default {
                self.anything(default);
            }
            self.argument(owner, &p.name, p.span);
        }
    }

    fn argument(&mut self, owner: &str, name: &Spanned<String>, whole: dsl::Span) {
        let key = format!("{owner}.{}", name.value);
        self.declare((Class::Argument, key.clone()), name, whole, &[]);
        self.scope.push((name.value.clone(), key));
    }

    /// A repetition; `f` looks at each part of it.
    pub(super) fn repeat<T>(&mut self, repeat: &Repeat<T>, mut f: impl FnMut(&mut Self, &T)) {
        let outer = self.scope.len();
        match &repeat.values {
            Values::List(list) => self.anything(list),
            Values::Range(first, last) => {
                self.anything(first);
                self.anything(last);
            }
        }
        let at = repeat.variable.span;
        self.argument(&format!("for {}", at.start), &repeat.variable, at);
        for part in &repeat.body {
            f(self, part);
        }
        self.scope.truncate(outer);
    }

    /// The levels that changes name: they are those of the base.
    pub(super) fn changed(&mut self, stack: &Stack) {
        let Some(base) = &stack.base else { return };
        let prefix = format!("{}.", base.name.value);
        let known = self.found.names(Class::Level).filter_map(|n| n.strip_prefix(&prefix)).map(str::to_string);
        let known: Vec<String> = known.collect();
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

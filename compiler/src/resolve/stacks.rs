//! References in stacks, and arguments of declarations with parameters.

use dsl::tree::{Call, Change, Entry, Level, Member, MemberTask, Stack, Value};

use super::declare::declared_levels;
use super::symbols::{Formal, SymbolId, SymbolKind as K};
use super::{CompletionContext as C, Meaning, Resolver};
use crate::expand::Class;
use crate::sections::{InSyntax, LEVEL, MEMBER, STACK};

impl Resolver<'_> {
    pub(super) fn stack(&mut self, stack: &Stack) {
        self.section(&stack.settings, &STACK);
        if let Some(base) = &stack.base {
            self.stack_call(base);
        }
        declared_levels(stack).for_each(|level| self.level(level));
        for change in &stack.changes {
            if let Change::Replace(level) = change {
                self.level(level);
            }
        }
        self.changes(stack);
    }

    /// Resolves a use of a stack.
    pub(super) fn stack_call(&mut self, call: &Call) {
        let name = &call.name;
        self.spanned_name(&name.value, name.span, Class::Stack, K::Stack, &[K::Stack]);
        let owner = self.declared(Class::Stack, &name.value);
        self.arguments(owner, &call.args, &call.named);
    }

    fn level(&mut self, level: &Level) {
        if let Some(span) = level.hard {
            self.keyword("hard", span.range().start, LEVEL.key("hard", self.syntax));
        }
        self.section(&level.settings, &LEVEL);
        level.members.iter().for_each(|member| self.level_member(member));
    }

    fn level_member(&mut self, member: &Member) {
        match &member.task {
            MemberTask::Inline(definition) => self.definition(definition),
            MemberTask::For(repeat) => self.repeat(repeat, member.span, |r, member| r.level_member(member)),
            MemberTask::Name(name) => {
                if !self.is_cursor(&name.value, |_| C::Member) && !self.is_bound(&name.value, name.span) {
                    let found = self.declared(Class::Task, &name.value);
                    match stdlib_tasks::find(&name.value).filter(|_| found.is_none()) {
                        Some(kind) => self.note(&name.value, name.span, Meaning::TaskType(kind)),
                        None => self.refer(&name.value, name.span, K::Task, found),
                    }
                }
            }
        }
        if let Some(weight) = &member.weight {
            self.keyword_before("weight", weight.span, MEMBER.key("weight", self.syntax));
            self.expression(weight);
        }
    }

    /// Resolves the levels that changes name: those of the stack itself, of its base, and of the bases of that.
    fn changes(&mut self, stack: &Stack) {
        let Some(base) = &stack.base else { return };
        let holders: Vec<SymbolId> =
            [&stack.name.value, &base.name.value].into_iter().filter_map(|n| self.declared(Class::Stack, n)).collect();
        for change in &stack.changes {
            let level = match change {
                Change::Replace(level) => &level.name,
                Change::Add(_, Some(beside)) => &beside.level,
                Change::Add(_, None) => continue,
                Change::Remove(removal) => &removal.level,
            };
            let of_base = |r: &Self| {
                let levels = holders.last().map_or(Vec::new(), |base| r.levels_of(*base));
                r.offering(&levels, |s| s.kind.word())
            };
            if !self.is_cursor(&level.value, of_base) {
                let found = holders
                    .iter()
                    .find_map(|h| self.levels_of(*h).into_iter().find(|id| self.out.symbol(*id).name == level.value));
                self.refer(&level.value, level.span, K::Level, found);
            }
        }
    }

    /// Levels of a stack: those that it declares, then those of its base.
    fn levels_of(&self, stack: SymbolId) -> Vec<SymbolId> {
        let mut out = Vec::new();
        let mut open = Some(self.out.origin(stack));
        let mut seen = Vec::new();
        while let Some(stack) = open.filter(|s| !seen.contains(s)) {
            seen.push(stack);
            out.extend(self.all_inside(stack, K::Level));
            open = self.bases.get(&stack).map(|base| self.out.origin(*base));
        }
        out
    }

    /// Resolves the arguments of a declaration with parameters.
    pub(super) fn arguments(&mut self, owner: Option<SymbolId>, args: &[Value], named: &[Entry]) {
        let formals = owner.map(|owner| self.out.symbol(owner).parameters.clone()).unwrap_or_default();
        // Parameters that are not given yet, after this number of positional arguments.
        let left = |before: usize| -> Vec<Formal> {
            let given = |f: &Formal| named.iter().any(|e| e.key.value == f.name);
            formals.iter().skip(before).filter(|f| !given(f)).cloned().collect()
        };
        for (i, value) in args.iter().enumerate() {
            let ty = formals.get(i).map(|f| f.ty.as_str());
            if !self.cursor_in(value, |_| C::Argument(ty.map(str::to_string), left(i))) {
                self.argument(ty, value);
            }
        }
        for e in named {
            if self.is_cursor(&e.key.value, |_| C::Argument(None, left(args.len()))) {
                continue;
            }
            let found = owner.and_then(|owner| self.inside(owner, K::Parameter, &e.key.value));
            self.refer(&e.key.value, e.key.span, K::Parameter, found);
            let ty = formals.iter().find(|f| f.name == e.key.value).map(|f| f.ty.as_str());
            if !self.cursor_in(&e.value, |_| C::Argument(ty.map(str::to_string), Vec::new())) {
                self.argument(ty, &e.value);
            }
        }
    }

    /// Resolves the argument for a parameter of type `ty`.
    pub(super) fn argument(&mut self, ty: Option<&str>, value: &Value) {
        match ty {
            Some("arm") => self.arm(value),
            Some("frame") => self.frame(value, &[K::Link, K::Arm]),
            Some("joints") => self.joints(value),
            Some("geometry") => self.geometries(value, C::Geometry { arms: false, people: false }),
            Some("task") => match value.word() {
                Some(name) if self.is_bound(name, value.span) => {}
                Some(name) if self.declared(Class::Task, name).is_some() => {
                    let found = self.declared(Class::Task, name);
                    self.refer(name, value.span, K::Task, found);
                }
                _ => self.anything(value),
            },
            _ => self.anything(value),
        }
    }
}

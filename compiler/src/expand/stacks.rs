//! Copies stacks: those with levels of their own, and those that change the levels of a base.

use dsl::tree::{Beside, Change, ItemKind, Level, Member, MemberTask, Removal, Repeat, Stack, Values};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};

use super::arguments::{Arguments, Taker};
use super::substitute::Frame;
use super::{Class, Expander};

impl Expander<'_> {
    /// Expands a stack with all its levels. Returns `None` if its base fails.
    pub(super) fn stack(&mut self, (m, i): (usize, usize), frame: &mut Frame) -> Option<Stack> {
        let ItemKind::Stack(stack) = self.modules[m].items[i].kind.clone() else { return None };
        self.expanded_stack(m, &stack, frame)
    }

    /// As [`Self::stack`], for a stack that is not declared itself; `m` is the module of its scope.
    pub(super) fn expanded_stack(&mut self, m: usize, stack: &Stack, frame: &mut Frame) -> Option<Stack> {
        let mut settings = self.block(&stack.settings, frame);
        let name = stack.name.clone();
        let Some(base) = &stack.base else {
            let levels = stack.levels.iter().map(|l| self.level(l, frame)).collect();
            return Some(plain(name, settings, levels));
        };
        let (bm, bi) = match self.find(frame.module, Class::Stack, &base.name.value) {
            Ok(found) => found,
            Err(failed) => {
                let wanted = self.name(&base.name, frame);
                self.unknown(frame.module, Class::Stack, &wanted, failed);
                return None;
            }
        };
        let ItemKind::Stack(other) = self.modules[bm].items[bi].kind.clone() else { return None };
        self.used.insert((bm, Class::Stack, other.name.value.clone()));
        let at = self.at(base.span, frame);
        self.active.push((m, Class::Stack, stack.name.value.clone()));
        let levels = if self.recursive(bm, Class::Stack, &other.name, at) {
            None
        } else {
            let taker = Taker { name: &other.name, parameters: &other.parameters, module: bm };
            let given = Arguments { args: &base.args, named: &base.named, at: base.span };
            let bound = self.arguments(&taker, &given, frame);
            bound.and_then(|bound| self.stack((bm, bi), &mut Frame::used(bm, bound, at)))
        };
        self.active.pop();
        let base = levels?;
        // A setting of the derived stack overrides that of the base.
        for entry in base.settings.entries {
            if settings.get(&entry.key.value).is_none() {
                settings.entries.push(entry);
            }
        }
        let mut levels = base.levels;
        self.changed(&stack.changes, &mut levels, &other.name, frame);
        Some(plain(name, settings, levels))
    }

    /// Applies changes to the levels of a base, in order.
    fn changed(&mut self, changes: &[Change], levels: &mut Vec<Level>, base: &Spanned<String>, frame: &mut Frame) {
        let mut replaced: Vec<Spanned<String>> = Vec::new();
        for change in changes {
            match change {
                Change::Replace(level) => {
                    let level = self.level(level, frame);
                    let Some(k) = self.place_of(&level.name, levels, base) else { continue };
                    if let Some(first) = replaced.iter().find(|r| **r == level.name) {
                        let d = Diagnostic::error(
                            "HQ0217",
                            level.name.span,
                            format!("level `{}` is replaced twice", level.name.value),
                        );
                        let d = d.label(first.span, "first here").help("keep one of them");
                        self.fail(d);
                        continue;
                    }
                    replaced.push(level.name.clone());
                    let before = std::mem::replace(&mut levels[k], level);
                    self.out.discarded.push(before);
                }
                Change::Add(level, beside) => {
                    let level = self.level(level, frame);
                    if let Some(known) = levels.iter().find(|l| l.name == level.name) {
                        let text = format!("stack `{}` has a level `{}` already", base.value, level.name.value);
                        let d = Diagnostic::error("HQ0217", level.name.span, text).label(known.name.span, "this one");
                        self.fail(d.help(Help::with(
                            "write {}, or choose another name",
                            [Snippet::entry("replace", level.name.value.as_str())],
                        )));
                        continue;
                    }
                    let at = match beside {
                        None => levels.len(),
                        Some(Beside { before, level: other }) => {
                            let other = self.name(other, frame);
                            let Some(k) = self.place_of(&other, levels, base) else { continue };
                            k + usize::from(!before)
                        }
                    };
                    levels.insert(at, level);
                }
                Change::Remove(removal) => {
                    let name = self.name(&removal.level, frame);
                    let Some(k) = self.place_of(&name, levels, base) else { continue };
                    if let Some(first) = replaced.iter().find(|r| **r == name) {
                        let d = Diagnostic::error(
                            "HQ0217",
                            name.span,
                            format!("level `{}` is replaced, and then removed", name.value),
                        );
                        let d = d.label(first.span, "replaced here").help("keep one of them");
                        self.fail(d);
                        continue;
                    }
                    let before = levels.remove(k);
                    self.out.discarded.push(before);
                }
            }
        }
    }

    /// Index of a level among those of a base.
    fn place_of(&mut self, name: &Spanned<String>, levels: &[Level], base: &Spanned<String>) -> Option<usize> {
        let found = levels.iter().position(|l| l.name == *name);
        if found.is_none() {
            let text = format!("stack `{}` has no level `{}`", base.value, name.value);
            let d = Diagnostic::error("HQ0217", name.span, text).label(base.span, "declared here");
            let names = levels.iter().map(|l| l.name.value.as_str());
            self.fail(d.one_of("its levels are", &name.value, names));
        }
        found
    }

    /// Copies a stack of a repetition: fills names and values, and keeps everything else unexpanded.
    pub(super) fn stack_as_written(&mut self, s: &Stack, frame: &mut Frame) -> Stack {
        let base = s.base.as_ref().map(|b| self.call(b, frame));
        let mut changes = Vec::new();
        for change in &s.changes {
            changes.push(match change {
                Change::Replace(level) => Change::Replace(self.level_as_written(level, frame)),
                Change::Add(level, beside) => {
                    let beside =
                        beside.as_ref().map(|b| Beside { before: b.before, level: self.name(&b.level, frame) });
                    Change::Add(self.level_as_written(level, frame), beside)
                }
                Change::Remove(r) => Change::Remove(Removal {
                    level: self.name(&r.level, frame),
                    span: self.at(r.span, frame),
                    comments: Default::default(),
                }),
            });
        }
        Stack {
            name: s.name.clone(),
            parameters: s.parameters.clone(),
            base,
            settings: self.block(&s.settings, frame),
            levels: s.levels.iter().map(|l| self.level_as_written(l, frame)).collect(),
            changes,
        }
    }

    fn level_as_written(&mut self, level: &Level, frame: &mut Frame) -> Level {
        Level {
            name: self.name(&level.name, frame),
            hard: level.hard.map(|h| self.at(h, frame)),
            settings: self.block(&level.settings, frame),
            members: self.members_as_written(&level.members, frame),
            span: self.at(level.span, frame),
            comments: Default::default(),
        }
    }

    fn members_as_written(&mut self, members: &[Member], frame: &mut Frame) -> Vec<Member> {
        let mut out = Vec::new();
        for m in members {
            let task = match &m.task {
                MemberTask::Name(name) => MemberTask::Name(self.member_word(name, frame)),
                MemberTask::Inline(d) => MemberTask::Inline(self.copied(d, frame)),
                MemberTask::For(r) => {
                    let values = match &r.values {
                        Values::List(list) => Values::List(self.value(list, frame)),
                        Values::Range(a, b) => Values::Range(self.value(a, frame), self.value(b, frame)),
                    };
                    let mut inner = frame.clone();
                    inner.bound.remove(&r.variable.value);
                    let body = self.members_as_written(&r.body, &mut inner);
                    let variable = r.variable.clone();
                    MemberTask::For(Box::new(Repeat { variable, values, body, closing_comments: Default::default() }))
                }
            };
            let weight = m.weight.as_ref().map(|w| self.value(w, frame));
            out.push(Member { task, weight, span: self.at(m.span, frame), comments: Default::default() });
        }
        out
    }

    /// A member that is a name; the variable of a repetition is replaced by the current name.
    fn member_word(&mut self, name: &Spanned<String>, frame: &mut Frame) -> Spanned<String> {
        match frame.bound.get(&name.value) {
            Some(super::substitute::Bound::Value(value) | super::substitute::Bound::Joints(value)) => {
                let word = crate::forms::text_of(value).map(str::to_string);
                let span: Span = self.at(name.span, frame);
                Spanned::new(word.unwrap_or_else(|| name.value.clone()), span)
            }
            _ => self.name(name, frame),
        }
    }
}

fn plain(name: Spanned<String>, settings: dsl::tree::Block, levels: Vec<Level>) -> Stack {
    Stack { name, parameters: Vec::new(), base: None, settings, levels, changes: Vec::new() }
}

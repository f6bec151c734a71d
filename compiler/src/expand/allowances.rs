//! Takes allowed warnings out of a tree, `allow HQ0606 "the tray is soft on purpose"`: the key that every block has. Later
//! stages do not meet it.

use std::collections::BTreeSet;

use dsl::tree::{
    Block, Change, Entry, Item, ItemKind, Level, Member, MemberTask, MissionMember, MissionRepeat, Spec, StateBody,
    Value, ValueKind,
};
use dsl::vocabulary::ALLOW;
use dsl::{Diagnostic, Fix, Help, Snippet, Span, Spanned, Syntax};

use crate::diagnostics::allowances::Allowance;
use crate::diagnostics::codes;

/// Removes the allowances of a spec, and returns them; reports those that are wrong.
pub(super) fn take(spec: &mut Spec, syntax: Syntax, diagnostics: &mut Vec<Diagnostic>) -> Vec<Allowance> {
    let mut taker = Taker { syntax, tasks: task_names(&spec.items), found: Vec::new(), diagnostics };
    taker.items(&mut spec.items, None);
    taker.found
}

/// Names that the levels of a file may contain: its tasks, and what it imports.
fn task_names(items: &[Item]) -> BTreeSet<String> {
    let names = items.iter().flat_map(|item| match &item.kind {
        ItemKind::Task(task) => vec![task.name.value.clone()],
        ItemKind::Import(import) => import.names.iter().map(|n| n.visible().value.clone()).collect(),
        ItemKind::For(repeat) => task_names(&repeat.body).into_iter().collect(),
        _ => Vec::new(),
    });
    names.collect()
}

struct Taker<'d> {
    syntax: Syntax,
    /// Names that levels may contain.
    tasks: BTreeSet<String>,
    found: Vec<Allowance>,
    diagnostics: &'d mut Vec<Diagnostic>,
}

impl Taker<'_> {
    /// Declarations; `scope` is the repetition around them.
    fn items(&mut self, items: &mut Vec<Item>, scope: Option<Span>) {
        items.retain(|item| {
            let ItemKind::Allow(allow) = &item.kind else { return true };
            let file = Span { start: 0, end: u32::MAX, ..item.span };
            let removable = (self.syntax == Syntax::Native).then_some(item.span);
            self.allowance(&allow.code, &allow.reason, scope.unwrap_or(file), removable);
            false
        });
        for item in items {
            let span = item.span;
            match &mut item.kind {
                ItemKind::Param(it) => self.block(&mut it.range, span),
                ItemKind::Robot(it) => self.block(&mut it.body, span),
                ItemKind::Task(it) => self.block(&mut it.definition.body, span),
                ItemKind::Signal(it) => self.block(&mut it.settings, span),
                ItemKind::Block(it) => self.block(&mut it.body, span),
                ItemKind::Scenario(it) => self.block(&mut it.body, span),
                ItemKind::Coverage(it) => self.block(&mut it.body, span),
                ItemKind::Run(it) => self.block(&mut it.body, span),
                ItemKind::Machine(it) => self.state(&mut it.body, span),
                ItemKind::Mission(it) => {
                    self.block(&mut it.settings, span);
                    self.mission(&mut it.members, &mut it.repeats);
                }
                ItemKind::Stack(it) => {
                    self.block(&mut it.settings, span);
                    it.levels.iter_mut().for_each(|level| self.level(level));
                    for change in &mut it.changes {
                        if let Change::Replace(level) | Change::Add(level, _) = change {
                            self.level(level);
                        }
                    }
                }
                ItemKind::For(it) => self.items(&mut it.body, Some(span)),
                ItemKind::Import(_) | ItemKind::Let(_) | ItemKind::Variable(_) | ItemKind::Allow(_) => {}
            }
        }
    }

    fn level(&mut self, level: &mut Level) {
        self.unquoted_reasons(level);
        self.block(&mut level.settings, level.span);
        self.members(&mut level.members);
    }

    /// Takes the words of a reason without quotes out of the tasks of a level, where they stand behind the code.
    fn unquoted_reasons(&mut self, level: &mut Level) {
        let allowed = level.settings.entries.iter_mut().filter(|e| e.key.value == ALLOW);
        let codes = allowed.filter_map(|e| match &mut e.value.kind {
            ValueKind::Block(codes) => Some(&mut codes.entries),
            _ => None,
        });
        for code in codes.flatten().filter(|code| matches!(code.value.kind, ValueKind::Missing)) {
            let behind = |m: &Member| m.span.source == code.key.span.source && m.span.start >= code.key.span.end;
            let Some(first) = level.members.iter().position(behind) else { continue };
            let unknown = |m: &Member| match &m.task {
                MemberTask::Name(name) => {
                    m.weight.is_none() && !self.tasks.contains(&name.value) && stdlib_tasks::find(&name.value).is_none()
                }
                _ => false,
            };
            let number = level.members[first..].iter().take_while(|m| unknown(m)).count();
            let words: Vec<Member> = level.members.drain(first..first + number).collect();
            let (Some(from), Some(to)) = (words.first(), words.last()) else { continue };
            let span = from.span.to(to.span);
            let text: Vec<&str> = words
                .iter()
                .filter_map(|m| if let MemberTask::Name(name) = &m.task { Some(name.value.as_str()) } else { None })
                .collect();
            let (written, text) = (code.key.value.as_str(), text.join(" "));
            let d = Diagnostic::error("HQ0222", span, format!("the reason of `{written}` is not in quotes"));
            let quoted = format!("\"{text}\"");
            self.diagnostics.push(
                d.note("without quotes the words are read as tasks of the level")
                    .help(format!("write `allow {written} {quoted}`"))
                    .fix(Fix::edit("Put the reason into quotes", span, quoted)),
            );
            code.value = Value { kind: ValueKind::Text(text), span };
        }
    }

    fn members(&mut self, members: &mut [Member]) {
        for member in members {
            match &mut member.task {
                MemberTask::Inline(task) => self.block(&mut task.body, member.span),
                MemberTask::For(repeat) => self.members(&mut repeat.body),
                MemberTask::Name(_) => {}
            }
        }
    }

    fn state(&mut self, body: &mut StateBody, span: Span) {
        self.block(&mut body.settings, span);
        for state in &mut body.states {
            self.state(&mut state.body, state.span);
        }
    }

    fn mission(&mut self, members: &mut [MissionMember], repeats: &mut [MissionRepeat]) {
        for member in members {
            self.block(&mut member.settings, member.span);
            self.mission(&mut member.members, &mut member.repeats);
        }
        for repeat in repeats {
            self.mission(&mut repeat.members, &mut repeat.repeats);
        }
    }

    /// The block of the declaration `scope`.
    fn block(&mut self, block: &mut Block, scope: Span) {
        block.entries.retain(|entry| entry.key.value != ALLOW || self.entry(entry, scope));
        for entry in &mut block.entries {
            let own = entry.key.span.to(entry.value.span);
            self.value(&mut entry.value, own);
        }
    }

    fn value(&mut self, value: &mut Value, scope: Span) {
        match &mut value.kind {
            ValueKind::Block(block) => self.block(block, scope),
            ValueKind::List(items) => items.iter_mut().for_each(|item| {
                let own = item.span;
                self.value(item, own);
            }),
            _ => {}
        }
    }

    /// The entry `allow` of a block. Returns true if it is something else: the position of a joint of this name.
    fn entry(&mut self, entry: &Entry, scope: Span) -> bool {
        match &entry.value.kind {
            ValueKind::Block(codes) => {
                let alone = (codes.entries.len() == 1).then(|| entry.key.span.to(entry.value.span));
                for code in &codes.entries {
                    self.allowance(&code.key, &code.value, scope, alone);
                }
                false
            }
            ValueKind::Missing => false,
            _ if entry.value.items().iter().all(|item| item.word().is_some()) => {
                let d = Diagnostic::error("HQ0220", entry.value.span, "`allow` takes a code and a reason");
                let shown = Snippet::each("allow HQ0606 \"the reason\"", "allow: { HQ0606: the reason }");
                self.diagnostics.push(d.help(Help::write(shown)));
                false
            }
            _ => true,
        }
    }

    fn allowance(&mut self, code: &Spanned<String>, reason: &Value, scope: Span, removable: Option<Span>) {
        let written = code.value.as_str();
        let known = codes::all().find(|page| page.code == written);
        let Some(page) = known.filter(|page| page.warning) else {
            let d = match known {
                Some(page) => Diagnostic::error("HQ0221", code.span, format!("`{written}` cannot be allowed"))
                    .here(page.title)
                    .note("only warnings can be allowed")
                    .help("delete it; `hierarq explain` says how the cause is mended"),
                None => Diagnostic::error("HQ0220", code.span, format!("there is no code `{written}`"))
                    .help("`hierarq explain` lists all codes")
                    .nearest(written, codes::all().filter(|page| page.warning).map(|page| page.code)),
            };
            self.diagnostics.push(match removable.filter(|_| known.is_some()) {
                Some(span) => d.fix(Fix::remove(&format!("allow {written}"), span)),
                None => d,
            });
            return;
        };
        let text = match &reason.kind {
            ValueKind::Text(text) => text.trim(),
            _ => "",
        };
        if text.is_empty() {
            let d = Diagnostic::error("HQ0222", code.span, format!("`{written}` is allowed without a reason"));
            let shown = Snippet::each(format!("allow {written} \"the reason\""), format!("{written}: the reason"));
            self.diagnostics.push(d.help(Help::write(shown)));
        }
        let span = code.span.to(reason.span);
        // Warnings are silent from the code on, so that the reason can be written in peace.
        self.found.push(Allowance { code: page.code, reason: text.to_string(), span, scope, removable });
    }
}

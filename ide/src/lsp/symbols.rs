//! Outline of a spec.

use dsl::tree::{BlockKind, Change, ItemKind, MissionMember, MissionRepeat, Robot, Stack, State, StateBody};
use dsl::{Span, Spanned};
use lsp_types::{DocumentSymbol, SymbolKind};

use super::document::Document;

/// Outline of all declarations, with parts of the robot and levels nested.
pub(super) fn of(document: &Document) -> Vec<DocumentSymbol> {
    let Some(spec) = document.spec() else { return Vec::new() };
    let o = Outline { document };
    spec.items.iter().map(|item| o.item(item)).collect()
}

struct Outline<'d> {
    document: &'d Document,
}

impl Outline<'_> {
    fn item(&self, item: &dsl::tree::Item) -> DocumentSymbol {
        let o = self;
        match &item.kind {
            ItemKind::Import(i) => o.symbol(&i.path, item.span, SymbolKind::FILE, "import", Vec::new()),
            ItemKind::Let(l) => o.symbol(&l.name, item.span, SymbolKind::CONSTANT, "let", Vec::new()),
            ItemKind::For(r) => {
                let body = r.body.iter().map(|item| o.item(item)).collect();
                o.symbol(&r.variable, item.span, SymbolKind::NAMESPACE, "for", body)
            }
            ItemKind::Param(p) => o.symbol(&p.name, item.span, SymbolKind::CONSTANT, "param", Vec::new()),
            ItemKind::Robot(r) => o.symbol(&r.name, item.span, SymbolKind::CLASS, "robot", o.robot(r)),
            ItemKind::Task(t) => {
                o.symbol(&t.name, item.span, SymbolKind::FUNCTION, &t.definition.kind.value, Vec::new())
            }
            ItemKind::Stack(s) => o.symbol(&s.name, item.span, SymbolKind::MODULE, "stack", o.stack(s)),
            ItemKind::Signal(s) => {
                let mark = if s.optional.is_some() { "?" } else { "" };
                let detail = format!("signal, {}{mark}", s.ty.value);
                o.symbol(&s.name, item.span, SymbolKind::EVENT, &detail, Vec::new())
            }
            ItemKind::Block(h) if h.kind == BlockKind::Human => {
                let points = h.body.get("points").map_or(&[][..], |e| e.value.items());
                let point = |p: &dsl::tree::Value| {
                    let name = Spanned::new(p.word()?.to_string(), p.span);
                    Some(o.symbol(&name, p.span, SymbolKind::FIELD, "point", Vec::new()))
                };
                let points = points.iter().filter_map(point).collect();
                o.symbol(&h.name, item.span, SymbolKind::CLASS, "human", points)
            }
            ItemKind::Block(b) => {
                let detail = b.kind.keyword().replace('_', " ");
                o.symbol(&b.name, item.span, SymbolKind::FUNCTION, &detail, Vec::new())
            }
            ItemKind::Variable(v) => {
                let mark = if v.optional.is_some() { "?" } else { "" };
                let detail = format!("variable, {}{mark}", v.ty.value);
                o.symbol(&v.name, item.span, SymbolKind::VARIABLE, &detail, Vec::new())
            }
            ItemKind::Machine(m) => o.symbol(&m.name, item.span, SymbolKind::CLASS, "machine", o.states(&m.body)),
            ItemKind::Mission(m) => {
                let detail = format!("mission, {}", m.kind.value);
                o.symbol(&m.name, item.span, SymbolKind::MODULE, &detail, o.members(&m.members, &m.repeats))
            }
            ItemKind::Scenario(s) => o.symbol(&s.name, item.span, SymbolKind::EVENT, "scenario", Vec::new()),
            ItemKind::Allow(a) => {
                let code = Spanned::new(format!("allow {}", a.code.value), a.code.span);
                o.symbol(&code, item.span, SymbolKind::EVENT, "", Vec::new())
            }
            ItemKind::Coverage(_) | ItemKind::Run(_) => {
                let word = if matches!(item.kind, ItemKind::Run(_)) { "run" } else { "coverage" };
                let start = item.span.range().start;
                let name = Spanned::new(word.to_string(), Span::new(item.span.source, start, start + word.len()));
                o.symbol(&name, item.span, SymbolKind::EVENT, "", Vec::new())
            }
        }
    }

    #[allow(deprecated, reason = "the field of the protocol has no other way to be left out")]
    fn symbol(
        &self,
        name: &Spanned<String>,
        whole: Span,
        kind: SymbolKind,
        detail: &str,
        children: Vec<DocumentSymbol>,
    ) -> DocumentSymbol {
        // The range must contain the name, also if a broken text separates them.
        let (inner, outer) = (name.span.range(), whole.range());
        let outer = outer.start.min(inner.start)..outer.end.max(inner.end);
        DocumentSymbol {
            // The protocol does not allow empty names.
            name: if name.value.is_empty() { "?".to_string() } else { name.value.clone() },
            detail: (!detail.is_empty()).then(|| detail.to_string()),
            kind,
            tags: None,
            deprecated: None,
            range: self.document.text.range(outer),
            selection_range: self.document.text.range(inner),
            children: (!children.is_empty()).then_some(children),
        }
    }

    fn robot(&self, robot: &Robot) -> Vec<DocumentSymbol> {
        let mut out = Vec::new();
        for (key, detail, kind) in [
            ("arms", "arm", SymbolKind::OBJECT),
            ("points", "point", SymbolKind::FIELD),
            ("segments", "segment", SymbolKind::FIELD),
            ("groups", "group", SymbolKind::ARRAY),
            ("joints", "joints", SymbolKind::ARRAY),
        ] {
            let entries = robot.body.get(key).map_or(&[][..], |e| e.value.entries());
            out.extend(
                entries.iter().map(|e| self.symbol(&e.key, e.key.span.to(e.value.span), kind, detail, Vec::new())),
            );
        }
        out.sort_by_key(|s| (s.range.start.line, s.range.start.character));
        out
    }

    fn states(&self, body: &StateBody) -> Vec<DocumentSymbol> {
        let state = |s: &State| {
            let detail = if s.final_.is_some() { "state, final" } else { s.word() };
            self.symbol(&s.name, s.span, SymbolKind::ENUM_MEMBER, detail, self.states(&s.body))
        };
        body.states.iter().map(state).collect()
    }

    /// Members of a mission, and repetitions with their members.
    fn members(&self, members: &[MissionMember], repeats: &[MissionRepeat]) -> Vec<DocumentSymbol> {
        let member = |m: &MissionMember| {
            let kind = match m.role.value.as_str() {
                "task" => SymbolKind::FUNCTION,
                "layer" => SymbolKind::NAMESPACE,
                "object" | "place" => SymbolKind::OBJECT,
                _ => SymbolKind::CLASS,
            };
            let detail = m.action.as_ref().map_or(&m.role.value, |action| &action.value);
            self.symbol(&m.name, m.span, kind, detail, self.members(&m.members, &m.repeats))
        };
        let repeat = |r: &MissionRepeat| {
            let body = self.members(&r.members, &r.repeats);
            self.symbol(&r.variable, r.span, SymbolKind::NAMESPACE, "for", body)
        };
        let mut out: Vec<_> = members.iter().map(member).chain(repeats.iter().map(repeat)).collect();
        out.sort_by_key(|s| (s.range.start.line, s.range.start.character));
        out
    }

    fn stack(&self, stack: &Stack) -> Vec<DocumentSymbol> {
        let level = |l: &dsl::tree::Level| {
            let detail = if l.hard.is_some() { "level, hard" } else { "level" };
            self.symbol(&l.name, l.span, SymbolKind::NAMESPACE, detail, Vec::new())
        };
        let changed = stack.changes.iter().filter_map(|change| match change {
            Change::Add(level, _) | Change::Replace(level) => Some(level),
            Change::Remove(_) => None,
        });
        stack.levels.iter().chain(changed).map(level).collect()
    }
}

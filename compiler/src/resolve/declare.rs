//! Symbols of a file: all names that its tree declares, before any reference is resolved.

use dsl::tree::{
    BlockKind, Change, Item, ItemKind, Level, Machine, Mission, MissionMember, MissionRepeat, Parameter, Spec, Stack,
    StateBody, Value,
};
use dsl::{Span, Spanned};

use super::symbols::{FileId, Formal, Symbol, SymbolId, SymbolKind};
use super::{CURSOR, CompletionContext, Meaning, Reference, Resolver};
use crate::lowering::VERBS;

/// Keys of a robot whose entries are its parts.
const PARTS: [(&str, SymbolKind); 5] = [
    ("arms", SymbolKind::Arm),
    ("points", SymbolKind::Point),
    ("segments", SymbolKind::Segment),
    ("groups", SymbolKind::Group),
    ("joints", SymbolKind::JointGroup),
];

/// A symbol to declare.
pub(super) struct New<'n> {
    pub kind: SymbolKind,
    pub name: &'n Spanned<String>,
    /// The whole declaration.
    pub whole: Span,
    /// Comments before it.
    pub doc: &'n [String],
    pub container: Option<SymbolId>,
    pub ty: &'n str,
    pub parameters: &'n [Parameter],
}

impl<'n> New<'n> {
    pub fn of(kind: SymbolKind, name: &'n Spanned<String>, whole: Span) -> New<'n> {
        New { kind, name, whole, doc: &[], container: None, ty: "", parameters: &[] }
    }

    fn doc(self, doc: &'n [String]) -> Self {
        New { doc, ..self }
    }

    fn ty(self, ty: &'n str) -> Self {
        New { ty, ..self }
    }

    pub fn inside(self, container: Option<SymbolId>) -> Self {
        New { container, ..self }
    }
}

/// Levels that a stack declares: its own, and those that it adds to its base.
pub(super) fn declared_levels(stack: &Stack) -> impl Iterator<Item = &Level> {
    let added = stack.changes.iter().filter_map(|change| match change {
        Change::Add(level, _) => Some(level),
        _ => None,
    });
    stack.levels.iter().chain(added)
}

impl Resolver<'_> {
    /// Adds a symbol. Returns `None` for the cursor, which is no name.
    pub(super) fn declare(&mut self, file: FileId, new: &New) -> Option<SymbolId> {
        let name = &new.name.value;
        if self.is_cursor(name, |_| CompletionContext::Nothing) || name.is_empty() {
            return None;
        }
        let (place, exact) = super::walk::place_of(self.text_of(file), name, new.name.span);
        let range = new.whole.range();
        let formal = |p: &Parameter| Formal {
            name: p.name.value.clone(),
            ty: p.ty.value.clone(),
            optional: p.default.is_some(),
        };
        let id = self.add_symbol(Symbol {
            kind: new.kind,
            name: name.clone(),
            file,
            place: place.clone(),
            whole: range.start.min(place.start)..range.end.max(place.end),
            container: new.container,
            doc: new.doc.to_vec(),
            ty: new.ty.to_string(),
            parameters: new.parameters.iter().map(formal).collect(),
            imported: None,
        });
        if file == FileId(0) {
            self.out.references.push(Reference { place, exact, declares: true, meaning: Meaning::Symbol(id) });
        }
        Some(id)
    }

    pub(super) fn add_symbol(&mut self, symbol: Symbol) -> SymbolId {
        let id = SymbolId(self.out.symbols.len());
        if let Some(container) = symbol.container {
            self.inside.entry((container, symbol.name.clone())).or_default().push(id);
            self.children.entry(container).or_default().push(id);
        }
        self.out.symbols.push(symbol);
        id
    }

    /// Declares the symbols of a file, except for the events that actions raise.
    pub(super) fn declare_spec(&mut self, file: FileId, spec: &Spec) {
        spec.items.iter().for_each(|item| self.declare_item(file, item));
    }

    fn declare_item(&mut self, file: FileId, item: &Item) {
        use SymbolKind as K;
        let doc = &item.comments.before;
        let new = |kind, name| New::of(kind, name, item.span).doc(doc);
        match &item.kind {
            ItemKind::Import(_)
            | ItemKind::Allow(_)
            | ItemKind::Coverage(_)
            | ItemKind::Run(_)
            | ItemKind::Scenario(_) => {}
            ItemKind::For(repeat) => repeat.body.iter().for_each(|item| self.declare_item(file, item)),
            ItemKind::Param(p) => {
                self.declare(file, &new(K::Param, &p.name));
            }
            ItemKind::Let(l) => {
                self.declare(file, &new(K::Let, &l.name));
            }
            ItemKind::Variable(v) => {
                self.declare(file, &new(K::Variable, &v.name).ty(&v.ty.value));
            }
            ItemKind::Signal(s) => {
                let kind = if s.ty.value == "event" { K::Event } else { K::Signal };
                self.declare(file, &new(kind, &s.name).ty(&s.ty.value));
            }
            ItemKind::Block(b) => {
                let kind = match b.kind {
                    BlockKind::Human => K::Human,
                    BlockKind::SafetyField => K::SafetyField,
                    BlockKind::Obstacle => K::Obstacle,
                };
                let declared = self.declare(file, &new(kind, &b.name));
                let points = if b.kind == BlockKind::Human { b.body.get("points") } else { None };
                for point in points.map_or(&[][..], |e| e.value.items()) {
                    let Some(name) = point.word() else { continue };
                    let name = Spanned::new(name.to_string(), point.span);
                    self.declare(file, &New::of(K::HumanPoint, &name, point.span).inside(declared));
                }
            }
            ItemKind::Robot(r) => {
                let robot = self.declare(file, &new(K::Robot, &r.name));
                for (key, kind) in PARTS {
                    for e in r.body.get(key).map_or(&[][..], |e| e.value.entries()) {
                        let new = New::of(kind, &e.key, e.key.span.to(e.value.span)).doc(&e.comments.before);
                        if let Some(id) = self.declare(file, &new.inside(robot)) {
                            self.scopes[file.0].parts.entry((kind, e.key.value.clone())).or_insert(id);
                        }
                    }
                }
            }
            ItemKind::Task(t) => {
                let new = New { parameters: &t.parameters, ..new(K::Task, &t.name).ty(&t.definition.kind.value) };
                let task = self.declare(file, &new);
                self.declare_parameters(file, task, &t.parameters);
            }
            ItemKind::Stack(s) => {
                let stack = self.declare(file, &New { parameters: &s.parameters, ..new(K::Stack, &s.name) });
                self.declare_parameters(file, stack, &s.parameters);
                for l in declared_levels(s) {
                    self.declare(file, &New::of(K::Level, &l.name, l.span).doc(&l.comments.before).inside(stack));
                }
            }
            ItemKind::Machine(m) => {
                let machine = self.declare(file, &new(K::Machine, &m.name));
                self.declare_states(file, machine, &m.body);
            }
            ItemKind::Mission(m) => self.declare_mission(file, m, &new(K::Mission, &m.name).ty(&m.kind.value)),
        }
    }

    fn declare_parameters(&mut self, file: FileId, owner: Option<SymbolId>, all: &[Parameter]) {
        for p in all {
            self.declare(file, &New::of(SymbolKind::Parameter, &p.name, p.span).ty(&p.ty.value).inside(owner));
        }
    }

    fn declare_states(&mut self, file: FileId, holder: Option<SymbolId>, body: &StateBody) {
        for s in &body.states {
            let new = New::of(SymbolKind::State, &s.name, s.span).doc(&s.comments.before);
            let state = self.declare(file, &new.inside(holder));
            self.declare_states(file, state, &s.body);
        }
    }

    fn declare_mission(&mut self, file: FileId, m: &Mission, new: &New) {
        let mission = self.declare(file, new);
        self.declare_members(file, mission, &m.members, &m.repeats);
    }

    fn declare_members(
        &mut self,
        file: FileId,
        container: Option<SymbolId>,
        members: &[MissionMember],
        repeats: &[MissionRepeat],
    ) {
        for m in members {
            let new = New::of(SymbolKind::Member, &m.name, m.span).doc(&m.comments.before).ty(&m.role.value);
            let member = self.declare(file, &new.inside(container));
            self.declare_members(file, member, &m.members, &m.repeats);
        }
        for r in repeats {
            self.declare_members(file, container, &r.members, &r.repeats);
        }
    }

    /// Declares the events that actions raise, if no signal declares them; after the scope of the file is complete.
    pub(super) fn declare_raised(&mut self, item: &Item) {
        match &item.kind {
            ItemKind::Machine(m) => self.raised_by(m),
            ItemKind::For(repeat) => repeat.body.iter().for_each(|item| self.declare_raised(item)),
            _ => {}
        }
    }

    /// Declares the events that the actions of a machine raise: their outcomes, and those that they name unless a
    /// signal declares them.
    fn raised_by(&mut self, machine: &Machine) {
        let file = FileId(0);
        let mut open = vec![&machine.body];
        while let Some(body) = open.pop() {
            open.extend(body.states.iter().rev().map(|s| &s.body));
            for a in &body.actions {
                let Some(verb) = VERBS.iter().find(|v| v.name == a.verb.value) else { continue };
                for outcome in verb.outcomes {
                    if !self.scopes[file.0].raised.contains_key(*outcome) {
                        let place = a.verb.span.range();
                        let id = self.add_symbol(Symbol {
                            kind: SymbolKind::Outcome,
                            name: (*outcome).to_string(),
                            file,
                            place: place.clone(),
                            whole: place,
                            container: None,
                            doc: Vec::new(),
                            ty: String::new(),
                            parameters: Vec::new(),
                            imported: None,
                        });
                        self.scopes[file.0].raised.insert((*outcome).to_string(), id);
                    }
                }
                if let Some(event) = a.args.first().filter(|_| verb.raises) {
                    self.raised_name(event);
                }
            }
        }
    }

    fn raised_name(&mut self, event: &Value) {
        let Some(name) = event.word().filter(|name| *name != CURSOR) else { return };
        if self.event(name).is_some() {
            return;
        }
        let name = Spanned::new(name.to_string(), event.span);
        if let Some(id) = self.declare(FileId(0), &New::of(SymbolKind::RaisedEvent, &name, event.span)) {
            self.scopes[0].raised.insert(name.value, id);
        }
    }
}

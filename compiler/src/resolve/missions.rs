//! References in missions and in the scenarios that execute them: members, measures, and the controllers of workers.

use dsl::tree::{Block, Formula, FormulaKind, Mission, MissionMember, MissionRepeat, Value, ValueKind};
use dsl::{Span, Spanned, Syntax};
use mission::kinds::find;

use super::context::{Offered, used};
use super::machines::path_of;
use super::sections::MEASURED;
use super::symbols::{FileId, Symbol, SymbolId, SymbolKind as K};
use super::{Around, CURSOR, CompletionContext as C, Meaning, Resolver};
use crate::expand::Class;
use crate::sections::{BlockSchema, DRIVEN, InSyntax, MISSION, RUNS, ValueType};

/// Schema of the block of a key.
fn inside(section: &'static BlockSchema, name: &str, syntax: Syntax) -> Option<&'static BlockSchema> {
    match section.key(name, syntax)?.value {
        ValueType::Block(section) => Some(section),
        _ => None,
    }
}

impl Resolver<'_> {
    pub(super) fn mission(&mut self, m: &Mission) {
        if !self.is_cursor(&m.kind.value, |_| C::Keys(&MISSION, Vec::new()))
            && let Some(key) = MISSION.key(&m.kind.value, self.syntax)
        {
            self.note(&m.kind.value, m.kind.span, Meaning::Key(key));
        }
        let skills = m.members.iter().filter_map(|m| Some(used(m.settings.get("skills")?.value.block()?)));
        let mut skills: Vec<String> = skills.flatten().filter(|skill| skill != CURSOR).collect();
        skills.sort();
        skills.dedup();
        self.around.of_mission = true;
        self.around.mission = self.declared(Class::Mission, &m.name.value);
        let section = inside(&MISSION, &m.kind.value, self.syntax);
        self.settings(&m.settings, section);
        self.members(&m.members, &m.repeats, section, &skills);
    }

    fn settings(&mut self, settings: &Block, section: Option<&'static BlockSchema>) {
        match section {
            Some(section) => self.section(settings, section),
            None => settings.entries.iter().for_each(|e| self.anything(&e.value)),
        }
    }

    fn members(
        &mut self,
        members: &[MissionMember],
        repeats: &[MissionRepeat],
        section: Option<&'static BlockSchema>,
        skills: &[String],
    ) {
        let mut title = None;
        for m in members {
            // In YAML, members share the key that contains them.
            if title.replace(m.role.span) != Some(m.role.span) {
                let role = &m.role.value;
                let word = if self.syntax == Syntax::Native { role.clone() } else { format!("{role}s") };
                if let Some(key) = section.and_then(|s| s.key(&word, self.syntax)) {
                    self.note(&word, m.role.span, Meaning::Key(key));
                }
            }
            if let Some(action) = &m.action {
                let one = |s: &String| Offered { name: s.clone(), about: "skill" };
                self.is_cursor(&action.value, |_| C::Offered(skills.iter().map(one).collect()));
            }
            let own = section.and_then(|s| inside(s, &m.role.value, Syntax::Native));
            self.settings(&m.settings, own);
            self.members(&m.members, &m.repeats, own, skills);
        }
        for r in repeats {
            let outer = self.bound.len();
            self.repeated_over(&r.variable, &r.values, r.span);
            self.members(&r.members, &r.repeats, section, skills);
            self.bound.truncate(outer);
        }
    }

    /// Member of the mission at any depth, with one of these roles; of all roles if there are none.
    fn find_member(&self, name: &str, roles: &[&str]) -> Option<SymbolId> {
        let holders = self.around.mission.into_iter().chain(self.members_of(&[]));
        let mut found = holders.filter_map(|holder| self.inside(holder, K::Member, name));
        found.find(|id| roles.is_empty() || roles.contains(&self.out.symbol(*id).ty.as_str()))
    }

    /// Members of the mission at any depth, with one of these roles; all if there are none.
    fn members_of(&self, roles: &[&str]) -> Vec<SymbolId> {
        let mut out = Vec::new();
        let mut open: Vec<SymbolId> = self.around.mission.into_iter().collect();
        while let Some(holder) = open.pop() {
            for id in self.all_inside(holder, K::Member) {
                open.push(id);
                if roles.is_empty() || roles.contains(&self.out.symbol(id).ty.as_str()) {
                    out.push(id);
                }
            }
        }
        out
    }

    /// Resolves the name of a member with one of these roles.
    pub(super) fn member(&mut self, name: &str, span: Span, roles: &[&str]) {
        if !self.around.of_mission {
            return;
        }
        if !self.is_cursor(name, |r| r.offering(&r.members_of(roles), |s| role(&s.ty))) {
            let found = self.find_member(name, roles);
            self.refer(name, span, K::Member, found);
        }
    }

    /// Resolves a position, or the name of a place.
    pub(super) fn place_name(&mut self, value: &Value) {
        match value.word() {
            Some(name) if name == CURSOR || self.find_member(name, &["place"]).is_some() => {
                self.member(name, value.span, &["place"]);
            }
            _ => self.expression(value),
        }
    }

    /// Resolves a formula of an expectation.
    pub(super) fn formula(&mut self, f: &Formula) {
        use FormulaKind as F;
        match &f.kind {
            F::Always(w, a) | F::Eventually(w, a) | F::Never(w, a) => {
                w.from.iter().chain(&w.to).for_each(|v| self.expression(v));
                self.formula(a);
            }
            F::Until(a, w, b) => {
                self.formula(a);
                w.from.iter().chain(&w.to).for_each(|v| self.expression(v));
                self.formula(b);
            }
            F::After(a, b) | F::And(a, b) | F::Or(a, b) | F::Implies(a, b) => {
                self.formula(a);
                self.formula(b);
            }
            F::Not(a) => self.formula(a),
            F::Value(v) => {
                self.with(Around { state: true, expected: true, ..self.around.clone() }, |r| r.expression(v));
            }
            F::Missing => {}
        }
    }

    /// Resolves the argument of `margin(..)` and other measures of a scenario.
    pub(super) fn measured(&mut self, function: &str, value: &Value) {
        match (function, &value.kind) {
            ("margin" | "error", ValueKind::Field(inner, _)) => self.measured(function, inner),
            ("margin" | "error", _) => self.name_in(value, Class::Task, K::Task, &[K::Task]),
            ("in", _) if self.around.of_mission => self.state_of_worker(value),
            ("in", _) => self.state_of_machine(value),
            ("reversals", _) => self.joints(value),
            ("speed" | "acceleration", _) => match value.word() {
                Some(name) if name != CURSOR && self.is_no_joint(name) => self.frame(value, &[K::Link, K::Arm]),
                _ => self.joints(value),
            },
            ("fault", _) => self.fault(value),
            _ => self.offer(value, |_| C::Nothing),
        }
    }

    /// Resolves `h1.waited` and `vineyard.makespan`; returns false for other values.
    pub(super) fn member_field(&mut self, inner: &Value, field: &Spanned<String>) -> bool {
        let (true, ValueKind::Name(name)) = (self.around.expected && self.around.of_mission, &inner.kind) else {
            return false;
        };
        let member = self.find_member(name, &MEASURED);
        let mission = self.around.mission.filter(|_| self.declared(Class::Mission, name) == self.around.mission);
        let Some(found) = member.or(mission) else { return false };
        self.refer(name, inner.span, K::Member, Some(found));
        let role = member.map(|id| role(&self.out.symbol(id).ty));
        let kind = self.around.mission.and_then(|m| find(&self.out.symbol(m).ty));
        let measures = kind.map(|kind| (kind.measures)()).unwrap_or_default();
        let one = |name: &str| Offered { name: name.to_string(), about: "measured" };
        let offered = || measures.iter().filter(|m| m.is_of(role)).map(|m| one(m.name)).collect();
        self.is_cursor(&field.value, |_| C::Offered(offered()));
        true
    }

    /// Completion context at the start of an expectation of a mission.
    pub(super) fn of_mission(&self) -> C {
        let C::Offered(mut offered) = self.offering(&self.members_of(&MEASURED), |s| role(&s.ty)) else {
            return C::Nothing;
        };
        if let Some(mission) = self.around.mission {
            offered.push(Offered { name: self.out.symbol(mission).name.clone(), about: K::Mission.word() });
        }
        offered.push(Offered { name: "done".to_string(), about: "measured" });
        offered.extend(["distance", "norm", "time", "in"].map(|w| Offered { name: w.to_string(), about: "built in" }));
        C::Offered(offered)
    }

    /// Resolves the block `runs` of a member.
    pub(super) fn runs(&mut self, block: &Block, section: &'static BlockSchema) {
        let controller = self.controller(block);
        self.with(Around { controller, ..self.around.clone() }, |r| r.section(block, section));
    }

    /// Spec that a block `runs` names.
    fn controller(&self, runs: &Block) -> Option<FileId> {
        self.named_files.get(runs.get("spec")?.value.word()?).copied()
    }

    /// Resolves the path of a spec.
    pub(super) fn spec_path(&mut self, value: &Value) {
        if let Some(path) = value.word()
            && !self.is_cursor(path, |_| C::Nothing)
        {
            let file = self.named_files.get(path).copied();
            self.note(path, value.span, Meaning::File(file));
        }
    }

    /// Resolves the path of the URDF, or of the SRDF.
    pub(super) fn described_path(&mut self, value: &Value, is_srdf: bool) {
        if let Some(path) = value.word()
            && !self.is_cursor(path, |_| C::Nothing)
        {
            let urdf = || (0..self.out.files.len()).map(FileId).find(|f| self.out.files[f.0].syntax.is_none());
            let file = if is_srdf { self.srdf } else { urdf() };
            self.note(path, value.span, Meaning::File(file));
        }
    }

    /// Resolves a signal of a type of the spec that the current member runs.
    pub(super) fn signal_there(&mut self, name: &str, span: Span, ty: &str) {
        self.value_there(name, span, K::Signal, |symbol| symbol.ty == ty);
    }

    /// Resolves a human of the spec that the current member runs.
    pub(super) fn human_there(&mut self, name: &str, span: Span) {
        self.value_there(name, span, K::Human, |symbol| symbol.kind == K::Human);
    }

    fn value_there(&mut self, name: &str, span: Span, kind: K, offers: impl Fn(&Symbol) -> bool) {
        let Some(FileId(file)) = self.around.controller else { return };
        let fitting = |r: &Self| {
            let own = r.scopes[file].declared.iter().filter(|((class, _), _)| *class == Class::Value);
            let all: Vec<SymbolId> = own.map(|(_, id)| *id).filter(|id| offers(r.out.symbol(*id))).collect();
            r.offering(&all, |s| s.kind.word())
        };
        if !self.is_cursor(name, fitting) {
            let found = self.scopes[file].declared.get(&(Class::Value, name.to_string())).copied();
            self.refer(name, span, kind, found);
        }
    }

    /// Machines that a file declares or imports.
    pub(super) fn machines_of(&self, file: FileId) -> Vec<SymbolId> {
        let all = self.scopes[file.0].declared.iter().filter(|((class, _), _)| *class == Class::Machine);
        all.map(|(_, id)| *id).collect()
    }

    /// Resolves a state of the spec that the current worker runs.
    pub(super) fn state_there(&mut self, value: &Value) {
        if let Some(file) = self.around.controller {
            self.states_of(&self.machines_of(file), &path_of(value));
        }
    }

    /// Resolves `w1.picking` in `in(..)`, in a scenario of a mission.
    fn state_of_worker(&mut self, value: &Value) {
        let parts = path_of(value);
        let Some((worker, states)) = parts.split_first() else { return };
        let running: Vec<SymbolId> =
            self.members_of(RUNNING).into_iter().filter(|id| self.controllers.contains_key(id)).collect();
        if self.is_cursor(&worker.value, |r| r.offering(&running, |s| role(&s.ty))) {
            return;
        }
        let found = self.find_member(&worker.value, RUNNING);
        self.refer(&worker.value, worker.span, K::Member, found);
        if let Some(file) = found.and_then(|id| self.controllers.get(&id).copied()) {
            self.states_of(&self.machines_of(file), states);
        }
    }
}

/// Roles of members that may run controllers.
const RUNNING: &[&str] = &["worker", "robot"];

/// Returns true for the block of a member that runs a controller.
pub(super) fn is_of_controller(section: &'static BlockSchema) -> bool {
    std::ptr::eq(section, &RUNS) || std::ptr::eq(section, &DRIVEN)
}

/// The role of a member as a word of the language.
fn role(ty: &str) -> &'static str {
    dsl::vocabulary::ROLES.iter().copied().find(|r| *r == ty).unwrap_or("member")
}

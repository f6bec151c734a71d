//! Copies missions and unrolls their repetitions.

use std::collections::BTreeMap;

use dsl::Span;
use dsl::tree::{Entry, ItemKind, Mission, MissionMember, MissionRepeat, Value, ValueKind};

use super::module::twice;
use super::substitute::Frame;
use super::{Class, Expander};

impl Expander<'_> {
    /// Copies a mission: fills holes, and appends the members of unrolled repetitions to its own.
    pub(super) fn copied_mission(&mut self, m: &Mission, frame: &mut Frame) -> Mission {
        let name = self.name(&m.name, frame);
        let kind = self.name(&m.kind, frame);
        let settings = self.block(&m.settings, frame);
        let members = self.all_members((&m.members, &m.repeats), frame);
        Mission { name, kind, settings, members, repeats: Vec::new() }
    }

    fn all_members(&mut self, of: (&[MissionMember], &[MissionRepeat]), frame: &mut Frame) -> Vec<MissionMember> {
        let mut out = Vec::new();
        self.mission_members(of, frame, &mut out);
        // If a name could not be filled, that is one mistake; its copies would collide and be reported again.
        if self.out.whole {
            self.distinct(&out);
        }
        out
    }

    fn mission_members(
        &mut self,
        (members, repeats): (&[MissionMember], &[MissionRepeat]),
        frame: &mut Frame,
        out: &mut Vec<MissionMember>,
    ) {
        for m in members {
            if frame.copies() && !self.count(m.span) {
                return;
            }
            let copy = self.mission_member(m, frame);
            out.push(copy);
        }
        for repeat in repeats {
            for value in self.values(&repeat.values, frame).unwrap_or_default() {
                if !self.count(value.span) {
                    return;
                }
                let at = value.span;
                let mut inner = frame.with(&repeat.variable.value, value, at);
                self.mission_members((&repeat.members, &repeat.repeats), &mut inner, out);
            }
        }
    }

    fn mission_member(&mut self, m: &MissionMember, frame: &mut Frame) -> MissionMember {
        MissionMember {
            role: self.name(&m.role, frame),
            name: self.name(&m.name, frame),
            action: m.action.as_ref().map(|action| self.name(action, frame)),
            settings: self.block(&m.settings, frame),
            members: self.all_members((&m.members, &m.repeats), frame),
            repeats: Vec::new(),
            span: self.at(m.span, frame),
            comments: Default::default(),
        }
    }

    /// Reports members of one role with equal names.
    fn distinct(&mut self, members: &[MissionMember]) {
        let mut seen: BTreeMap<(&str, &str), Span> = BTreeMap::new();
        for m in members {
            match seen.get(&(m.role.value.as_str(), m.name.value.as_str())) {
                Some(first) => self.fail(twice(&m.name, *first)),
                None => {
                    seen.insert((&m.role.value, &m.name.value), m.name.span);
                }
            }
        }
    }

    /// Adds a mission to the program.
    pub(super) fn emit_mission(&mut self, (m, i): (usize, usize)) {
        let ItemKind::Mission(mission) = self.modules[m].items[i].kind.clone() else { return };
        let mut copy = self.copied_mission(&mission, &mut Frame::of(m));
        copy.name.value = self.program_name(m, Class::Mission, &copy.name.value);
        self.paths(m, &mut copy.settings.entries);
        for member in &mut copy.members {
            let runs = member.settings.entries.iter_mut().find(|e| e.key.value == "runs");
            if let Some(Entry { value: Value { kind: ValueKind::Block(runs), .. }, .. }) = runs {
                self.paths(m, &mut runs.entries);
            }
        }
        self.out.missions.push(copy);
    }
}

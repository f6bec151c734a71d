//! Indexes references to the specs that workers of missions run: signals and states in other files.

use std::rc::Rc;

use compiler::sections::RUNS;
use dsl::Span;
use dsl::tree::{Block, ItemKind, MissionMember, MissionRepeat, Spec, Value, ValueKind};

use super::library::File;
use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::walk::{entries, word};
use super::walk_reuse::brought;

/// Spec that a member runs, as written.
fn spec_of(member: &MissionMember) -> Option<&str> {
    let runs = entries(&member.settings.get("runs")?.value);
    word(&runs.iter().find(|e| e.key.value == "spec")?.value).filter(|spec| *spec != MARKER)
}

/// Specs that workers of all missions of a spec run, as written.
pub(super) fn specs(spec: &Spec) -> Vec<&str> {
    fn below<'s>(members: &'s [MissionMember], repeats: &'s [MissionRepeat], out: &mut Vec<&'s str>) {
        out.extend(members.iter().filter_map(spec_of));
        repeats.iter().for_each(|r| below(&r.members, &r.repeats, out));
    }
    let mut out = Vec::new();
    for item in &spec.items {
        if let ItemKind::Mission(m) = &item.kind {
            below(&m.members, &m.repeats, &mut out);
        }
    }
    out
}

/// Names of a path such as `outer.inner`, each with its span.
fn parts(value: &Value) -> Vec<(&str, Span)> {
    let (mut parts, mut rest) = (Vec::new(), value);
    while let ValueKind::Field(inner, field) = &rest.kind {
        parts.push((field.value.as_str(), field.span));
        rest = inner;
    }
    parts.extend(word(rest).map(|first| (first, rest.span)));
    parts.reverse();
    parts
}

impl Walker<'_> {
    /// Indexes the block `runs` of a worker.
    pub(super) fn runs(&mut self, block: &Block) {
        let spec = block.get("spec").and_then(|e| word(&e.value)).map(str::to_string);
        let around = std::mem::replace(&mut self.there, spec);
        self.section(block, &RUNS);
        self.there = around;
    }

    /// Indexes the path of a spec.
    pub(super) fn spec_path(&mut self, value: &Value) {
        if let Some(path) = word(value)
            && !self.marked(path, || Slot::Nothing)
        {
            self.note(path, value.span, What::Spec(path.to_string()));
        }
    }

    /// Records the spec that a worker runs, by the worker's qualified name.
    pub(super) fn declared_runs(&mut self, member: &str, m: &MissionMember) {
        if let Some(spec) = spec_of(m) {
            self.found.runs.insert(member.to_string(), spec.to_string());
        }
    }

    fn file_there(&self, spec: Option<&str>) -> Option<Rc<File>> {
        self.imports.iter().find(|i| Some(i.written.as_str()) == spec)?.file.clone()
    }

    /// Indexes a signal of the spec that the current worker runs.
    pub(super) fn signal_there(&mut self, value: &Value) {
        let (Some(name), Some(file)) = (word(value), self.file_there(self.there.as_deref())) else { return };
        let flags = || {
            let is_flag = |name: &&str| file.mentions.types.get(*name).is_some_and(|ty| ty == "flag");
            file.mentions.names(Class::Signal).filter(is_flag).map(|n| (n.to_string(), Class::Signal.word())).collect()
        };
        if !self.marked(name, || Slot::Offered(flags())) {
            self.there(&file, (Class::Signal, name.to_string()), (name, value.span));
        }
    }

    /// Indexes a state of the spec that the current worker runs.
    pub(super) fn state_there(&mut self, value: &Value) {
        if let Some(file) = self.file_there(self.there.as_deref()) {
            self.states_there(&file, &parts(value));
        }
    }

    /// Indexes `w1.picking` in `in(..)`, in a scenario of a mission.
    pub(super) fn state_of_worker(&mut self, value: &Value) {
        let parts = parts(value);
        let (Some(((name, span), states)), Some(mission)) = (parts.split_first(), self.mission.clone()) else { return };
        let running = |w: &Self| {
            let before = format!("{mission}.worker.");
            let own = w.found.runs.keys().filter_map(|key| Some(key.strip_prefix(&before)?.to_string()));
            own.map(|name| (name, "worker")).collect()
        };
        if *name == MARKER {
            self.found.slot = Some(Slot::Offered(running(self)));
            return;
        }
        let key = format!("{mission}.worker.{name}");
        if self.has(Class::Member, &key) {
            self.note(name, *span, What::Declared(Class::Member, key.clone()));
        }
        let spec = self.found.runs.get(&key).cloned();
        if let Some(file) = self.file_there(spec.as_deref()) {
            self.states_there(&file, states);
        }
    }

    /// Indexes states of a file, by the path from the machine or a suffix of it.
    fn states_there(&mut self, file: &File, parts: &[(&str, Span)]) {
        let mut known: Vec<&str> = file.mentions.names(Class::State).collect();
        if parts.iter().any(|p| p.0 == MARKER) {
            let before: String = parts.iter().take_while(|p| p.0 != MARKER).map(|p| format!("{}.", p.0)).collect();
            let paths = known.iter().filter_map(|key| Some(key.split_once('.')?.1));
            let offered = paths.filter_map(|path| path.strip_prefix(&before));
            self.found.slot = Some(Slot::Offered(offered.map(|s| (s.to_string(), Class::State.word())).collect()));
            return;
        }
        // Shorter names first: a complete path has precedence over a suffix of a longer one.
        known.sort_by_key(|key| key.len());
        let path: String = parts.iter().map(|p| format!(".{}", p.0)).collect();
        let Some(key) = known.iter().find(|key| key.ends_with(&path)) else { return };
        let outer = key.strip_suffix(&path).unwrap_or("");
        let mut key = outer.to_string();
        for (name, span) in parts {
            key = format!("{key}.{name}");
            self.there(file, (Class::State, key.clone()), (name, *span));
        }
    }

    /// Records a word that refers to a declaration of another file.
    fn there(&mut self, file: &File, key: (Class, String), (name, span): (&str, Span)) {
        if let Some((_, elsewhere)) = brought(file, &key) {
            self.note(name, span, What::Brought(key.0, Box::new(elsewhere)));
        }
    }
}

//! A mission of the kind `layers`, as a problem of its planner.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use dsl::tree::{Mission, MissionMember, Value, ValueKind};
use mission::kinds::layers::Layers;
use mission::kinds::layers::check::{Item, Key};
use mission::kinds::layers::problem::{Agent, Object, Problem, Task, Weights};

use super::super::Lowerer;
use super::super::declared::twice;
use super::places::OfLayers as Places;
use super::reading::Keys;
use super::spots::Spots;
use crate::expr::constants::with_units;
use crate::forms::{check_keys, text_of};
use crate::sections::{LAYER, LAYERS, LAYERS_TASK, LAYERS_WEIGHTS};

impl Lowerer<'_> {
    /// A mission of layers. `None` where it cannot be planned; the diagnostics say why.
    pub(super) fn layers(&mut self, m: &Mission) -> Option<Layers> {
        let before = self.errors();
        let mut places = Places::new(m.name.span);
        places.note(Item::Mission, None, m.name.span);
        check_keys(&m.settings, &LAYERS, self.diagnostics);
        let keys = Keys { block: &m.settings, section: &LAYERS, at: m.name.span };
        keys.entry("weights").iter().for_each(|e| places.note(Item::Mission, Some(Key::Weights), e.value.span));
        let weights = self.layers_weights(keys);
        if weights.is_none() {
            places.spoil(Item::Mission, Key::Weights);
        }
        let batch = match keys.entry("batch") {
            Some(_) => self.batch(keys).map(Some),
            None => Some(None),
        };
        let reallocate_above = self.key_number(keys, "reallocate_above").ok().flatten();
        let returns = keys.entry("returns").map_or(Some(true), |e| self.flag(&e.value, "returns"));
        let (spots, agents, objects) = self.layers_team(m, &mut places);
        let (layers, tasks) = self.layers_tasks(m, (&agents, &objects, &spots), &mut places);
        let instruction = keys.entry("instruction").and_then(|e| self.sentence(&e.value, "instruction"));
        let directives = keys.entry("directives").map_or(&[][..], |e| e.value.items());
        let directives = directives.iter().filter_map(|item| self.sentence(item, "directives")).collect();
        let labels = self.labels(m, &tasks);
        self.mistaken_labels(m, agents.iter().map(|a| &a.name), &labels);
        let mut problem = Problem {
            agents,
            objects,
            layers,
            tasks,
            weights: weights.unwrap_or(Weights { workload: 1.0, energy: 1.0, makespan: 1.0 }),
            returns: returns.unwrap_or(true),
            start: 0.0,
            begun: Vec::new(),
            places: spots,
            labels,
        };
        if let Some(e) = keys.entry("layers_from") {
            // The file is held against the team, which must be good for that.
            if self.errors() == before {
                problem = self.layers_from(m, e, problem)?;
            }
        } else {
            let waits = instruction.is_some() && problem.layers.is_empty();
            self.layers_mistakes(m, &problem, &places, waits);
        }
        if self.errors() == before {
            self.layers_warnings(m, &problem, &places);
        }
        if self.errors() > before {
            return None;
        }
        Some(Layers { problem, batch: batch?, reallocate_above: reallocate_above?, instruction, directives })
    }

    fn layers_weights(&mut self, keys: Keys) -> Option<Weights> {
        let keys = self.inner_or_nothing(keys, "weights", &LAYERS_WEIGHTS)?;
        let mut one = |name: &str| match keys {
            Some(keys) => self.key_number(keys, name).ok().flatten(),
            None => Some(1.0),
        };
        let (workload, energy, makespan) = (one("workload"), one("energy"), one("makespan"));
        Some(Weights { workload: workload?, energy: energy?, makespan: makespan? })
    }

    /// A text in quotes.
    fn sentence(&mut self, value: &Value, name: &str) -> Option<String> {
        if let ValueKind::Text(text) = &value.kind {
            return Some(text.clone());
        }
        let d = Diagnostic::error("HQ0304", value.span, format!("`{name}` is said in words, in quotes"));
        self.push(d.help(format!(
            "write for instance `{}`",
            if name == "directives" { "[\"Objects must not overlap.\"]" } else { "\"Build the letter H.\"" }
        )));
        None
    }

    /// `true` or `false`.
    fn flag(&mut self, value: &Value, name: &str) -> Option<bool> {
        match text_of(value) {
            Some("true") => Some(true),
            Some("false") => Some(false),
            _ => {
                let d = Diagnostic::error("HQ0304", value.span, format!("`{name}` is `true` or `false`"));
                self.push(d.help("write one of the two"));
                None
            }
        }
    }

    /// Who takes part and what is there: places; robots, then people; objects; each in the order written.
    fn layers_team(&mut self, m: &Mission, places: &mut Places) -> (Spots, Vec<Agent>, Vec<Object>) {
        let mut names: BTreeMap<&str, &MissionMember> = BTreeMap::new();
        let mut known: Vec<&MissionMember> = Vec::new();
        for member in &m.members {
            let inner = (member.role.value == "layer").then_some(&LAYER);
            if !self.roles(member, &LAYERS, inner) {
                places.lose();
                continue;
            }
            match names.get(member.name.value.as_str()) {
                // Two of one role were reported when repetitions were unrolled; a layer may be called as anything else.
                Some(first) if first.role == member.role => places.lose(),
                Some(first) if member.role.value != "layer" && first.role.value != "layer" => {
                    self.push(twice(&member.name, first.name.span));
                    places.lose();
                    // It still is what others mean by its name.
                    known.push(member);
                }
                Some(_) => known.push(member),
                None => {
                    names.insert(&member.name.value, member);
                    known.push(member);
                }
            }
        }
        let of = |role: &str| known.iter().filter(|k| k.role.value == role).copied().collect::<Vec<_>>();
        let spots = self.spots(&of("place"));
        let mut agents = Vec::new();
        for member in of("robot").into_iter().chain(of("human")) {
            agents.push(self.layers_agent(agents.len(), member, &spots, places));
        }
        let mut objects = Vec::new();
        for member in of("object") {
            objects.push(self.object(objects.len(), member, &spots, places));
        }
        (spots, agents, objects)
    }

    /// The names of the layers, and all tasks in their order. A task is called after its layer too where another one has
    /// its name.
    fn layers_tasks(
        &mut self,
        m: &Mission,
        team: (&[Agent], &[Object], &Spots),
        places: &mut Places,
    ) -> (Vec<String>, Vec<Task>) {
        let all: Vec<&MissionMember> = m.members.iter().filter(|k| k.role.value == "layer").collect();
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for task in all.iter().flat_map(|layer| &layer.members) {
            *counts.entry(&task.name.value).or_default() += 1;
        }
        let (mut layers, mut tasks) = (Vec::new(), Vec::new());
        for layer in all {
            check_keys(&layer.settings, &LAYER, self.diagnostics);
            places.note(Item::Layer(layers.len()), None, layer.name.span);
            for member in layer.members.iter().filter(|t| t.role.value == "task") {
                let name = &member.name.value;
                let several = counts.get(name.as_str()).is_some_and(|n| *n > 1);
                let name = if several { format!("{}.{name}", layer.name.value) } else { name.clone() };
                tasks.push(self.layers_task((tasks.len(), layers.len()), (name, member), team, places));
            }
            layers.push(layer.name.value.clone());
        }
        (layers, tasks)
    }

    fn layers_task(
        &mut self,
        (number, layer): (usize, usize),
        (name, member): (String, &MissionMember),
        (agents, objects, spots): (&[Agent], &[Object], &Spots),
        places: &mut Places,
    ) -> Task {
        let item = Item::Task(number);
        places.note(item, None, member.name.span);
        check_keys(&member.settings, &LAYERS_TASK, self.diagnostics);
        let keys = Keys { block: &member.settings, section: &LAYERS_TASK, at: member.name.span };
        for (name, key) in [
            ("features", Key::Features),
            ("to", Key::Path),
            ("via", Key::Path),
            ("object", Key::Object),
            ("agent", Key::Agent),
        ] {
            keys.entry(name).iter().for_each(|e| places.note(item, Some(key), e.value.span));
        }
        // The reader has said that an action is missing.
        let action = member.action.as_ref();
        action.iter().for_each(|a| places.note(item, Some(Key::Action), a.span));
        let features = self.words(keys, "features");
        let path = self.path_of_task(keys, spots);
        let object = self.member_named(keys, "object", objects.iter().map(|o| o.name.as_str()));
        let agent = self.member_named(keys, "agent", agents.iter().map(|a| a.name.as_str()));
        let wrong = [
            (action.is_none(), Key::Action),
            (features.is_none() || keys.misspells("features"), Key::Features),
            (path.is_none(), Key::Path),
            (object.is_err(), Key::Object),
            (agent.is_err(), Key::Agent),
        ];
        wrong.into_iter().filter(|w| w.0).for_each(|(_, key)| places.spoil(item, key));
        Task {
            name,
            layer,
            action: action.map(|a| a.value.clone()).unwrap_or_default(),
            features: features.unwrap_or_default(),
            path: path.unwrap_or_default(),
            object: object.unwrap_or_default(),
            agent: agent.unwrap_or_default(),
        }
    }

    /// The places on the way of a task and its end.
    fn path_of_task(&mut self, keys: Keys, spots: &Spots) -> Option<Vec<[f64; 3]>> {
        let mut path = Vec::new();
        if let Some(e) = keys.entry("via") {
            let items = with_units(&e.value).unwrap_or_else(|| e.value.items().to_vec());
            for item in &items {
                path.push(self.position(item, spots)?);
            }
        }
        if let Some(e) = keys.entry("to") {
            path.push(self.position(&e.value, spots)?);
        }
        Some(path)
    }

    /// Words of a list; none where the key is left out.
    pub(super) fn words(&mut self, keys: Keys, name: &str) -> Option<BTreeSet<String>> {
        let Some(e) = keys.entry(name) else { return Some(BTreeSet::new()) };
        let mut all = BTreeSet::new();
        for item in e.value.items() {
            let Some(word) = text_of(item) else {
                let d = Diagnostic::error("HQ0304", item.span, format!("`{name}` are words"));
                self.push(d.help(format!("write for instance `{name} [cube, red]`")));
                return None;
            };
            all.insert(word.to_string());
        }
        Some(all)
    }

    /// The number of a member that a key names.
    fn member_named<'n>(
        &mut self,
        keys: Keys,
        name: &str,
        names: impl Iterator<Item = &'n str>,
    ) -> Result<Option<usize>, ()> {
        let Some(e) = keys.entry(name) else { return Ok(None) };
        let names: Vec<&str> = names.collect();
        if let Some(word) = text_of(&e.value) {
            return self.one_of(&format!("{name} of this mission"), word, e.value.span, &names).map(Some).ok_or(());
        }
        let first = match &e.value.kind {
            ValueKind::Missing => return Err(()),
            ValueKind::List(items) => items.first().and_then(text_of),
            _ => None,
        };
        let text = match first {
            Some(_) => format!("`{name}` is one name, not a list"),
            None => format!("`{name}` is the name of an {name} of this mission"),
        };
        let d = Diagnostic::error("HQ0304", e.value.span, text);
        self.push(d.help(match first.or(names.first().copied()) {
            Some(word) => format!("write for instance `{name} {word}`"),
            None => "leave it out".to_string(),
        }));
        Err(())
    }
}

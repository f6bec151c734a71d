//! The team and the objects of a mission of layers.

use dsl::tree::MissionMember;
use dsl::{Diagnostic, Spanned};
use mission::kinds::layers::check::{Item, Key};
use mission::kinds::layers::problem::{Agent, Body, Object, Skill};
use mission::numbers::Energy;
use mission::numbers::Range;
use stdlib_tasks::dimension::{NONE, TIME};
use stdlib_tasks::params::Quantity;

use super::super::Lowerer;
use super::places::OfLayers as Places;
use super::reading::Keys;
use super::spots::Spots;
use crate::forms::{block_of, check_keys};
use crate::sections::{LAYERS_HUMAN, LAYERS_ROBOT, OBJECT};

/// What stands for a speed that is wrong, so that the rest can be looked at (m/s).
const SOME_SPEED: f64 = 1.0;

impl Lowerer<'_> {
    /// The agent of this number. Where something of it is wrong, a usual value stands in its place, and `places` knows.
    pub(super) fn layers_agent(
        &mut self,
        number: usize,
        member: &MissionMember,
        spots: &Spots,
        places: &mut Places,
    ) -> Agent {
        let item = Item::Agent(number);
        places.note(item, None, member.name.span);
        let is_robot = member.role.value == "robot";
        let section = if is_robot { &LAYERS_ROBOT } else { &LAYERS_HUMAN };
        check_keys(&member.settings, section, self.diagnostics);
        let keys = Keys { block: &member.settings, section, at: member.name.span };
        for (name, key) in [
            ("place", Key::Place),
            ("speed", Key::Speed),
            ("skills", Key::Skills),
            ("paces", Key::Skills),
            ("energy", Key::Energy),
            ("slowing", Key::Slowing),
            ("reach", Key::Reach),
            ("payload", Key::Payload),
            ("cannot", Key::Cannot),
            ("spread", Key::Spread),
        ] {
            keys.entry(name).iter().for_each(|e| places.note(item, Some(key), e.value.span));
        }
        let place = self.base_of(keys, spots);
        let body = if is_robot { self.robot_body(keys) } else { self.human_body(keys) };
        let skills = self.skills(keys);
        let (reach, payload) = (self.key_number(keys, "reach"), self.key_number(keys, "payload"));
        let cannot = self.words(keys, "cannot");
        let spread = self.key_number(keys, "spread");
        let wrong = [
            (place.is_none(), Key::Place),
            (body.is_none(), Key::Speed),
            (body.is_none(), Key::Energy),
            (body.is_none(), Key::Slowing),
            (skills.is_none(), Key::Skills),
            (reach.is_err(), Key::Reach),
            (payload.is_err(), Key::Payload),
            (cannot.is_none(), Key::Cannot),
            (spread.is_err(), Key::Spread),
        ];
        wrong.into_iter().filter(|w| w.0).for_each(|(_, key)| places.spoil(item, key));
        let some = Body::Human { speed: SOME_SPEED, slowing: 0.0 };
        Agent {
            name: member.name.value.clone(),
            place: place.unwrap_or_default(),
            body: body.unwrap_or(some),
            skills: skills.unwrap_or_default(),
            reach: reach.ok().flatten(),
            payload: payload.ok().flatten(),
            cannot: cannot.unwrap_or_default(),
            spread: spread.ok().flatten().unwrap_or(0.0),
            lost: false,
        }
    }

    /// A position behind `place`, which must be there.
    fn base_of(&mut self, keys: Keys, spots: &Spots) -> Option<[f64; 3]> {
        match keys.entry("place") {
            Some(e) => self.position(&e.value, spots),
            None if keys.misspells("place") => None,
            None => {
                let d = Diagnostic::error("HQ0206", keys.at, format!("{} needs `place`", keys.section.name));
                self.push(d.help("write for instance `place [0.4, 0, 0.1] m`"));
                None
            }
        }
    }

    fn robot_body(&mut self, keys: Keys) -> Option<Body> {
        let factor = self.key_number(keys, "factor");
        let speed: Result<Option<Range>, ()> = self.key_range(keys, "speed");
        let energy: Option<Energy> = self.energy(keys, factor.ok().flatten().unwrap_or(1.0));
        factor.ok()?;
        Some(Body::Robot { speed: speed.ok()??, energy: energy? })
    }

    fn human_body(&mut self, keys: Keys) -> Option<Body> {
        let (speed, slowing) = (self.key_number(keys, "speed"), self.key_number(keys, "slowing"));
        Some(Body::Human { speed: speed.ok()??, slowing: slowing.ok()?? })
    }

    /// What an agent is able to do.
    fn skills(&mut self, keys: Keys) -> Option<Vec<Skill>> {
        let Some(e) = keys.entry("skills") else {
            self.lacks(keys, "skills");
            return None;
        };
        let block = block_of(&e.value, "`skills`", self.diagnostics)?;
        let (mut all, mut good) = (Vec::new(), true);
        for e in &block.entries {
            match self.number_within(&e.value, &e.key.value, &Quantity::at_least(TIME, 0.0)) {
                Some(duration) => all.push(Skill { action: e.key.value.clone(), duration, pace: 1.0 }),
                None => good = false,
            }
        }
        let paces = keys.entry("paces").map(|e| block_of(&e.value, "`paces`", self.diagnostics));
        for e in paces.iter().flatten().flat_map(|b| &b.entries) {
            let pace = self.number_within(&e.value, &e.key.value, &Quantity::between(NONE, 0.0, 1.0));
            let names: Vec<&str> = all.iter().map(|s: &Skill| s.action.as_str()).collect();
            let found = self.skill_named(&e.key, &names);
            match found.and_then(|i| all.get_mut(i)).zip(pace) {
                Some((skill, pace)) => skill.pace = pace,
                None => good = false,
            }
        }
        (good && paces.is_none_or(|p| p.is_some())).then_some(all)
    }

    fn skill_named(&mut self, name: &Spanned<String>, names: &[&str]) -> Option<usize> {
        self.one_of("skill of this agent", &name.value, name.span, names)
    }

    /// The object of this number.
    pub(super) fn object(
        &mut self,
        number: usize,
        member: &MissionMember,
        spots: &Spots,
        places: &mut Places,
    ) -> Object {
        let item = Item::Object(number);
        places.note(item, None, member.name.span);
        check_keys(&member.settings, &OBJECT, self.diagnostics);
        let keys = Keys { block: &member.settings, section: &OBJECT, at: member.name.span };
        for (name, key) in [("place", Key::Place), ("mass", Key::Mass), ("features", Key::Features)] {
            keys.entry(name).iter().for_each(|e| places.note(item, Some(key), e.value.span));
        }
        let (place, mass) = (self.base_of(keys, spots), self.key_number(keys, "mass"));
        let features = self.words(keys, "features");
        let featureless = features.is_none() || keys.misspells("features");
        let wrong = [(place.is_none(), Key::Place), (mass.is_err(), Key::Mass), (featureless, Key::Features)];
        wrong.into_iter().filter(|w| w.0).for_each(|(_, key)| places.spoil(item, key));
        Object {
            name: member.name.value.clone(),
            place: place.unwrap_or_default(),
            mass: mass.ok().flatten().unwrap_or(0.0),
            features: features.unwrap_or_default(),
        }
    }
}

//! The robots of a schedule: those that serve.

use dsl::tree::MissionMember;
use mission::kinds::schedule::check::{Item, Key};
use mission::kinds::schedule::problem::Robot;
use mission::numbers::{Energy, Range};

use super::super::Lowerer;
use super::places::OfSchedule as Places;
use super::reading::Keys;
use crate::forms::{block_of, check_keys};
use crate::sections::{ENERGY, SCHEDULE_ROBOT};

/// What stands for a speed that is wrong, so that the rest can be looked at.
const SOME_SPEED: f64 = 1.0;

impl Lowerer<'_> {
    /// The robot of this number. Where something of it is wrong, a usual value stands in its place, and `places` knows.
    pub(super) fn schedule_robot(&mut self, number: usize, member: &MissionMember, places: &mut Places) -> Robot {
        let item = Item::Robot(number);
        places.note(item, None, member.name.span);
        check_keys(&member.settings, &SCHEDULE_ROBOT, self.diagnostics);
        let keys = Keys { block: &member.settings, section: &SCHEDULE_ROBOT, at: member.name.span };
        let names = [
            ("depot", Key::Depot),
            ("speed", Key::Speed),
            ("proximity_speed", Key::Proximity),
            ("serve", Key::Serve),
            ("deposit", Key::Deposit),
            ("factor", Key::Factor),
            ("energy", Key::Energy),
        ];
        for (name, key) in names {
            keys.entry(name).iter().for_each(|e| places.note(item, Some(key), e.value.span));
        }
        let mut or = |found: Result<Option<f64>, ()>, key: Key, otherwise: f64| match found {
            Ok(x) => x.unwrap_or(otherwise),
            Err(()) => {
                places.spoil(item, key);
                otherwise
            }
        };
        let serve = or(self.key_number(keys, "serve"), Key::Serve, 0.0);
        let deposit = or(self.key_number(keys, "deposit"), Key::Deposit, 0.0);
        let factor = or(self.key_number(keys, "factor"), Key::Factor, 1.0);
        let depot = self.key_pair(keys, "depot");
        let speed = self.key_range(keys, "speed");
        let proximity = self.key_range(keys, "proximity_speed");
        let energy = self.energy(keys, factor);
        let wrong = [
            (depot.is_none(), Key::Depot),
            (speed.is_err(), Key::Speed),
            (proximity.is_err(), Key::Proximity),
            (energy.is_none(), Key::Energy),
        ];
        wrong.into_iter().filter(|w| w.0).for_each(|(_, key)| places.spoil(item, key));
        Robot {
            name: member.name.value.clone(),
            depot: depot.unwrap_or_default(),
            speed: speed.ok().flatten().unwrap_or(Range::point(SOME_SPEED)),
            proximity: proximity.ok().flatten(),
            serve,
            deposit,
            factor,
            energy: energy.unwrap_or(Energy::of_factor(1.0)),
        }
    }

    /// The coefficients of the power; `None` where one is wrong.
    pub(super) fn energy(&mut self, keys: Keys, factor: f64) -> Option<Energy> {
        let usual = Energy::of_factor(factor);
        let Some(e) = keys.entry("energy") else { return Some(usual) };
        let block = block_of(&e.value, "`energy`", self.diagnostics)?;
        check_keys(block, &ENERGY, self.diagnostics);
        let keys = Keys { block, section: &ENERGY, at: e.key.span };
        let standby = self.key_number(keys, "standby");
        let friction = self.key_number(keys, "friction");
        let drag = self.key_number(keys, "drag");
        Some(Energy {
            standby: standby.ok()?.unwrap_or(usual.standby),
            friction: friction.ok()?.unwrap_or(usual.friction),
            drag: drag.ok()?.unwrap_or(usual.drag),
        })
    }
}

//! The agents of a schedule: the people and working robots that are served.

use dsl::Spanned;
use dsl::tree::MissionMember;
use mission::kinds::schedule::check::{Item, Key, MAX_OPERATIONS};
use mission::kinds::schedule::problem::{Agent, AgentKind, Approach, Duration, Robot, WAIT_LIMIT};

use super::super::Lowerer;
use super::places::OfSchedule as Places;
use super::reading::Keys;
use crate::forms::{block_of, check_keys};
use crate::sections::{APPROACH, SCHEDULE_HUMAN, SCHEDULE_WORKER};

/// What stands for a duration that is wrong, so that the rest can be looked at (s).
const SOME_DURATION: f64 = 1.0;

impl Lowerer<'_> {
    /// The agent of this number. Where something of it is wrong, a usual value stands in its place, and `places` knows.
    pub(super) fn schedule_agent(
        &mut self,
        (number, kind): (usize, AgentKind),
        member: &MissionMember,
        robots: &[Robot],
        places: &mut Places,
    ) -> Agent {
        let item = Item::Agent(number);
        places.note(item, None, member.name.span);
        let section = if kind == AgentKind::Human { &SCHEDULE_HUMAN } else { &SCHEDULE_WORKER };
        check_keys(&member.settings, section, self.diagnostics);
        let keys = Keys { block: &member.settings, section, at: member.name.span };
        let names = [
            ("place", Key::Place),
            ("operations", Key::Operations),
            ("duration", Key::Duration),
            ("severity", Key::Severity),
            ("wait_distance", Key::WaitDistance),
            ("wait_limit", Key::WaitLimit),
            ("approaches", Key::Approaches),
            ("wait_weights", Key::WaitWeights),
            ("approach_weights", Key::ApproachWeights),
        ];
        for (name, key) in names {
            keys.entry(name).iter().for_each(|e| places.note(item, Some(key), e.value.span));
        }
        let place = self.key_pair(keys, "place");
        let operations = self.key_count(keys, "operations");
        let duration = self.key_spread(keys, "duration");
        // A worker has neither, and nothing stands for them.
        let severity = if kind == AgentKind::Human { self.key_number(keys, "severity") } else { Ok(None) };
        let limit = if kind == AgentKind::Human { self.key_number(keys, "wait_limit") } else { Ok(None) };
        let distance = self.key_number(keys, "wait_distance");
        // So many are refused as a whole; what they weigh does not matter then.
        let operations_known = operations.is_ok_and(|n| n <= MAX_OPERATIONS);
        let count = operations.unwrap_or(0);
        let waits =
            if kind == AgentKind::Human { self.key_weights(keys, "wait_weights", count) } else { Some(Vec::new()) };
        let near = self.key_weights(keys, "approach_weights", count);
        let approaches = self.approaches((keys, number), robots, places);
        let wrong = [
            (place.is_none(), Key::Place),
            (operations.is_err(), Key::Operations),
            (duration.is_none(), Key::Duration),
            (severity.is_err(), Key::Severity),
            (distance.is_err(), Key::WaitDistance),
            (limit.is_err(), Key::WaitLimit),
            (waits.is_none() || !operations_known, Key::WaitWeights),
            (near.is_none() || !operations_known, Key::ApproachWeights),
            (approaches.is_none(), Key::Approaches),
        ];
        wrong.into_iter().filter(|w| w.0).for_each(|(_, key)| places.spoil(item, key));
        Agent {
            name: member.name.value.clone(),
            kind,
            place: place.unwrap_or_default(),
            operations: operations.unwrap_or(1),
            duration: duration.unwrap_or(Duration { mean: SOME_DURATION, sigma: 0.0 }),
            severity: severity.ok().flatten().unwrap_or(0.0),
            wait_distance: distance.ok().flatten().unwrap_or(0.0),
            approaches: approaches.unwrap_or_default(),
            wait_weights: waits.unwrap_or_default(),
            wait_limit: limit.ok().flatten().unwrap_or(WAIT_LIMIT),
            limit_weights: Vec::new(),
            approach_weights: near.unwrap_or_default(),
        }
    }

    /// What differs for single robots; `None` where something of it is wrong.
    fn approaches(
        &mut self,
        (keys, agent): (Keys, usize),
        robots: &[Robot],
        places: &mut Places,
    ) -> Option<Vec<Approach>> {
        let Some(e) = keys.entry("approaches") else { return Some(Vec::new()) };
        let block = block_of(&e.value, "`approaches`", self.diagnostics)?;
        let (mut all, mut good) = (Vec::new(), true);
        for e in &block.entries {
            let robot = self.robot_named(&e.key, robots);
            let Some(block) = block_of(&e.value, "an approach", self.diagnostics) else {
                good = false;
                continue;
            };
            check_keys(block, &APPROACH, self.diagnostics);
            let keys = Keys { block, section: &APPROACH, at: e.key.span };
            if let (Some(robot), Some(e)) = (robot, keys.entry("speed")) {
                places.note_approach((agent, robot), e.value.span);
            }
            let (speed, distance) = (self.key_range(keys, "speed"), self.key_number(keys, "wait_distance"));
            match (robot, speed, distance) {
                (Some(robot), Ok(speed), Ok(wait_distance)) => all.push(Approach { robot, speed, wait_distance }),
                _ => good = false,
            }
        }
        good.then_some(all)
    }

    /// The number of a robot of the mission.
    pub(super) fn robot_named(&mut self, name: &Spanned<String>, robots: &[Robot]) -> Option<usize> {
        let names: Vec<&str> = robots.iter().map(|m| m.name.as_str()).collect();
        self.one_of("robot of this mission", &name.value, name.span, &names)
    }
}

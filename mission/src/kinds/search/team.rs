//! States of a team, srs (13), (20), (21): ongoing actions with their ends, pools, reward so far; and their successors.
//!
//! A state follows whenever the action of somebody ends. Those who are free choose an action: a way to a spot, a stay at the
//! source of the spot, a wait for the next end of another's action, or the end of their activities.

use super::belief::Undetected;
use super::geometry::{Pose, distance};
use super::plan::{Activity, Awaited, Phase};
use super::problem::{EMPTY, Problem, SourceKind};
use super::reward::{Motion, look, produced, settle};
use super::ways::{ActionSets, Way};

/// Instants that are at most this far apart are one (s).
const SAME: f64 = 1e-9;
/// Shortest stay (s).
const SHORTEST: f64 = 0.1;

/// An action of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Act {
    /// It stays at its spot, and consumes the source there or looks for hidden objects.
    Stay,
    /// It moves to a spot.
    Go(usize),
    /// It waits until an action of somebody else ends.
    Wait,
    /// It does nothing any more.
    End,
}

/// Current action of an agent.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Doing {
    /// It chooses its next action now.
    Free,
    Staying,
    /// From this spot.
    Going(usize),
    Waiting,
    Ended,
}

/// The state of an agent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    /// Its spot, or that to which it goes.
    spot: usize,
    doing: Doing,
    since: f64,
    /// End of a stay or a way (s).
    ends: f64,
    heading: f64,
    /// Number of actions that it has begun.
    actions: usize,
}

/// A state of the team.
#[derive(Clone, Debug)]
pub struct State {
    /// Present time (s).
    pub time: f64,
    /// Reward of the team so far.
    pub reward: f64,
    /// Content of the sources.
    pub pools: Vec<f64>,
    /// Worth of the hidden objects that are not yet expected to be detected.
    pub undetected: Undetected,
    pub(super) agents: Vec<Standing>,
    /// Nothing happens any more until the horizon.
    pub terminal: bool,
    /// Sum of the times of all actions that have ended (s).
    pub busy: f64,
    /// End of the last activity that has ended (s).
    pub latest: f64,
}

/// Choices of free agents, in their order.
pub type Choices = Vec<(usize, Act)>;

/// A team that plans.
#[derive(Debug)]
pub struct Team<'p> {
    /// The problem.
    pub problem: &'p Problem,
    /// The action sets.
    pub sets: &'p ActionSets,
    /// Some source can be opened by another, or is relative to an agent: waiting may be worth something.
    waits: bool,
}

/// An estimate of an action on its own.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Reward of the action and, of a way, of the stay at its end.
    pub gain: f64,
    /// Time that both take (s).
    pub time: f64,
    /// Upper bound on the reward of everything that the agent can still collect if it begins so, as if it were alone.
    pub bound: f64,
}

impl<'p> Team<'p> {
    /// The team of a problem.
    pub fn new(problem: &'p Problem, sets: &'p ActionSets) -> Team<'p> {
        let waits = problem.sources.iter().any(|s| !s.after.is_empty() || s.kind == SourceKind::Interaction);
        Team { problem, sets, waits }
    }

    /// The first state, in which everybody who takes part is free.
    pub fn root(&self) -> State {
        let standing = |agent: &super::problem::Agent| Standing {
            spot: 0,
            doing: if agent.lost { Doing::Ended } else { Doing::Free },
            since: self.problem.start,
            ends: self.problem.start,
            heading: agent.heading,
            actions: 0,
        };
        State {
            time: self.problem.start,
            reward: 0.0,
            pools: self.problem.pools(),
            undetected: Undetected::of(self.problem),
            agents: self.problem.agents.iter().map(standing).collect(),
            terminal: self.problem.agents.iter().all(|agent| agent.lost),
            busy: 0.0,
            latest: self.problem.start,
        }
    }

    /// Agents that choose an action now.
    pub fn free<'s>(&self, state: &'s State) -> impl Iterator<Item = usize> + 's {
        state.agents.iter().enumerate().filter(|(_, agent)| agent.doing == Doing::Free).map(|(agent, _)| agent)
    }

    /// The action that leads to the goal that somebody has told an agent, if it has to come first now.
    pub fn told(&self, state: &State, agent: usize) -> Option<Act> {
        let act = Act::Go(self.sets.of[agent].told?);
        (state.agents[agent].spot == 0 && self.end_of(state, agent, act).is_some()).then_some(act)
    }

    /// Every action that an agent may have at its spot at some time.
    pub fn menu(&self, state: &State, agent: usize) -> Vec<Act> {
        let (set, at) = (&self.sets.of[agent], state.agents[agent].spot);
        let mut acts = Vec::new();
        if set.spots[at].source.is_some() || set.spots[at].lookout {
            acts.push(Act::Stay);
        }
        acts.extend((0..set.spots.len()).filter(|to| *to != at && set.way(at, *to).is_some()).map(Act::Go));
        if self.waits && self.problem.agents.len() > 1 {
            acts.push(Act::Wait);
        }
        acts.push(Act::End);
        acts
    }

    /// Returns true if a source can still give an agent something, now or once it is open.
    fn is_useful(&self, state: &State, agent: usize, source: usize) -> bool {
        let of = &self.problem.sources[source];
        state.pools[source] > EMPTY
            && self.problem.consumes(agent, source)
            && !of.until.iter().any(|other| state.pools[*other] <= EMPTY)
    }

    /// End of an action that begins now (s); that of a wait is the horizon. None: the action is impossible or pointless.
    pub fn end_of(&self, state: &State, agent: usize, act: Act) -> Option<f64> {
        let (set, at) = (&self.sets.of[agent], state.agents[agent].spot);
        let horizon = self.problem.end();
        // A goal that somebody has told comes first; who has no time for it does nothing that is planned.
        if let Some(told) = set.told.filter(|_| at == 0) {
            let ends = set.way(at, told).map(|way| state.time + way.duration).filter(|ends| *ends <= horizon);
            return match act {
                Act::Go(to) if to == told => ends,
                Act::End if ends.is_none() => Some(state.time),
                _ => None,
            };
        }
        match act {
            Act::Stay if set.spots[at].lookout => {
                let time = self.problem.planner.stay.min(horizon - state.time);
                (time > SAME).then_some(state.time + time)
            }
            Act::Stay => {
                let source = set.spots[at].source?;
                let open = self.is_useful(state, agent, source) && self.problem.is_open(source, &state.pools);
                if !open || horizon - state.time <= SAME {
                    return None;
                }
                let rate = set.spots[at].rates[source];
                let pool = state.pools[source];
                let time = if pool.is_finite() { pool / rate } else { self.problem.planner.stay };
                Some((state.time + time.max(SHORTEST)).min(horizon))
            }
            Act::Go(to) if set.spots[to].lookout => {
                let ends = state.time + set.way(at, to)?.duration;
                (ends <= horizon && distance(set.spots[at].at, set.spots[to].at) >= SAME).then_some(ends)
            }
            Act::Go(to) => {
                let source = set.spots[to].source?;
                let ends = state.time + set.way(at, to)?.duration;
                let again = set.spots[at].source == Some(source) && distance(set.spots[at].at, set.spots[to].at) < SAME;
                (ends <= horizon && !again && self.is_useful(state, agent, source)).then_some(ends)
            }
            Act::Wait => {
                let others = state.agents.iter().enumerate().any(|(other, standing)| {
                    other != agent && !matches!(standing.doing, Doing::Ended | Doing::Waiting)
                });
                let closed = |source: usize| {
                    let of = &self.problem.sources[source];
                    self.is_useful(state, agent, source)
                        && (of.kind == SourceKind::Interaction || !self.problem.is_open(source, &state.pools))
                };
                (others && (0..self.problem.sources.len()).any(closed)).then_some(horizon)
            }
            Act::End => Some(state.time),
        }
    }

    /// Estimates an action of an agent that is possible now.
    pub fn estimate(&self, state: &State, agent: usize, act: Act, optimistic: bool) -> Estimate {
        let (set, at) = (&self.sets.of[agent], state.agents[agent].spot);
        let horizon = self.problem.end();
        let opens = |source: usize| optimistic || self.problem.is_open(source, &state.pools);
        // The stay at a spot from a time on: its reward and its time.
        let stay = |spot: usize, from: f64| {
            if set.spots[spot].lookout {
                let time = self.problem.planner.stay.min(horizon - from);
                return (self.seen_from(state, agent, spot, [from, from + time]), time);
            }
            let Some(source) = set.spots[spot].source.filter(|source| opens(*source)) else { return (0.0, 0.0) };
            let (rate, pool) = (set.spots[spot].rates[source], state.pools[source]);
            let time = if pool.is_finite() { pool / rate } else { self.problem.planner.stay };
            let time = time.max(SHORTEST).min(horizon - from);
            ((rate * time).min(pool), time)
        };
        let rest = |from: f64, without: Option<usize>| -> f64 {
            let best = set.best_rates.iter().copied().enumerate();
            let others = best.filter(|(source, rate)| *rate > 0.0 && Some(*source) != without);
            let useful = others.filter(|(source, _)| self.is_useful(state, agent, *source));
            let sources: f64 = useful.map(|(source, rate)| (rate * (horizon - from)).min(state.pools[source])).sum();
            sources + state.undetected.sum * self.problem.urgency(from)
        };
        match act {
            Act::Stay => {
                let (gain, time) = stay(at, state.time);
                Estimate { gain, time, bound: gain + rest(state.time + time, set.spots[at].source) }
            }
            Act::Go(to) => {
                let Some(way) = set.way(at, to) else { return Estimate { gain: 0.0, time: 0.0, bound: 0.0 } };
                let on_the_way: f64 = way
                    .rewards
                    .iter()
                    .map(|(source, sums)| {
                        let sum = sums.last().copied().unwrap_or_default();
                        let counts = Some(*source) != set.spots[to].source && opens(*source);
                        if counts { sum.min(state.pools[*source]) } else { 0.0 }
                    })
                    .sum();
                let (gain, time) = stay(to, state.time + way.duration);
                let gain = gain + on_the_way + self.seen_along(state, agent, way);
                let bound = gain + rest(state.time + way.duration + time, set.spots[to].source);
                Estimate { gain, time: way.duration + time, bound }
            }
            Act::Wait => Estimate { gain: 0.0, time: 1.0, bound: rest(state.time, None) },
            Act::End => Estimate { gain: 0.0, time: 0.0, bound: 0.0 },
        }
    }

    /// Expected worth of what an agent detects from a spot between two times, of what is undetected now.
    fn seen_from(&self, state: &State, agent: usize, spot: usize, [from, to]: [f64; 2]) -> f64 {
        let (Some(sight), Some(sees)) = (&self.sets.sight, self.problem.looks(agent)) else { return 0.0 };
        let Some(seat) = self.sets.of[agent].spots[spot].seat else { return 0.0 };
        let detected = state.undetected.gain(sight, seat, sees.within, sees.rate * (to - from));
        detected * self.problem.urgency(0.5 * (from + to))
    }

    /// About the same of a way that begins now: cells that are in sight from several places of it count more than they should.
    fn seen_along(&self, state: &State, agent: usize, way: &Way) -> f64 {
        let (Some(sight), Some(sees)) = (&self.sets.sight, self.problem.looks(agent)) else { return 0.0 };
        let mut worth = 0.0;
        for dwell in &way.dwells {
            let [begin, end] = dwell.shares.map(|share| share * way.duration);
            let detected = state.undetected.gain(sight, dwell.seat, sees.within, sees.rate * (end - begin));
            worth += detected * self.problem.urgency(state.time + 0.5 * (begin + end));
        }
        worth
    }

    /// The state that follows when every free agent has chosen: that at the next end of an action, or at the horizon.
    pub fn next(&self, state: &State, choices: &[(usize, Act)]) -> State {
        let mut then = state.clone();
        self.pass_to_next(&mut then, choices);
        then
    }

    /// The same in place.
    pub(super) fn pass_to_next(&self, then: &mut State, choices: &[(usize, Act)]) {
        let now = then.time;
        // An action is possible or not by the others as they were before anybody chose.
        let ends: Vec<f64> =
            choices.iter().map(|(agent, act)| self.end_of(then, *agent, *act).unwrap_or(now)).collect();
        for ((agent, act), ends) in choices.iter().zip(ends) {
            let standing = &mut then.agents[*agent];
            standing.since = now;
            standing.ends = ends;
            standing.actions += 1;
            standing.doing = match act {
                Act::Stay => Doing::Staying,
                Act::Go(to) => {
                    let from = std::mem::replace(&mut standing.spot, *to);
                    Doing::Going(from)
                }
                Act::Wait => Doing::Waiting,
                Act::End => Doing::Ended,
            };
        }
        let active = |standing: &&Standing| matches!(standing.doing, Doing::Staying | Doing::Going(_));
        let next = then.agents.iter().filter(active).map(|standing| standing.ends).reduce(f64::min);
        then.terminal = next.is_none();
        let end = next.unwrap_or(self.problem.end()).max(now);
        self.pass(then, end);
        for standing in &mut then.agents {
            let over = match standing.doing {
                Doing::Staying | Doing::Going(_) => standing.ends <= end + SAME,
                Doing::Waiting => !then.terminal,
                Doing::Free | Doing::Ended => false,
            };
            if over {
                then.busy += end - standing.since;
                then.latest = end;
                standing.doing = Doing::Free;
            }
        }
    }

    /// Lets time pass until `end`, with its rewards.
    fn pass(&self, state: &mut State, end: f64) {
        let now = state.time;
        let motions: Vec<Motion<'_>> = state
            .agents
            .iter_mut()
            .enumerate()
            .map(|(agent, standing)| {
                let set = &self.sets.of[agent];
                if self.problem.agents[agent].lost {
                    return Motion::Absent;
                }
                if let Doing::Going(from) = standing.doing
                    && let Some(way) = set.way(from, standing.spot)
                    && way.duration > 0.0
                {
                    let share = |t: f64| (t - standing.since) / way.duration;
                    let motion = Motion::Along { way, shares: [share(now), share(end)], pace: 1.0 };
                    if let [.., a, b] = way.points[..] {
                        standing.heading = f64::atan2(b[1] - a[1], b[0] - a[0]);
                    }
                    return motion;
                }
                let spot = &set.spots[standing.spot];
                // An agent that waits for nothing has no further activity.
                let idle = standing.doing == Doing::Ended || state.terminal;
                let pose = Pose { at: spot.at, heading: standing.heading };
                Motion::Still { rates: &spot.rates, pose, seat: spot.seat, idle }
            })
            .collect();
        let mut gained = Vec::new();
        produced(self.problem, &motions, end - now, &mut gained);
        state.reward += settle(self.problem, &mut state.pools, &gained, |_, _, _| {});
        if let Some(sight) = &self.sets.sight {
            state.reward += look(self.problem, sight, &motions, [now, end], &mut state.undetected, |_, _| {});
        }
        state.time = end;
    }

    /// The activities of the sequence of choices that leads to an end.
    pub fn activities(&self, choices: &[Choices]) -> Vec<Activity> {
        let mut state = self.root();
        let mut all: Vec<Vec<Activity>> = vec![Vec::new(); self.problem.agents.len()];
        for chosen in choices {
            if state.terminal {
                break;
            }
            let then = self.next(&state, chosen);
            for (agent, act) in chosen {
                let (set, from, to) = (&self.sets.of[*agent], state.agents[*agent].spot, then.agents[*agent].spot);
                let (phase, way) = match act {
                    Act::Stay => (Phase::Staying, vec![set.spots[from].at]),
                    Act::Go(_) => (Phase::Going, set.way(from, to).map(|way| way.points.clone()).unwrap_or_default()),
                    Act::Wait => (Phase::Waiting, vec![set.spots[from].at]),
                    Act::End => continue,
                };
                let source = if *act == Act::Wait { None } else { set.spots[to].source };
                let end = self.end_of(&state, *agent, *act).unwrap_or(state.time);
                let (start, agent) = (state.time, *agent);
                all[agent].push(Activity { agent, phase, start, end, way, source, awaits: None, begun: false });
            }
            // Those who wait do so until the action of somebody else ends now.
            let ended = (0..all.len()).find_map(|agent| {
                let last = all[agent].last()?;
                let is = last.phase != Phase::Waiting && (last.end - then.time).abs() <= SAME;
                is.then(|| Awaited { agent, number: all[agent].len() - 1 })
            });
            for (own, agent) in all.iter_mut().zip(&state.agents) {
                let waits = matches!(agent.doing, Doing::Waiting | Doing::Free);
                let open = |last: &&mut Activity| last.phase == Phase::Waiting && last.awaits.is_none();
                if let Some(last) = own.last_mut().filter(open).filter(|_| waits) {
                    (last.end, last.awaits) = (then.time, ended);
                }
            }
            state = then;
        }
        for own in &mut all {
            // Nobody waits for nothing.
            own.pop_if(|last| last.phase == Phase::Waiting && last.awaits.is_none());
        }
        all.into_iter().flatten().collect()
    }
}

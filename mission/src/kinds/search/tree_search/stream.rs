//! One tree of the search: its states, the probabilities of actions, and its rollouts, srs Algorithm 2.

use std::collections::BTreeMap;

use rand_pcg::Pcg64;

use super::Candidate;
use crate::engine::Watch;
use crate::kinds::search::greedy::greedy_act;
use crate::kinds::search::team::{Act, Choices, Estimate, State, Team};
use crate::random::{stream, unit};

/// The most states of a stream, for its memory.
const MOST_STATES: usize = 400_000;
/// The most memory of a stream for what is undetected in its states (bytes).
const MOST_BYTES: usize = 64 << 20;
/// Draws of successors before exhausted ones are stepped over.
const DRAWS: usize = 8;
/// The least `q` relative to the greatest one of a node.
const LEAST: f64 = 1e-9;

/// Actions of an agent after one of its sequences of actions.
#[derive(Debug)]
struct Menu {
    acts: Vec<Act>,
    /// Probability of each, not normalised.
    q: Vec<f64>,
    /// Menu after each; 0: not made yet.
    next: Vec<u32>,
}

/// Feasible actions of a free agent.
#[derive(Debug)]
struct Free {
    agent: usize,
    menu: u32,
    /// Indices of its menu.
    feasible: Vec<u16>,
}

/// A state of the tree.
#[derive(Debug)]
struct Node {
    state: State,
    free: Vec<Free>,
    /// Menu of each agent.
    menus: Vec<u32>,
    /// Number of successors, srs (13), and of those that are exhausted.
    successors: u64,
    exhausted_successors: u64,
    exhausted: bool,
    children: BTreeMap<u64, u32>,
}

/// Policy by which a rollout chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Policy {
    /// By `q`.
    Sample,
    /// Greedily.
    Greedy,
}

/// A tree with its rollouts.
pub(super) struct Stream<'t> {
    team: &'t Team<'t>,
    random: Pcg64,
    menus: Vec<Menu>,
    nodes: Vec<Node>,
    rollouts: usize,
    pub(super) best: Candidate,
}

impl<'t> Stream<'t> {
    /// A tree of the first state, with a plan to begin from.
    pub(super) fn new(team: &'t Team<'t>, number: usize, best: Candidate) -> Stream<'t> {
        let random = stream(team.problem.planner.seed, &["rollouts", &number.to_string()]);
        // Menu 0 is of nobody.
        let menus = vec![Menu { acts: Vec::new(), q: Vec::new(), next: Vec::new() }];
        let mut of = Stream { team, random, menus, nodes: Vec::new(), rollouts: 0, best };
        let menus = vec![0; team.problem.agents.len()];
        of.add_node(team.root(), menus);
        of
    }

    /// Adds a state; its free agents get menus.
    fn add_node(&mut self, state: State, mut menus: Vec<u32>) -> u32 {
        let mut free = Vec::new();
        let mut successors = 1_u64;
        for agent in self.team.free(&state).filter(|_| !state.terminal) {
            if menus[agent] == 0 {
                menus[agent] = self.add_menu(&state, agent);
            }
            let menu = &self.menus[menus[agent] as usize];
            let possible = |index: &usize| self.team.end_of(&state, agent, menu.acts[*index]).is_some();
            let feasible: Vec<u16> = (0..menu.acts.len()).filter(possible).map(|index| index as u16).collect();
            successors = successors.saturating_mul(feasible.len() as u64);
            free.push(Free { agent, menu: menus[agent], feasible });
        }
        let exhausted = state.terminal;
        let children = BTreeMap::new();
        self.nodes.push(Node { state, free, menus, successors, exhausted_successors: 0, exhausted, children });
        (self.nodes.len() - 1) as u32
    }

    /// The eligible actions of an agent: the `N_a` goals with the greatest upper bounds, staying, waiting and ending. Their
    /// probability is the bound by the time until it can be had.
    fn add_menu(&mut self, state: &State, agent: usize) -> u32 {
        let estimated =
            self.team.menu(state, agent).into_iter().map(|act| (act, self.team.estimate(state, agent, act, true)));
        let (mut goals, others): (Vec<_>, Vec<_>) = estimated.partition(|(act, _)| matches!(act, Act::Go(_)));
        if let Some(told) = self.team.told(state, agent) {
            goals.retain(|(act, _)| *act == told);
        }
        // If something is hidden, bounds hardly differ: everything can still be detected after every action.
        let hidden = state.undetected.sum > 0.0;
        let rate = |estimate: &Estimate| (estimate.gain / (1.0 + estimate.time)).max(0.0);
        if hidden {
            goals.sort_by(|a, b| rate(&b.1).total_cmp(&rate(&a.1)).then(a.0.cmp(&b.0)));
            goals.truncate(self.team.problem.planner.goals);
        }
        goals.sort_by(|a, b| b.1.bound.total_cmp(&a.1.bound).then(a.1.time.total_cmp(&b.1.time)).then(a.0.cmp(&b.0)));
        goals.truncate(self.team.problem.planner.goals);
        let all: Vec<_> = others.into_iter().chain(goals).collect();
        let weight = |estimate: &Estimate| match hidden {
            true => rate(estimate),
            false => (estimate.bound / (1.0 + estimate.time)).max(0.0),
        };
        let top = all.iter().map(|(_, estimate)| weight(estimate)).fold(0.0, f64::max);
        let q = |estimate: &Estimate| if top > 0.0 { (weight(estimate) / top).max(0.05) } else { 1.0 };
        let menu = Menu {
            q: all.iter().map(|(_, estimate)| q(estimate)).collect(),
            next: vec![0; all.len()],
            acts: all.into_iter().map(|(act, _)| act).collect(),
        };
        self.menus.push(menu);
        (self.menus.len() - 1) as u32
    }

    /// Draws one of the feasible actions of an agent by `q`; returns its place among them.
    fn draw(random: &mut Pcg64, menus: &[Menu], free: &Free) -> usize {
        let q = &menus[free.menu as usize].q;
        let total: f64 = free.feasible.iter().map(|index| q[*index as usize]).sum();
        let mut left = unit(random) * total;
        for (place, index) in free.feasible.iter().enumerate() {
            left -= q[*index as usize];
            if left <= 0.0 {
                return place;
            }
        }
        free.feasible.len() - 1
    }

    /// The number of a successor from the places of the chosen actions among the feasible ones.
    fn key(free: &[Free], places: &[usize]) -> u64 {
        free.iter().zip(places).fold(0, |key, (free, place)| key * free.feasible.len() as u64 + *place as u64)
    }

    fn places(free: &[Free], mut key: u64) -> Vec<usize> {
        let mut places: Vec<usize> = free
            .iter()
            .rev()
            .map(|free| {
                let count = free.feasible.len() as u64;
                let place = key % count;
                key /= count;
                place as usize
            })
            .collect();
        places.reverse();
        places
    }

    /// Chooses a successor that is not exhausted.
    fn choose(&mut self, at: u32, policy: Policy, follow: Option<&Choices>) -> Vec<usize> {
        let node = &self.nodes[at as usize];
        let free = &node.free;
        let is_open = |key: u64| node.children.get(&key).is_none_or(|child| !self.nodes[*child as usize].exhausted);
        let place_of = |of: &Free, act: Act| {
            let acts = &self.menus[of.menu as usize].acts;
            of.feasible.iter().position(|index| acts[*index as usize] == act)
        };
        let given: Option<Vec<usize>> = match (follow, policy) {
            (Some(choices), _) => free
                .iter()
                .map(|of| {
                    let (_, act) = choices.iter().find(|(agent, _)| *agent == of.agent)?;
                    place_of(of, *act)
                })
                .collect(),
            (None, Policy::Greedy) => {
                free.iter().map(|of| place_of(of, greedy_act(self.team, &node.state, of.agent))).collect()
            }
            (None, Policy::Sample) => None,
        };
        if let Some(places) = given
            && is_open(Self::key(free, &places))
        {
            return places;
        }
        let mut key = 0;
        for _ in 0..DRAWS {
            let places: Vec<usize> = free.iter().map(|of| Self::draw(&mut self.random, &self.menus, of)).collect();
            key = Self::key(free, &places);
            if is_open(key) {
                return places;
            }
        }
        // As the state is not exhausted, one of its successors is not.
        let mut others = (1..node.successors).map(|step| (key + step) % node.successors);
        Self::places(free, others.find(|key| is_open(*key)).unwrap_or(key))
    }

    /// A rollout, Algorithm 2.
    fn rollout(&mut self) {
        let turn = self.rollouts % 3;
        self.rollouts += 1;
        let known = self.best.choices.clone();
        let mut follow =
            if turn == 0 || known.is_empty() { 0 } else { (unit(&mut self.random) * known.len() as f64) as usize };
        let mut samples = if turn == 2 { 1 } else { usize::MAX };
        let (mut at, mut path, mut choices) = (0_u32, vec![0_u32], Vec::new());
        let mut taken: Vec<Vec<(u32, u16)>> = vec![Vec::new(); self.team.problem.agents.len()];
        while !self.nodes[at as usize].state.terminal {
            let given = if follow > 0 { known.get(choices.len()) } else { None };
            let policy = if samples > 0 { Policy::Sample } else { Policy::Greedy };
            let places = self.choose(at, policy, given);
            match follow {
                0 => samples = samples.saturating_sub(1),
                _ => follow -= 1,
            }
            let node = &self.nodes[at as usize];
            let chosen: Vec<(usize, u32, u16)> =
                node.free.iter().zip(&places).map(|(of, place)| (of.agent, of.menu, of.feasible[*place])).collect();
            let acts: Choices = chosen
                .iter()
                .map(|(agent, menu, index)| (*agent, self.menus[*menu as usize].acts[*index as usize]))
                .collect();
            if given.is_some_and(|given| *given != acts) {
                follow = 0;
            }
            for (agent, menu, index) in &chosen {
                taken[*agent].push((*menu, *index));
            }
            let key = Self::key(&node.free, &places);
            let child = match node.children.get(&key) {
                Some(child) => *child,
                None => {
                    let state = self.team.next(&node.state, &acts);
                    let mut menus = node.menus.clone();
                    for (agent, menu, index) in &chosen {
                        menus[*agent] = self.menus[*menu as usize].next[*index as usize];
                    }
                    let child = self.add_node(state, menus);
                    for (agent, menu, index) in &chosen {
                        let own = self.nodes[child as usize].menus[*agent];
                        self.menus[*menu as usize].next[*index as usize] = own;
                    }
                    self.nodes[at as usize].children.insert(key, child);
                    child
                }
            };
            choices.push(acts);
            path.push(child);
            at = child;
        }
        let end = &self.nodes[at as usize].state;
        let candidate = Candidate::new(end, choices);
        if candidate.beats(&self.best) {
            self.best = candidate;
        }
        self.update(&taken);
        self.exhaust(&path);
    }

    /// Reduces `q` of the actions that a rollout took, srs (14).
    fn update(&mut self, taken: &[Vec<(u32, u16)>]) {
        let planner = &self.team.problem.planner;
        for own in taken {
            let mut discount = 1.0;
            for (menu, index) in own.iter().rev() {
                let q = &mut self.menus[*menu as usize].q;
                q[*index as usize] *= 1.0 - (1.0 - planner.reduction) * discount;
                discount *= planner.discount;
                let top = q.iter().copied().fold(0.0, f64::max);
                if top < 1e-3 {
                    q.iter_mut().for_each(|q| *q = (*q / top).max(LEAST));
                }
            }
        }
    }

    /// Marks the states of a finished rollout that have nothing new below them.
    fn exhaust(&mut self, path: &[u32]) {
        for two in path.windows(2).rev() {
            let (parent, child) = (two[0] as usize, two[1] as usize);
            // The end of a path is exhausted once; a state above it when its last successor becomes so.
            if !self.nodes[child].exhausted {
                return;
            }
            self.nodes[parent].exhausted_successors += 1;
            if self.nodes[parent].exhausted_successors < self.nodes[parent].successors {
                return;
            }
            self.nodes[parent].exhausted = true;
        }
    }

    /// True if nothing is left to try, or no memory.
    pub(super) fn is_over(&self) -> bool {
        let cells = self.nodes[0].state.undetected.weights.len();
        let most = MOST_STATES.min(MOST_BYTES / (8 * cells.max(1)));
        self.nodes[0].exhausted || self.nodes.len() >= most
    }

    /// Number of states that were expanded.
    pub(super) fn states(&self) -> u64 {
        self.nodes.len() as u64 - 1
    }

    /// True if every sequence of the action sets was tried.
    pub(super) fn is_exhausted(&self) -> bool {
        self.nodes[0].exhausted
    }

    /// Expands at least this number of states, unless everything is exhausted or the time is over. Returns true in the last
    /// case.
    pub(super) fn expand(&mut self, states: u64, watch: &Watch) -> bool {
        let end = self.nodes.len() as u64 + states;
        while (self.nodes.len() as u64) < end && !self.is_over() {
            if watch.is_over() {
                return true;
            }
            self.rollout();
        }
        false
    }
}

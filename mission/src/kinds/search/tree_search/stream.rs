//! One tree of the search: its states, the probabilities of actions, and its rollouts, srs Algorithm 2.

use std::ops::Range;

use rand_pcg::Pcg64;

use super::Candidate;
use super::states::States;
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
#[derive(Clone, Copy, Debug)]
struct Free {
    agent: u32,
    menu: u32,
    /// Part of [`Stream::feasible`].
    first: u32,
    count: u32,
}

/// A state of the tree.
#[derive(Debug)]
struct Node {
    /// Part of [`Stream::free`].
    free: Range<u32>,
    /// Number of successors, srs (13), and of those that are exhausted.
    successors: u64,
    exhausted_successors: u64,
    exhausted: bool,
    /// Successors that were expanded: their numbers among all and their nodes, in this order.
    children: Vec<(u64, u32)>,
}

/// Policy by which a rollout chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Policy {
    /// By `q`.
    Sample,
    /// Greedily.
    Greedy,
}

/// A tree with its rollouts. A state costs few allocations: with one for each of its parts, threads spend their time in the
/// allocator.
pub(super) struct Stream<'t> {
    team: &'t Team<'t>,
    random: Pcg64,
    menus: Vec<Menu>,
    nodes: Vec<Node>,
    states: States,
    /// Free agents of all nodes.
    free: Vec<Free>,
    /// Indices of menus, of all free agents.
    feasible: Vec<u16>,
    /// Menu of each agent, node by node.
    menu_of: Vec<u32>,
    rollouts: usize,
    pub(super) best: Candidate,
}

/// An action that was chosen: agent, menu, and index of the menu.
type Chosen = (usize, u32, u16);

impl<'t> Stream<'t> {
    /// A tree of the first state, with a plan to begin from.
    pub(super) fn new(team: &'t Team<'t>, number: usize, best: Candidate) -> Stream<'t> {
        let random = stream(team.problem.planner.seed, &["rollouts", &number.to_string()]);
        let mut of = Stream {
            team,
            random,
            // Menu 0 is of nobody.
            menus: vec![Menu { acts: Vec::new(), q: Vec::new(), next: Vec::new() }],
            nodes: Vec::new(),
            states: States::default(),
            free: Vec::new(),
            feasible: Vec::new(),
            menu_of: Vec::new(),
            rollouts: 0,
            best,
        };
        of.menu_of.resize(team.problem.agents.len(), 0);
        of.add_node(&team.root());
        of
    }

    /// Adds a state; its free agents get menus. The menus that are known are the last ones of `menu_of`.
    fn add_node(&mut self, state: &State) -> u32 {
        let team = self.team;
        let own = self.menu_of.len() - team.problem.agents.len();
        let first = self.free.len() as u32;
        let mut successors = 1_u64;
        for agent in team.free(state).filter(|_| !state.terminal) {
            if self.menu_of[own + agent] == 0 {
                self.menu_of[own + agent] = self.add_menu(state, agent);
            }
            let menu = self.menu_of[own + agent];
            let acts = &self.menus[menu as usize].acts;
            let possible = |index: &usize| team.end_of(state, agent, acts[*index]).is_some();
            let begin = self.feasible.len();
            self.feasible.extend((0..acts.len()).filter(possible).map(|index| index as u16));
            let count = self.feasible.len() - begin;
            successors = successors.saturating_mul(count as u64);
            self.free.push(Free { agent: agent as u32, menu, first: begin as u32, count: count as u32 });
        }
        self.states.push(state);
        let free = first..self.free.len() as u32;
        let exhausted = state.terminal;
        self.nodes.push(Node { free, successors, exhausted_successors: 0, exhausted, children: Vec::new() });
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

    /// The free agents of a node.
    fn free_of(&self, at: u32) -> &[Free] {
        let Range { start, end } = self.nodes[at as usize].free;
        &self.free[start as usize..end as usize]
    }

    /// Indices of its menu that a free agent may choose.
    fn feasible_of(&self, of: &Free) -> &[u16] {
        &self.feasible[of.first as usize..(of.first + of.count) as usize]
    }

    /// Draws one of the feasible actions of each free agent by `q`; returns the number of the successor.
    fn draw(&mut self, at: u32) -> u64 {
        let mut key = 0;
        let Range { start, end } = self.nodes[at as usize].free;
        for place in start..end {
            let of = self.free[place as usize];
            let left = unit(&mut self.random);
            let (q, feasible) = (&self.menus[of.menu as usize].q, self.feasible_of(&of));
            let total: f64 = feasible.iter().map(|index| q[*index as usize]).sum();
            let mut left = left * total;
            let is_last = |index: &u16| {
                left -= q[*index as usize];
                left <= 0.0
            };
            let place = feasible.iter().position(is_last).unwrap_or(feasible.len() - 1);
            key = key * u64::from(of.count) + place as u64;
        }
        key
    }

    /// The number of the successor in which each free agent does this; none: an action is not feasible or not known.
    fn key(&self, at: u32, act: impl Fn(usize) -> Option<Act>) -> Option<u64> {
        let mut key = 0;
        for of in self.free_of(at) {
            let act = act(of.agent as usize)?;
            let acts = &self.menus[of.menu as usize].acts;
            let place = self.feasible_of(of).iter().position(|index| acts[*index as usize] == act)?;
            key = key * u64::from(of.count) + place as u64;
        }
        Some(key)
    }

    /// Writes the actions that lead to a successor, in the order of the agents.
    fn chosen(&self, at: u32, mut key: u64, chosen: &mut Vec<Chosen>) {
        chosen.clear();
        for of in self.free_of(at).iter().rev() {
            let place = (key % u64::from(of.count)) as usize;
            key /= u64::from(of.count);
            chosen.push((of.agent as usize, of.menu, self.feasible_of(of)[place]));
        }
        chosen.reverse();
    }

    /// The act of a menu.
    fn act(&self, &(agent, menu, index): &Chosen) -> (usize, Act) {
        (agent, self.menus[menu as usize].acts[index as usize])
    }

    /// The node of a successor, if it was expanded.
    fn child(&self, at: u32, key: u64) -> Option<u32> {
        let children = &self.nodes[at as usize].children;
        children.binary_search_by_key(&key, |child| child.0).ok().map(|place| children[place].1)
    }

    /// Chooses a successor that is not exhausted: the given one, or one by the policy. `room` is any state.
    fn choose(&mut self, at: u32, policy: Policy, given: Option<Option<u64>>, room: &mut State) -> u64 {
        let wished = match (given, policy) {
            (Some(key), _) => key,
            (None, Policy::Greedy) => {
                self.states.load(at, room);
                self.key(at, |agent| Some(greedy_act(self.team, room, agent)))
            }
            (None, Policy::Sample) => None,
        };
        let is_open = |of: &Self, key: u64| of.child(at, key).is_none_or(|child| !of.nodes[child as usize].exhausted);
        if let Some(key) = wished
            && is_open(self, key)
        {
            return key;
        }
        let mut key = 0;
        for _ in 0..DRAWS {
            key = self.draw(at);
            if is_open(self, key) {
                return key;
            }
        }
        // As the state is not exhausted, one of its successors is not.
        let successors = self.nodes[at as usize].successors;
        let mut others = (1..successors).map(|step| (key + step) % successors);
        others.find(|key| is_open(self, *key)).unwrap_or(key)
    }

    /// A rollout, Algorithm 2. `room` is any state.
    fn rollout(&mut self, room: &mut State) {
        let turn = self.rollouts % 3;
        self.rollouts += 1;
        // The plan is given back below, unless there is a better one.
        let known = std::mem::take(&mut self.best.choices);
        let mut follow =
            if turn == 0 || known.is_empty() { 0 } else { (unit(&mut self.random) * known.len() as f64) as usize };
        let mut samples = if turn == 2 { 1 } else { usize::MAX };
        let agents = self.team.problem.agents.len();
        let (mut at, mut path, mut keys) = (0_u32, vec![0_u32], Vec::new());
        let (mut chosen, mut acts): (Vec<Chosen>, Choices) = (Vec::new(), Vec::new());
        let mut taken: Vec<Vec<(u32, u16)>> = vec![Vec::new(); agents];
        while !self.states.is_terminal(at) {
            let given = known.get(keys.len()).filter(|_| follow > 0).map(|choices| {
                self.key(at, |agent| choices.iter().find(|choice| choice.0 == agent).map(|choice| choice.1))
            });
            let policy = if samples > 0 { Policy::Sample } else { Policy::Greedy };
            let key = self.choose(at, policy, given, room);
            match follow {
                0 => samples = samples.saturating_sub(1),
                _ => follow -= 1,
            }
            if given.is_some_and(|given| given != Some(key)) {
                follow = 0;
            }
            self.chosen(at, key, &mut chosen);
            for (agent, menu, index) in &chosen {
                taken[*agent].push((*menu, *index));
            }
            let child = match self.child(at, key) {
                Some(child) => child,
                None => {
                    acts.clear();
                    acts.extend(chosen.iter().map(|chosen| self.act(chosen)));
                    self.expand_into(at, key, &chosen, &acts, room)
                }
            };
            keys.push(key);
            path.push(child);
            at = child;
        }
        self.states.load(at, room);
        let better = Candidate::new(room, Vec::new());
        if better.beats(&self.best) {
            let choices = path.iter().zip(&keys).map(|(at, key)| {
                self.chosen(*at, *key, &mut chosen);
                chosen.iter().map(|chosen| self.act(chosen)).collect()
            });
            self.best = Candidate { choices: choices.collect(), ..better };
        } else {
            self.best.choices = known;
        }
        self.update(&taken);
        self.exhaust(&path);
    }

    /// Adds the successor of a node that follows from these choices. `room` is any state.
    fn expand_into(&mut self, at: u32, key: u64, chosen: &[Chosen], acts: &[(usize, Act)], room: &mut State) -> u32 {
        self.states.load(at, room);
        self.team.pass_to_next(room, acts);
        let agents = self.team.problem.agents.len();
        let (above, own) = (at as usize * agents, self.menu_of.len());
        self.menu_of.extend_from_within(above..above + agents);
        for (agent, menu, index) in chosen {
            self.menu_of[own + agent] = self.menus[*menu as usize].next[*index as usize];
        }
        let child = self.add_node(room);
        for (agent, menu, index) in chosen {
            self.menus[*menu as usize].next[*index as usize] = self.menu_of[own + agent];
        }
        let children = &mut self.nodes[at as usize].children;
        if let Err(place) = children.binary_search_by_key(&key, |child| child.0) {
            children.insert(place, (key, child));
        }
        child
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
        let cells = self.states.cells();
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
        let mut room = self.team.root();
        while (self.nodes.len() as u64) < end && !self.is_over() {
            if watch.is_over() {
                return true;
            }
            self.rollout(&mut room);
        }
        false
    }
}

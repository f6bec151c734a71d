//! Formula as a network of operations that processes one tick at a time.
//!
//! Every operation takes the values of its operands in the order of ticks and passes on its own values, as soon as they
//! are certain, in a [`Ring`]. An operation without a temporal operator above it is needed at the first tick only. It
//! has no ring, and its value is known at any time as far as it is decided, so that a violation is reported at once.

use super::operator::{FirstTime, Running, Sliding, first_times, open_end};
use super::queue::{Queue, Stretch};
use super::value::{Interval, Value};
use super::verdict::Sense;
use crate::program::Window;
use crate::program::{Formula, Node};
use crate::program::{ProgramError, error};

/// Largest number of values that one network keeps, and that all expectations of a scenario keep together.
pub const MAX_KEPT: usize = 1 << 23;

/// Step of a network: a tick, or the end.
pub(super) struct Step<'a> {
    /// Numbers of the tick; `None` at the end.
    pub values: Option<&'a [f64]>,
    /// Number of ticks so far, this one included.
    pub ticks: u32,
}

/// Values of an operation at the most recent ticks.
#[derive(Clone, Debug, Default)]
struct Ring {
    /// Storage of the values. Its length is a power of two, or zero.
    values: Vec<Interval>,
    /// Number of values that were put in.
    len: u32,
}

impl Ring {
    fn put(&mut self, value: Interval) {
        let place = self.place(self.len);
        self.values[place] = value;
        self.len += 1;
    }

    fn at(&self, tick: u32) -> Interval {
        self.values[self.place(tick)]
    }

    fn place(&self, tick: u32) -> usize {
        tick as usize & (self.values.len() - 1)
    }
}

/// Kind of an operation, and its memory. `negate`: the goal is negated, and so is the result.
#[derive(Clone, Debug)]
enum Action {
    Predicate { signal: usize, sense: Sense },
    Not,
    And,
    Or,
    Implies,
    Rise { before: Interval },
    Running { until: Running, negate: bool },
    Sliding { until: Box<Sliding>, negate: bool },
    OpenEnd { first: u32, before: Box<Queue>, negate: bool },
    FirstTime { last: u32, period: f64, first: FirstTime },
    FirstTimes { last: u32, period: f64 },
}

/// One operation.
#[derive(Clone, Debug)]
struct Operation {
    action: Action,
    operands: Vec<usize>,
    /// Number of ticks of its operands that it has taken.
    taken: u32,
    /// Its value at the first tick, as far as it is known; used only if no other tick is needed.
    now: Interval,
    /// Its values; empty if only the value at the first tick is needed.
    ring: Ring,
}

/// Operations of a formula, operands before users.
#[derive(Clone, Debug)]
pub(super) struct Network {
    operations: Vec<Operation>,
    /// Number of values that it keeps.
    pub kept: usize,
}

impl Network {
    /// Creates the network of a formula that has passed [`Formula::check`], for a run of at most `ticks`.
    pub fn new(formula: &Formula, sense: Sense, ticks: u32) -> Result<Network, ProgramError> {
        let nodes = &formula.nodes;
        let once = wanted_once(nodes);
        let mut kept = Kept { ticks, count: 0 };
        let mut operations: Vec<Operation> = Vec::with_capacity(nodes.len());
        // Lag of each operation behind its signals, in ticks; `None` if its values are known only at the end.
        let mut lags: Vec<Option<u32>> = Vec::with_capacity(nodes.len());
        for (i, node) in nodes.iter().enumerate() {
            let action = action(node, once[i], sense, formula.period, &mut kept)?;
            let operands = node.operands().to_vec();
            let trail = operands.iter().try_fold(0_u32, |most, &a| lags[a].map(|lag| lag.max(most)));
            // An operand can be ahead of its user by the lag of the slowest operand.
            let ahead = match &action {
                Action::OpenEnd { .. } | Action::FirstTimes { .. } => None,
                _ => trail,
            };
            for &a in operands.iter().filter(|a| !once[**a]) {
                operations[a].ring.values = vec![Interval::FALSE; kept.ring(ahead)?];
            }
            lags.push(match (&action, node) {
                (Action::OpenEnd { .. } | Action::FirstTimes { .. }, _) => None,
                (Action::Sliding { until, .. }, _) => trail.map(|lag| lag.saturating_add(until.reach())),
                _ => trail,
            });
            operations.push(Operation { action, operands, taken: 0, now: Interval::unknown(0), ring: Ring::default() });
        }
        Ok(Network { operations, kept: kept.count })
    }

    /// Passes a tick, or the end, through all operations.
    pub fn advance(&mut self, step: &Step) {
        for i in 0..self.operations.len() {
            let (before, rest) = self.operations.split_at_mut(i);
            if let Some(operation) = rest.first_mut() {
                operation.advance(before, step);
            }
        }
    }

    /// Value of the formula at the first tick, as far as it is known; `ended` is true if no tick follows.
    pub fn value(&mut self, ended: bool) -> Interval {
        for i in 0..self.operations.len() {
            let (before, rest) = self.operations.split_at_mut(i);
            if let Some(operation) = rest.first_mut() {
                operation.settle(before, ended);
            }
        }
        self.operations.last().map_or(Interval::unknown(0), |root| root.now)
    }
}

/// Marks the operations that are needed at the first tick only: those without a temporal operator above them.
fn wanted_once(nodes: &[Node]) -> Vec<bool> {
    let mut once = vec![false; nodes.len()];
    if let Some(root) = once.last_mut() {
        *root = true;
    }
    for (i, node) in nodes.iter().enumerate().rev() {
        let temporal = matches!(node, Node::Always(..) | Node::Eventually(..) | Node::Until(..) | Node::Within(..));
        for &a in node.operands() {
            once[a] = once[i] && !temporal;
        }
    }
    once
}

/// Counts the values that a network will keep.
struct Kept {
    ticks: u32,
    count: usize,
}

impl Kept {
    fn add(&mut self, values: usize) -> Result<(), ProgramError> {
        self.count = self.count.saturating_add(values);
        if self.count <= MAX_KEPT {
            return Ok(());
        }
        Err(error(
            "nodes",
            "the windows have too many ticks to be watched: shorten them, or the run, or lengthen the period",
        ))
    }

    /// Number of values of a ring whose operation may be `ahead` by so many ticks; `None` means the whole run.
    fn ring(&mut self, ahead: Option<u32>) -> Result<usize, ProgramError> {
        let most = ahead.map_or(self.ticks, |ahead| ahead.saturating_add(1).min(self.ticks));
        let size = (most as usize).max(1).next_power_of_two();
        self.add(size).map(|()| size)
    }

    /// Adds the values of a queue with this room, in ticks.
    fn queue(&mut self, room: usize) -> Result<(), ProgramError> {
        // A tick of a queue takes three stretches of two values.
        self.add(room.saturating_mul(6))
    }
}

fn action(node: &Node, once: bool, sense: Sense, period: f64, kept: &mut Kept) -> Result<Action, ProgramError> {
    let (window, negate) = match node {
        Node::Predicate(signal) => return Ok(Action::Predicate { signal: *signal, sense }),
        Node::Not(_) => return Ok(Action::Not),
        Node::And(_) => return Ok(Action::And),
        Node::Or(_) => return Ok(Action::Or),
        Node::Implies(_) => return Ok(Action::Implies),
        Node::Rise(_) => return Ok(Action::Rise { before: Interval::FALSE }),
        Node::Within(last, _) if sense == Sense::Number => {
            let last = *last;
            let once = once.then(|| Action::FirstTime { last, period, first: FirstTime::default() });
            return Ok(once.unwrap_or(Action::FirstTimes { last, period }));
        }
        Node::Within(last, _) => (Window { first: 0, last: Some(*last) }, false),
        Node::Always(window, _) => (*window, true),
        Node::Eventually(window, _) | Node::Until(window, _) => (*window, false),
    };
    let Window { first, last } = window;
    if once {
        return Ok(Action::Running { until: Running::new(window), negate });
    }
    match last {
        Some(last) => {
            for room in Sliding::room(first, last, kept.ticks) {
                kept.queue(room)?;
            }
            Ok(Action::Sliding { until: Box::new(Sliding::new(first, last, kept.ticks)), negate })
        }
        None => {
            let room = first.min(kept.ticks) as usize + 1;
            kept.queue(room)?;
            Ok(Action::OpenEnd { first, before: Box::new(Queue::with_capacity(room)), negate })
        }
    }
}

impl Operation {
    fn advance(&mut self, before: &[Operation], step: &Step) {
        let Operation { action, operands, taken, now, ring } = self;
        let once = ring.values.is_empty();
        let (ended, ticks) = (step.values.is_none(), step.ticks);
        let ready = operands.iter().map(|&a| before[a].ring.len).min().unwrap_or(0);
        let operand = |t: u32| before[operands[0]].ring.at(t);
        let stretch = |t: u32, negate: bool| {
            let (hold, goal) = match operands[..] {
                [hold, goal] => (before[hold].ring.at(t), before[goal].ring.at(t)),
                _ => (Interval::TRUE, operand(t)),
            };
            Stretch { hold, goal: signed(goal, negate) }
        };
        match action {
            Action::Predicate { signal, sense } => {
                let Some(values) = step.values else { return };
                let value = Interval::exact(Value::of_signal(values[*signal], ticks - 1));
                let value = if *sense == Sense::Truth { value.truth() } else { value };
                if !once {
                    ring.put(value);
                } else if ticks == 1 {
                    *now = value;
                }
            }
            Action::Not | Action::And | Action::Or | Action::Implies | Action::Rise { .. } if once => {}
            Action::Not | Action::And | Action::Or | Action::Implies | Action::Rise { .. } => {
                for t in ring.len..ready {
                    ring.put(action.at_a_tick(t, operands.iter().map(|&a| before[a].ring.at(t))));
                    if let Action::Rise { before } = action {
                        *before = operand(t).truth();
                    }
                }
            }
            Action::Running { until, negate } => {
                while *taken < ready && until.is_open() {
                    until.take(stretch(*taken, *negate));
                    *taken += 1;
                }
            }
            Action::Sliding { until, negate } => {
                for t in *taken..ready {
                    if let Some(value) = until.take(t, stretch(t, *negate)) {
                        ring.put(signed(value, *negate));
                    }
                }
                *taken = ready;
                while ended && ring.len < ticks {
                    ring.put(signed(until.rest(ticks), *negate));
                }
            }
            Action::OpenEnd { first, before, negate } if ended => {
                let out = &mut ring.values[..ticks as usize];
                open_end(*first, ticks, |t| stretch(t, *negate), before, out);
                out.iter_mut().for_each(|value| *value = signed(*value, *negate));
                ring.len = ticks;
            }
            Action::FirstTime { first, .. } => {
                for t in *taken..ready {
                    first.take(operand(t));
                }
                *taken = ready;
            }
            Action::FirstTimes { last, period } if ended => {
                first_times(*last, *period, ticks, operand, &mut ring.values[..ticks as usize]);
                ring.len = ticks;
            }
            Action::OpenEnd { .. } | Action::FirstTimes { .. } => {}
        }
    }

    /// Sets the value at the first tick, if only that one is needed.
    fn settle(&mut self, before: &[Operation], ended: bool) {
        if !self.ring.values.is_empty() {
            return;
        }
        self.now = match &self.action {
            Action::Predicate { .. } => self.now,
            Action::Running { until, negate } => signed(until.value(ended), *negate),
            Action::FirstTime { last, period, first } => first.value(*last, *period),
            action => action.at_a_tick(0, self.operands.iter().map(|&a| before[a].now)),
        };
    }
}

impl Action {
    /// Computes the value at tick `t` of an operation that depends on one tick only, from the values of its operands.
    fn at_a_tick(&self, t: u32, mut operands: impl Iterator<Item = Interval>) -> Interval {
        let mut next = || operands.next().unwrap_or(Interval::TRUE);
        match self {
            Action::Not => next().negated(),
            Action::Or => operands.fold(Interval::FALSE, Interval::or),
            Action::Implies => next().negated().or(next()),
            // A value that held before would date the denial of the rise one tick too early.
            Action::Rise { before } => next().truth().and(before.negated()).known_from(t),
            _ => operands.fold(Interval::TRUE, Interval::and),
        }
    }
}

fn signed(value: Interval, negate: bool) -> Interval {
    if negate { value.negated() } else { value }
}

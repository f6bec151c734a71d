//! The table of values at a tick: the moving ones, from the tape, for those who read them.

use std::collections::BTreeSet;

use crate::fault::Fault;
use crate::program::{Interface, Lost, Op, SignalProgram, Tape, Times, ValueRange, Values};
use crate::trajectory::Follower;

/// The part of the table of values that some tasks or conditions read.
pub(crate) struct ValueTable {
    tape: Tape,
    ranges: Vec<ValueRange>,
    /// Captured numbers.
    pub inputs: Vec<f64>,
    /// For each captured number, the first place that follows from it.
    reads: Vec<Option<usize>>,
    /// Signals that must be present: those that are read, but for those whose presence is asked for.
    needs: Vec<usize>,
    /// The number that says whether each of them may be used.
    presence: Vec<usize>,
    registers: Vec<f64>,
    /// Values, in the places of [`Values::initial`].
    pub current: Vec<f64>,
    /// Their time derivatives.
    pub rates: Vec<f64>,
    moves: Moves,
}

/// The trajectories of a table of values.
struct Moves {
    followers: Vec<Follower>,
    /// The numbers that they give.
    numbers: Vec<f64>,
    /// For each number the trajectory, where it is the first one that is read of it.
    first: Vec<Option<usize>>,
    /// For each place of the table of values that follows from a trajectory, that.
    places: Vec<(usize, usize)>,
}

impl Moves {
    fn new(tape: &Tape) -> Moves {
        let numbers = tape.trajectory_numbers();
        let mut first = vec![None; numbers];
        let mut begun = vec![false; tape.trajectories.len()];
        // For each operation the trajectories that it follows from.
        let mut from: Vec<BTreeSet<usize>> = Vec::with_capacity(if numbers > 0 { tape.ops.len() } else { 0 });
        for op in tape.ops.iter().filter(|_| numbers > 0) {
            let mut set: BTreeSet<usize> = op.operands().iter().flatten().flat_map(|&o| from[o].clone()).collect();
            if let Op::Trajectory(k) = *op
                && let Some(t) = tape.trajectory_of(k)
            {
                set.insert(t);
                set.extend(tape.trajectories[t].inputs().flat_map(|o| from[o].clone()));
                if !std::mem::replace(&mut begun[t], true) {
                    first[k] = Some(t);
                }
            }
            from.push(set);
        }
        let of = |o: &crate::program::Output| from.get(o.value).cloned().unwrap_or_default();
        Moves {
            followers: tape.trajectories.iter().map(Follower::new).collect(),
            numbers: vec![f64::NAN; numbers],
            first,
            places: tape.outputs.iter().flat_map(|o| of(o).into_iter().map(move |t| (o.at, t))).collect(),
        }
    }
}

impl ValueTable {
    /// The part of a program's values that stands in the wanted places.
    pub fn new(values: &Values, wanted: &BTreeSet<usize>, interface: &Interface) -> Self {
        let tape = values.tape.only(wanted);
        let read = tape.signals();
        // One that is held is needed all the same: asking whether it is seen says nothing of who never was.
        let held = |s: &SignalProgram| s.motion.is_some_and(|m| matches!(m.lost, Lost::Hold(_)));
        let asked = |at: &usize| {
            let signal = interface.signal_of(*at).map(|s| &interface.signals[s]);
            signal.is_none_or(|s| {
                read.contains(&s.at) && (!held(s) || read.range(s.at + 1..s.at + s.width()).next().is_none())
            })
        };
        let needs: BTreeSet<usize> =
            read.iter().filter(|at| !asked(at)).filter_map(|at| interface.signal_of(*at)).collect();
        ValueTable {
            ranges: values.ranges.iter().filter(|r| wanted.contains(&r.at)).copied().collect(),
            inputs: vec![0.0; tape.inputs],
            reads: tape.readers(),
            presence: needs.iter().map(|&s| interface.signals[s].known_at()).collect(),
            needs: needs.into_iter().collect(),
            registers: vec![0.0; tape.ops.len()],
            current: values.initial.clone(),
            rates: vec![0.0; values.initial.len()],
            moves: Moves::new(&tape),
            tape,
        }
    }

    /// Whether something follows from a captured number.
    pub fn is_read(&self, input: usize) -> bool {
        self.reads.get(input).is_some_and(Option::is_some)
    }

    /// Signals that must be present.
    pub fn needs(&self) -> &[usize] {
        &self.needs
    }

    /// The first signal that must be present and is not.
    pub fn absent(&self, signals: &[f64]) -> Option<usize> {
        let absent = self.presence.iter().zip(&self.needs).find(|(at, _)| signals[**at] < 0.0);
        absent.map(|(_, &signal)| signal)
    }

    /// Lets trajectories begin anew.
    pub fn restart(&mut self) {
        self.moves.followers.iter_mut().for_each(Follower::restart);
    }

    /// Whether all trajectories that a place follows from stand at their goals.
    pub fn is_settled(&self, at: usize) -> bool {
        let mut of = self.moves.places.iter().filter(|p| p.0 == at);
        of.all(|p| self.moves.followers.get(p.1).is_none_or(Follower::is_done))
    }

    /// Works out the moving values. Twice at one time is the same as once. Never allocates.
    pub fn evaluate(&mut self, times: Times, signals: &[f64]) {
        let ValueTable { tape, inputs, registers, current, rates, moves, .. } = self;
        let Moves { followers, numbers, first, .. } = moves;
        tape.evaluate_with(times, (inputs, signals), registers, (current, rates), |k, r| {
            if let Some(t) = first[k] {
                let program = &tape.trajectories[t];
                followers[t].at(times.time, program, |o| r[o], &mut numbers[program.numbers()]);
            }
            numbers[k]
        });
    }

    /// Whether the values may be used.
    ///
    /// # Errors
    /// A signal is absent, or a value is not finite or out of its range.
    pub fn check(&mut self, signals: &[f64]) -> Result<(), Fault> {
        // Told of before a `min` or an `if` can hide it.
        if let Some(signal) = self.absent(signals) {
            return Err(Fault::Stale { signal });
        }
        let mut lost = self.inputs.iter().zip(&self.reads).filter(|(x, _)| !x.is_finite());
        if let Some(at) = lost.find_map(|(_, at)| *at) {
            self.current[at] = f64::NAN;
            return Err(Fault::Value { at });
        }
        let bad = self.ranges.iter().find(|r| !r.contains(self.current[r.at]) || !self.rates[r.at].is_finite());
        bad.map_or(Ok(()), |r| Err(Fault::Value { at: r.at }))
    }
}

//! Table of values at a tick: the moving values, computed from the tape, for their readers.

use std::collections::BTreeSet;

use crate::fault::Fault;
use crate::program::{Interface, Lost, Op, SignalProgram, Tape, TapeReads, TapeWrites, Times, ValueRange, Values};
use crate::trajectory::Follower;

/// The part of the table of values that some tasks or conditions read.
pub(crate) struct ValueTable {
    tape: Tape,
    ranges: Vec<ValueRange>,
    /// Captured numbers.
    pub inputs: Vec<f64>,
    /// Captured numbers that are read, in ascending order.
    reads: Vec<Read>,
    /// Signals that must be present: those that are read, except those whose presence is tested.
    needs: Vec<usize>,
    /// For each of these, the index of the number that is 1 if it may be used.
    presence: Vec<usize>,
    registers: Vec<f64>,
    /// Values, at the indices of [`Values::initial`].
    pub current: Vec<f64>,
    /// Their time derivatives.
    pub rates: Vec<f64>,
    moves: Moves,
    /// Time for which its trajectories have waited (s).
    waited: f64,
}

/// A captured number that the table reads.
struct Read {
    input: usize,
    /// The first entry that depends on it.
    at: usize,
}

/// Trajectories of a table of values.
struct Moves {
    followers: Vec<Follower>,
    /// Numbers that they produce.
    numbers: Vec<f64>,
    /// For each number, its trajectory if this is the first of its numbers that is read.
    first: Vec<Option<usize>>,
    /// Entries of the table of values that depend on a trajectory, each with that trajectory.
    places: Vec<(usize, usize)>,
}

impl Moves {
    fn new(tape: &Tape) -> Moves {
        let numbers = tape.trajectory_numbers();
        let mut first = vec![None; numbers];
        let mut begun = vec![false; tape.trajectories.len()];
        // Trajectories that each operation depends on.
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
    /// Prepares the part of a program's values that the wanted entries need.
    pub fn new(values: &Values, wanted: &BTreeSet<usize>, interface: &Interface) -> Self {
        let tape = values.tape.only(wanted);
        let read = tape.signals();
        // A signal that can be held is needed even if its presence is tested: the test does not cover a point that was
        // never seen.
        let held = |s: &SignalProgram| s.motion.is_some_and(|m| matches!(m.lost, Lost::Hold(_)));
        let asked = |at: &usize| {
            let signal = interface.signal_of(*at).map(|s| &interface.signals[s]);
            signal.is_none_or(|s| {
                // An age is always there.
                s.age_of.is_some()
                    || read.contains(&s.at) && (!held(s) || read.range(s.at + 1..s.at + s.width()).next().is_none())
            })
        };
        let needs: BTreeSet<usize> =
            read.iter().filter(|at| !asked(at)).filter_map(|at| interface.signal_of(*at)).collect();
        ValueTable {
            ranges: values.ranges.iter().filter(|r| wanted.contains(&r.at)).copied().collect(),
            inputs: vec![0.0; tape.inputs],
            reads: tape
                .readers()
                .iter()
                .enumerate()
                .filter_map(|(input, at)| Some(Read { input, at: (*at)? }))
                .collect(),
            presence: needs.iter().map(|&s| interface.signals[s].known_at()).collect(),
            needs: needs.into_iter().collect(),
            registers: vec![0.0; tape.ops.len()],
            current: values.initial.clone(),
            rates: vec![0.0; values.initial.len()],
            moves: Moves::new(&tape),
            waited: 0.0,
            tape,
        }
    }

    /// Returns true if an entry is one that the table computes.
    pub fn computes(&self, at: usize) -> bool {
        self.tape.outputs.iter().any(|o| o.at == at)
    }

    /// Returns true if an entry depends on a captured number.
    pub fn is_read(&self, input: usize) -> bool {
        self.reads.binary_search_by_key(&input, |r| r.input).is_ok()
    }

    /// Signals that must be present.
    pub fn needs(&self) -> &[usize] {
        &self.needs
    }

    /// First signal that must be present and is absent.
    pub fn absent(&self, signals: &[f64]) -> Option<usize> {
        let absent = self.presence.iter().zip(&self.needs).find(|(at, _)| signals[**at] < 0.0);
        absent.map(|(_, &signal)| signal)
    }

    /// Restarts all trajectories.
    pub fn restart(&mut self) {
        self.waited = 0.0;
        self.moves.followers.iter_mut().for_each(Follower::restart);
    }

    /// Lets all trajectories stand for a time (s).
    pub fn wait(&mut self, time: f64) {
        self.waited += time;
        self.moves.followers.iter_mut().for_each(|follower| follower.wait(time));
    }

    /// Lets its trajectories wait as those of another table of the same values have.
    pub fn wait_as(&mut self, leader: &ValueTable) {
        if self.waited != leader.waited {
            self.wait(leader.waited - self.waited);
            self.waited = leader.waited;
        }
    }

    /// Returns true if all trajectories that an entry depends on are at rest at their goals.
    pub fn is_settled(&self, at: usize) -> bool {
        let mut of = self.moves.places.iter().filter(|p| p.0 == at);
        of.all(|p| self.moves.followers.get(p.1).is_none_or(Follower::is_done))
    }

    /// Computes the moving values. A second evaluation at the same time changes nothing. Never allocates.
    pub fn evaluate(&mut self, times: Times, signals: &[f64]) {
        let ValueTable { tape, inputs, registers, current, rates, moves, .. } = self;
        let Moves { followers, numbers, first, .. } = moves;
        let (read, write) = (TapeReads { inputs, signals }, TapeWrites { values: current, rates });
        tape.evaluate_with(times, read, registers, write, |k, r| {
            if let Some(t) = first[k] {
                let program = &tape.trajectories[t];
                followers[t].at(times.time, program, |o| r[o], &mut numbers[program.numbers()]);
            }
            numbers[k]
        });
    }

    /// Checks that the values may be used.
    ///
    /// # Errors
    /// A signal is absent, or a value is not finite or out of its range.
    pub fn check(&mut self, signals: &[f64]) -> Result<(), Fault> {
        // Absence is reported before a `min` or an `if` can hide it.
        if let Some(signal) = self.absent(signals) {
            return Err(Fault::Stale { signal });
        }
        if let Some(&Read { at, .. }) = self.reads.iter().find(|r| !self.inputs[r.input].is_finite()) {
            self.current[at] = f64::NAN;
            return Err(Fault::Value { at });
        }
        let bad = self.ranges.iter().find(|r| !r.contains(self.current[r.at]) || !self.rates[r.at].is_finite());
        bad.map_or(Ok(()), |r| Err(Fault::Value { at: r.at }))
    }
}

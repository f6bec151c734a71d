//! Expressions as a flat list of operations on numbers, each of which reads earlier results.
//!
//! The compiler writes the operations of a value and those of its exact time derivative into one tape, with common
//! parts shared. An evaluation is one pass over the list and allocates nothing.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
pub use stdlib_tasks::expression::Op;

use super::TrajectoryProgram;

/// Destination of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Index in the table of values.
    pub at: usize,
    /// Operation that computes the value.
    pub value: usize,
    /// Operation that computes its time derivative.
    pub rate: usize,
}

/// List of operations and the destinations of their results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tape {
    /// Operations, operands before users.
    pub ops: Vec<Op>,
    /// Results.
    pub outputs: Vec<Output>,
    /// Number of captured values.
    pub inputs: usize,
    /// Trajectories, in the order of their numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trajectories: Vec<TrajectoryProgram>,
}

/// The two clocks of an expression, in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Time since the state, and with it the stack, was entered.
    pub t: f64,
    /// Time since the start of the run.
    pub time: f64,
}

/// Tables that a tape reads.
#[derive(Clone, Copy)]
pub(crate) struct TapeReads<'a> {
    /// Captured values.
    pub inputs: &'a [f64],
    /// Table of signals.
    pub signals: &'a [f64],
}

/// Tables that a tape writes, of equal length.
pub(crate) struct TapeWrites<'a> {
    /// Values.
    pub values: &'a mut [f64],
    /// Their rates, per s.
    pub rates: &'a mut [f64],
}

impl Tape {
    /// Part of the tape that computes the given entries of the table of values.
    pub fn only(&self, wanted: &BTreeSet<usize>) -> Tape {
        let outputs = self.outputs_at(wanted);
        // A part is often small in a large tape, so that only what it needs is looked at. Operands come before users:
        // the last open operation is needed by none that follows.
        let mut open: BTreeSet<usize> = outputs.iter().flat_map(|o| [o.value, o.rate]).collect();
        let mut moved: BTreeSet<usize> = BTreeSet::new();
        let mut needed = Vec::new();
        while let Some(i) = open.pop_last() {
            needed.push(i);
            open.extend(self.ops[i].operands().into_iter().flatten());
            if let Op::Trajectory(k) = self.ops[i]
                && let Some(t) = self.trajectory_of(k)
                && moved.insert(t)
            {
                open.extend(self.trajectories[t].inputs());
            }
        }
        needed.reverse();
        let number = |op: usize| needed.binary_search(&op).unwrap_or(0);
        let ops = needed.iter().map(|&i| self.ops[i].renumber(number)).collect();
        let outputs = outputs.iter().map(|o| Output { at: o.at, value: number(o.value), rate: number(o.rate) });
        let trajectories = moved.iter().map(|&t| self.trajectories[t].renumber(number)).collect();
        Tape { outputs: outputs.collect(), ops, inputs: self.inputs, trajectories }
    }

    /// Outputs that write the given entries of the table of values.
    fn outputs_at(&self, wanted: &BTreeSet<usize>) -> Vec<Output> {
        if !self.outputs.is_sorted_by_key(|o| o.at) {
            return self.outputs.iter().filter(|o| wanted.contains(&o.at)).copied().collect();
        }
        let from = |at: usize| self.outputs.partition_point(|o| o.at < at);
        wanted.iter().flat_map(|&at| self.outputs[from(at)..].iter().take_while(move |o| o.at == at)).copied().collect()
    }

    /// For each captured value, the first entry of the table of values that depends on it. The tape has passed
    /// [`super::Program::check`].
    pub fn readers(&self) -> Vec<Option<usize>> {
        // First entry that needs each operation, propagated from users to operands.
        let mut first: Vec<Option<usize>> = vec![None; self.ops.len()];
        let earlier = |a: Option<usize>, b: Option<usize>| a.into_iter().chain(b).min();
        for o in &self.outputs {
            first[o.value] = earlier(first[o.value], Some(o.at));
        }
        let mut readers = vec![None; self.inputs];
        for (i, op) in self.ops.iter().enumerate().rev() {
            for &o in op.operands().iter().flatten() {
                first[o] = earlier(first[o], first[i]);
            }
            match *op {
                Op::Input(k) => readers[k] = earlier(readers[k], first[i]),
                Op::Trajectory(k) => {
                    let read = self.trajectory_of(k).and_then(|t| self.trajectories.get(t));
                    for o in read.into_iter().flat_map(TrajectoryProgram::inputs) {
                        first[o] = earlier(first[o], first[i]);
                    }
                }
                _ => {}
            }
        }
        readers
    }

    /// Indices of the numbers of signals that it reads, in ascending order.
    pub fn signals(&self) -> BTreeSet<usize> {
        let read = |op: &Op| match *op {
            Op::Signal(k) => Some(k),
            _ => None,
        };
        self.ops.iter().filter_map(read).collect()
    }

    /// Evaluates all operations into `registers` (as many as operations) and writes the outputs into the tables of
    /// values and rates. Trajectories keep their start values. The tape has passed [`super::Program::check`].
    pub fn evaluate(
        &self,
        times: Times,
        inputs: &[f64],
        signals: &[f64],
        registers: &mut [f64],
        values: &mut [f64],
        rates: &mut [f64],
    ) {
        let start = |k: usize, r: &[f64]| {
            let read = self.trajectory_of(k).and_then(|t| self.trajectories.get(t));
            read.map_or(f64::NAN, |t| t.start.get(k - t.at).map_or(0.0, |&op| r[op]))
        };
        self.evaluate_with(times, TapeReads { inputs, signals }, registers, TapeWrites { values, rates }, start);
    }

    /// Like [`Tape::evaluate`], with numbers of trajectories that `trajectory` computes from the operations before the
    /// reader.
    pub(crate) fn evaluate_with(
        &self,
        times: Times,
        read: TapeReads,
        registers: &mut [f64],
        write: TapeWrites,
        mut trajectory: impl FnMut(usize, &[f64]) -> f64,
    ) {
        for (i, op) in self.ops.iter().enumerate() {
            let r = &*registers;
            let leaf = |op: Op| match op {
                Op::T => times.t,
                Op::Time => times.time,
                Op::Input(k) => read.inputs[k],
                Op::Signal(k) => read.signals[k],
                _ => f64::NAN,
            };
            registers[i] = match *op {
                Op::Trajectory(k) => trajectory(k, r),
                op => op.value(|a| r[a], leaf),
            };
        }
        for o in &self.outputs {
            write.values[o.at] = registers[o.value];
            write.rates[o.at] = registers[o.rate];
        }
    }
}

//! Table of values: constants are folded, moving values and their rates are computed by a tape.

use std::collections::BTreeMap;

use runtime::program::{Op, Output, Tape, TrajectoryProgram, Values};

use super::Lowerer;

impl Lowerer<'_> {
    /// Builds the table of values: constants are folded, moving values and their rates are computed by the tape.
    pub(super) fn values(&mut self) -> Values {
        let nodes = std::mem::take(&mut self.table.nodes);
        self.table.placed.clone_from(&nodes);
        let mut initial = Vec::with_capacity(nodes.len());
        let mut moving = Vec::new();
        for (at, &n) in nodes.iter().enumerate() {
            match self.graph.constant(n) {
                Some(x) => initial.push(x),
                None => {
                    initial.push(0.0);
                    moving.push((at, n, self.graph.rate(n)));
                }
            }
        }
        let roots: Vec<usize> = moving.iter().flat_map(|m| [m.1, m.2]).collect();
        let (mut ops, index) = self.graph.extract(&roots);
        let trajectories = trajectories(self.graph.trajectories(), &mut ops, &index);
        let outputs = moving.iter().map(|m| Output { at: m.0, value: index[&m.1], rate: index[&m.2] }).collect();
        let tape = Tape { ops, outputs, inputs: self.table.inputs, trajectories };
        let mut registers = vec![0.0; tape.ops.len()];
        let mut rates = vec![0.0; initial.len()];
        let inputs = vec![0.0; tape.inputs];
        let signals = vec![f64::NAN; self.interface.width()];
        tape.evaluate(Default::default(), &inputs, &signals, &mut registers, &mut initial, &mut rates);
        // A value that depends on a capture is NaN here, which JSON cannot represent.
        for o in tape.outputs.iter().filter(|o| !registers[o.value].is_finite()) {
            initial[o.at] = 0.0;
        }
        debug_assert!(tape.ops.iter().enumerate().all(|(i, o)| o.operands().iter().flatten().all(|&x| x < i) && !matches!(o, Op::Const(x) if x.is_nan())));
        let (ranges, captures) = (std::mem::take(&mut self.table.ranges), std::mem::take(&mut self.table.captures));
        Values { ranges, initial, tape, captures }
    }
}

/// Returns the trajectories that the operations read, with consecutive numbers.
fn trajectories(all: &[TrajectoryProgram], ops: &mut [Op], index: &BTreeMap<usize, usize>) -> Vec<TrajectoryProgram> {
    let mut used: Vec<TrajectoryProgram> = Vec::new();
    let mut number = BTreeMap::new();
    for t in all {
        let read = ops.iter().any(|op| matches!(op, Op::Trajectory(k) if t.numbers().contains(k)));
        if !read {
            continue;
        }
        let at = used.last().map_or(0, |t| t.numbers().end);
        number.extend(t.numbers().map(|k| (k, at + k - t.at)));
        let place = |node: usize| index.get(&node).copied().unwrap_or(0);
        used.push(TrajectoryProgram { at, ..t.renumber(place) });
    }
    for op in ops {
        if let Op::Trajectory(k) = op {
            *k = number.get(k).copied().unwrap_or(0);
        }
    }
    used
}

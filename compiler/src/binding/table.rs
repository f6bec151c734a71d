//! The table of values while it is laid out: the places of parameters, and what is captured.

use runtime::program::{Capture, CaptureSource};
use stdlib_tasks::bound::Slot;

/// The table of values while it is being laid out: for each place the node that gives it.
#[derive(Debug, Default)]
pub struct Table {
    /// Node of each place.
    pub nodes: Vec<usize>,
    /// Captures, in the order of their inputs.
    pub captures: Vec<Capture>,
    /// Number of captured values.
    pub inputs: usize,
    /// Ranges of places that move, for the controller to watch.
    pub ranges: Vec<(usize, f64, f64)>,
}

impl Table {
    pub(super) fn place(&mut self, nodes: &[usize]) -> Slot {
        let at = self.nodes.len();
        self.nodes.extend_from_slice(nodes);
        Slot { at, len: nodes.len() }
    }

    /// Captures a value once, however often it is named; gives the first input.
    pub(super) fn capture(&mut self, source: CaptureSource, len: usize) -> usize {
        if let Some(c) = self.captures.iter().find(|c| c.source == source) {
            return c.at;
        }
        let at = self.inputs;
        self.captures.push(Capture { at, len, source });
        self.inputs += len;
        at
    }
}

//! What safety planners tell: values that the controller sets at each tick, and nobody else.

use dsl::tree::Task;
use runtime::PLANNER_OUTPUTS;
use runtime::program::{Conditioning, Initial, Op, SignalProgram};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE, VELOCITY};

use super::Lowerer;
use crate::constants::is_word;
use crate::expr::{Axes, Kind, Symbol, Typed, told};

impl Lowerer<'_> {
    /// Declares what the safety planners among declared tasks tell.
    pub(super) fn planners(&mut self, tasks: &[&Task]) {
        for task in tasks.iter().filter(|t| t.definition.kind.value == "safety_planner") {
            let name = &task.name;
            if is_word(&name.value) {
                continue;
            }
            let (length, speed) = (("length", LENGTH), ("speed", VELOCITY));
            let dimensions: [(&str, Dimension); 5] = [("number", NONE), length, speed, speed, length];
            for (output, (kind, dimension)) in PLANNER_OUTPUTS.into_iter().zip(dimensions) {
                let at = self.interface.width();
                self.interface.signals.push(SignalProgram {
                    name: format!("{}.{output}", name.value),
                    kind: kind.to_string(),
                    at,
                    len: 1,
                    optional: true,
                    timeout: None,
                    conditioning: Conditioning::default(),
                    variable: Some(Initial { value: None }),
                    motion: None,
                });
                let nodes = vec![self.graph.push(Op::Signal(at + 1))];
                let axes = Axes::default();
                let value = Typed { kind: Kind::Scalar, dimension, nodes, bare: false, axes, span: name.span };
                self.params.symbols.insert(told(&name.value, output), Symbol { value, declared: name.span });
            }
        }
    }
}

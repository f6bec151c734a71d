//! Outputs of running tasks: values that only the controller sets, at each tick.

use dsl::tree::Task;
use runtime::program::Op;

use super::Lowerer;
use crate::expand::type_of;
use crate::expr::constants::is_word;
use crate::expr::{Axes, Kind, Symbol, Typed, output_symbol};

impl Lowerer<'_> {
    /// Declares the outputs of the declared tasks.
    pub(super) fn declare_task_outputs(&mut self, tasks: &[&Task]) {
        for task in tasks.iter().filter(|t| !is_word(&t.name.value)) {
            let name = &task.name;
            for of in stdlib_tasks::find(&task.definition.kind.value).map_or(&[][..], |k| k.outputs) {
                let kind = type_of(of.dimension).unwrap_or("number");
                let signal = self.interface.declare_output(format!("{}.{}", name.value, of.name), kind);
                let nodes = vec![self.graph.push(Op::Signal(self.interface.signals[signal].at + 1))];
                let (kind, axes) = (Kind::Scalar, Axes::default());
                let value = Typed { kind, dimension: of.dimension, nodes, bare: false, axes, span: name.span };
                self.params.symbols.insert(output_symbol(&name.value, of.name), Symbol { value, declared: name.span });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::type_of;

    #[test]
    fn outputs_have_a_type() {
        for output in stdlib_tasks::KINDS.iter().flat_map(|k| k.outputs) {
            assert!(type_of(output.dimension).is_some(), "{output:?}");
        }
    }
}

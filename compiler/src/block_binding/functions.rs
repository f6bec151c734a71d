//! Numbers that may depend on the arguments that a key gives, such as a reward rate on the distance from a boundary.

use blocks::FunctionType;
use dsl::tree::Value;
use dsl::{Diagnostic, Help};
use expressions::Function;

use super::BlockBinder;
use super::values::Asked;
use crate::expr::Kind;
use crate::expr::functions_of_arguments::{Argument, Extracted, mentions};

impl BlockBinder<'_> {
    /// Binds a number that may depend on arguments.
    pub(super) fn function(&mut self, value: &Value, asked: Asked, of: &FunctionType) -> Option<Function> {
        let names: Vec<&str> = of.names().collect();
        // A constant is a number like any other.
        if !mentions(value, &names) {
            return self.number(value, asked.name, &of.result).map(Function::constant);
        }
        let mut first = 0;
        let mut arguments = Vec::new();
        for argument in of.arguments {
            let kind = if argument.is_vector { Kind::Vector } else { Kind::Scalar };
            arguments.push(Argument { name: argument.name, kind, dimension: argument.dimension, first });
            first += kind.width();
        }
        let typed = self.constants.function(value, &arguments, self.diagnostics)?;
        if typed.kind != Kind::Scalar {
            let text = format!("`{}` is a number, and this is {}", asked.name, typed.kind.describe());
            let d = Diagnostic::error("HQ0304", value.span, text);
            self.diagnostics.push(d.help(Help::write_for_instance(asked.key.written())));
            return None;
        }
        let what = format!("`{}`", asked.name);
        if let Some(wrong) = self.constants.check_dimension(&typed, of.result.dimension, &what) {
            self.diagnostics.push(wrong);
            return None;
        }
        let result = typed.nodes[0];
        match Extracted::new(self.constants.graph, &[result], &names, false, value.span) {
            Ok(Extracted { ops, index }) => {
                Some(Function { ops, result: index[&result], text: dsl::expression_text(value) })
            }
            Err(wrong) => {
                self.diagnostics.push(*wrong);
                None
            }
        }
    }
}

//! Functions of arguments: expressions in which certain names stand for numbers that are known when the function is
//! evaluated. A block of the language says which.

use std::collections::BTreeMap;

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span};
use expressions::{MAX_OPERATIONS, Op};
use names::list;
use stdlib_tasks::dimension::Dimension;

use super::constants::Constants;
use super::{Axes, Graph, Kind, Symbol, Typed};

/// Numbers of the table of signals that stand for arguments while a function is typed; no signal has them.
const FIRST: usize = usize::MAX / 2;

/// An argument of a function.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Argument<'n> {
    /// Its name.
    pub name: &'n str,
    /// A number or a vector.
    pub kind: Kind,
    /// Its unit.
    pub dimension: Dimension,
    /// Index of its first number among those of all arguments.
    pub first: usize,
}

impl Argument<'_> {
    /// The node of a number.
    pub fn node(&self, graph: &mut Graph) -> usize {
        graph.moving_signal(FIRST + 2 * self.first, FIRST + 2 * self.first + 1)
    }

    fn symbol(&self, graph: &mut Graph, span: Span) -> Symbol {
        // The rates of arguments follow, each behind its argument.
        let signal = |k: usize| FIRST + 2 * (self.first + k);
        let nodes = (0..self.kind.width()).map(|k| graph.moving_signal(signal(k), signal(k) + 1)).collect();
        let (kind, dimension) = (self.kind, self.dimension);
        let value = Typed { kind, dimension, nodes, bare: false, axes: Axes::default(), span };
        Symbol { value, declared: span }
    }
}

/// Returns true if an expression has one of these names in it.
pub(crate) fn mentions(value: &Value, names: &[&str]) -> bool {
    let inside = |value: &Value| mentions(value, names);
    match &value.kind {
        ValueKind::Name(name) => names.contains(&name.as_str()),
        ValueKind::Unit(inner, _)
        | ValueKind::Field(inner, _)
        | ValueKind::In(inner, _)
        | ValueKind::Named(_, inner)
        | ValueKind::Negate(inner)
        | ValueKind::Not(inner) => inside(inner),
        ValueKind::Call(_, items) | ValueKind::List(items) => items.iter().any(inside),
        ValueKind::Binary(_, left, right) => inside(left) || inside(right),
        ValueKind::Block(_) | ValueKind::Number(_) | ValueKind::Text(_) | ValueKind::Missing => false,
    }
}

impl Constants<'_> {
    /// Types a function of these arguments, which hide declared values of the same names.
    pub(crate) fn function(
        &mut self,
        value: &Value,
        arguments: &[Argument],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        let mut hidden = Vec::new();
        for argument in arguments {
            let symbol = argument.symbol(self.graph, value.span);
            hidden.push((argument.name, self.params.symbols.insert(argument.name.to_string(), symbol)));
        }
        let typed = self.typed(value, diagnostics);
        for (name, own) in hidden {
            match own {
                Some(own) => self.params.symbols.insert(name.to_string(), own),
                None => self.params.symbols.remove(name),
            };
        }
        typed
    }
}

/// Operations of a function, in which [`Op::Input`] reads its arguments.
#[derive(Debug)]
pub(crate) struct Extracted {
    /// Operations, operands before users.
    pub ops: Vec<Op>,
    /// New index of each operation of the graph.
    pub index: BTreeMap<usize, usize>,
}

impl Extracted {
    /// Extracts the operations that compute these results; `names` are those of the arguments, for messages. `slope` says that
    /// the first argument is the variable of a derivative, whose own derivative is one.
    ///
    /// # Errors
    /// The function depends on something else, or has too many operations.
    pub fn new(
        graph: &Graph,
        results: &[usize],
        names: &[&str],
        slope: bool,
        at: Span,
    ) -> Result<Extracted, Box<Diagnostic>> {
        let (mut ops, index) = graph.extract(results);
        for op in &mut ops {
            match *op {
                Op::Signal(k) if slope && k == FIRST + 1 => *op = Op::Const(1.0),
                Op::Signal(k) if k >= FIRST && (k - FIRST).is_multiple_of(2) => *op = Op::Input((k - FIRST) / 2),
                Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => {
                    let text =
                        format!("this function depends on something else than {}", list(names.iter().copied(), 8));
                    let help = "leave `t`, `time`, signals and people out of it";
                    return Err(Box::new(Diagnostic::error("HQ0307", at, text).help(help)));
                }
                _ => {}
            }
        }
        if ops.len() > MAX_OPERATIONS {
            let with = if slope { " with its derivative" } else { "" };
            let text = format!("this function has {} operations{with}, and {MAX_OPERATIONS} are the most", ops.len());
            return Err(Box::new(Diagnostic::error("HQ0308", at, text).help("write a shorter one")));
        }
        Ok(Extracted { ops, index })
    }
}

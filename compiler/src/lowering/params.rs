//! Values with a name: params, lets, signals, humans and safety fields in the order written; and what each param of a spec is worth.

use dsl::tree::Let;
use dsl::{Diagnostic, Sources};

use super::declared::Declared;
use super::{Context, Lowerer};
use crate::expand::{Expanded, Named};
use crate::expr::Kind;
use crate::expr::constants::Constants;
use crate::units;
use stdlib_tasks::dimension::NONE;

/// What a param of a spec is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamValue {
    /// Its name.
    pub name: String,
    /// Its number in SI; none for a vector, an orientation, a pose or a truth value.
    pub number: Option<f64>,
    /// What it is: `a number`, `a vector` ..
    pub kind: &'static str,
    /// The SI unit of its numbers, as one writes it: `m`, `/s`; empty for a bare number.
    pub unit: String,
}

impl Lowerer<'_> {
    /// Declares all values with a name. Gives the lets that wait until the robot is known.
    pub(super) fn named_values<'t>(&mut self, expanded: &'t Expanded, declared: &Declared) -> Vec<&'t Let> {
        let overrides = self.overrides(declared);
        let (mut later, mut told) = (Vec::new(), false);
        for value in &expanded.values {
            // What tasks tell stands behind the signals, and before what may read it.
            if matches!(value, Named::Let(_)) && !std::mem::replace(&mut told, true) {
                self.told(&declared.tasks);
            }
            match value {
                Named::Param(p) => {
                    let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
                    constants.declare(p, overrides.get(&p.name.value), self.diagnostics);
                }
                Named::Let(l) => {
                    let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
                    later.extend(constants.declare_let(l, self.diagnostics).then_some(l));
                }
                Named::Signal(s) => self.signal(s),
                Named::Human(h) => self.human(h),
                Named::Field(f) => self.declare_field(f),
                Named::Variable(v) => self.variable(v),
            }
        }
        if !told {
            self.told(&declared.tasks);
        }
        later
    }
}

/// What the params of an expanded spec are worth, in the order written; without those that are wrong.
pub(crate) fn params(
    context: &Context,
    expanded: &Expanded,
    sources: &mut Sources,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<ParamValue> {
    let mut lowerer = Lowerer::new(context, sources, diagnostics);
    let declared = lowerer.collect(expanded);
    lowerer.named_values(expanded, &declared);
    let mut all = Vec::new();
    for p in &declared.params {
        let Some(symbol) = lowerer.params.symbols.get(&p.name.value) else { continue };
        let typed = symbol.value.clone();
        let mut constants = Constants { graph: &mut lowerer.graph, params: &mut lowerer.params };
        let own = constants.constant(&p.value, lowerer.diagnostics).map_or(NONE, |own| own.dimension);
        let dimension = if typed.dimension == NONE { own } else { typed.dimension };
        let number = typed.nodes.first().and_then(|&n| lowerer.graph.constant(n));
        all.push(ParamValue {
            name: p.name.value.clone(),
            number: number.filter(|_| typed.kind == Kind::Scalar),
            kind: typed.kind.describe(),
            unit: units::written(dimension),
        });
    }
    all
}

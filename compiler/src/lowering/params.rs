//! Named values in source order: params, lets, signals, humans and safety fields; and the values of a spec's params.

use dsl::tree::{BlockKind, Let};
use dsl::{Diagnostic, Sources};

use super::ages;
use super::declared::Declared;
use super::sensors::Sensor;
use super::variables::Variables;
use super::{Context, Lowerer};
use crate::expand::{Expanded, Named};
use crate::expr::Kind;
use crate::expr::constants::Constants;
use crate::units;
use stdlib_tasks::dimension::NONE;

/// Value of a param.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamValue {
    /// Name.
    pub name: String,
    /// Number in SI; `None` for a vector, an orientation, a pose or a truth value.
    pub number: Option<f64>,
    /// Description of the kind: `a number`, `a vector` ..
    pub kind: &'static str,
    /// SI unit of the numbers, as in a spec: `m`, `/s`; empty for a bare number.
    pub unit: String,
}

/// The named values of a spec are typed. These parts of them wait for the robot and the machine.
#[derive(Default)]
pub(super) struct NamedValues<'t> {
    /// Expressions of the robot's state, each after those that it uses.
    pub later: Vec<&'t Let>,
    /// Settings of signals that depend on the robot.
    pub sensors: Vec<Sensor>,
    /// Variables, which the machine sets.
    pub variables: Variables,
}

impl Lowerer<'_> {
    /// Declares all named values.
    pub(super) fn named_values<'t>(&mut self, expanded: &'t Expanded, declared: &Declared) -> NamedValues<'t> {
        let overrides = self.overrides(declared);
        self.aged = ages::aged(expanded);
        let (mut all, mut outputs_declared) = (NamedValues::default(), false);
        for value in &expanded.values {
            // Outputs of tasks come after the signals and before the lets, which may use them.
            if matches!(value, Named::Let(_)) && !std::mem::replace(&mut outputs_declared, true) {
                self.declare_task_outputs(&declared.tasks);
            }
            match value {
                Named::Param(p) => {
                    let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
                    constants.declare(p, overrides.get(&p.name.value), self.diagnostics);
                }
                Named::Let(l) => {
                    let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
                    all.later.extend(constants.declare_let(l, self.diagnostics).then_some(l));
                }
                Named::Signal(s) => all.sensors.extend(self.signal(s)),
                Named::Block(b) => match b.kind {
                    BlockKind::Human => self.human(b),
                    BlockKind::SafetyField => self.declare_field(b),
                    BlockKind::Obstacle => self.declare_obstacle(b),
                },
                Named::Variable(v) => self.variable(v, &mut all.variables),
            }
        }
        if !outputs_declared {
            self.declare_task_outputs(&declared.tasks);
        }
        all
    }
}

/// Evaluates the params of an expanded spec, in source order; params with errors are left out.
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

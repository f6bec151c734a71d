//! Values that are needed at compile time: declared `param`s, and constants in blocks of robots and runs.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Span, Spanned};
use quantities::usual::of_joint;
use robot::Model;
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH};

pub use crate::expr::dimension_check::{
    bare_angle, check_dimension, merge_bare, misplaced_unit, one_unit, wrong_dimension,
};
pub use crate::expr::environment::{Human, Params, is_word};
use crate::expr::{Frame, Graph, Kind, Lowering, Meaning, RobotStateTerm, Scope, Typed, unusual};

/// Context of values that are needed at compile time: their graph and scope.
pub struct Constants<'a> {
    /// The graph of the whole program.
    pub graph: &'a mut Graph,
    /// Declared parameters.
    pub params: &'a mut Params,
}

/// Scope of an expression that may use declared values only; `moves` says if these may depend on time.
struct DeclaredOnly<'s> {
    params: &'s mut Params,
    moves: bool,
}

impl Scope for DeclaredOnly<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        self.params.meaning(name)
    }

    fn names(&self) -> Vec<String> {
        self.params.names()
    }

    fn presence(&mut self, name: &str) -> Option<usize> {
        self.params.presence(name)
    }

    fn age(&mut self, name: &str) -> Option<usize> {
        self.params.age(name)
    }

    fn moves(&self) -> bool {
        self.moves
    }

    fn initial(&mut self, _: &mut Graph, _: &Value, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        diagnostics.push(
            Diagnostic::error("HQ0311", span, "`initial(..)` has no meaning here")
                .note("it captures a value when a stack becomes active, and this value is needed before")
                .help("write a constant here, or `initial(..)` in the parameter of a task"),
        );
        None
    }

    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        diagnostics.push(
            Diagnostic::error("HQ0314", name.span, "axes of the robot are not available here")
                .note("params and the description of a robot are evaluated before any task; the numbers of a point are in the axes of its link")
                .help(format!("leave `in {0}` out here, and write it where the value is used", name.value)),
        );
        None
    }

    fn now(
        &mut self,
        _: &mut Graph,
        _: &RobotStateTerm,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        diagnostics.push(
            Diagnostic::error("HQ0312", span, "the robot's state is not available here")
                .note("this value is needed before the robot moves")
                .help("write a constant here, or the expression in the parameters of a task `keep` or `track`"),
        );
        None
    }
}

/// Dimension of a joint's position: an angle or a length.
pub fn joint_dimension(model: &Model, dof: usize) -> Dimension {
    model.dofs.get(dof).map_or(ANGLE, |d| d.unit.select(LENGTH, ANGLE))
}

impl Constants<'_> {
    /// Types a value that must be constant.
    pub(crate) fn constant(&mut self, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let typed = self.typed(value, diagnostics)?;
        let bad = self.not_constant(&typed);
        let good = bad.is_none();
        diagnostics.extend(bad);
        good.then_some(typed)
    }

    /// Types a value that may use parameters only.
    pub fn typed(&mut self, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let mut scope = DeclaredOnly { params: self.params, moves: false };
        Lowering { graph: self.graph, scope: &mut scope, diagnostics }.value(value).ok()
    }

    /// Types a value that may depend on time and on signals.
    pub fn moving(&mut self, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let mut scope = DeclaredOnly { params: self.params, moves: true };
        Lowering { graph: self.graph, scope: &mut scope, diagnostics }.value(value).ok()
    }

    /// Types an argument of a task or a stack. Names that only a task knows, and mistakes, are left to its uses: `None`.
    pub fn argument(&mut self, value: &Value) -> Option<Typed> {
        let mut scope = DeclaredOnly { params: self.params, moves: true };
        Lowering { graph: self.graph, scope: &mut scope, diagnostics: &mut Vec::new() }.value(value).ok()
    }

    fn not_constant(&self, typed: &Typed) -> Option<Diagnostic> {
        for &n in &typed.nodes {
            match self.graph.constant(n) {
                None => {
                    return Some(
                        Diagnostic::error(
                            "HQ0307",
                            typed.span,
                            "this value depends on time or on a signal, and it is needed before the run",
                        )
                        .help("leave `t`, `time` and signals out"),
                    );
                }
                Some(x) if !x.is_finite() => {
                    return Some(
                        Diagnostic::error("HQ0309", typed.span, "this value is not a finite number")
                            .help("check for a division by zero, or factors that are far too large"),
                    );
                }
                Some(_) => {}
            }
        }
        None
    }

    fn numbers(
        &mut self,
        value: &Value,
        kind: Kind,
        wanted: Dimension,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Vec<f64>> {
        let typed = self.typed(value, diagnostics)?;
        if typed.kind != kind {
            let text = format!("{} is needed here, and this is {}", kind.describe(), typed.kind.describe());
            let help = if kind == Kind::Vector { "write three numbers, `[x, y, z]`" } else { "write one number" };
            diagnostics.push(Diagnostic::error("HQ0304", value.span, text).help(help));
            return None;
        }
        if let Some(mut d) = self.check_dimension(&typed, wanted, "") {
            d.help = misplaced_unit(value, wanted).map(Help::from).or(d.help);
            let error = d.severity == dsl::Severity::Error;
            diagnostics.push(d);
            if error {
                return None;
            }
        }
        if let Some(bad) = self.not_constant(&typed) {
            diagnostics.push(bad);
            return None;
        }
        typed.nodes.iter().map(|&n| self.graph.constant(n)).collect()
    }

    /// As [`check_dimension`], without a name of a parameter.
    pub fn check_dimension(&self, typed: &Typed, wanted: Dimension, what: &str) -> Option<Diagnostic> {
        check_dimension(self.graph, typed, wanted, what)
    }

    /// Evaluates a constant number of the dimension `wanted`, in SI.
    pub fn scalar(&mut self, value: &Value, wanted: Dimension, diagnostics: &mut Vec<Diagnostic>) -> Option<f64> {
        self.numbers(value, Kind::Scalar, wanted, diagnostics).map(|v| v[0])
    }

    /// Evaluates a constant vector of the dimension `wanted`, in SI.
    pub fn vector(&mut self, value: &Value, wanted: Dimension, diagnostics: &mut Vec<Diagnostic>) -> Option<[f64; 3]> {
        self.numbers(value, Kind::Vector, wanted, diagnostics).map(|v| [v[0], v[1], v[2]])
    }

    /// Evaluates constant positions for some joints, each with its span: one number for all joints, or a list with one
    /// number per joint, with or without a unit behind the list.
    pub fn per_joint(
        &mut self,
        value: &Value,
        dofs: &[usize],
        model: &Model,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Vec<(f64, Span)>> {
        let before = diagnostics.len();
        let Some(items) = joint_items(value, dofs.len(), diagnostics)? else {
            let all: Option<Vec<(f64, Span)>> = dofs
                .iter()
                .map(|&d| Some((self.scalar(value, joint_dimension(model, d), diagnostics)?, value.span)))
                .collect();
            if let (Some(all), Some(&d)) = (&all, dofs.first()) {
                self.usual_position(value, all[0].0, joint_dimension(model, d), diagnostics);
            }
            return all;
        };
        let all: Vec<Option<(f64, Span)>> = items
            .iter()
            .zip(dofs)
            .map(|(item, &d)| Some((self.scalar(item, joint_dimension(model, d), diagnostics)?, item.span)))
            .collect();
        merge_bare(diagnostics, before, value.span);
        one_unit(diagnostics, before, value, items.len());
        let all: Option<Vec<(f64, Span)>> = all.into_iter().collect();
        for ((item, (x, _)), &d) in items.iter().zip(all.iter().flatten()).zip(dofs) {
            self.usual_position(item, *x, joint_dimension(model, d), diagnostics);
        }
        all
    }

    /// Warns of a position of a joint that has an unusual size.
    fn usual_position(&self, value: &Value, x: f64, unit: Dimension, diagnostics: &mut Vec<Diagnostic>) {
        diagnostics.extend(unusual(value, "a position", &[x], &of_joint(unit)));
    }
}

/// Items of a list with one value per joint; a unit behind the list applies to each. Returns `Some(None)` if one value
/// counts for all joints, and `None` if the list has another length.
pub fn joint_items(value: &Value, joints: usize, diagnostics: &mut Vec<Diagnostic>) -> Option<Option<Vec<Value>>> {
    let Some(items) = with_units(value) else { return Some(None) };
    if items.len() != joints {
        diagnostics.push(
            Diagnostic::error("HQ0310", value.span, format!("{joints} joints, and {} values", items.len()))
                .here(format!("{} values", items.len()))
                .help("give one value for each joint, or a single one for all"),
        );
        return None;
    }
    Some(Some(items))
}

/// Items of a list, each with the unit behind the list. Returns `None` if the value is not a list.
pub fn with_units(value: &Value) -> Option<Vec<Value>> {
    match &value.kind {
        ValueKind::List(items) => Some(items.clone()),
        ValueKind::Unit(inner, unit) => match &inner.kind {
            ValueKind::List(items) => {
                let one = |i: &Value| Value { kind: ValueKind::Unit(Box::new(i.clone()), unit.clone()), span: i.span };
                Some(items.iter().map(one).collect())
            }
            _ => None,
        },
        _ => None,
    }
}

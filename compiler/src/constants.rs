//! Values that are needed before anything moves: declared `param`s, and constants in robot and run blocks.

use std::collections::BTreeMap;

use dsl::tree::{Param, Value, ValueKind};
use dsl::{Diagnostic, Span};
use robot::{DofUnit, Model};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, NONE};

use crate::expr::{Graph, Kind, Lowering, Scope, Symbol, Typed};
use crate::robot_binding::items_of;
use crate::units;

/// Declared parameters, typed; the graph that their values stand in.
pub struct Constants<'a> {
    /// The graph of the whole program.
    pub graph: &'a mut Graph,
    /// Parameters by name.
    pub params: BTreeMap<String, Symbol>,
    /// Parameters that something used.
    pub used: std::collections::BTreeSet<String>,
}

/// The scope of an expression that may name parameters only.
struct ParamsOnly<'s> {
    params: &'s BTreeMap<String, Symbol>,
    used: &'s mut std::collections::BTreeSet<String>,
}

impl Scope for ParamsOnly<'_> {
    fn name(&mut self, name: &str) -> Option<Symbol> {
        let symbol = self.params.get(name).cloned();
        if symbol.is_some() {
            self.used.insert(name.to_string());
        }
        symbol
    }

    fn names(&self) -> Vec<String> {
        self.params.keys().cloned().collect()
    }

    fn initial(&mut self, _: &mut Graph, _: &Value, span: Span) -> Result<Typed, Box<Diagnostic>> {
        Err(Box::new(
            Diagnostic::error("HQ0311", span, "`initial(..)` has no meaning here")
                .note("it captures a value when a stack becomes active, and this value is needed before"),
        ))
    }
}

/// rad or m.
pub fn joint_dimension(model: &Model, dof: usize) -> Dimension {
    match model.dofs.get(dof).map(|d| d.unit) {
        Some(DofUnit::Metre) => LENGTH,
        _ => ANGLE,
    }
}

/// The value of a joint written as a plain number with or without a unit, in SI.
pub fn plain_joint_value(value: &Value) -> Option<f64> {
    match &value.kind {
        ValueKind::Number(n) => Some(n.value),
        ValueKind::Negate(inner) => plain_joint_value(inner).map(|x| -x),
        ValueKind::Unit(inner, unit) => Some(plain_joint_value(inner)? * units::meaning(unit).ok()?.0),
        _ => None,
    }
}

/// The diagnostic for a value of another dimension than is needed.
pub fn wrong_dimension(typed: &Typed, wanted: Dimension, what: &str) -> Diagnostic {
    let is = typed.dimension.describe();
    let d =
        Diagnostic::error("HQ0301", typed.span, format!("{what} is {}, and this is {is}", wanted.describe())).here(is);
    match units::symbols_of(wanted).first() {
        _ if typed.dimension == NONE && wanted != NONE => d.help(format!("give it a unit: `{wanted}`")),
        Some(symbol) => d.help(format!("write a number in `{symbol}`")),
        None => d.help(format!("its unit is `{wanted}`").replace("`1/", "`/")),
    }
}

impl Constants<'_> {
    /// Types a declared parameter. A second one of the same name, or one without a value, is reported.
    pub fn declare(&mut self, param: &Param, diagnostics: &mut Vec<Diagnostic>) {
        if let Some(first) = self.params.get(&param.name.value) {
            diagnostics.push(
                Diagnostic::error("HQ0202", param.name.span, format!("`{}` is declared twice", param.name.value))
                    .label(first.declared, "first here"),
            );
            return;
        }
        if ["pi", "t", "time", "true", "false", "auto"].contains(&param.name.value.as_str()) {
            diagnostics.push(
                Diagnostic::error(
                    "HQ0202",
                    param.name.span,
                    format!("`{}` is a word of the language", param.name.value),
                )
                .help("choose another name"),
            );
            return;
        }
        let Some(value) = self.typed(&param.value, diagnostics) else { return };
        if let Some(bad) = self.not_constant(&value) {
            diagnostics.push(bad);
            return;
        }
        self.params.insert(param.name.value.clone(), Symbol { value, declared: param.name.span });
    }

    /// Types a value that may name parameters only.
    pub fn typed(&mut self, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let mut scope = ParamsOnly { params: &self.params, used: &mut self.used };
        Lowering { graph: self.graph, scope: &mut scope, diagnostics }.value(value).ok()
    }

    fn not_constant(&self, typed: &Typed) -> Option<Diagnostic> {
        for &n in &typed.nodes {
            match self.graph.constant(n) {
                None => {
                    return Some(
                        Diagnostic::error(
                            "HQ0307",
                            typed.span,
                            "this value depends on time, and it is needed before time begins",
                        )
                        .help("leave `t` and `time` out"),
                    );
                }
                Some(x) if !x.is_finite() => {
                    return Some(Diagnostic::error("HQ0309", typed.span, "this value is not a finite number"));
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
            diagnostics.push(Diagnostic::error(
                "HQ0304",
                value.span,
                format!("{} is needed here, and this is {}", kind.describe(), typed.kind.describe()),
            ));
            return None;
        }
        if let Some(d) = self.fits(&typed, wanted, "the value needed here") {
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

    /// Whether a value fits a dimension; a diagnostic otherwise, a warning for a bare number that is read as an angle.
    /// A bare number is SI for every other dimension.
    pub fn fits(&self, typed: &Typed, wanted: Dimension, what: &str) -> Option<Diagnostic> {
        fits(self.graph, typed, wanted, what)
    }

    /// A constant number of a dimension, in SI.
    pub fn scalar(&mut self, value: &Value, wanted: Dimension, diagnostics: &mut Vec<Diagnostic>) -> Option<f64> {
        self.numbers(value, Kind::Scalar, wanted, diagnostics).map(|v| v[0])
    }

    /// A constant vector of a dimension, in SI.
    pub fn vector(&mut self, value: &Value, wanted: Dimension, diagnostics: &mut Vec<Diagnostic>) -> Option<[f64; 3]> {
        self.numbers(value, Kind::Vector, wanted, diagnostics).map(|v| [v[0], v[1], v[2]])
    }

    /// The position of a joint whose unit is not known yet.
    pub fn joint_value(&mut self, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<f64> {
        let typed = self.typed(value, diagnostics)?;
        if !ANGLE.accepts(typed.dimension) && typed.dimension != LENGTH || typed.kind != Kind::Scalar {
            diagnostics.push(Diagnostic::error(
                "HQ0301",
                value.span,
                format!("a joint's position is an angle or a length, and this is {}", typed.dimension.describe()),
            ));
            return None;
        }
        if let Some(bad) = self.not_constant(&typed) {
            diagnostics.push(bad);
            return None;
        }
        self.graph.constant(typed.nodes[0])
    }

    /// Constant positions for some joints: one number for all, or a list with one each, with or without a unit behind it.
    pub fn per_joint(
        &mut self,
        value: &Value,
        dofs: &[usize],
        model: &Model,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Vec<f64>> {
        let (items, unit) = match &value.kind {
            ValueKind::Unit(inner, unit) if matches!(inner.kind, ValueKind::List(_)) => (items_of(inner), Some(unit)),
            ValueKind::List(_) => (items_of(value), None),
            _ => {
                return dofs.iter().map(|&d| self.scalar(value, joint_dimension(model, d), diagnostics)).collect();
            }
        };
        if items.len() != dofs.len() {
            diagnostics.push(
                Diagnostic::error("HQ0310", value.span, format!("{} joints, and {} values", dofs.len(), items.len()))
                    .help("give one value for each joint, or a single one for all"),
            );
            return None;
        }
        let mut out = Vec::new();
        for (item, &dof) in items.iter().zip(dofs) {
            let with_unit = match unit {
                Some(u) => Value { kind: ValueKind::Unit(Box::new(item.clone()), u.clone()), span: item.span },
                None => item.clone(),
            };
            out.push(self.scalar(&with_unit, joint_dimension(model, dof), diagnostics)?);
        }
        Some(out)
    }
}

/// See [`Constants::fits`].
pub fn fits(graph: &Graph, typed: &Typed, wanted: Dimension, what: &str) -> Option<Diagnostic> {
    let zero = typed.nodes.iter().all(|&n| graph.constant(n) == Some(0.0));
    if typed.kind == Kind::Rotation || wanted == typed.dimension || (zero && typed.dimension == NONE) {
        return None;
    }
    if typed.bare {
        let angular = wanted.rad != 0;
        return angular.then(|| {
            Diagnostic::warning("HQ0305", typed.span, "a bare number is read as radians here")
                .help(format!("write `{wanted}`, or `deg`, behind it").replace("`1/", "`/"))
        });
    }
    if wanted.accepts(typed.dimension) { None } else { Some(wrong_dimension(typed, wanted, what)) }
}

//! Values that are needed before anything moves: declared `param`s, and constants in robot and run blocks.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::{BinaryOp, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use robot::{DofUnit, Model};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, NONE, RATE, TIME};

use crate::expr::{
    FUNCTIONS, Frame, Graph, Kind, Lowering, Meaning, Now, Scope, Symbol, TRAJECTORIES, Typed, bracketed,
};
use crate::forms::target;
use crate::units;

/// True for a name that the language gives a meaning of its own.
pub fn is_word(name: &str) -> bool {
    let words = [
        "pi",
        "t",
        "time",
        "true",
        "false",
        "auto",
        "initial",
        "frame",
        "joint",
        "com",
        "and",
        "or",
        "not",
        "present",
        "uncertainty",
        "field",
    ];
    words.contains(&name) || FUNCTIONS.iter().any(|f| f.name == name) || TRAJECTORIES.iter().any(|t| t.name == name)
}

/// A human: points that are tracked.
#[derive(Clone, Debug, PartialEq)]
pub struct Human {
    /// The names of its points, each with the number that says whether it is present, and that of its uncertainty.
    pub points: Vec<(String, usize, usize)>,
    /// Segments between two points, by the points' places.
    pub links: Vec<(usize, usize)>,
    /// Whether its points are held when their readings stop.
    pub held: bool,
}

/// What is known of the declared parameters, and of other named values.
#[derive(Debug, Default)]
pub struct Params {
    /// Values by name.
    pub symbols: BTreeMap<String, Symbol>,
    /// Those whose value is wrong. They were reported, and who uses one stays silent.
    pub failed: BTreeSet<String>,
    /// Named expressions of what the robot does, until the robot is known.
    pub later: BTreeSet<String>,
    /// Those that something used.
    pub used: BTreeSet<String>,
    /// Signals with the number of the table of signals that says whether they are present.
    pub presence: BTreeMap<String, usize>,
    /// Signals that are wrenches.
    pub wrenches: BTreeSet<String>,
    /// Humans. A point stands among the symbols under a name that cannot be written.
    pub humans: BTreeMap<String, Human>,
    /// Safety fields. The value of one stands among the symbols under a name that cannot be written.
    pub fields: BTreeSet<String>,
    /// Events that the host raises, and where they were declared.
    pub events: BTreeMap<String, Span>,
}

impl Params {
    /// What a name means, where it is a parameter.
    pub fn meaning(&mut self, name: &str) -> Meaning {
        let name = target(name);
        if self.failed.contains(name) {
            return Meaning::Failed;
        }
        if self.later.contains(name) {
            return Meaning::Later;
        }
        match self.symbols.get(name) {
            Some(symbol) => {
                self.used.insert(name.to_string());
                Meaning::Value(symbol.clone())
            }
            None if self.wrenches.contains(name) => Meaning::Wrench,
            None if self.humans.contains_key(name) => {
                self.used.insert(name.to_string());
                Meaning::Human(self.humans[name].clone())
            }
            None if self.fields.contains(name) => {
                self.used.insert(name.to_string());
                Meaning::Field
            }
            None if self.events.contains_key(name) => Meaning::Event,
            None => Meaning::Unknown,
        }
    }

    /// The number that says whether a signal is present.
    pub fn presence(&mut self, name: &str) -> Option<usize> {
        let name = target(name);
        let at = self.presence.get(name).copied()?;
        self.used.insert(name.to_string());
        Some(at)
    }

    /// True for the name of a value.
    pub fn knows(&self, name: &str) -> bool {
        let name = target(name);
        self.wrenches.contains(name)
            || self.humans.contains_key(name)
            || self.fields.contains(name)
            || self.symbols.contains_key(name)
            || self.failed.contains(name)
            || self.later.contains(name)
    }

    /// All names that can be written.
    pub fn names(&self) -> Vec<String> {
        self.symbols
            .keys()
            .chain(self.humans.keys())
            .chain(&self.fields)
            .chain(&self.failed)
            .filter(|n| !n.contains('.'))
            .cloned()
            .collect()
    }
}

/// Values that are needed before anything moves: the graph that they stand in, and what they may name.
pub struct Constants<'a> {
    /// The graph of the whole program.
    pub graph: &'a mut Graph,
    /// Declared parameters.
    pub params: &'a mut Params,
}

/// The scope of an expression that may name parameters only.
struct ParamsOnly<'s>(&'s mut Params);

impl Scope for ParamsOnly<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        self.0.meaning(name)
    }

    fn names(&self) -> Vec<String> {
        self.0.names()
    }

    fn presence(&mut self, name: &str) -> Option<usize> {
        self.0.presence(name)
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
            Diagnostic::error("HQ0314", name.span, "axes of the robot have no meaning here")
                .note("a param and the description of a robot stand before any task; the numbers of a point count along its own link")
                .help(format!("leave `in {0}` out here, and write it where the value is used", name.value)),
        );
        None
    }

    fn now(&mut self, _: &mut Graph, _: &Now, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        diagnostics.push(
            Diagnostic::error("HQ0312", span, "what the robot does now has no meaning here")
                .note("this value is needed before the robot moves")
                .help("write a constant here, or the expression in the parameters of a task `keep` or `track`"),
        );
        None
    }
}

/// rad or m.
pub fn joint_dimension(model: &Model, dof: usize) -> Dimension {
    match model.dofs.get(dof).map(|d| d.unit) {
        Some(DofUnit::Metre) => LENGTH,
        _ => ANGLE,
    }
}

/// The diagnostic for a value of another dimension than is needed. `what` is the parameter in backquotes, or empty.
pub fn wrong_dimension(typed: &Typed, wanted: Dimension, what: &str) -> Diagnostic {
    let (is, needed) = (typed.dimension.describe(), wanted.describe());
    let message = if what.is_empty() {
        format!("{needed} is needed here, and this is {is}")
    } else {
        format!("{what} is {needed}, and this is {is}")
    };
    let d = Diagnostic::error("HQ0301", typed.span, message).here(is);
    let unit = units::written(wanted);
    if wanted == NONE {
        d.help("leave the unit out, or divide by a value of the same unit")
    } else if typed.dimension == NONE {
        d.help(format!("give it a unit, such as `{unit}`"))
    } else if wanted == RATE && typed.dimension == TIME {
        d.help("a time T is the rate 1/T: write `100 Hz` for 10 ms")
    } else {
        d.help(format!("write a number in `{unit}`"))
    }
}

/// The help for `1/2 m`, where the unit belongs to the 2 alone, if the unit behind the whole has the dimension.
pub fn unit_of_divisor(value: &Value, wanted: Dimension) -> Option<String> {
    let ValueKind::Binary(op, left, right) = &value.kind else { return None };
    let ValueKind::Unit(_, unit) = &right.kind else { return None };
    let (_, dimension) = units::meaning(unit).ok()?;
    let fits = op.value == BinaryOp::Div && wanted.accepts(dimension) && wanted != NONE;
    let meant = bracketed(op.value, left, right).filter(|_| fits)?;
    Some(format!("a unit belongs to the number before it: write `{meant}`"))
}

impl Constants<'_> {
    /// Types a value that must not move.
    pub(crate) fn constant(&mut self, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let typed = self.typed(value, diagnostics)?;
        let bad = self.not_constant(&typed);
        let good = bad.is_none();
        diagnostics.extend(bad);
        good.then_some(typed)
    }

    /// Types a value that may name parameters only.
    pub fn typed(&mut self, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let mut scope = ParamsOnly(self.params);
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
                            "this value depends on time or on a signal, and it is needed before time begins",
                        )
                        .help("leave `t`, `time` and signals out"),
                    );
                }
                Some(x) if !x.is_finite() => {
                    return Some(
                        Diagnostic::error("HQ0309", typed.span, "this value is not a finite number")
                            .help("look for a division by zero, or for factors that are far too large"),
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
            diagnostics.push(Diagnostic::error(
                "HQ0304",
                value.span,
                format!("{} is needed here, and this is {}", kind.describe(), typed.kind.describe()),
            ));
            return None;
        }
        if let Some(mut d) = self.fits(&typed, wanted, "") {
            d.help = unit_of_divisor(value, wanted).or(d.help);
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

    /// Constant positions for some joints, each with the place that it was written at: one number for all, or a list
    /// with one each, with or without a unit behind it.
    pub fn per_joint(
        &mut self,
        value: &Value,
        dofs: &[usize],
        model: &Model,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Vec<(f64, Span)>> {
        let before = diagnostics.len();
        let Some(items) = joint_items(value, dofs.len(), diagnostics)? else {
            let all =
                dofs.iter().map(|&d| Some((self.scalar(value, joint_dimension(model, d), diagnostics)?, value.span)));
            return all.collect();
        };
        let all: Vec<Option<(f64, Span)>> = items
            .iter()
            .zip(dofs)
            .map(|(item, &d)| Some((self.scalar(item, joint_dimension(model, d), diagnostics)?, item.span)))
            .collect();
        merge_bare(diagnostics, before, value.span);
        one_unit(diagnostics, before, value, items.len());
        all.into_iter().collect()
    }
}

/// A wrong unit behind a list is one mistake, and not one for each of its items.
pub fn one_unit(diagnostics: &mut Vec<Diagnostic>, before: usize, value: &Value, items: usize) {
    let new = diagnostics.get_mut(before..).unwrap_or_default();
    let all = items == new.len() && new.iter().all(|d| d.code == "HQ0301" && d.message == new[0].message);
    if let (ValueKind::Unit(..), true, Some(first)) = (&value.kind, all, new.first_mut()) {
        first.primary.span = value.span;
        diagnostics.truncate(before + 1);
    }
}

/// The items of a list with one value for each joint, a unit behind the list given to each of them; `Some(None)` where
/// one value stands for all, `None` where the list has another length.
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

/// The items of a list, each with the unit that stands behind the list. `None` for what is no list.
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

/// Whether a value from the command line may stand in the place of a parameter's own.
pub(crate) fn replaces(graph: &Graph, new: &Typed, own: &Typed, name: &Spanned<String>) -> Option<Diagnostic> {
    let what = format!("`{}`", name.value);
    let d = if new.kind != own.kind {
        let text = format!("{what} is {}, and this is {}", own.kind.describe(), new.kind.describe());
        Some(Diagnostic::error("HQ0304", new.span, text))
    } else if own.bare {
        None
    } else {
        fits(graph, new, own.dimension, &what)
    };
    d.map(|d| d.label(name.span, "declared here"))
}

/// See [`Constants::fits`].
pub fn fits(graph: &Graph, typed: &Typed, wanted: Dimension, what: &str) -> Option<Diagnostic> {
    let zero = typed.nodes.iter().all(|&n| graph.constant(n) == Some(0.0));
    if matches!(typed.kind, Kind::Rotation | Kind::Pose)
        || wanted == typed.dimension
        || (zero && typed.dimension == NONE)
    {
        return None;
    }
    if typed.bare {
        return (wanted.rad != 0).then(|| bare_angle(graph, typed, wanted));
    }
    if wanted.accepts(typed.dimension) { None } else { Some(wrong_dimension(typed, wanted, what)) }
}

/// The warning for a bare number that is read as an angle; a stronger one where it is more than a turn.
pub fn bare_angle(graph: &Graph, typed: &Typed, wanted: Dimension) -> Diagnostic {
    let unit = units::written(wanted);
    let degrees = unit.replacen("rad", "deg", 1);
    let largest = typed.nodes.iter().filter_map(|&n| graph.constant(n)).fold(0.0_f64, |a, x| a.max(x.abs()));
    let turns = largest / (2.0 * std::f64::consts::PI);
    if turns > 1.0 {
        Diagnostic::warning("HQ0305", typed.span, format!("without a unit this is read as {largest} {unit}"))
            .here(format!("{turns:.1} turns{}", unit.trim_start_matches("rad")))
            .note("angles without a unit are radians, and this one looks like degrees")
            .help(format!("write `{degrees}` behind it, or `{unit}` if it is meant"))
    } else {
        Diagnostic::warning("HQ0305", typed.span, format!("without a unit this is read as `{unit}`"))
            .help(format!("write `{unit}` behind it, or `{degrees}` if degrees are meant"))
    }
}

/// Several bare angles in one list or call are one slip: the warnings since `from` become one for the whole of it.
pub fn merge_bare(diagnostics: &mut Vec<Diagnostic>, from: usize, span: Span) {
    let mut bare: Vec<Diagnostic> = diagnostics.extract_if(from.., |d| d.code == "HQ0305").collect();
    let most = bare.iter().position(|d| !d.notes.is_empty()).unwrap_or(0);
    if bare.len() > 1 {
        let mut one = bare.swap_remove(most);
        one.primary.span = span;
        one.message = one.message.replace("without a unit this is", "without a unit these numbers are");
        if let Some((start, rest)) = one.message.split_once("read as ").filter(|_| !one.notes.is_empty()) {
            one.message = format!("{start}read as radians, one of them as {rest}");
        }
        one.help = one.help.map(|h| h.replace("behind it", "behind them"));
        diagnostics.push(one);
    } else {
        diagnostics.append(&mut bare);
    }
}

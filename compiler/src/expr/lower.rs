//! From a written value to a typed expression, with every mistake said where it was made.

use dsl::tree::{BinaryOp, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::Op;
use stdlib_tasks::dimension::{ANGLE, Dimension, NONE, TIME};

use super::functions::{self, CallError, FUNCTIONS};
use super::helps::{bracketed, count, elsewhere, families, help_for_kinds, help_for_sum};
use super::ops::{self, Mismatch};
use super::present::{Now, PRESENT};
use super::trajectories::{self, TRAJECTORIES, needs_from};
use super::{Axes, Frame, Graph, Kind, Start, Typed, frames};
use crate::codes;
use crate::constants::{Human, bare_angle, merge_bare};
use crate::names::suggest;
use crate::units;

/// Something that a name in an expression can mean.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Its value.
    pub value: Typed,
    /// Where it was declared.
    pub declared: Span,
}

/// What a name means.
#[derive(Clone, Debug)]
pub enum Meaning {
    /// A value.
    Value(Symbol),
    /// A declaration that was wrong, and reported; who uses it stays silent.
    Failed,
    /// A named expression of what the robot does, which has no value before the robot is known.
    Later,
    /// A signal with a force and a moment.
    Wrench,
    /// A person, whose points are tracked.
    Human(Human),
    /// A safety field, whose value is asked for by `field(NAME)`.
    Field,
    /// An event, which is no value.
    Event,
    /// Nothing.
    Unknown,
}

/// What names mean where an expression stands.
pub trait Scope {
    /// What a name means that is not built in.
    fn name(&mut self, name: &str) -> Meaning;
    /// Names that could have been meant.
    fn names(&self) -> Vec<String>;
    /// The number of the table of signals that says whether a signal is present; none where a name is that of no signal.
    fn presence(&mut self, name: &str) -> Option<usize>;
    /// What to write where the name is that of a part of the robot, or no value for another reason.
    fn instead(&self, _name: &str) -> Option<String> {
        None
    }
    /// The value that `initial(ARGUMENT)` captures. `None` where nothing can be captured; the diagnostics say why.
    fn initial(
        &mut self,
        graph: &mut Graph,
        argument: &Value,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed>;
    /// Where a trajectory begins, whose argument `from` is given or not. `None` where that has no meaning here; the
    /// diagnostics say why.
    fn start(
        &mut self,
        _graph: &mut Graph,
        from: Option<&Value>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Start> {
        if from.is_some() {
            return Some(Start::Written);
        }
        diagnostics.push(needs_from(span));
        None
    }
    /// The axes that a name behind `in` means. `None` where it means none here; the diagnostics say why.
    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame>;
    /// What the robot does now. `None` where it has no meaning here; the diagnostics say why.
    fn now(&mut self, graph: &mut Graph, what: &Now, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed>;
    /// What is measured in a scenario: a call of one of [`MEASURES`]. `None` where it has no meaning here; the
    /// diagnostics say why.
    fn measured(
        &mut self,
        _graph: &mut Graph,
        function: &Spanned<String>,
        _args: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        let text = format!("`{}(..)` has no meaning here", function.value);
        diagnostics.push(
            Diagnostic::error("HQ0312", span, text)
                .note("it is measured from outside while a scenario runs, and no controller knows it")
                .help("write it behind `expect` in a scenario"),
        );
        None
    }
}

/// The functions that expectations know, of what is measured while a scenario runs.
pub const MEASURES: &[&str] = &["margin", "error", "in", "fault", "speed"];

/// A value cannot be typed; the diagnostics say why.
pub struct Failed;

/// Lowers values into a graph.
pub struct Lowering<'a> {
    /// Where nodes go.
    pub graph: &'a mut Graph,
    /// What names mean.
    pub scope: &'a mut dyn Scope,
    /// Where mistakes go.
    pub diagnostics: &'a mut Vec<Diagnostic>,
}

impl Lowering<'_> {
    pub(super) fn fail<T>(&mut self, diagnostic: Diagnostic) -> Result<T, Failed> {
        self.diagnostics.push(diagnostic);
        Err(Failed)
    }

    /// Types a value and brings it to SI.
    ///
    /// # Errors
    /// It has no type; the diagnostics say why.
    pub fn value(&mut self, value: &Value) -> Result<Typed, Failed> {
        let span = value.span;
        let scalar = |node: usize, dimension: Dimension, bare: bool| Typed {
            kind: Kind::Scalar,
            dimension,
            nodes: vec![node],
            bare,
            axes: Axes::default(),
            span,
        };
        match &value.kind {
            ValueKind::Missing => Err(Failed),
            ValueKind::Number(n) => Ok(scalar(self.graph.number(n.value), NONE, true)),
            ValueKind::Unit(inner, unit) => {
                let inner = self.value(inner)?;
                // A bare angle was warned of where it was given.
                if units::is_assumed(unit) && !inner.bare {
                    return Ok(Typed { span, ..inner });
                }
                let (factor, dimension) = match units::meaning(unit) {
                    Ok(x) => x,
                    Err(e) => return self.fail(codes::unit_error(&e, unit.span)),
                };
                self.scaled(inner, factor, dimension, span)
            }
            ValueKind::Text(_) => self.fail(
                Diagnostic::error("HQ0304", span, "this is text, and a number is needed here")
                    .help("write it without quotes"),
            ),
            ValueKind::Name(name) => self.name(name, span),
            ValueKind::Call(function, args) => self.call(function, args, span),
            ValueKind::Named(..) => self.fail(
                Diagnostic::error("HQ0214", span, "only an argument of a call has a name").help("leave the name out"),
            ),
            ValueKind::Field(inner, field) => self.field(inner, field, span),
            ValueKind::List(items) => self.list(items, span),
            ValueKind::Block(_) => self.fail(
                Diagnostic::error("HQ0304", span, "these are named values in braces, and a number is needed here")
                    .help("write a number, or `[x, y, z]` for a vector"),
            ),
            ValueKind::Negate(inner) => {
                let a = self.value(inner)?;
                if matches!(a.kind, Kind::Rotation | Kind::Pose) {
                    let text = format!("{} has no negative", a.kind.describe());
                    return self
                        .fail(Diagnostic::error("HQ0304", span, text).help("for the way back write `inverse(..)`"));
                }
                if a.kind == Kind::Truth {
                    let d = Diagnostic::error("HQ0304", span, "a truth value has no negative");
                    return self.fail(d.help("write `(not ..)` for its opposite"));
                }
                let nodes = a.nodes.iter().map(|&n| self.graph.push(Op::Neg(n))).collect();
                let axes = a.axes.scaled(Some(-1.0));
                Ok(Typed { nodes, axes, span, ..a })
            }
            ValueKind::In(inner, frame) => self.in_frame(inner, frame, span),
            ValueKind::Not(inner) => self.not(inner, span),
            ValueKind::Binary(op, left, right) => {
                let (a, b) = (self.value(left), self.value(right));
                let (a, b) = (a?, b?);
                let result = self.binary(op, &a, &b, span);
                // `2^2 m`: the unit was meant for the whole.
                let meant = bracketed(op.value, left, right).filter(|_| op.value == BinaryOp::Pow && result.is_err());
                if let (Some(meant), Some(d)) = (meant, self.diagnostics.last_mut()) {
                    d.help = Some(format!("a unit behind an exponent is the exponent's: write `{meant}`"));
                }
                result
            }
        }
    }

    fn scaled(&mut self, inner: Typed, factor: f64, dimension: Dimension, span: Span) -> Result<Typed, Failed> {
        if matches!(inner.kind, Kind::Rotation | Kind::Pose | Kind::Truth) {
            let text = format!("{} has no unit", inner.kind.describe());
            return self.fail(Diagnostic::error("HQ0304", span, text).help("leave the unit out"));
        }
        let Some(total) = inner.dimension.times(dimension) else {
            return self.fail(codes::unit_error(&units::UnitError::TooLarge, span));
        };
        let f = self.graph.number(factor);
        let nodes = inner.nodes.iter().map(|&n| self.graph.push(Op::Mul(n, f))).collect();
        Ok(Typed { dimension: total, nodes, bare: false, span, ..inner })
    }

    fn name(&mut self, name: &str, span: Span) -> Result<Typed, Failed> {
        let scalar = |node: usize, dimension: Dimension| Typed {
            kind: Kind::Scalar,
            dimension,
            nodes: vec![node],
            bare: false,
            axes: Axes::default(),
            span,
        };
        match name {
            "pi" => return Ok(scalar(self.graph.number(std::f64::consts::PI), NONE)),
            "t" => return Ok(scalar(self.graph.push(Op::T), TIME)),
            "com" => return self.now(&Now::Com, span),
            "time" => return Ok(scalar(self.graph.push(Op::Time), TIME)),
            "true" | "false" => {
                let node = self.graph.number(if name == "true" { 1.0 } else { -1.0 });
                return Ok(Typed { kind: Kind::Truth, ..scalar(node, NONE) });
            }
            _ => {}
        }
        match self.scope.name(name) {
            Meaning::Value(symbol) => return Ok(Typed { span, ..symbol.value }),
            Meaning::Failed => return Err(Failed),
            Meaning::Later => {
                let written = crate::forms::written(name);
                let text = format!("`{written}` is made of what the robot does, and this value is needed before");
                let d = Diagnostic::error("HQ0312", span, text);
                return self.fail(d.help("write a constant here; such a `let` may stand in the parameters of tasks"));
            }
            Meaning::Wrench => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is a wrench, which is no single value"));
                return self.fail(d.help(format!("write `{written}.force` or `{written}.moment`")));
            }
            Meaning::Human(human) => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is a person, who is no single value"));
                let points: Vec<String> = human.points.iter().map(|p| format!("`{written}.{}`", p.0)).collect();
                return self.fail(d.help(format!("name one of its points: {}", points.join(", "))));
            }
            Meaning::Field => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error(
                    "HQ0304",
                    span,
                    format!("`{written}` is a safety field, and no number by itself"),
                );
                return self.fail(d.help(format!("write `field({written})` for its value at this moment")));
            }
            Meaning::Event => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is an event, which has no value"));
                return self.fail(d.help(format!("a transition waits for it: `on {written} -> STATE`")));
            }
            Meaning::Unknown => {}
        }
        let mut known = self.scope.names();
        known.extend(["pi", "t", "time", "com"].map(String::from));
        let mut d = Diagnostic::error("HQ0201", span, format!("there is no value called `{name}`"));
        if let Some(help) = self.scope.instead(name) {
            d = d.help(help);
        } else if let Some(near) = suggest(name, known.iter().map(String::as_str)) {
            d = d.help(format!("did you mean `{near}`?"));
        } else if FUNCTIONS.iter().any(|f| f.name == name) {
            d = d.help(format!("`{name}` is a function: write `{name}(..)`"));
        } else if units::symbols().any(|u| u == name) {
            d = d
                .note("a unit stands behind a number or a bracket")
                .help(format!("for the unit write `1 {name}` or `1 /{name}`; for a value declare `param {name} = ..`"));
        } else {
            d = d.help("declare it with `param NAME = VALUE`, or use `t`, `time`, `pi`");
        }
        self.fail(d)
    }

    fn list(&mut self, items: &[Value], span: Span) -> Result<Typed, Failed> {
        let typed: Vec<Result<Typed, Failed>> = items.iter().map(|i| self.value(i)).collect();
        let typed: Vec<Typed> = typed.into_iter().collect::<Result<_, _>>()?;
        if typed.len() != 3 {
            return self.fail(
                Diagnostic::error(
                    "HQ0310",
                    span,
                    format!("a vector has three numbers, and this list has {}", typed.len()),
                )
                .help("write `[x, y, z]`"),
            );
        }
        if let Some(bad) = typed.iter().find(|x| x.kind != Kind::Scalar) {
            return self.fail(
                Diagnostic::error("HQ0304", bad.span, format!("{} cannot be a part of a vector", bad.kind.describe()))
                    .help("a vector is made of three numbers"),
            );
        }
        let mut sum = typed[0].clone();
        for x in &typed[1..] {
            match ops::joined(self.graph, &sum, x) {
                Some(dimension) => sum.dimension = if ops::is_zero(self.graph, &sum) { x.dimension } else { dimension },
                None => {
                    return self.fail(
                        codes::different(&sum, x, "the parts of a vector have one unit", span)
                            .help("give all three the same unit"),
                    );
                }
            }
            if !ops::is_zero(self.graph, x) {
                sum.nodes = x.nodes.clone();
                sum.span = x.span;
            }
        }
        let nodes = typed.iter().map(|x| x.nodes[0]).collect();
        Ok(Typed {
            kind: Kind::Vector,
            dimension: sum.dimension,
            nodes,
            bare: typed.iter().all(|x| x.bare),
            axes: Axes::default(),
            span,
        })
    }

    fn call(&mut self, function: &Spanned<String>, args: &[Value], span: Span) -> Result<Typed, Failed> {
        if let Some(of) = TRAJECTORIES.iter().find(|t| t.name == function.value) {
            return self.trajectory(of, args, span);
        }
        if let Some(arg) = args.iter().find(|a| matches!(a.kind, ValueKind::Named(..))) {
            let form = FUNCTIONS.iter().find(|f| f.name == function.value).map(|f| f.form);
            return self.fail(trajectories::no_names(function, arg, form));
        }
        if function.value == "initial" {
            let [argument] = args else {
                return self.fail(
                    Diagnostic::error("HQ0311", span, format!("`initial` takes one argument, not {}", args.len()))
                        .help("write for instance `initial(frame(left_tool).position)`"),
                );
            };
            return self.scope.initial(self.graph, argument, span, self.diagnostics).ok_or(Failed);
        }
        if function.value == "present" {
            return self.presence(args, span);
        }
        if function.value == "uncertainty" {
            return self.uncertainty(args, span);
        }
        if PRESENT.contains(&function.value.as_str()) {
            return self.present(function, args, span);
        }
        if MEASURES.contains(&function.value.as_str()) {
            return self.scope.measured(self.graph, function, args, span, self.diagnostics).ok_or(Failed);
        }
        let Some(known) = FUNCTIONS.iter().find(|f| f.name == function.value) else {
            let names = FUNCTIONS
                .iter()
                .map(|f| f.name)
                .chain(["initial", "present", "uncertainty"])
                .chain(PRESENT.iter().copied());
            let names = names.chain(TRAJECTORIES.iter().map(|t| t.name));
            let mut d =
                Diagnostic::error("HQ0201", function.span, format!("there is no function `{}`", function.value));
            d = d.help(match (elsewhere(&function.value), suggest(&function.value, names)) {
                (Some(form), _) => format!("it is written `{form}`"),
                (None, Some(near)) => format!("did you mean `{near}`?"),
                (None, None) => families(),
            });
            return self.fail(d);
        };
        let typed: Vec<Result<Typed, Failed>> = args.iter().map(|a| self.value(a)).collect();
        if !known.arity.contains(&args.len()) {
            return self.fail(
                Diagnostic::error(
                    "HQ0310",
                    span,
                    format!("`{}` takes {}, and this call has {}", known.name, count(&known.arity), args.len()),
                )
                .help(format!("write `{}`", known.form)),
            );
        }
        let typed: Vec<Typed> = typed.into_iter().collect::<Result<_, _>>()?;
        let before = self.diagnostics.len();
        for a in typed.iter().enumerate().filter(|(i, _)| functions::is_angle(known.name, *i)).map(|(_, a)| a) {
            if a.kind == Kind::Scalar && a.bare && !ops::is_zero(self.graph, a) {
                self.diagnostics.push(bare_angle(self.graph, a, ANGLE));
            }
        }
        // What is joined with an angle is one.
        let alike: Vec<&Typed> = typed[functions::alike(known.name, typed.len())].iter().collect();
        self.angles_alike(&alike);
        merge_bare(self.diagnostics, before, span);
        let error = match functions::call(self.graph, known.name, &typed, span) {
            Ok(x) => return Ok(x),
            Err(e) => e,
        };
        let d = match error {
            CallError::Argument { index, wanted } => {
                let a = &typed[index];
                let is = if a.kind == Kind::Scalar { a.dimension.describe() } else { a.kind.describe().to_string() };
                let mut d =
                    Diagnostic::error("HQ0306", a.span, format!("`{}` needs {wanted}, and this is {is}", known.name))
                        .here(is);
                if wanted == "an angle" && a.dimension == TIME {
                    d = d.note("a time alone is no angle: something must say how fast the angle grows").help(
                        "divide by a time, such as `2*pi*t/(25 s)`, or multiply with a rate, such as `0.5 rad/s * t`",
                    );
                } else if known.name == "slerp" && a.kind == Kind::Pose {
                    d = d.help("between poses stands `lerp(from, to, share)`");
                } else {
                    d = d.help(format!("the form is `{}`", known.form));
                }
                d
            }
            CallError::Different { first, second } => codes::different(
                &typed[first],
                &typed[second],
                &format!("the arguments of `{}` have one unit", known.name),
                span,
            )
            .help("bring them to one unit"),
            CallError::Axes { first, second } => frames::different(&typed[first], &typed[second], span),
            CallError::Undefined(text) => {
                Diagnostic::error("HQ0309", span, text).help(format!("`{}`: change what it is given", known.form))
            }
        };
        self.fail(d)
    }

    fn binary(&mut self, op: &Spanned<BinaryOp>, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Failed> {
        if !matches!(op.value, BinaryOp::Mul | BinaryOp::Div | BinaryOp::Pow) {
            self.angles_alike(&[a, b]);
        }
        let result = match op.value {
            BinaryOp::Add => ops::additive(self.graph, a, b, Op::Add, span),
            BinaryOp::Sub => ops::additive(self.graph, a, b, Op::Sub, span),
            BinaryOp::Mul => ops::multiply(self.graph, a, b, span),
            BinaryOp::Div => {
                if b.kind == Kind::Scalar && self.graph.constant(b.nodes[0]) == Some(0.0) {
                    return self.fail(
                        Diagnostic::error("HQ0309", b.span, "this divides by zero")
                            .here("zero")
                            .help("change the divisor"),
                    );
                }
                ops::divide(self.graph, a, b, span)
            }
            BinaryOp::Pow => return self.power(a, b, span),
            _ => return self.truth(op, a, b, span),
        };
        let (verb, what) = match op.value {
            BinaryOp::Add => ("add", "to"),
            BinaryOp::Sub => ("subtract", "from"),
            BinaryOp::Mul => ("multiply", "with"),
            _ => ("divide", "by"),
        };
        match result {
            Ok(x) => Ok(x),
            Err(Mismatch::Dimensions) => self.fail(
                codes::different(a, b, &format!("only like can be {verb}ed {what} like"), span)
                    .help(help_for_sum(a, b)),
            ),
            Err(Mismatch::Kinds) => self.fail(
                Diagnostic::error(
                    "HQ0304",
                    op.span,
                    format!("cannot {verb} {} and {}", a.kind.describe(), b.kind.describe()),
                )
                .label(a.span, a.kind.describe())
                .label(b.span, b.kind.describe())
                .help(help_for_kinds(op.value, a.kind, b.kind)),
            ),
            Err(Mismatch::Axes) if op.value == BinaryOp::Mul => self.fail(frames::turned(a, b, span)),
            Err(Mismatch::Axes) => self.fail(frames::different(a, b, span)),
            Err(Mismatch::TooLarge) => self.fail(codes::unit_error(&units::UnitError::TooLarge, span)),
        }
    }

    fn power(&mut self, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Failed> {
        let exponent = self.graph.constant(b.nodes[0]).filter(|_| b.kind == Kind::Scalar && b.dimension == NONE);
        if b.kind == Kind::Scalar && b.dimension != NONE {
            let d = Diagnostic::error("HQ0304", b.span, "an exponent has no unit").here(b.dimension.describe());
            return self
                .fail(d.help("a unit behind an exponent is the exponent's: put the power in brackets, `(2^3) m`"));
        }
        let (Kind::Scalar, Some(exponent)) = (a.kind, exponent) else {
            return self.fail(
                Diagnostic::error("HQ0304", span, "`^` raises a number to a constant whole number")
                    .help("for other powers of a bare number write `exp(y*log(x))`"),
            );
        };
        if exponent.fract() != 0.0 || exponent.abs() > 100.0 {
            return self.fail(
                Diagnostic::error(
                    "HQ0304",
                    b.span,
                    format!("the exponent {exponent} is not a whole number within -100 and 100"),
                )
                .help("for a root write `sqrt(x)`; for other powers of a bare number `exp(y*log(x))`"),
            );
        }
        let n = exponent as i32;
        let Some(dimension) = a.dimension.power(n) else {
            return self.fail(codes::unit_error(&units::UnitError::TooLarge, span));
        };
        let node = self.graph.push(Op::Powi(a.nodes[0], n));
        Ok(Typed { kind: Kind::Scalar, dimension, nodes: vec![node], bare: a.bare, axes: Axes::default(), span })
    }
}

//! Calls: selects the function, and checks the types of its arguments.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use names::suggest;
use stdlib_tasks::dimension::{ANGLE, TIME};

use super::arguments::CallError;
use super::errors;
use super::functions::{self, FUNCTIONS, Family};
use super::helps::{count, elsewhere, families};
use super::robot_state::PRESENT;
use super::scope::{Failed, MEASURES, REACHED};
use super::signals::AGE;
use super::trajectories::{self, TRAJECTORIES};
use super::{Kind, Lowering, Typed, frames, ops, unusual_angle};
use crate::expr::constants::{bare_angle, merge_bare};

impl Lowering<'_> {
    /// Lowers a call.
    pub(super) fn call(&mut self, function: &Spanned<String>, args: &[Value], span: Span) -> Result<Typed, Failed> {
        if let Some(of) = TRAJECTORIES.iter().find(|t| t.name == function.value) {
            return self.trajectory(of, args, span);
        }
        if let Some(arg) = args.iter().find(|a| matches!(a.kind, ValueKind::Named(..))) {
            let form = functions::function(&function.value).map(|f| f.form);
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
        if function.value == AGE {
            return self.age(args, span);
        }
        if PRESENT.contains(&function.value.as_str()) {
            return self.present(function, args, span);
        }
        if MEASURES.contains(&function.value.as_str()) || function.value == REACHED {
            return self.scope.measured(self.graph, function, args, span, self.diagnostics).ok_or(Failed);
        }
        let Some(known) = functions::function(&function.value) else {
            let names = FUNCTIONS
                .iter()
                .map(|f| f.name)
                .chain(["initial", "present", "uncertainty", AGE])
                .chain(PRESENT.iter().copied())
                .chain(MEASURES.iter().copied())
                .chain([REACHED]);
            let names = names.chain(TRAJECTORIES.iter().map(|t| t.name));
            let mut d = Diagnostic::undeclared("function", &function.value, function.span);
            d = match (elsewhere(&function.value), suggest(&function.value, names)) {
                (Some(form), _) => d.help(format!("it is written `{form}`")),
                (None, Some(near)) => d.meant(near),
                (None, None) => d.help(families()),
            };
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
        for a in typed.iter().enumerate().filter(|(i, _)| known.is_angle(*i)).map(|(_, a)| a) {
            if a.kind == Kind::Scalar && a.bare && !ops::is_zero(self.graph, a) {
                self.diagnostics.push(bare_angle(self.graph, a, ANGLE));
            }
        }
        if known.family == Family::Orientations {
            for (a, written) in typed.iter().zip(args).enumerate().filter(|(i, _)| known.is_angle(*i)).map(|(_, a)| a) {
                let x = (a.kind == Kind::Scalar).then(|| self.graph.constant(a.nodes[0])).flatten();
                self.diagnostics.extend(x.and_then(|x| unusual_angle(written, x)));
            }
        }
        // A bare number beside an angle is read as an angle.
        let alike: Vec<&Typed> = known.same_dimension(&typed).iter().collect();
        self.angles_alike(&alike);
        merge_bare(self.diagnostics, before, span);
        let error = match (known.apply)(self.graph, &typed, span) {
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
                    d = d.note("a time is not an angle: multiply it with a rate").help(
                        "divide by a time, such as `2*pi*t/(25 s)`, or multiply with a rate, such as `0.5 rad/s * t`",
                    );
                } else if known.name == "slerp" && a.kind == Kind::Pose {
                    d = d.help("interpolate poses by `lerp(from, to, share)`");
                } else {
                    d = d.help(format!("the form is `{}`", known.form));
                }
                d
            }
            CallError::Different { first, second } => errors::different(
                &typed[first],
                &typed[second],
                &format!("the arguments of `{}` have one unit", known.name),
                span,
            )
            .help("bring them to one unit"),
            CallError::Axes { first, second } => {
                frames::different(&typed[first], &typed[second], span, self.scope.follows())
            }
            CallError::Undefined(text) => {
                Diagnostic::error("HQ0309", span, text).help(format!("`{}`: change its arguments", known.form))
            }
        };
        self.fail(d)
    }
}

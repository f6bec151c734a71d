//! Variables of the machine: their declarations, and the actions that set them. The action `tare`, which sets a bias,
//! is here as well.

use std::collections::BTreeSet;

use dsl::tree::{Action, Value, Variable};
use dsl::{Diagnostic, Help, Snippet, Spanned, Topic};
use names::list;
use runtime::program::{Conditioning, Initial, MachineAction, SignalProgram};
use stdlib_tasks::dimension::Dimension;

use super::Lowerer;
use super::machine::MachineLowering;
use super::signals::{Carries, carries, signal_types};
use crate::expand::{Expanded, Named};
use crate::expr::Kind;
use crate::expr::constants::is_word;
use crate::forms::{target, text_of};

/// Declared variables of the machine.
#[derive(Debug, Default)]
pub(super) struct Variables {
    /// Kind and dimension of each variable, by name.
    kinds: std::collections::BTreeMap<String, (Kind, Dimension)>,
    /// Variables that an action sets.
    set: BTreeSet<String>,
}

/// Types that variables may have.
fn variable_types() -> impl Iterator<Item = &'static str> {
    signal_types().filter(|t| matches!(carries(t), Some(Carries::Quantity(..))))
}

impl Lowerer<'_> {
    /// Declares a variable.
    pub(super) fn variable(&mut self, v: &Variable, variables: &mut Variables) {
        let name = &v.name;
        if is_word(&name.value) {
            let d = Diagnostic::error("HQ0202", name.span, format!("`{}` is a word of the language", name.value));
            self.push(d.help("choose another name"));
        }
        let Some(Carries::Quantity(kind, dimension)) = carries(&v.ty.value) else {
            // The parser reported an unreadable type.
            if !v.ty.value.is_empty() {
                let d = Diagnostic::unknown_name(v.ty.span, format!("no variable has the type `{}`", v.ty.value));
                self.push(
                    d.help(format!("types are {}", list(variable_types(), 30))).nearest(&v.ty.value, variable_types()),
                );
            }
            self.params.failed.insert(name.value.clone());
            return;
        };
        let at = self.interface.width();
        let mut signal = SignalProgram {
            name: name.value.clone(),
            kind: v.ty.value.clone(),
            at,
            len: kind.width(),
            optional: v.optional.is_some(),
            timeout: None,
            conditioning: Conditioning::default(),
            variable: None,
            age_of: None,
            motion: None,
        };
        let value = match &v.value {
            Some(value) => self.held(&signal, value),
            None => {
                if v.optional.is_none() {
                    let text = format!("variable `{}` has no initial value", name.value);
                    let d = Diagnostic::error("HQ0206", name.span, text).about(Topic::MissingKeys(Vec::new()));
                    self.push(d.help("write ` = VALUE` after its type, or `?` after it for one that may be absent"));
                }
                None
            }
        };
        signal.variable = Some(Initial { value });
        self.params.presence.insert(name.value.clone(), at);
        self.interface.signals.push(signal);
        variables.kinds.insert(name.value.clone(), (kind, dimension));
        self.quantity(name, kind, dimension, at + 1);
    }

    /// Initial value of a variable.
    fn held(&mut self, signal: &SignalProgram, value: &Value) -> Option<Vec<f64>> {
        self.constant_of(signal, value, &format!("`{}`", signal.name))
    }

    /// Warns of variables that no action sets.
    pub(super) fn never_set(&mut self, expanded: &Expanded, variables: &Variables) {
        for value in &expanded.values {
            let Named::Variable(v) = value else { continue };
            let name: &Spanned<String> = &v.name;
            if variables.set.contains(&name.value) || !variables.kinds.contains_key(&name.value) {
                continue;
            }
            let text = match &v.value {
                Some(_) => format!("variable `{}` never changes", name.value),
                None => format!("variable `{}` is always absent", name.value),
            };
            let help = match &v.value {
                Some(_) => format!("write `enter set({}, ..)` in a state, or make it a `param`", name.value),
                None => format!("write `enter set({}, ..)` in a state, or remove it", name.value),
            };
            self.push(
                Diagnostic::warning("HQ0712", name.span, text).note("no action of the machine sets it").help(help),
            );
        }
    }
}

impl MachineLowering<'_, '_> {
    /// Variable that an action names.
    fn variable_named(&mut self, verb: &str, value: &Value) -> Option<(usize, String)> {
        let Some(name) = text_of(value).map(|_| named(value)) else {
            let d = Diagnostic::error("HQ0304", value.span, format!("`{verb}` is followed by the name of a variable"));
            self.lowerer
                .push(d.help(format!("write `{verb}({})`", if verb == "set" { "NAME, VALUE" } else { "NAME" })));
            return None;
        };
        let found = self.lowerer.interface.signal(&name).filter(|s| self.lowerer.interface.signals[*s].is_variable());
        if found.is_none() && !self.lowerer.params.failed.contains(&name) {
            let shown = text_of(value).unwrap_or_default();
            let variables: Vec<&str> = self.variables.kinds.keys().map(String::as_str).collect();
            let (message, note) = match self.lowerer.params.knows(&name) {
                _ if self.lowerer.interface.signal(&name).is_some() => {
                    (format!("`{shown}` is a signal, which the host sends"), true)
                }
                true => (format!("`{shown}` is no variable"), false),
                false => (format!("there is no variable `{shown}`"), false),
            };
            let example =
                Snippet::each("variable NAME : number = 0", "variables: { NAME: { type: number, value: 0 } }");
            let d = Diagnostic::unknown_name(value.span, message);
            let d = if note { d.note("the machine sets only its own variables") } else { d };
            self.lowerer
                .push(d.help(Help::with("declare it: {}", [example])).nearest(shown, variables.iter().copied()));
        }
        found.map(|s| (s, name))
    }

    /// Lowers an action that the controller performs itself. Returns `None` if a part of it is wrong, with diagnostics.
    pub(super) fn own(&mut self, a: &Action) -> Option<MachineAction> {
        let first = a.args.first()?;
        match a.verb.value.as_str() {
            "set" => {
                let (variable, name) = self.variable_named("set", first)?;
                let wanted = *self.variables.kinds.get(&name)?;
                self.variables.set.insert(name.clone());
                // The value of `set` is no use of its variable: `set(n, n + 1)` alone does not affect the robot.
                let used = self.lowerer.params.used.contains(&name);
                let what = format!("variable `{}`", text_of(first).unwrap_or_default());
                let value = self.lowerer.binder(self.around.robot).assigned(a.args.get(1)?, wanted, &what);
                if !used {
                    self.lowerer.params.used.remove(&name);
                }
                Some(MachineAction::Set { variable, value: value? })
            }
            "clear" => {
                let (variable, name) = self.variable_named("clear", first)?;
                self.variables.set.insert(name);
                let s = &self.lowerer.interface.signals[variable];
                if !s.optional {
                    let text = format!("variable `{}` is never absent", s.name);
                    let optional = Snippet::of_type("variable", &s.name, format!("{}?", s.kind));
                    let help = Help::with("declare it with `?` after its type, {}", [optional]);
                    self.lowerer.push(Diagnostic::unknown_key("HQ0205", first.span, text).help(help));
                    return None;
                }
                Some(MachineAction::Clear(variable))
            }
            _ => {
                let name = named(first);
                let found = self.lowerer.interface.signal(&name);
                let wrench = found.filter(|s| self.lowerer.interface.signals[*s].kind == "wrench");
                if wrench.is_none() && !self.lowerer.params.failed.contains(&name) {
                    let shown = text_of(first).unwrap_or_default();
                    let text = match found {
                        Some(_) => format!("signal `{shown}` is no wrench"),
                        None => format!("there is no signal `{shown}`"),
                    };
                    let wrenches = self.lowerer.params.wrenches.iter().map(String::as_str);
                    let d = Diagnostic::unknown_name(first.span, text);
                    let d = d.help("name a signal of the type `wrench`").nearest(shown, wrenches);
                    self.lowerer.push(d);
                }
                self.lowerer.params.used.insert(name);
                Some(MachineAction::Tare(wrench?))
            }
        }
    }
}

/// Name in the program that an action refers to.
fn named(value: &Value) -> String {
    match &value.kind {
        dsl::tree::ValueKind::Name(name) => target(name).to_string(),
        _ => text_of(value).unwrap_or_default().to_string(),
    }
}

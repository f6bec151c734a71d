//! Parameters of declarations, arguments in parentheses, and the values of a repetition; both readers share this file.

use crate::Diagnostic;
use crate::diagnostic::clip;
use crate::expr::{Place, missing};
use crate::grammar::{Pair, Rule};
use crate::limits::MAX_PARAMETERS;
use crate::tree::{Comments, Entry, Parameter, Value, Values};
use crate::{Spanned, checks};

/// Converts a node `expr` or `within`.
pub(crate) type ReadExpr<'f> = &'f mut dyn FnMut(Pair<'_>) -> Value;

/// Converts a node `formals`: `(side: arm, gain: rate = 5 /s)`.
pub(crate) fn parameters(
    pair: Pair<'_>,
    place: Place,
    read: ReadExpr<'_>,
    diags: &mut Vec<Diagnostic>,
) -> Vec<Parameter> {
    let mut all: Vec<Parameter> = Vec::new();
    for formal in pair.into_inner() {
        let span = place.of(&formal);
        let (mut name, mut ty, mut default, mut junk) = (None, None, None, None);
        for part in formal.into_inner() {
            match part.as_rule() {
                Rule::name if name.is_none() => name = Some(place.spanned(&part)),
                Rule::name => ty = Some(place.spanned(&part)),
                Rule::within => default = Some(read(part)),
                _ => junk = Some((place.of(&part), part.as_str().trim().to_owned())),
            }
        }
        let form = "write `name: type`, or `name: type = value`";
        if let Some((at, text)) = junk {
            let message = format!("`{}` cannot be read in a list of parameters", clip(&text));
            diags.push(Diagnostic::error("HQ0128", at, message).help(form));
            continue;
        }
        let Some(name) = name else { continue };
        let Some(ty) = ty else {
            let message = format!("the parameter `{}` has no type", clip(&name.value));
            diags.push(Diagnostic::error("HQ0128", name.span, message).help(format!(
                "write for instance `{}: arm`, `{}: point` or `{}: rate = 5 /s`",
                name.value, name.value, name.value
            )));
            continue;
        };
        if all.len() == MAX_PARAMETERS {
            let text = format!("more than {MAX_PARAMETERS} parameters");
            diags.push(
                Diagnostic::error("HQ0190", name.span, text)
                    .here("read up to here")
                    .help("combine numbers into vectors, or declare constants with `param`"),
            );
            break;
        }
        if let Some(first) = all.iter().find(|p| p.name == name) {
            diags.push(checks::duplicate(&name.value, first.name.span, name.span));
            continue;
        }
        all.push(Parameter { name, ty, default, span });
    }
    all
}

/// Converts a node `actuals`: arguments by position, then those by name.
pub(crate) fn arguments(
    pair: Pair<'_>,
    place: Place,
    read: ReadExpr<'_>,
    diags: &mut Vec<Diagnostic>,
) -> (Vec<Value>, Vec<Entry>) {
    let (mut args, mut named): (Vec<Value>, Vec<Entry>) = (Vec::new(), Vec::new());
    for actual in pair.into_inner() {
        let (mut name, mut value) = (None, None);
        for part in actual.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(place.spanned(&part)),
                _ => value = Some(read(part)),
            }
        }
        let Some(value) = value else { continue };
        match (name, named.first()) {
            (Some(key), _) => named.push(Entry { key, value, comments: Comments::default() }),
            (None, None) => args.push(value),
            (None, Some(first)) => {
                diags.push(
                    Diagnostic::error("HQ0123", value.span, "a positional argument follows a named one")
                        .label(first.key.span, "first named argument")
                        .help("write positional arguments first, or name this one too"),
                );
                args.push(value);
            }
        }
    }
    checks::duplicates(&named, diags);
    (args, named)
}

/// Converts a node `values`: `[left, right]`, `1..4`.
pub(crate) fn values(pair: Pair<'_>, place: Place, read: ReadExpr<'_>) -> Values {
    let span = place.of(&pair);
    let mut parts = pair.into_inner();
    let first = parts.next().map_or_else(|| missing(span), &mut *read);
    match parts.next() {
        Some(last) => Values::Range(first, read(last)),
        None => Values::List(first),
    }
}

/// Returns the diagnostic for a repetition without a required part.
pub(crate) fn incomplete(span: crate::Span, what: &str) -> Diagnostic {
    Diagnostic::error("HQ0125", span, format!("this `for` has no {what}"))
}

/// Returns an empty name, for parts that cannot be read.
pub(crate) fn nameless(span: crate::Span) -> Spanned<String> {
    Spanned::new(String::new(), span)
}

//! Actions of a state, `say "text"`, `gripper close`, `capture(head_camera)`; both readers share this file.

use crate::Spanned;
use crate::calls::{self, ReadExpr};
use crate::expr::{Place, missing, quantity, unescape};
use crate::grammar::{Pair, Rule};
use crate::tree::{Entry, Value, ValueKind};
use crate::{Diagnostic, Span};

/// The verb of an action and its arguments.
pub(crate) struct Done {
    pub verb: Spanned<String>,
    pub args: Vec<Value>,
    pub named: Vec<Entry>,
    /// True if written without parentheses.
    pub bare: bool,
}

/// Converts a node `action_call`.
pub(crate) fn call(pair: Pair<'_>, place: Place, read: ReadExpr<'_>, diags: &mut Vec<Diagnostic>) -> Done {
    let mut done = Done { verb: calls::nameless(place.of(&pair)), args: Vec::new(), named: Vec::new(), bare: true };
    for (i, part) in pair.into_inner().enumerate() {
        let span = place.of(&part);
        match part.as_rule() {
            Rule::name if i == 0 => done.verb = place.spanned(&part),
            Rule::name => done.args.push(Value { kind: ValueKind::Name(part.as_str().to_owned()), span }),
            Rule::text => {
                let text = unescape(&part, place, diags);
                done.args.push(Value { kind: ValueKind::Text(text), span });
            }
            Rule::quantity => done.args.push(quantity(part, place, diags)),
            Rule::actuals => {
                (done.args, done.named) = calls::arguments(part, place, &mut *read, diags);
                done.bare = false;
            }
            _ => done.args.push(missing(span)),
        }
    }
    done
}

/// Returns the diagnostic for an action without a verb.
pub(crate) fn nothing(word: &str, span: Span) -> Diagnostic {
    Diagnostic::error("HQ0142", span, format!("`{word}` has no action"))
        .help(format!("write an action, for instance `{word} say \"text\"` or `{word} gripper(close)`"))
}

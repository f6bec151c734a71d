//! Schemas of values: quantities with compatible units, vectors, names.

use compiler::units;
use dsl::Span;
use dsl::tree::Unit;
use serde_json::{Value, json};
use stdlib_tasks::dimension::{Dimension, NONE};
use stdlib_tasks::params::Quantity;

/// Pattern of a user-defined name, which may contain `${side}`.
pub(super) static NAME: &str = r"^(?:[A-Za-z_]|\$\{[-+* A-Za-z0-9_]+\})(?:[A-Za-z0-9_]|\$\{[-+* A-Za-z0-9_]+\})*$";

/// Pattern of the name of a task or stack, with parameters if it has some: `reach(side: arm)`.
pub(super) static HEAD: &str =
    r"^(?:[A-Za-z_]|\$\{[-+* A-Za-z0-9_]+\})(?:[A-Za-z0-9_]|\$\{[-+* A-Za-z0-9_]+\})*(?:\s*\(.*\)\s*)?$";

/// Pattern of a key for joints: a name, which may contain further characters, a group, or a pattern of names.
pub(super) static JOINT_KEY: &str =
    r"^(?:[A-Za-z0-9_*?./:-]|\$\{[-+* A-Za-z0-9_]+\})(?:[A-Za-z0-9_*?./:-]|\$\{[-+* A-Za-z0-9_]+\})*$";

/// Pattern of a plain number before a unit.
static NUMBER: &str = r"[-+]?[0-9]+(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?";

/// Pattern of a list without nested lists.
static LIST: &str = r"\[[^\[\]]*\]";

/// Dimension of a product of units with exponents; `None` if it is too large.
fn dimension(symbols: &[(&str, i32)]) -> Option<Dimension> {
    let factors = symbols.iter().map(|(s, e)| ((*s).to_string(), *e)).collect();
    units::meaning(&Unit { factors, span: Span::default() }).ok().map(|m| m.1)
}

/// Units of one or two symbols that are compatible with a dimension, as alternatives of a pattern.
fn fitting(wanted: Dimension) -> String {
    let fits = |symbols: &[(&str, i32)]| dimension(symbols).is_some_and(|d| wanted.accepts(d));
    let all: Vec<&str> = units::symbols().collect();
    let mut out = Vec::new();
    for a in &all {
        if fits(&[(a, 1)]) {
            out.push((*a).to_string());
        }
        for e in [1, 2] {
            let power = if e == 1 { String::new() } else { format!(r"\^{e}") };
            if e > 1 && fits(&[(a, e)]) {
                out.push(format!("{a}{power}"));
            }
            if fits(&[(a, -e)]) {
                out.push(format!(r"/ ?{a}{power}"));
            }
            for b in &all {
                if fits(&[(a, 1), (b, -e)]) {
                    out.push(format!(r"{a} ?/ ?{b}{power}"));
                }
            }
        }
    }
    out.join("|")
}

/// Pattern of a text in which a plain value (`before`) must have a compatible unit. Longer units, and all other
/// expressions, match.
fn pattern(before: &str, wanted: Dimension) -> String {
    let known = units::symbols().collect::<Vec<_>>().join("|");
    let shape = format!(r"[A-Za-z]+(?:\^2)?(?: ?/ ?(?:{known})(?:\^2)?)?|/ ?(?:{known})(?:\^2)?");
    let fitting = fitting(wanted);
    let behind = if fitting.is_empty() { String::new() } else { format!(r"|^\s*{before}\s*(?:{fitting})\s*$") };
    format!(r"^(?!\s*{before}\s*(?:{shape})\s*$){behind}")
}

/// Describes the compatible units.
fn units_of(wanted: Dimension) -> String {
    if wanted == NONE {
        return "a number without a unit".to_string();
    }
    let mut known = vec![units::written(wanted)];
    for symbol in units::symbols().filter(|s| dimension(&[(s, 1)]) == Some(wanted)) {
        if !known.iter().any(|k| k == symbol) {
            known.push(symbol.to_string());
        }
    }
    format!("a number in {}", known.join(", "))
}

/// A number of a dimension: bare (in SI), or an expression.
pub(super) fn scalar(q: &Quantity) -> Value {
    let mut schema = json!({
        "type": ["number", "string"],
        "pattern": pattern(NUMBER, q.dimension),
        "patternErrorMessage": format!("the unit does not fit: {} is needed", units_of(q.dimension)),
    });
    if q.min.is_finite() {
        schema[if q.min_included { "minimum" } else { "exclusiveMinimum" }] = json!(q.min);
    }
    if q.max.is_finite() {
        schema["maximum"] = json!(q.max);
    }
    schema
}

/// Three numbers: an expression, or a list.
pub(super) fn vector(d: Dimension) -> Value {
    json!({
        "type": ["string", "array"],
        "pattern": pattern(LIST, d),
        "patternErrorMessage": format!("the unit does not fit: each of the three is {}", units_of(d)),
        "items": scalar(&Quantity::any(d)),
        "minItems": 3,
        "maxItems": 3,
    })
}

/// Two numbers: a list with or without a unit after it.
pub(super) fn pair(d: Dimension) -> Value {
    let mut schema = vector(d);
    schema["patternErrorMessage"] = json!(format!("the unit does not fit: each of the two is {}", units_of(d)));
    schema["minItems"] = json!(2);
    schema["maxItems"] = json!(2);
    schema
}

/// One number, or the lower and upper end of a range.
pub(super) fn range(q: &Quantity) -> Value {
    let mut schema = per_axis(q);
    schema["minItems"] = json!(2);
    schema["maxItems"] = json!(2);
    schema
}

/// One number for three axes, or three numbers.
pub(super) fn per_axis(q: &Quantity) -> Value {
    let mut schema = scalar(q);
    schema["type"] = json!(["number", "string", "array"]);
    schema["pattern"] = json!(pattern(&format!("(?:{NUMBER}|{LIST})"), q.dimension));
    schema["items"] = scalar(q);
    schema["minItems"] = json!(3);
    schema["maxItems"] = json!(3);
    schema
}

/// A list of `least` to `most` vectors.
pub(super) fn vectors(least: usize, most: usize, d: Dimension) -> Value {
    json!({ "type": ["string", "array"], "items": vector(d), "minItems": least, "maxItems": most })
}

/// A number or an expression of any dimension, or the three numbers of a vector.
pub(super) fn any() -> Value {
    json!({
        "type": ["number", "string", "array"],
        "items": { "type": ["number", "string"] },
        "minItems": 3,
        "maxItems": 3,
        "minLength": 1,
    })
}

/// A name, or a list of names.
pub(super) fn names() -> Value {
    json!({ "type": ["string", "array"], "minLength": 1, "items": { "type": "string", "minLength": 1 } })
}

/// A name.
pub(super) fn name() -> Value {
    json!({ "type": "string", "minLength": 1 })
}

/// Values by joint, group or pattern: one for all joints, or a list with one per joint. The unit is not checked,
/// because it depends on the joint.
pub(super) fn per_joint() -> Value {
    let each = json!({ "type": ["number", "string"] });
    json!({
        "type": "object",
        "propertyNames": { "pattern": JOINT_KEY },
        "additionalProperties": { "type": ["number", "string", "array"], "items": each },
    })
}

/// An angle by arm, with the dimension `d`.
pub(super) fn per_arm(d: Dimension) -> Value {
    json!({
        "type": "object",
        "propertyNames": { "pattern": NAME },
        "minProperties": 1,
        "additionalProperties": scalar(&Quantity::any(d)),
    })
}

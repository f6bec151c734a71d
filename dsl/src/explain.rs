//! Diagnostics for text that the grammar cannot parse: one per piece, at the exact location.

use crate::diagnostic::{Topic, clip};
use crate::expr::Place;
use crate::fix::Fix;
use crate::grammar::{Grammar, Rule};
use crate::words::nearest_unit;
use crate::{Diagnostic, tree};
use blocks::Help;
use pest::Parser;

/// Context before the unreadable text.
#[derive(Clone, Copy, Debug)]
pub(crate) enum After<'a> {
    /// A key that still needs a value.
    Key(&'a str),
    /// A complete value.
    Value(&'a tree::Value),
    /// The start of a construct, described by the text: it is expected here.
    Start(&'a str),
}

/// Returns the diagnostic for the unreadable `text[start..end]`. If a value should begin there, the strict grammar
/// locates the error. With `unit_only`, a word after a number can only be a unit (YAML scalars, `param`).
pub(crate) fn junk(
    text: &str,
    start: usize,
    end: usize,
    place: Place,
    after: After<'_>,
    unit_only: bool,
) -> Diagnostic {
    let end = start + text[start..end].trim_end().len();
    let region = &text[start..end];
    let at = match after {
        After::Value(_) => start,
        After::Key(_) | After::Start(_) => {
            let rule = if matches!(after, After::Key(_)) { Rule::strict_value } else { Rule::strict_call };
            start
                + match Grammar::parse(rule, region) {
                    Ok(_) => 0,
                    Err(error) => match error.location {
                        pest::error::InputLocation::Pos(at) => at,
                        pest::error::InputLocation::Span((at, _)) => at,
                    },
                }
        }
    };
    let at = at + text[at..end].len() - text[at..end].trim_start().len();
    let mut diagnostic = at_place(text, start, at.min(end), end, place, after, unit_only);
    if matches!(place, Place::Whole(_)) {
        // The place is the whole scalar, and not the piece that a fix would replace.
        diagnostic.fixes.clear();
    }
    diagnostic
}

/// Returns the range of an unquoted name pattern at byte `at`, or just before it: `finger_*`, `arm_?_joint`, `*_elbow`.
pub(crate) fn unquoted_pattern(text: &str, at: usize, after: After<'_>) -> Option<std::ops::Range<usize>> {
    let part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '*' | '?');
    let start = text[..at].trim_end_matches(part).len();
    let end = text[at..].find(|c: char| !part(c)).map_or(text.len(), |n| at + n);
    let word = &text[start..end];
    let named = word.starts_with(|c: char| c.is_ascii_alphabetic() || matches!(c, '_' | '*' | '?'))
        && word.contains(|c: char| c.is_ascii_alphabetic() || c == '_');
    // `a * b` and `a**2` are arithmetic; after a value `*` is an operator.
    let starred = word.starts_with('*') || word.ends_with('*') || word.contains("_*") || word.contains("*_");
    let is_pattern = word.contains('?') || (starred && !matches!(after, After::Value(_)));
    (named && is_pattern && !word.contains("**")).then_some(start..end)
}

/// Returns the diagnostic for a pattern without quotes.
pub(crate) fn needs_quotes(word: &str, span: crate::Span) -> Diagnostic {
    Diagnostic::unreadable("HQ0113", span, "a name pattern must be in quotes").write(format!("\"{word}\""))
}

/// Returns the diagnostic for the character at byte `at` of the piece `start..end`.
fn at_place(
    text: &str,
    start: usize,
    at: usize,
    end: usize,
    place: Place,
    after: After<'_>,
    unit_only: bool,
) -> Diagnostic {
    let rest = &text[at..end];
    let before = text[..at].trim_end();
    let last = before.chars().next_back();
    let Some(first) = rest.chars().next() else { return ends_early(text, start, end, place, after) };
    let one = place.span(at, at + first.len_utf8());
    let word_end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).map_or(end, |n| at + n);
    if let Some(range) = unquoted_pattern(text, at, after) {
        return needs_quotes(&text[range.clone()], place.span(range.start, range.end));
    }
    let follows_operator = last.is_some_and(|c| "+-*/^<>".contains(c)) && before.len() > start;
    match first {
        '\'' => {
            let close = rest[1..].find('\'').map_or(end, |n| at + n + 2);
            let inner = text[at + 1..close].trim_end_matches('\'');
            Diagnostic::error("HQ0109", place.span(at, close), "a text needs double quotes")
                .write(format!("\"{inner}\""))
                .certain()
        }
        '"' if crate::limits::text_end(&text[..end], at).is_none() => {
            Diagnostic::error("HQ0109", place.span(at, end), "this text is not closed")
                .here("no closing `\"` on this line")
                .help("end the text with `\"`; a line break inside it is written `\\n`")
        }
        '#' => Diagnostic::error("HQ0110", place.span(at, end), "`#` does not begin a comment here")
            .help(Help::each("comments in a `.hq` file begin with `//`", "write the comment outside the quotes"))
            .fix(Fix::edit("Begin the comment with `//`", one, "//").certain()),
        '_' if glued_to_digit(text, at) => {
            let from = text[..at].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |n| n + 1);
            let plain: String = text[from..word_end].chars().filter(|c| *c != '_').collect();
            let diagnostic = Diagnostic::error("HQ0111", place.span(from, word_end), "a number must not contain `_`");
            if plain.bytes().all(|b| b.is_ascii_digit()) { diagnostic.write(plain).certain() } else { diagnostic }
        }
        '.' if rest[1..].starts_with(|c: char| c.is_ascii_digit()) && !glued_to_digit(text, at) => {
            let digits = rest[1..].find(|c: char| !c.is_ascii_digit()).map_or(end, |n| at + 1 + n);
            let number = &text[at..digits];
            Diagnostic::error("HQ0111", place.span(at, digits), "a number begins with a digit")
                .write(format!("0{number}"))
                .certain()
        }
        '.' if glued_to_digit(text, at) || rest.starts_with("..") => crate::numbers::point(text, at, end, place),
        '*' if text[..at].ends_with('*') => power(place, at),
        '*' | '/' | '+' | '^' | '-' | '<' | '>' if matches!(after, After::Value(_)) => {
            if rest.starts_with("**") {
                return power(place, at + 1);
            }
            let behind = rest[1..].trim_start();
            let readable = if behind.is_empty() { "" } else { " readable" };
            let message = format!("expected a value{readable} after `{first}`");
            let diagnostic = Diagnostic::unreadable("HQ0114", one, message).here("expects a value on both sides");
            match behind.chars().next() {
                Some(c) if !"})],;".contains(c) => {
                    let next = end - behind.len();
                    let inner = at_place(text, start, next, end, place, After::Start("a value"), unit_only);
                    // An error further inside brackets is reported there.
                    let here = inner.primary.span.start <= place.span(next, next).start;
                    if here && inner.topic == Topic::Unreadable {
                        diagnostic.label(place.span(next, next + c.len_utf8()), "not a value")
                    } else {
                        inner
                    }
                }
                _ => diagnostic.help("delete it, or write the second value"),
            }
        }
        '*' | '/' | '+' | '^' => Diagnostic::unreadable("HQ0114", one, format!("`{first}` has no value before it"))
            .here("expects a value on both sides"),
        ':' | '=' => Diagnostic::error("HQ0108", one, format!("`{first}` is unexpected here"))
            .help(Help::each(
                "in a block, the value follows its key: `d_min 0.5 m`",
                "write one key and one value per line; quote a text as `'\"..\"'`",
            ))
            .fix(Fix::delete(one, &first.to_string())),
        ')' | ']' | '}' if follows_operator => {
            let op = before.len() - 1;
            let sign = &before[op..];
            Diagnostic::unreadable("HQ0114", place.span(op, op + 1), format!("expected a value after `{sign}`"))
                .here("expects a value on both sides")
                .help("delete it, or write the second value")
        }
        ')' | ']' | '}' => match opener(text, start, at) {
            Some((open, c)) => loose(one, first)
                .label(place.span(open, open + 1), format!("this `{c}` is still open"))
                .help(format!("write `{}` first, or check the brackets", closer(c))),
            None => loose(one, first)
                .fix(Fix::delete(one, &first.to_string()))
                .help("delete it, or add the missing opening bracket"),
        },
        '(' | '[' if opener(text, at, end).is_some() => {
            let (open, c) = left_open(text, at, end).unwrap_or((at, first));
            unclosed(place, open, c)
        }
        '[' if at < end && deeper(Rule::list, rest).is_some_and(|n| n > 0) => {
            let inside = at + deeper(Rule::list, rest).unwrap_or(0);
            at_place(text, start, inside, end, place, After::Start("a value"), unit_only)
        }
        '(' => match Grammar::parse(Rule::args, rest) {
            Err(error) if at < end => {
                let inside = match error.location {
                    pest::error::InputLocation::Pos(n) | pest::error::InputLocation::Span((n, _)) => at + n,
                };
                if inside > at {
                    at_place(text, start, inside, end, place, After::Key("this argument"), unit_only)
                } else {
                    Diagnostic::unreadable("HQ0113", one, "`(` is unexpected here")
                }
            }
            _ => Diagnostic::unreadable("HQ0113", one, "`(` is unexpected here")
                .note("arguments follow the function name directly, without a space"),
        },
        ',' => Diagnostic::unreadable("HQ0113", one, "`,` is unexpected here")
            .note("a value is expected between two commas"),
        '{' => match after {
            After::Start(what) => {
                Diagnostic::unreadable("HQ0113", one, format!("{what} is expected here, not a block"))
            }
            _ => Diagnostic::unreadable("HQ0113", one, "a block is not allowed here")
                .note("a block follows a key, a kind (`target { .. }`) or, in a task, its arguments"),
        },
        c if c.is_ascii_alphanumeric() || c == '_' => word(text, start, at, word_end, place, after, unit_only),
        '%' | '&' | '|' | '<' | '>' | '!' | '~' | '?' | '@' | '$' | '\\' | '`' => {
            Diagnostic::unreadable("HQ0113", one, format!("`{first}` is not an operator"))
                .note("expressions have `+ - * / ^`, parentheses, calls such as `sin(x)`, lists and fields")
        }
        c if c.is_control() => Diagnostic::unreadable("HQ0113", one, "unexpected control character"),
        _ => {
            let until = rest.find(char::is_whitespace).map_or(end, |n| at + n);
            // For a letter beyond ASCII, the diagnostic shows the whole word.
            let stem = text[..at].trim_end_matches(|c: char| c.is_alphanumeric() || c == '_').len();
            let at = if first.is_alphabetic() { stem.max(text[..at].rfind('\n').map_or(0, |n| n + 1)) } else { at };
            let until = if first.is_alphabetic() {
                text[at..until].find(|c: char| !(c.is_alphanumeric() || c == '_')).map_or(until, |n| at + n)
            } else {
                until
            };
            let diagnostic = Diagnostic::unreadable(
                "HQ0113",
                place.span(at, until),
                format!("`{}` is unexpected here", clip(&text[at..until])),
            );
            if first.is_alphabetic() {
                diagnostic.note("names consist of the letters A to Z, digits and `_`")
            } else if let After::Start(what) = after {
                diagnostic.note(format!("{what} is expected"))
            } else {
                diagnostic
            }
        }
    }
}

/// Returns the position at which a rule fails; `None` if it does not.
fn deeper(rule: Rule, text: &str) -> Option<usize> {
    match Grammar::parse(rule, text).err()?.location {
        pest::error::InputLocation::Pos(n) | pest::error::InputLocation::Span((n, _)) => Some(n),
    }
}

fn power(place: Place, at: usize) -> Diagnostic {
    let sign = place.span(at - usize::from(at > 0), at + 1);
    Diagnostic::unreadable("HQ0113", sign, "`**` is not an operator")
        .help("a power is written `x^2`")
        .fix(Fix::replace(sign, "^").certain())
}

fn glued_to_digit(text: &str, at: usize) -> bool {
    text[..at].ends_with(|c: char| c.is_ascii_digit())
}

/// Returns the diagnostic for a word that is not allowed here.
fn word(
    text: &str,
    start: usize,
    at: usize,
    end: usize,
    place: Place,
    after: After<'_>,
    unit_only: bool,
) -> Diagnostic {
    let word = &text[at..end];
    let number = text[..at].trim_end();
    let on_line = !text[number.len()..at].contains('\n');
    if word.starts_with(|c: char| c.is_ascii_digit()) {
        let letters = word.find(|c: char| !c.is_ascii_digit());
        return match letters {
            Some(n) if word[n..].bytes().all(|b| b.is_ascii_digit() || b == b'_') => {
                let plain: String = word.chars().filter(|c| *c != '_').collect();
                Diagnostic::error("HQ0111", place.span(at, end), "a number must not contain `_`").write(plain)
            }
            Some(n) => unknown_unit(&word[n..], place.span(at + n, end)),
            None => Diagnostic::unreadable(
                "HQ0113",
                place.span(at, number_end(text, end)),
                format!("`{}` is unexpected here", clip(&text[at..number_end(text, end)])),
            )
            .note(match after {
                After::Value(_) => "the value before it is complete".to_owned(),
                After::Key(_) => "a value is expected".to_owned(),
                After::Start(what) => format!("{what} is expected"),
            }),
        };
    }
    let behind_number = number.ends_with(|c: char| c.is_ascii_digit() || c == ')' || c == ']');
    let value_takes_unit = match after {
        After::Value(value) => crate::words::takes_unit(value),
        _ => behind_number && number.len() > start,
    };
    if unit_only && value_takes_unit && on_line {
        return unknown_unit(word, place.span(at, end));
    }
    if let After::Value(value) = after
        && on_line
        && is_expression(value)
        && let Some(unit) = unit_end(text, at)
    {
        return unit_behind_expression(&text[at..unit], place.span(at, unit));
    }
    let diagnostic =
        Diagnostic::unreadable("HQ0113", place.span(at, end), format!("`{}` is unexpected here", clip(word)));
    match after {
        After::Value(tree::Value { kind: tree::ValueKind::Unit(_, unit), .. }) => {
            diagnostic.note(format!("the value before it ends with its unit `{unit}`"))
        }
        After::Value(_) => diagnostic.note("the value before it is complete"),
        After::Key(_) => diagnostic.note("a comma or an operator is expected between two values"),
        After::Start(what) => diagnostic.note(format!("{what} is expected")),
    }
}

/// Returns the end of a number whose integer part ends at `end`, including its fraction.
fn number_end(text: &str, end: usize) -> usize {
    let fraction = text[end..].strip_prefix('.').unwrap_or("");
    match fraction.find(|c: char| !c.is_ascii_digit()).unwrap_or(fraction.len()) {
        0 => end,
        digits => end + 1 + digits,
    }
}

/// Returns the diagnostic for a bracket that closes nothing.
fn loose(span: crate::Span, bracket: char) -> Diagnostic {
    Diagnostic::error("HQ0106", span, format!("`{bracket}` closes nothing")).about(Topic::LooseBracket)
}

/// Bytes of a unit that are read.
const LONGEST_UNIT: usize = 64;

/// Returns the end of the unit at byte `at`, such as `rad/s`; `None` if there is no unit.
pub(crate) fn unit_end(text: &str, at: usize) -> Option<usize> {
    let line = text[at..].lines().next().unwrap_or("");
    let word = line.find(|c: char| !c.is_ascii_alphabetic()).map_or(line, |n| &line[..n]);
    if !crate::vocabulary::UNITS.contains(&word) {
        return None;
    }
    // The grammar copies what it cannot read: all of a long line, at each of its words.
    let mut end = line.len().min(LONGEST_UNIT);
    while !line.is_char_boundary(end) {
        end -= 1;
    }
    let unit = Grammar::parse(Rule::unit, &line[..end]).ok()?.next()?.as_str().trim_end();
    let whole = !text[at + unit.len()..].starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
    whole.then_some(at + unit.len())
}

/// Returns true for a value behind which there can only be a unit if it is put into parentheses.
pub(crate) fn is_expression(value: &tree::Value) -> bool {
    use tree::ValueKind::{Binary, Field, Name, Negate};
    match &value.kind {
        Negate(inner) => is_expression(inner),
        kind => matches!(kind, Binary(..) | Name(_) | Field(..)),
    }
}

/// Returns the diagnostic for the unit in `0.4*pi rad/s`.
pub(crate) fn unit_behind_expression(unit: &str, span: crate::Span) -> Diagnostic {
    Diagnostic::unreadable("HQ0113", span, format!("the unit `{unit}` stands behind an expression"))
        .note("a unit belongs to the number, the list or the parentheses directly before it")
        .help(format!("write `(..) {unit}`, with the expression in parentheses"))
}

/// Returns the diagnostic for a word after a number that is no unit.
pub(crate) fn unknown_unit(word: &str, span: crate::Span) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("HQ0112", span, format!("unknown unit `{}`", clip(word))).about(Topic::UnknownUnit);
    match nearest_unit(word) {
        Some(symbol) => diagnostic.here("not a unit").meant(symbol),
        None => diagnostic.here("not a unit").help("units are products of symbols such as `m`, `rad`, `s`, `kg`, `N`"),
    }
}

/// Returns the diagnostic for a piece that ends before it is complete.
fn ends_early(text: &str, start: usize, end: usize, place: Place, after: After<'_>) -> Diagnostic {
    if let Some((open, c)) = left_open(text, start, end) {
        return unclosed(place, open, c);
    }
    let before = text[..end].trim_end();
    if let Some(sign) = before.chars().next_back().filter(|c| "+-*/^".contains(*c)) {
        let at = before.len() - 1;
        return Diagnostic::unreadable("HQ0114", place.span(at, at + 1), format!("expected a value after `{sign}`"))
            .here("expects a value on both sides")
            .help("delete it, or write the second value");
    }
    match after {
        After::Key(key) => no_value(key, place.span(start, end)),
        After::Value(_) | After::Start(_) => Diagnostic::unreadable(
            "HQ0113",
            place.span(start, end),
            format!("`{}` cannot be read", clip(&text[start..end])),
        ),
    }
}

/// Returns the unclosed bracket of a piece, preferably one that the rest of the line does not close either.
fn left_open(text: &str, start: usize, end: usize) -> Option<(usize, char)> {
    let line = text[end..].find('\n').map_or(text.len(), |n| end + n);
    opener(text, start, line).filter(|o| o.0 < end).or_else(|| opener(text, start, end))
}

/// Returns the diagnostic for a bracket without a partner.
pub(crate) fn unclosed(place: Place, open: usize, bracket: char) -> Diagnostic {
    Diagnostic::error("HQ0105", place.span(open, open + 1), format!("this `{bracket}` is not closed"))
        .about(Topic::OpenBracket)
        .here("opened here")
        .help(format!("write the missing `{}`", closer(bracket)))
}

/// Returns the diagnostic for a key without a value.
pub(crate) fn no_value(key: &str, span: crate::Span) -> Diagnostic {
    Diagnostic::incomplete("HQ0107", span, format!("`{}` has no value", clip(key)))
        .help(format!("write the value after it, as in `{} 0.5`, or delete the key", clip(key)))
}

fn closer(bracket: char) -> char {
    match bracket {
        '(' => ')',
        '[' => ']',
        _ => '}',
    }
}

/// Returns the innermost bracket that is open at `end`, scanning from `start`.
pub(crate) fn opener(text: &str, start: usize, end: usize) -> Option<(usize, char)> {
    let bytes = text.as_bytes();
    let mut open: Vec<(usize, char)> = Vec::new();
    let mut at = start;
    while at < end {
        let byte = *bytes.get(at)?;
        match byte {
            b'"' => {
                if let Some(close) = crate::limits::text_end(&text[..end], at) {
                    at = close;
                    continue;
                }
            }
            b'(' | b'[' | b'{' => open.push((at, byte as char)),
            b')' | b']' | b'}' if open.last().is_some_and(|(_, c)| closer(*c) == byte as char) => {
                open.pop();
            }
            _ => {}
        }
        at += 1;
    }
    open.pop()
}

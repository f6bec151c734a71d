//! Numbers with too many points: `0.05..0.2 m/s`, which was meant as a range, `0.05.2`, and `5.` without a digit.

use crate::Diagnostic;
use crate::expr::Place;
use crate::fix::Fix;
use crate::vocabulary::UNITS;
use blocks::Snippet;

/// Returns the diagnostic for the point at byte `at`, which follows a number or the unit of one.
pub(crate) fn point(text: &str, at: usize, end: usize, place: Place) -> Diagnostic {
    if text[at..end].starts_with("..") {
        return range(text, at, end, place);
    }
    let from = text[..at].rfind(|c: char| !is_part(c)).map_or(0, |n| n + 1);
    let whole = &text[from..at];
    if whole.contains('.') {
        let more = text[at..end].find(|c: char| !is_part(c)).map_or(end, |n| at + n);
        let diagnostic = Diagnostic::error("HQ0111", place.span(from, more), "a number has a single point");
        return diagnostic.help(format!("write for instance `{whole}`"));
    }
    let span = place.span(from, at + 1);
    Diagnostic::error("HQ0111", span, "a digit is missing after the point")
        .help(format!("write `{whole}.0` or `{whole}`"))
        .fix(Fix::replace(span, format!("{whole}.0")).certain())
        .fix(Fix::replace(span, whole))
}

/// Returns the diagnostic for two numbers with `..` between them at byte `at`.
fn range(text: &str, at: usize, end: usize, place: Place) -> Diagnostic {
    let (low, high) = (before(&text[..at]), behind(&text[at + 2..end]));
    let from = low.map_or(at, |(length, _)| at - length);
    let until = high.map_or(at + 2, |(length, ..)| at + 2 + length);
    let error = |message: &str| Diagnostic::error("HQ0111", place.span(from, until), message);
    match (low, high) {
        (Some((_, low)), Some((_, high, unit))) => {
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            let range = Snippet::value(format!("[{low}, {high}]{unit}"));
            error("`..` makes no range of a value")
                .help(range.clone())
                .fix(Fix::snippet(place.span(from, until), range))
        }
        (_, None) => error("expected a number after `..`")
            .help("a `for` counts through `1..4`; the range of a value is a list, `[0.05, 0.2] m/s`"),
        _ => error("`..` makes no range of a value").help("write the two ends as a list, `[0.05, 0.2] m/s`"),
    }
}

/// Returns true for the characters of a number without an exponent.
fn is_part(c: char) -> bool {
    c.is_ascii_digit() || c == '.'
}

/// Finds the number at the end of a text, with an optional unit: number of bytes of both, and the number.
fn before(text: &str) -> Option<(usize, &str)> {
    let unit = |c: char| c.is_ascii_alphabetic() || c == '/';
    let number = if text.ends_with(is_part) { text } else { text.trim_end_matches(unit).trim_end() };
    let start = number.trim_end_matches(is_part).len();
    let start = start - usize::from(number[..start].ends_with('-'));
    let alone = number[..start].chars().next_back().is_none_or(|c| c.is_whitespace() || "([,\"".contains(c));
    (alone && number.ends_with(|c: char| c.is_ascii_digit())).then(|| (text.len() - start, &number[start..]))
}

/// Finds the number at the start of a text and the unit after it: number of bytes of both, the number, the unit.
fn behind(text: &str) -> Option<(usize, &str, &str)> {
    let start = text.len() - text.trim_start_matches(' ').len();
    let sign = start + usize::from(text[start..].starts_with('-'));
    let number = text[sign..].find(|c: char| !is_part(c)).map_or(text.len(), |n| sign + n);
    if !text[..number].ends_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let rest = text[number..].trim_start_matches(' ');
    let word = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '/' || c == '^')).unwrap_or(rest.len());
    let symbol = |part: &str| UNITS.contains(&part.split('^').next().unwrap_or(""));
    match rest[..word].trim_start_matches('/') {
        unit if !unit.is_empty() && unit.split('/').all(symbol) => {
            Some((text.len() - rest.len() + word, &text[start..number], &rest[..word]))
        }
        _ => Some((number, &text[start..number], "")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Span;

    #[test]
    fn ranges() {
        for (text, help) in [
            ("0.05..0.2 m/s", "write `[0.05, 0.2] m/s`"),
            ("0.05 .. 0.2 m/s", "write `[0.05, 0.2] m/s`"),
            ("-1 m..2 m", "write `[-1, 2] m`"),
            ("1..4 serve", "write `[1, 4]`"),
            ("1..-4.5", "write `[1, -4.5]`"),
        ] {
            let at = text.find("..").expect("two points");
            let found = point(text, at, text.len(), Place::Whole(Span::default()));
            assert_eq!(found.help.as_deref(), Some(help), "{text}");
        }
        for text in ["1..", "a..b", "m^2..3", "é..é", ".."] {
            let at = text.find("..").expect("two points");
            assert_eq!(point(text, at, text.len(), Place::Whole(Span::default())).code, "HQ0111");
        }
    }
}

//! Output to the terminal: a closed pipe is no error but a full disk is one, colours are used only on terminals, and
//! texts quoted from files or servers contain no control characters.

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::OnceLock;

use compiler::{Report, Style};
use mission::characters::commands;

/// Prints text for people to standard output, without colours.
pub fn print(text: &str) {
    data(&plain(text));
}

/// Prints text for people to standard output, with its colours; quoted parts must have been made [`plain`] before.
pub fn painted(text: &str) {
    data(&shown(text));
}

/// Removes control characters for terminals, including colours, except for line ends.
pub fn plain(text: &str) -> String {
    shown(&text.replace('\u{1b}', "\u{1a}"))
}

/// First error of writing to standard output.
static UNWRITTEN: OnceLock<String> = OnceLock::new();

/// Prints data for other programs unchanged to standard output. [`unwritten`] returns an error if that failed.
pub fn data(text: &str) {
    let mut out = std::io::stdout().lock();
    printed(out.write_all(text.as_bytes()).and_then(|()| out.flush()));
}

/// Stores the result of writing to standard output; a closed pipe is no error.
pub fn printed(written: std::io::Result<()>) {
    if let Err(e) = written
        && e.kind() != ErrorKind::BrokenPipe
    {
        UNWRITTEN.get_or_init(|| format!("cannot write to standard output: {e}"));
    }
}

/// Returns the error message if output was lost.
pub fn unwritten() -> Option<&'static str> {
    UNWRITTEN.get().map(String::as_str)
}

/// Prints a line to standard error.
pub fn error_line(text: &str) {
    let _ = writeln!(std::io::stderr(), "hierarq: {}", plain(text));
}

/// Prints text to standard error, without colours.
pub fn eprint(text: &str) {
    let _ = std::io::stderr().write_all(plain(text).as_bytes());
}

/// Removes control characters for terminals, except for line ends and colours.
fn shown(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let whole = match c {
            '\n' | '\t' => 1,
            '\u{1b}' => colour(rest).unwrap_or(0),
            c if commands(c) => 0,
            c => c.len_utf8(),
        };
        shown.push_str(if whole == 0 { "\u{fffd}" } else { &rest[..whole] });
        rest = &rest[whole.max(c.len_utf8())..];
    }
    shown
}

/// Returns the length in bytes of a colour sequence at the begin of a text.
fn colour(text: &str) -> Option<usize> {
    let numbers = text.strip_prefix("\u{1b}[")?;
    let end = numbers.find(|c: char| !c.is_ascii_digit() && c != ';')?;
    numbers[end..].starts_with('m').then_some(end + 3)
}

/// Colours for a terminal; none for a file, a pipe, or if `NO_COLOR` is set.
pub fn style(stream_is_terminal: bool) -> Style {
    let wanted = std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    if stream_is_terminal && wanted { Style::Terminal } else { Style::Plain }
}

/// Returns the width of the terminal, or 100 columns.
pub fn width() -> usize {
    let columns = std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok());
    columns.unwrap_or(100).clamp(60, 160)
}

/// Prints all diagnostics to standard error.
pub fn show(report: &Report) {
    if !report.diagnostics.is_empty() {
        // Quoted texts in a report have no colours of their own.
        let text = shown(&report.render(style(std::io::stderr().is_terminal()), width()));
        let _ = std::io::stderr().write_all(text.as_bytes());
    }
}

/// Returns `1 error, 2 warnings`, or `None` without any.
pub fn count(report: &Report) -> Option<String> {
    let plural = |n: usize, word: &str| (n > 0).then(|| format!("{n} {word}{}", if n == 1 { "" } else { "s" }));
    let parts: Vec<String> =
        [plural(report.errors(), "error"), plural(report.warnings(), "warning")].into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// Returns `, 2 warnings allowed`, or an empty text without any.
pub fn allowed(report: &Report) -> String {
    match report.allowed.len() {
        0 => String::new(),
        1 => ", 1 warning allowed".to_string(),
        n => format!(", {n} warnings allowed"),
    }
}

/// Prints the report of a file without a program, as text to standard error or as JSON to standard output; for a spec
/// with missions only, a hint on their use.
pub fn refuse(report: &compiler::Report, spec: &Path, json: bool) -> Result<super::Outcome, String> {
    if report.errors() == 0 {
        return Err(hierarq::project::missions_alone(spec));
    }
    if json {
        data(&format!("{:#}\n", report.to_json()));
    } else {
        show(report);
    }
    Ok(super::Outcome::Failed)
}

#[cfg(test)]
mod tests {
    use super::{plain, shown};

    #[test]
    fn what_commands_is_not_printed() {
        assert_eq!(
            shown("a\u{1b}[2J\u{1b}]0;b\u{7}\u{202e}c\u{9b}2J\r\n"),
            "a\u{fffd}[2J\u{fffd}]0;b\u{fffd}\u{fffd}c\u{fffd}2J\u{fffd}\n"
        );
        let coloured = "\u{1b}[1;31mé\u{1b}[0m\tü 🧊\n";
        assert_eq!(shown(coloured), coloured);
        assert_eq!(shown("\u{1b}[1;31\u{1b}"), "\u{fffd}[1;31\u{fffd}");
        assert_eq!(plain("\u{1b}[8mhidden\n"), "\u{fffd}[8mhidden\n");
    }
}

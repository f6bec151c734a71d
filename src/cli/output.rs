//! Writing to the terminal: a closed pipe is no error and a full disk is one, colours only where somebody sees them, and
//! what is quoted from files or servers commands nothing.

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::OnceLock;

use compiler::{Report, Style};
use mission::characters::commands;

/// Prints text for people to standard output, without colours.
pub fn print(text: &str) {
    data(&plain(text));
}

/// Prints text for people to standard output, with its colours: what is quoted in it was made [`plain`] before.
pub fn painted(text: &str) {
    data(&shown(text));
}

/// The text without what a terminal would obey, colours too, but for ends of lines.
pub fn plain(text: &str) -> String {
    shown(&text.replace('\u{1b}', "\u{1a}"))
}

/// Why standard output could not be written, the first time.
static UNWRITTEN: OnceLock<String> = OnceLock::new();

/// Prints what another program may read, as it is, to standard output. [`unwritten`] tells where that failed.
pub fn data(text: &str) {
    let mut out = std::io::stdout().lock();
    printed(out.write_all(text.as_bytes()).and_then(|()| out.flush()));
}

/// Notes what became of writing to standard output; a reader that went away is not our mistake.
pub fn printed(written: std::io::Result<()>) {
    if let Err(e) = written
        && e.kind() != ErrorKind::BrokenPipe
    {
        UNWRITTEN.get_or_init(|| format!("cannot write to standard output: {e}"));
    }
}

/// What to say where a part of what was printed is lost.
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

/// The text without what a terminal would obey, but for ends of lines and colours.
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

/// Bytes of the order that sets a colour, if the text begins with one.
fn colour(text: &str) -> Option<usize> {
    let numbers = text.strip_prefix("\u{1b}[")?;
    let end = numbers.find(|c: char| !c.is_ascii_digit() && c != ';')?;
    numbers[end..].starts_with('m').then_some(end + 3)
}

/// Colours for a terminal, none for a file, a pipe or where `NO_COLOR` asks for none.
pub fn style(stream_is_terminal: bool) -> Style {
    let wanted = std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    if stream_is_terminal && wanted { Style::Terminal } else { Style::Plain }
}

/// Width of the terminal, or 100 columns.
pub fn width() -> usize {
    let columns = std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok());
    columns.unwrap_or(100).clamp(60, 160)
}

/// Shows all diagnostics on standard error.
pub fn show(report: &Report) {
    if !report.diagnostics.is_empty() {
        // What a report quotes has no colours of its own.
        let text = shown(&report.render(style(std::io::stderr().is_terminal()), width()));
        let _ = std::io::stderr().write_all(text.as_bytes());
    }
}

/// `1 error, 2 warnings`, or nothing.
pub fn count(report: &Report) -> Option<String> {
    let plural = |n: usize, word: &str| (n > 0).then(|| format!("{n} {word}{}", if n == 1 { "" } else { "s" }));
    let parts: Vec<String> =
        [plural(report.errors(), "error"), plural(report.warnings(), "warning")].into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// A file that gave no program: its report, as text on standard error or as JSON on standard output; of missions alone,
/// what can be done with them.
pub fn refuse(report: &compiler::Report, spec: &Path, json: bool) -> super::Outcome {
    if report.errors() == 0 {
        return super::Outcome::Trouble(hierarq::project::missions_alone(spec));
    }
    if json {
        data(&format!("{:#}\n", report.to_json()));
    } else {
        show(report);
    }
    super::Outcome::Failed
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

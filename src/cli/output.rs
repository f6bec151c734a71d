//! Writing to the terminal: a closed pipe is no error, colours only where somebody sees them.

use std::io::{IsTerminal, Write};
use std::path::Path;

use compiler::{Report, Style};

/// Prints text to standard output; a reader that went away is not our mistake.
pub fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Prints a line to standard error.
pub fn error_line(text: &str) {
    let _ = writeln!(std::io::stderr(), "hierarq: {text}");
}

/// Prints text to standard error.
pub fn eprint(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
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
        eprint(&report.render(style(std::io::stderr().is_terminal()), width()));
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
        print(&format!("{:#}\n", report.to_json()));
    } else {
        show(report);
    }
    super::Outcome::Failed
}

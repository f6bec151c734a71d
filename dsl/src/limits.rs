//! Bounds on the cost of a text, and the scan of a `*.hq` text that enforces them before the recursive parse: size,
//! nesting, number of words, control characters. The scan also collects the comments.

use crate::comments::Comment;
use crate::tree::BlockKind;
use crate::{Diagnostic, SourceId, Span};

/// Maximum size of a text, in bytes.
pub const MAX_BYTES: usize = 8 << 20;
/// Maximum nesting of brackets, or of YAML collections.
pub const MAX_DEPTH: usize = 64;
/// Maximum nesting of states.
pub const MAX_STATE_NESTING: usize = 16;
/// Maximum number of words, numbers and signs in a text.
pub const MAX_TOKENS: usize = 400_000;
/// Maximum number of YAML nodes after the expansion of aliases.
pub const MAX_NODES: usize = 100_000;
/// Maximum number of operators in one expression.
pub const MAX_OPERATORS: usize = 200;
/// Maximum number of parameters of a task or stack.
pub const MAX_PARAMETERS: usize = 100;
/// Maximum height of an expression tree.
pub const MAX_HEIGHT: u32 = 256;
/// Maximum number of diagnostics of one text; one more reports that there were more.
pub const MAX_DIAGNOSTICS: usize = 100;

/// Decodes bytes as UTF-8; the error points at the first invalid byte.
///
/// # Errors
/// `HQ0193` if the bytes are not UTF-8. The span is a range of `bytes`.
pub fn decode(source: SourceId, bytes: &[u8]) -> Result<&str, Box<Diagnostic>> {
    std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        let byte = bytes.get(at).copied().unwrap_or_default();
        let line = bytes[..at].iter().filter(|&&b| b == b'\n').count() + 1;
        let length = error.error_len().unwrap_or(bytes.len() - at);
        let span = Span::new(source, at, at + length);
        Box::new(
            Diagnostic::error("HQ0193", span, format!("byte {at} (line {line}) is not UTF-8"))
                .here(format!("byte 0x{byte:02x}"))
                .help("save the file as UTF-8"),
        )
    })
}

/// Returns a diagnostic if the text is too large.
pub(crate) fn check_size(source: SourceId, text: &str) -> Option<Diagnostic> {
    (text.len() > MAX_BYTES).then(|| {
        Diagnostic::error("HQ0190", Span::new(source, 0, 0), "this text is larger than 8 MiB")
            .note(format!("it has {} bytes; a spec of ten thousand lines has about half a million", text.len()))
            .help("check that this is the file you meant")
    })
}

/// Returns the diagnostic for a text with too many words.
pub(crate) fn too_many_words(source: SourceId, at: usize) -> Diagnostic {
    Diagnostic::error(
        "HQ0190",
        Span::new(source, at, at),
        format!("this text has more than {MAX_TOKENS} words and signs"),
    )
    .here("read up to here")
    .help("split the spec, or generate it closer to the robot")
}

/// Returns the diagnostic for brackets nested too deeply.
pub(crate) fn too_deep(span: Span) -> Diagnostic {
    Diagnostic::error("HQ0191", span, format!("nested more than {MAX_DEPTH} deep"))
        .here("one too many")
        .help("name an inner part with `param` or `task`, or close a bracket that was left open")
}

/// Result of the scan.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    /// Comments in the order of the text.
    pub comments: Vec<Comment>,
    /// Set if the text must not be parsed.
    pub refused: Option<Diagnostic>,
    /// Other diagnostics.
    pub diagnostics: Vec<Diagnostic>,
}

/// Returns true if a declaration begins here: the rule `item_head` of the grammar.
fn item_head(text: &str) -> bool {
    let blank = |c: char| matches!(c, ' ' | '\t' | '\r');
    // Returns the text after `word`, and true if blanks precede it.
    let behind = |word: &str| {
        let rest = text.strip_prefix(word)?;
        let trimmed = rest.trim_start_matches(blank);
        Some((trimmed, trimmed.len() < rest.len()))
    };
    // Returns the text after `word NAME`, and true if blanks precede it.
    let named = |word: &str| {
        let (name, true) = behind(word)? else { return None };
        let mut rest = name;
        loop {
            let next = rest.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
            match crate::holes::leading(next) {
                Some((_, after)) => rest = after,
                None => {
                    rest = next;
                    break;
                }
            }
        }
        if rest.len() == name.len() || name.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        let trimmed = rest.trim_start_matches(blank);
        Some((trimmed, trimmed.len() < rest.len()))
    };
    let head = |word: &str, sign: char| named(word).is_some_and(|(rest, _)| rest.starts_with(sign));
    let from = |word: &str| {
        named(word)
            .is_some_and(|(rest, apart)| apart && rest.strip_prefix("from").is_some_and(|rest| rest.starts_with(blank)))
    };
    let nameless = |word: &str, sign: char| behind(word).is_some_and(|(rest, _)| rest.starts_with(sign));
    let repeats = |(rest, apart): (&str, bool)| {
        apart
            && rest
                .strip_prefix("in")
                .is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_'))
    };
    ["param", "let", "task"].iter().any(|word| head(word, '=') || nameless(word, '='))
        || ["task", "stack"].iter().any(|word| head(word, '('))
        || ["robot", "stack"].iter().any(|word| head(word, '{') || from(word))
        || nameless("import", '"')
        || named("for").is_some_and(repeats)
        || nameless("run", '{')
        || nameless("coverage", '{')
        || head("signal", ':')
        || BlockKind::ALL.iter().any(|kind| head(kind.keyword(), '{'))
        || head("variable", ':')
        || head("mission", ':')
        || head("mission", '{')
        || ["machine", "scenario"].iter().any(|word| head(word, '{') || quoted_head(text, word))
}

/// Returns true for `word "TEXT" {`.
fn quoted_head(text: &str, word: &str) -> bool {
    let blank = |c: char| matches!(c, ' ' | '\t' | '\r');
    let Some(rest) = text.strip_prefix(word) else { return false };
    let name = rest.trim_start_matches(blank);
    if name.len() == rest.len() || !name.starts_with('"') {
        return false;
    }
    text_end(name, 0).is_some_and(|end| name[end..].trim_start_matches(blank).starts_with('{'))
}

/// Returns the diagnostic for the first control character other than tabs and line breaks.
fn control_character(source: SourceId, text: &str) -> Option<Diagnostic> {
    let at = text.bytes().position(|b| b < b' ' && !matches!(b, b'\t' | b'\r' | b'\n') || b == 0x7f)?;
    let byte = text.as_bytes()[at];
    let message = format!("control character 0x{byte:02x} in the text");
    let diagnostic = Diagnostic::error("HQ0194", Span::new(source, at, at + 1), message);
    Some(diagnostic.help("delete it; the file may be damaged or not a text"))
}

/// Returns the end of a text literal that opens at `start`; `None` if the line ends first.
pub(crate) fn text_end(text: &str, start: usize) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = start + 1;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'"' => return Some(at + 1),
            b'\n' => return None,
            b'\\' if bytes.get(at + 1).is_some_and(|&b| b != b'\n') => at += 2,
            b'\\' => return None,
            _ => at += 1,
        }
    }
    None
}

/// Scans a `*.hq` text once, from start to end.
pub(crate) fn scan(source: SourceId, text: &str, begin: usize) -> Scan {
    let bytes = text.as_bytes();
    let mut scan = Scan::default();
    let mut open: Vec<u8> = Vec::new();
    let (mut at, mut words, mut line_start) = (begin, 0usize, begin);
    scan.diagnostics.extend(control_character(source, text));
    while let Some(&byte) = bytes.get(at) {
        words += usize::from(byte > b' ');
        if words > MAX_TOKENS {
            scan.refused = Some(too_many_words(source, at));
            return scan;
        }
        match byte {
            b'\n' => {
                line_start = at + 1;
                if item_head(&text[line_start..]) {
                    open.clear();
                }
            }
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                let end = text[at..].find('\n').map_or(text.len(), |n| at + n);
                let whole_line = text[line_start..at].trim().is_empty();
                scan.comments.push(Comment::new(at, end, whole_line, &text[at + 2..end]));
                at = end;
                continue;
            }
            b'"' => {
                if let Some(end) = text_end(text, at) {
                    at = end;
                    continue;
                }
            }
            b'(' | b'[' | b'{' => {
                open.push(byte);
                if open.len() > MAX_DEPTH {
                    scan.refused = Some(too_deep(Span::new(source, at, at + 1)));
                    return scan;
                }
            }
            b'}' => {
                while let Some(last) = open.pop() {
                    if last == b'{' {
                        break;
                    }
                }
            }
            b')' | b']' => {
                let opener = if byte == b')' { b'(' } else { b'[' };
                if open.last() == Some(&opener) {
                    open.pop();
                }
            }
            b if b.is_ascii_alphanumeric() || b == b'_' => {
                while bytes.get(at).is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_') {
                    at += 1;
                }
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    scan
}

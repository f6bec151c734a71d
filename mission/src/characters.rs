//! Control characters, which a terminal or a page executes instead of displaying: they are not allowed in names, and
//! are replaced in quoted external text.

/// Replacement of a control character.
pub const INSTEAD: char = '\u{fffd}';

/// Returns true for characters that are not displayed but executed: control characters, line ends among them, and
/// characters that change the direction of writing.
pub fn commands(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Returns the text with each such character replaced by [`INSTEAD`].
pub fn plain(text: &str) -> String {
    text.chars().map(|c| if commands(c) { INSTEAD } else { c }).collect()
}

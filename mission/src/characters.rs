//! Characters that a terminal or a page obeys instead of showing: they have no place in a name, and none in what is
//! quoted from outside.

/// What stands in place of a character that is not shown.
pub const INSTEAD: char = '\u{fffd}';

/// Whether a character commands instead of being one that is read: controls, ends of lines among them, and what turns
/// the direction of writing.
pub fn commands(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text with [`INSTEAD`] in place of each such character.
pub fn plain(text: &str) -> String {
    text.chars().map(|c| if commands(c) { INSTEAD } else { c }).collect()
}

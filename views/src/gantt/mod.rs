//! Drawings of plans: a Gantt chart for the terminal and as SVG, and a map of positions and paths.
//!
//! All are functions of data: a [`mission::chart::Chart`], a [`mission::map::Map`], an instant. Kinds of bars differ in
//! character or height as well as in colour.

use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

mod axis;
mod frame;
mod map;
mod svg;
mod text;

pub use map::{Standing, map};
pub use svg::{Look, picture, svg};
pub use text::text;

/// Style sheet of all drawings, light and dark, for a page that embeds them without their own.
pub static STYLE: &str = include_str!("style.css");

/// Returns the number of terminal columns of a text: two for a wide character, none for a combining one.
pub fn columns(text: &str) -> usize {
    UnicodeWidthStr::width(text)
}

/// Shortens a text to at most `most` columns, with a mark at the cut.
fn shortened(text: &str, most: usize) -> String {
    if columns(text) <= most {
        return text.to_string();
    }
    let mut taken = 0;
    let fits = |c: &char| {
        taken += UnicodeWidthChar::width(*c).unwrap_or(0);
        taken < most
    };
    text.chars().take_while(fits).chain(['…']).collect()
}

/// Formats a number of pixels with at most one decimal.
fn px(x: f64) -> String {
    let text = format!("{x:.1}");
    match text.strip_suffix(".0") {
        Some("-0") => "0".to_string(),
        Some(whole) => whole.to_string(),
        None => text,
    }
}

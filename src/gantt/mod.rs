//! Plans as pictures: a Gantt chart for the terminal, the same as SVG, and a map of places and ways.
//!
//! All are functions of data: a [`mission::plan::Plan`], a problem, an instant. A chart has a row for each robot and each
//! agent; phases differ in character or height as well as in colour. Operations count from 1 here, as people count.

use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

mod above;
mod axis;
mod frame;
mod map;
mod rows;
mod svg;
mod text;

pub use above::layered_map;
pub use map::{Standing, map};
pub use svg::{Look, picture, svg};
pub use text::text;

/// The rules of form and colour of all pictures, light and dark, for a page that shows them without their own.
pub static STYLE: &str = include_str!("style.css");

/// Columns that a text takes on a terminal: two for a wide character, none for an accent that joins the one before.
pub fn columns(text: &str) -> usize {
    UnicodeWidthStr::width(text)
}

/// A text in at most so many columns, with a mark where it is cut.
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

/// Numbers to a tenth of a pixel, without a zero that says nothing.
fn px(x: f64) -> String {
    let text = format!("{x:.1}");
    match text.strip_suffix(".0") {
        Some("-0") => "0".to_string(),
        Some(whole) => whole.to_string(),
        None => text,
    }
}

//! `hierarq schema`

use super::{Outcome, output};

pub fn run() -> Outcome {
    output::print(&format!("{:#}\n", hierarq::schema::schema()));
    Outcome::Good
}

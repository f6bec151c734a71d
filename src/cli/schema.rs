//! `hierarq schema`

use super::{Outcome, output};

pub fn run() -> Outcome {
    output::data(&format!("{:#}\n", hierarq::schema::schema()));
    Outcome::Good
}

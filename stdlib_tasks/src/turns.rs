//! Whole turns in the error of an angle: taken to the nearest turn, or as they are written.
//!
//! ```text
//! e = y_d - y - 2 pi k      k the integer with the smallest |e|: -pi <= e <= pi        nearest
//! e = y_d - y                                                                          exact
//! ```

pub use robot::nearest_turn;

use crate::build::BuildError;
use crate::params::ParamType;

/// Word for the error to the nearest turn.
pub const NEAREST: &str = "nearest";

/// Word for the error as it is written.
pub const EXACT: &str = "exact";

/// Type of a parameter that chooses between the two.
pub const TURNS: ParamType = ParamType::Choice(&[NEAREST, EXACT]);

/// Returns true if a word, which is [`NEAREST`] where none is written, asks for the nearest turn.
///
/// # Errors
/// It is none of the two words, which a compiled program excludes.
pub fn asks_for_nearest(word: &str) -> Result<bool, BuildError> {
    match word {
        NEAREST => Ok(true),
        EXACT => Ok(false),
        other => {
            let text = format!("`turns` is `{other}`, and only `{NEAREST}` and `{EXACT}` have a meaning");
            Err(BuildError::new("turns", text))
        }
    }
}

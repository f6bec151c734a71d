//! Requests the layers of a mission from a model. The checks of hand-written layers judge the answers.

use mission::kinds::layers::json::{Imported, import};

use crate::endpoint::Chat;
use crate::generate::{Bounds, GenerateError, generate};
use crate::prompt::{Wish, prompt};
use crate::transcript::Exchange;

/// Asks the model for the layers of a mission until an answer passes the checks. Passes each exchange to `keep`.
///
/// # Errors
///
/// As [`generate`].
pub fn layers(
    chat: &mut dyn Chat,
    wish: &Wish,
    bounds: &Bounds,
    keep: impl FnMut(&Exchange) -> std::io::Result<()>,
) -> Result<Imported, GenerateError> {
    let judge = |text: &str| {
        import(text, wish.problem, wish.mode)
            .map_err(|faults| faults.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    generate(chat, &prompt(wish), bounds, judge, keep)
}

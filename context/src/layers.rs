//! Layers from a model: the prompt of a mission, and the checks of layers as the judge of what is answered.

use mission::layers::json::{Imported, import};

use crate::endpoint::Chat;
use crate::generate::{Bounds, GenerateError, generate};
use crate::prompt::{Wish, prompt};
use crate::transcript::Exchange;

/// Asks the model for the layers of a mission until they pass the checks. Each exchange is given to `keep`.
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

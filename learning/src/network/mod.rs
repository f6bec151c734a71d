//! Small networks with dense layers, over inputs of which few are 1 and the others 0.
//!
//! x₁ = φ(Σ_{i active} W₀[i] + b₀),  x_{l+1} = φ(xₗ Wₗ + bₗ),  output = x_L W_L + b_L
//!
//! The weights of an input stand together (`W[input][output]`), so that an input that is 0 costs nothing, neither in the first
//! layer nor behind a rectifier.

mod adam;
mod layers;
mod real;
mod shape;
mod softmax;

pub use adam::{Adam, clip};
pub use layers::{Network, Trace};
pub use real::Real;
pub use shape::{Activation, LayerSize, MAX_LAYERS, MAX_PARAMETERS, MAX_UNITS, Shape, ShapeError};
pub use softmax::{log_softmax, sigmoid, softplus};

//! Sizes of a network.

use super::Real;

/// The most hidden layers.
pub const MAX_LAYERS: usize = 8;
/// The most units of a hidden layer.
pub const MAX_UNITS: usize = 1024;
/// The most parameters, 64 MB of `f32`.
pub const MAX_PARAMETERS: usize = 1 << 24;

/// Function of the hidden units.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Activation {
    /// max(x, 0)
    Relu,
    /// Hyperbolic tangent.
    Tanh,
}

impl Activation {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Activation::Relu => "relu",
            Activation::Tanh => "tanh",
        }
    }

    /// The function with this name in files.
    pub fn from_name(name: &str) -> Option<Activation> {
        [Activation::Relu, Activation::Tanh].into_iter().find(|activation| activation.name() == name)
    }

    pub(super) fn value<T: Real>(self, x: T) -> T {
        match self {
            Activation::Relu => {
                if x > T::default() {
                    x
                } else {
                    T::default()
                }
            }
            Activation::Tanh => x.tanh(),
        }
    }

    /// Derivative, as a function of the value.
    pub(super) fn derivative<T: Real>(self, value: T) -> T {
        match self {
            Activation::Relu => {
                if value > T::default() {
                    T::of(1.0)
                } else {
                    T::default()
                }
            }
            Activation::Tanh => T::of(1.0) - value * value,
        }
    }
}

/// Inputs, hidden layers and outputs of a network.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Shape {
    inputs: usize,
    hidden: Vec<usize>,
    outputs: usize,
    activation: Activation,
}

/// Reason why there is no network of some sizes.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ShapeError {
    /// Too many layers.
    #[error("there are {0} hidden layers; at most {MAX_LAYERS} are possible")]
    Layers(usize),
    /// An empty layer, or one that is too wide.
    #[error("a hidden layer has {0} units; 1 to {MAX_UNITS} are possible")]
    Units(usize),
    /// No inputs or no outputs.
    #[error("a network needs inputs and outputs")]
    Empty,
    /// Too many parameters.
    #[error("the network would have more than {MAX_PARAMETERS} parameters")]
    Parameters,
}

impl Shape {
    /// Checks the sizes.
    pub fn new(inputs: usize, hidden: &[usize], outputs: usize, activation: Activation) -> Result<Shape, ShapeError> {
        if hidden.len() > MAX_LAYERS {
            return Err(ShapeError::Layers(hidden.len()));
        }
        if let Some(units) = hidden.iter().copied().find(|units| !(1..=MAX_UNITS).contains(units)) {
            return Err(ShapeError::Units(units));
        }
        if inputs == 0 || outputs == 0 {
            return Err(ShapeError::Empty);
        }
        let shape = Shape { inputs, hidden: hidden.to_vec(), outputs, activation };
        let of_layer = |size: LayerSize| size.inputs.checked_add(1)?.checked_mul(size.outputs);
        let sum = shape.layer_sizes().try_fold(0_usize, |sum, size| sum.checked_add(of_layer(size)?));
        sum.filter(|sum| *sum <= MAX_PARAMETERS).map(|_| shape).ok_or(ShapeError::Parameters)
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Units of the hidden layers.
    pub fn hidden(&self) -> &[usize] {
        &self.hidden
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Function of the hidden units.
    pub fn activation(&self) -> Activation {
        self.activation
    }

    /// Inputs and outputs of each layer, the last one being the outputs of the network.
    pub fn layer_sizes(&self) -> impl Iterator<Item = LayerSize> + '_ {
        let outputs = self.hidden.iter().copied().chain([self.outputs]);
        let inputs = [self.inputs].into_iter().chain(self.hidden.iter().copied());
        inputs.zip(outputs).map(|(inputs, outputs)| LayerSize { inputs, outputs })
    }
}

/// Size of a layer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LayerSize {
    /// Its inputs.
    pub inputs: usize,
    /// Its outputs.
    pub outputs: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_beyond_the_bounds_are_refused() {
        let of = |inputs, hidden: &[usize]| Shape::new(inputs, hidden, 5, Activation::Relu).map(|_| ());
        assert_eq!(of(10, &[4, 3]), Ok(()));
        assert_eq!(of(0, &[4]), Err(ShapeError::Empty));
        assert_eq!(of(10, &[4, 0]), Err(ShapeError::Units(0)));
        assert_eq!(of(10, &[2000]), Err(ShapeError::Units(2000)));
        assert_eq!(of(10, &[1; 9]), Err(ShapeError::Layers(9)));
        assert_eq!(of(usize::MAX, &[4]), Err(ShapeError::Parameters));
        assert_eq!(of(100_000, &[1024]), Err(ShapeError::Parameters));
    }
}

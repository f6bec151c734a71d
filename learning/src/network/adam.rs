//! Adam (Kingma and Ba, 2015): steps along the mean gradient over the root of its mean square.
//!
//! m ← β₁ m + (1-β₁) g,  v ← β₂ v + (1-β₂) g²,  p ← p - α m/(1-β₁ᵗ) / (√(v/(1-β₂ᵗ)) + ε)

use super::Real;

const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Moments of the gradient.
#[derive(Clone, PartialEq, Debug)]
pub struct Adam<T> {
    mean: Vec<T>,
    square: Vec<T>,
    steps: u64,
}

impl<T: Real> Adam<T> {
    /// Before the first step, for a network of `parameters` parameters.
    pub fn new(parameters: usize) -> Adam<T> {
        Adam { mean: vec![T::default(); parameters], square: vec![T::default(); parameters], steps: 0 }
    }

    /// In the middle of a training; `None` if the two have different lengths.
    pub fn resumed(mean: Vec<T>, square: Vec<T>, steps: u64) -> Option<Adam<T>> {
        (mean.len() == square.len()).then_some(Adam { mean, square, steps })
    }

    /// Mean of the gradient.
    pub fn mean(&self) -> &[T] {
        &self.mean
    }

    /// Mean square of the gradient.
    pub fn square(&self) -> &[T] {
        &self.square
    }

    /// Steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Takes a step at this learning rate α.
    pub fn step(&mut self, parameters: &mut [T], gradient: &[T], rate: f64) {
        self.steps += 1;
        let t = self.steps as f64;
        let correction_1 = 1.0 - libm::pow(BETA_1, t);
        let correction_2 = 1.0 - libm::pow(BETA_2, t);
        // α m̂ / (√v̂ + ε) with both corrections moved into the factors, once for all parameters.
        let root = libm::sqrt(correction_2);
        let (rate, epsilon) = (T::of(rate * root / correction_1), T::of(EPSILON * root));
        let (b1, b2, c1, c2) = (T::of(BETA_1), T::of(BETA_2), T::of(1.0 - BETA_1), T::of(1.0 - BETA_2));
        let moments = self.mean.iter_mut().zip(&mut self.square);
        for ((p, g), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
            *m = b1 * *m + c1 * *g;
            *v = b2 * *v + c2 * *g * *g;
            *p -= rate * *m / (v.sqrt() + epsilon);
        }
    }
}

/// Shortens a gradient to the length `most`.
pub fn clip<T: Real>(gradient: &mut [T], most: f64) {
    let length = libm::sqrt(gradient.iter().fold(0.0, |sum, g| sum + g.to_f64() * g.to_f64()));
    if length > most {
        let factor = T::of(most / length);
        gradient.iter_mut().for_each(|g| *g *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_value_of_a_quadratic_is_found() {
        let mut x = [3.0_f64, -2.0];
        let mut adam = Adam::new(2);
        for _ in 0..4000 {
            let gradient = [2.0 * (x[0] - 1.0), 20.0 * (x[1] - 0.5)];
            adam.step(&mut x, &gradient, 0.01);
        }
        assert!((x[0] - 1.0).abs() < 1e-3 && (x[1] - 0.5).abs() < 1e-3, "{x:?}");
    }

    /// The first step has the length of the rate in each coordinate, whatever the gradient.
    #[test]
    fn the_first_step_has_the_length_of_the_rate() {
        let mut x = [0.0_f64; 2];
        Adam::new(2).step(&mut x, &[1e-3, -50.0], 0.1);
        assert!((x[0] + 0.1).abs() < 1e-5 && (x[1] - 0.1).abs() < 1e-8, "{x:?}");
    }

    #[test]
    fn long_gradients_are_shortened() {
        let mut gradient = [3.0_f32, 4.0];
        clip(&mut gradient, 10.0);
        assert_eq!(gradient, [3.0, 4.0]);
        clip(&mut gradient, 1.0);
        assert!((gradient[0] - 0.6).abs() < 1e-6 && (gradient[1] - 0.8).abs() < 1e-6);
    }
}

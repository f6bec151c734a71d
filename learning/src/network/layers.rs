//! Parameters of a network, its outputs, and their derivatives.

use super::{Activation, Real, Shape};
use crate::random::{Pcg64, unit};

/// A network with its parameters in one vector: for each layer its weights, input by input, then its biases.
#[derive(Clone, PartialEq, Debug)]
pub struct Network<T> {
    shape: Shape,
    layers: Vec<Layer>,
    parameters: Vec<T>,
}

/// Places of the parameters of a layer.
#[derive(Clone, PartialEq, Debug)]
struct Layer {
    inputs: usize,
    outputs: usize,
    weights: usize,
    bias: usize,
}

/// Storage of one evaluation: values of all layers, and their errors on the way back.
#[derive(Clone, Debug)]
pub struct Trace<T> {
    values: Vec<Vec<T>>,
    errors: Vec<Vec<T>>,
}

impl<T: Real> Network<T> {
    /// A network in which all parameters are 0.
    pub fn zero(shape: Shape) -> Network<T> {
        let mut layers = Vec::new();
        let mut end = 0;
        for size in shape.layer_sizes() {
            let bias = end + size.inputs * size.outputs;
            layers.push(Layer { inputs: size.inputs, outputs: size.outputs, weights: end, bias });
            end = bias + size.outputs;
        }
        Network { shape, layers, parameters: vec![T::default(); end] }
    }

    /// Weights uniform in ±√(6/n) behind rectifiers and ±√(3/n) behind tanh, for `n` inputs that are not 0 at a time: `active`
    /// of the first layer. Those of the outputs are `gain` times that. Biases are 0.
    pub fn random(shape: Shape, active: usize, gain: f64, generator: &mut Pcg64) -> Network<T> {
        let mut network = Network::zero(shape);
        let last = network.layers.len() - 1;
        for (l, layer) in network.layers.iter().enumerate() {
            let inputs = if l == 0 { active.clamp(1, layer.inputs) } else { layer.inputs };
            let variance = if network.shape.activation() == Activation::Relu { 6.0 } else { 3.0 };
            let bound = libm::sqrt(variance / inputs as f64) * if l == last { gain } else { 1.0 };
            for weight in &mut network.parameters[layer.weights..layer.bias] {
                *weight = T::of(bound * (2.0 * unit(generator) - 1.0));
            }
        }
        network
    }

    /// A network with these parameters; `None` if their number is not the one of the shape.
    pub fn from_parameters(shape: Shape, parameters: Vec<T>) -> Option<Network<T>> {
        let network = Network::zero(shape);
        (network.parameters.len() == parameters.len()).then_some(Network { parameters, ..network })
    }

    /// Sizes.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// All parameters.
    pub fn parameters(&self) -> &[T] {
        &self.parameters
    }

    /// All parameters, to change them.
    pub fn parameters_mut(&mut self) -> &mut [T] {
        &mut self.parameters
    }

    /// Weights of a layer, `[input][output]`; empty behind the last layer.
    pub fn weights(&self, layer: usize) -> &[T] {
        self.layers.get(layer).map_or(&[], |layer| &self.parameters[layer.weights..layer.bias])
    }

    /// Biases of a layer; empty behind the last layer.
    pub fn biases(&self, layer: usize) -> &[T] {
        self.layers.get(layer).map_or(&[], |layer| &self.parameters[layer.bias..layer.bias + layer.outputs])
    }

    /// Storage for evaluations.
    pub fn trace(&self) -> Trace<T> {
        let values: Vec<Vec<T>> = self.layers.iter().map(|layer| vec![T::default(); layer.outputs]).collect();
        Trace { errors: values.clone(), values }
    }

    /// Outputs for these active inputs. Inputs from `inputs` on are a mistake of the program.
    pub fn forward<'a>(&self, active: &[u32], trace: &'a mut Trace<T>) -> &'a [T] {
        let last = self.layers.len() - 1;
        for (l, layer) in self.layers.iter().enumerate() {
            let (before, rest) = trace.values.split_at_mut(l);
            let out = &mut rest[0];
            out.copy_from_slice(self.biases(l));
            match before.last() {
                None => active.iter().for_each(|input| add(self.row(layer, *input as usize), out)),
                Some(values) => {
                    for (input, x) in values.iter().enumerate().filter(|(_, x)| **x != T::default()) {
                        add_scaled(*x, self.row(layer, input), out);
                    }
                }
            }
            if l < last {
                out.iter_mut().for_each(|x| *x = self.shape.activation().value(*x));
            }
        }
        &trace.values[last]
    }

    /// Adds to `gradient` the derivatives of `Σ error·output` by the parameters, at the last evaluation of `trace`, which had
    /// the same active inputs.
    pub fn backward(&self, active: &[u32], trace: &mut Trace<T>, error: &[T], gradient: &mut [T]) {
        let last = self.layers.len() - 1;
        trace.errors[last].copy_from_slice(error);
        for (l, layer) in self.layers.iter().enumerate().rev() {
            let (before, rest) = trace.errors.split_at_mut(l);
            let error = &rest[0];
            add(error, &mut gradient[layer.bias..layer.bias + layer.outputs]);
            let weights = &mut gradient[layer.weights..layer.bias];
            let Some(error_before) = before.last_mut() else {
                for input in active {
                    add(error, row_mut(weights, layer, *input as usize));
                }
                continue;
            };
            for (input, x) in trace.values[l - 1].iter().enumerate() {
                let derivative = self.shape.activation().derivative(*x);
                error_before[input] = if derivative == T::default() {
                    T::default()
                } else {
                    derivative * dot(self.row(layer, input), error)
                };
                if *x != T::default() {
                    add_scaled(*x, error, row_mut(weights, layer, input));
                }
            }
        }
    }

    fn row(&self, layer: &Layer, input: usize) -> &[T] {
        let start = layer.weights + input * layer.outputs;
        &self.parameters[start..start + layer.outputs]
    }
}

fn row_mut<'a, T>(weights: &'a mut [T], layer: &Layer, input: usize) -> &'a mut [T] {
    &mut weights[input * layer.outputs..(input + 1) * layer.outputs]
}

fn add<T: Real>(x: &[T], to: &mut [T]) {
    to.iter_mut().zip(x).for_each(|(y, x)| *y += *x);
}

fn add_scaled<T: Real>(factor: T, x: &[T], to: &mut [T]) {
    to.iter_mut().zip(x).for_each(|(y, x)| *y += factor * *x);
}

/// Sums in eight lanes, which vector units of any width add up in the same order.
fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut lanes = [T::default(); 8];
    for (a, b) in a.iter().zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += *a * *b;
        }
    }
    let rest = a_rest.iter().zip(b_rest).fold(T::default(), |sum, (a, b)| sum + *a * *b);
    // Halves of the lanes, again and again: the additions that vector units make.
    let [a, b, c, d, e, f, g, h] = lanes;
    (((a + e) + (c + g)) + ((b + f) + (d + h))) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::stream;

    fn network(activation: Activation) -> Network<f64> {
        let shape = Shape::new(12, &[11, 9], 3, activation).unwrap();
        let mut network = Network::random(shape, 3, 1.0, &mut stream(8, "test", &[]));
        let mut generator = stream(9, "test", &[]);
        // Biases that are not 0, and far enough from the kinks of the rectifier.
        network.parameters_mut().iter_mut().for_each(|p| *p += 0.1 * (unit(&mut generator) - 0.5));
        network
    }

    #[test]
    fn gradients_agree_with_central_differences() {
        for activation in [Activation::Relu, Activation::Tanh] {
            let mut network = network(activation);
            let (active, error) = ([1, 4, 11], [0.3, -1.2, 0.7]);
            let mut trace = network.trace();
            let mut gradient = vec![0.0; network.parameters().len()];
            network.forward(&active, &mut trace);
            network.backward(&active, &mut trace, &error, &mut gradient);
            let mut value = |network: &Network<f64>| -> f64 {
                network.forward(&active, &mut trace).iter().zip(error).map(|(y, e)| y * e).sum()
            };
            for (i, derivative) in gradient.iter().enumerate() {
                let at = network.parameters()[i];
                network.parameters_mut()[i] = at + 1e-5;
                let above = value(&network);
                network.parameters_mut()[i] = at - 1e-5;
                let below = value(&network);
                network.parameters_mut()[i] = at;
                let expected = (above - below) / 2e-5;
                assert!((derivative - expected).abs() < 1e-8, "{activation:?} {i}: {derivative} {expected}");
            }
        }
    }

    /// The same network written as sums over all inputs, the ones that are 0 included.
    #[test]
    fn outputs_agree_with_dense_sums() {
        let network = network(Activation::Tanh);
        let active = [0, 7];
        let mut x: Vec<f64> = (0..12).map(|i| if active.contains(&i) { 1.0 } else { 0.0 }).collect();
        for l in 0..3 {
            let (weights, biases) = (network.weights(l), network.biases(l));
            let sum = |j: usize| -> f64 { (0..x.len()).map(|i| x[i] * weights[i * biases.len() + j]).sum() };
            let y: Vec<f64> = (0..biases.len()).map(|j| sum(j) + biases[j]).collect();
            x = if l < 2 { y.into_iter().map(f64::tanh).collect() } else { y };
        }
        let mut trace = network.trace();
        for (y, expected) in network.forward(&active, &mut trace).iter().zip(&x) {
            assert!((y - expected).abs() < 1e-12);
        }
    }
}

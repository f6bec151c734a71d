//! Logarithms of probabilities without overflow.

use super::Real;

/// `out[i] = x[i] - ln Σ exp(x[j])`.
pub fn log_softmax<T: Real>(x: &[T], out: &mut [T]) {
    let greatest = x.iter().copied().fold(x[0], |a, b| if b > a { b } else { a });
    let sum = x.iter().fold(T::default(), |sum, x| sum + (*x - greatest).exp());
    let shift = greatest + sum.ln();
    out.iter_mut().zip(x).for_each(|(y, x)| *y = *x - shift);
}

/// `1 / (1 + exp(-x))`.
pub fn sigmoid<T: Real>(x: T) -> T {
    let one = T::of(1.0);
    if x < T::default() {
        let e = x.exp();
        e / (one + e)
    } else {
        one / (one + (-x).exp())
    }
}

/// `ln(1 + exp(x)) = -ln(1 - sigmoid(x))`.
pub fn softplus<T: Real>(x: T) -> T {
    let one = T::of(1.0);
    if x > T::default() { x + (one + (-x).exp()).ln() } else { (one + x.exp()).ln() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn great_numbers_do_not_overflow() {
        let mut out = [0.0_f32; 3];
        log_softmax(&[1000.0, 1000.0, -1000.0], &mut out);
        assert!((out[0] - 0.5_f32.ln()).abs() < 1e-4 && out[2] < -1000.0, "{out:?}");
        assert_eq!((sigmoid(-200.0_f32), sigmoid(200.0_f32)), (0.0, 1.0));
        assert!((sigmoid(0.3_f64) - 1.0 / (1.0 + (-0.3_f64).exp())).abs() < 1e-15);
        assert_eq!((softplus(200.0_f32), softplus(-200.0_f32)), (200.0, 0.0));
    }
}

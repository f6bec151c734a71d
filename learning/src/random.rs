//! Random numbers from streams that are named after their use, so that no number depends on the order in which others are
//! drawn, and a training needs no generator in its checkpoints.

pub use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// The generator of the stream with this name and these numbers, such as `("rollout", [iteration, environment])`.
pub fn stream(seed: u64, name: &str, numbers: &[u64]) -> Pcg64 {
    // FNV-1a over the name, a separator that no text holds, and the numbers.
    let bytes = name.bytes().chain([0xff]).chain(numbers.iter().flat_map(|n| n.to_le_bytes()));
    let hash =
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    Pcg64::seed_from_u64(hash ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Between 0 and 1, both excluded.
pub fn unit(generator: &mut Pcg64) -> f64 {
    ((generator.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// Uniform over `0..count`; 0 if `count` is 0.
pub fn below(generator: &mut Pcg64, count: usize) -> usize {
    // The product with a number below 1 can round up to `count` only for counts that no memory holds.
    ((unit(generator) * count as f64) as usize).min(count.saturating_sub(1))
}

/// Index drawn with these probabilities, which add up to 1 but for rounding.
pub fn index(generator: &mut Pcg64, probabilities: &[f64]) -> usize {
    let mut left = unit(generator);
    for (i, p) in probabilities.iter().enumerate() {
        left -= p;
        if left < 0.0 {
            return i;
        }
    }
    // Rounding left a remainder: the last index that can occur.
    probabilities.iter().rposition(|p| *p > 0.0).unwrap_or(0)
}

/// Permutes `items` uniformly (Fisher and Yates).
pub fn shuffle<T>(generator: &mut Pcg64, items: &mut [T]) {
    for last in (1..items.len()).rev() {
        items.swap(last, below(generator, last + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_name_number_and_seed() {
        let first = |seed, name, numbers: &[u64]| unit(&mut stream(seed, name, numbers));
        assert_eq!(first(1, "a", &[2]), first(1, "a", &[2]));
        assert_ne!(first(1, "a", &[2]), first(1, "a", &[3]));
        assert_ne!(first(1, "a", &[2]), first(1, "b", &[2]));
        assert_ne!(first(1, "a", &[2]), first(2, "a", &[2]));
    }

    #[test]
    fn indices_have_their_probabilities() {
        let mut generator = stream(3, "test", &[]);
        let mut counts = [0; 3];
        for _ in 0..10_000 {
            counts[index(&mut generator, &[0.2, 0.0, 0.8])] += 1;
        }
        assert_eq!(counts[1], 0);
        // Five standard deviations of a binomial number.
        assert!((f64::from(counts[0]) - 2_000.0).abs() < 200.0, "{counts:?}");
    }
}

//! Random numbers from streams that are named after what they model, so that no number depends on the order of others.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// The generator of the stream of this name, such as `["duration", "h1", "0"]`.
pub(crate) fn stream(seed: u64, name: &[&str]) -> Pcg64 {
    // FNV-1a, with a separator that no text holds.
    let bytes = name.iter().flat_map(|part| part.bytes().chain([0xff]));
    let hash =
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    Pcg64::seed_from_u64(hash ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Between 0 and 1, both excluded.
pub(crate) fn unit(generator: &mut Pcg64) -> f64 {
    ((generator.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

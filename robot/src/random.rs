//! Random numbers that a seed determines, the same on every machine: for configurations, tests and measurements.

/// The generator SplitMix64.
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// Returns the next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number from 0 to 1, 1 excluded.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns a source of numbers from 0 to 1, as [`Model::random_configuration`](crate::Model::random_configuration) takes
/// one.
pub fn units(seed: u64) -> impl FnMut() -> f64 {
    let mut generator = SplitMix64(seed);
    move || generator.unit()
}

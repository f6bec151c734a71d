//! Random configurations at which rows and fields are evaluated before the first tick.

/// Number of configurations.
pub(crate) const SAMPLES: usize = 48;

/// Seed of the configurations.
pub(crate) const SEED: u64 = 0x5eed;

/// Generator of uniform numbers in 0..1: a linear congruential one is enough to spread configurations (Knuth, MMIX).
pub(crate) struct Spread(pub(crate) u64);

impl Spread {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

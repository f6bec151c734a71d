//! Settings of AIRL.

use crate::ppo::{self, SettingsError};
use serde::{Deserialize, Serialize};

/// Settings of AIRL. [`Settings::paper`] has those of the paper's Table B2 where it names them.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The policy, the generator.
    pub policy: ppo::Settings,
    /// Hidden layers of g and h, with rectifiers.
    pub hidden: Vec<usize>,
    /// Learning rate of the discriminator.
    pub rate: f64,
    /// Demonstrated steps of a gradient of the discriminator, and as many of the policy.
    pub batch: usize,
    /// Gradients of the discriminator in an iteration.
    pub updates: usize,
}

impl Settings {
    /// Table B2: both rates 4e-4, batches of 256 steps, the policy as in [`ppo::Settings::paper`]. Its *batch size gen.* 8 is
    /// read as 8 environments. The paper does not name how often the discriminator is updated.
    pub fn paper() -> Settings {
        let policy = ppo::Settings::paper();
        Settings { policy, hidden: vec![64, 64], rate: 4e-4, batch: 256, updates: 4 }
    }

    /// Checks all settings.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.policy.check()?;
        ppo::Settings { hidden: self.hidden.clone(), ..self.policy.clone() }.check()?;
        for (name, value) in [("batch", self.batch), ("updates", self.updates)] {
            if !(1..=65_536).contains(&value) {
                return Err(SettingsError::Count { name, value, most: 65_536 });
            }
        }
        if !(0.0 < self.rate && self.rate <= 1.0) {
            let range = "more than 0 and at most 1";
            return Err(SettingsError::Number { name: "rate", value: self.rate, range });
        }
        Ok(())
    }
}

//! Settings of PPO.

use crate::network::{Activation, Shape, ShapeError};
use serde::{Deserialize, Serialize};

/// Settings of PPO. [`Settings::paper`] has those of the paper's Table B2 where it names them.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Hidden layers of actor and critic, with rectifiers.
    pub hidden: Vec<usize>,
    /// Environments that are drawn at a time.
    pub environments: usize,
    /// Steps of each environment in an iteration.
    pub horizon: usize,
    /// Epochs over the steps of an iteration.
    pub epochs: usize,
    /// Steps of a gradient.
    pub minibatch: usize,
    /// Learning rate.
    pub rate: f64,
    /// γ, the discount.
    pub gamma: f64,
    /// λ of the advantages.
    pub lambda: f64,
    /// ε of the clipping.
    pub clip: f64,
    /// c, the weight of the entropy, in the unit of rewards: advantages are not normalised.
    pub entropy: f64,
    /// Greatest length of a gradient.
    pub gradient: f64,
}

/// Reason why settings cannot be used.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum SettingsError {
    /// A count of 0 or far too many.
    #[error("`{name}` is {value}; 1 to {most} are possible")]
    Count {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: usize,
        /// Greatest value.
        most: usize,
    },
    /// A number outside of its range.
    #[error("`{name}` is {value}; it must be {range}")]
    Number {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Range in words.
        range: &'static str,
    },
    /// Impossible networks.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}

impl Settings {
    /// Table B2: rate 4e-4, 8 environments, ε = 0.1, γ = 0.999, 5 epochs. The paper names neither λ, the horizon, the
    /// minibatches, the networks nor the weight of the entropy.
    pub fn paper() -> Settings {
        Settings {
            hidden: vec![64, 64],
            environments: 8,
            horizon: 128,
            epochs: 5,
            minibatch: 256,
            rate: 4e-4,
            gamma: 0.999,
            lambda: 0.95,
            clip: 0.1,
            entropy: 0.0,
            gradient: 0.5,
        }
    }

    /// Checks all settings.
    pub fn check(&self) -> Result<(), SettingsError> {
        let counts = [
            ("environments", self.environments, 4096),
            ("horizon", self.horizon, 65_536),
            ("epochs", self.epochs, 1000),
            ("minibatch", self.minibatch, 65_536),
        ];
        for (name, value, most) in counts {
            if !(1..=most).contains(&value) {
                return Err(SettingsError::Count { name, value, most });
            }
        }
        let unit = "more than 0 and at most 1";
        let numbers = [
            ("rate", self.rate, 0.0 < self.rate && self.rate <= 1.0, unit),
            ("gamma", self.gamma, 0.0 < self.gamma && self.gamma <= 1.0, unit),
            ("lambda", self.lambda, (0.0..=1.0).contains(&self.lambda), "between 0 and 1"),
            ("clip", self.clip, 0.0 < self.clip && self.clip < 1.0, "more than 0 and less than 1"),
            ("entropy", self.entropy, (0.0..=10.0).contains(&self.entropy), "between 0 and 10"),
            ("gradient", self.gradient, 0.0 < self.gradient && self.gradient <= 1e6, "more than 0 and at most 1e6"),
        ];
        for (name, value, fits, range) in numbers {
            if !fits {
                return Err(SettingsError::Number { name, value, range });
            }
        }
        self.shape(1, 1).map(|_| ()).map_err(SettingsError::from)
    }

    /// Shape of a network with these hidden layers.
    pub fn shape(&self, inputs: usize, outputs: usize) -> Result<Shape, ShapeError> {
        Shape::new(inputs, &self.hidden, outputs, Activation::Relu)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_outside_of_their_range_are_refused() {
        assert_eq!(Settings::paper().check(), Ok(()));
        let refused = |change: fn(&mut Settings)| {
            let mut settings = Settings::paper();
            change(&mut settings);
            settings.check().unwrap_err().to_string()
        };
        assert_eq!(refused(|s| s.epochs = 0), "`epochs` is 0; 1 to 1000 are possible");
        assert_eq!(refused(|s| s.gamma = f64::NAN), "`gamma` is NaN; it must be more than 0 and at most 1");
        assert_eq!(refused(|s| s.clip = 1.0), "`clip` is 1; it must be more than 0 and less than 1");
        assert_eq!(refused(|s| s.hidden = vec![0]), "a hidden layer has 0 units; 1 to 1024 are possible");
    }
}

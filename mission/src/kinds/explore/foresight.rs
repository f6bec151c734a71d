//! The prediction of the person as the planner uses it: positions at the ends of the periods, and targets that the person is
//! expected to take (armchair (10b), Algorithm 1).

use super::polygon::Point;

/// The predicted way of the person.
#[derive(Clone, Debug, PartialEq)]
pub struct Foresight {
    /// Position (m) at the present and at the end of each period, up to the arrival at the exit.
    pub positions: Vec<Point>,
    /// Targets that the person is expected to take, with the number of the period at whose end.
    pub visits: Vec<(usize, usize)>,
    /// The prediction reaches the exit.
    pub arrives: bool,
    /// Covariance of each of the positions (m^2), of ways that are drawn from the model; empty: the model draws nothing.
    pub spread: Vec<Covariance>,
}

/// A covariance of positions (m^2).
pub type Covariance = [[f64; 2]; 2];

impl Foresight {
    /// Number of periods.
    pub fn periods(&self) -> usize {
        self.positions.len().saturating_sub(1)
    }
}

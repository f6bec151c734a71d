//! Windows of temporal operators, in whole ticks.

use serde::{Deserialize, Serialize};

/// Ticks from the present one on, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// The first tick; 0 is the present one.
    pub first: u32,
    /// The last tick; `None` for the end of the run.
    pub last: Option<u32>,
}

/// Reason why two instants do not form a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WindowError {
    /// An end is negative or not finite, or the period is not a positive number.
    #[error("the ends of a window are times that are not negative")]
    NotATime,
    /// It ends before it begins.
    #[error("the window ends before it begins")]
    UpsideDown,
    /// No tick falls into it: it is shorter than the period.
    #[error("no tick falls into the window: it is shorter than the period")]
    Empty,
    /// More than 4 thousand million ticks.
    #[error("the window has more than 4 thousand million ticks")]
    TooLong,
}

/// Distance from a tick, in ticks, at which a time counts as on it: the rounding error of `0.3 s / 0.1 s`.
const ON_A_TICK: f64 = 1e-6;

impl Window {
    /// From the present tick to the end of the run.
    pub const ALWAYS: Window = Window { first: 0, last: None };

    /// Window of the ticks whose time since the present one is in `[from, to]`, all in s; `to` is `None` for the end of
    /// the run.
    ///
    /// # Errors
    /// No tick is in it, or an end is not a valid time.
    pub fn seconds(from: f64, to: Option<f64>, period: f64) -> Result<Window, WindowError> {
        let good = |x: f64| x.is_finite() && x >= 0.0;
        if !good(from) || !to.is_none_or(good) || !good(period) || period == 0.0 {
            return Err(WindowError::NotATime);
        }
        if to.is_some_and(|to| to < from) {
            return Err(WindowError::UpsideDown);
        }
        let whole = |x: f64| if x < f64::from(u32::MAX) { Ok(x as u32) } else { Err(WindowError::TooLong) };
        let first = whole((from / period - ON_A_TICK).ceil().max(0.0))?;
        let last = to.map(|to| whole((to / period + ON_A_TICK).floor())).transpose()?;
        if last.is_some_and(|last| last < first) {
            return Err(WindowError::Empty);
        }
        Ok(Window { first, last })
    }

    /// Returns true if the window of a tick reaches past the end of a run of `ticks` and is undecided for that reason:
    /// a bounded window that is cut off, or an unbounded one that has not begun.
    pub fn is_cut(self, tick: u32, ticks: u32) -> bool {
        tick.saturating_add(self.last.unwrap_or(self.first)) >= ticks
    }
}

#[cfg(test)]
mod tests {
    use super::{Window, WindowError};

    #[test]
    fn seconds_become_ticks() {
        let ticks = |from, to, period| Window::seconds(from, to, period).map(|w| (w.first, w.last));
        assert_eq!(ticks(0.0, Some(25.0), 0.005), Ok((0, Some(5000))));
        assert_eq!(ticks(0.1, Some(0.3), 0.1), Ok((1, Some(3))));
        assert_eq!(ticks(0.7, None, 0.1), Ok((7, None)));
        assert_eq!(ticks(0.05, Some(0.35), 0.1), Ok((1, Some(3))));
        assert_eq!(ticks(0.01, Some(0.02), 0.1), Err(WindowError::Empty));
        assert_eq!(ticks(2.0, Some(1.0), 0.1), Err(WindowError::UpsideDown));
        assert_eq!(ticks(-1.0, None, 0.1), Err(WindowError::NotATime));
        assert_eq!(ticks(0.0, Some(f64::NAN), 0.1), Err(WindowError::NotATime));
        assert_eq!(ticks(0.0, Some(1.0), 0.0), Err(WindowError::NotATime));
        assert_eq!(ticks(0.0, Some(1e9), 1e-3), Err(WindowError::TooLong));
    }
}

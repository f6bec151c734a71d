//! State of a mission for its pages at one instant, as the engine publishes it.

use std::sync::Arc;
use std::time::Duration;

use mission::kind::pages::PageData;
use serde::Serialize;

/// State of a mission for its pages.
#[derive(Clone, Debug)]
pub struct Published {
    /// Name of the mission.
    pub mission: Arc<str>,
    /// The clock.
    pub clock: ClockState,
    /// Delay of the mission behind its clock, if it lags.
    pub behind: Option<Duration>,
    /// Reason why the journal cannot be written, if so.
    pub unwritten: Option<String>,
    /// Contents of the pages.
    pub pages: PageData,
}

/// The clock of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockState {
    /// Mission time (s).
    pub time: f64,
    /// Mission seconds per real second.
    pub speed: f64,
    /// True if it runs.
    pub running: bool,
}

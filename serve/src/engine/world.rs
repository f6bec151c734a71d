//! Interface between the engine and a mission of either kind, with the history for its pages.

use std::sync::Arc;

use mission::chart::Chart;
use mission::map::Map;

use crate::engine::Answer;
use crate::journal::Entry;
use crate::told::{PersonTells, SupervisorTells};
use crate::view::{PersonView, SupervisorView};

/// Writes an entry into the journal, before it has an effect; returns the reason if that fails.
pub type Note<'n> = dyn FnMut(Entry) -> Result<(), String> + 'n;

/// Page contents of a mission.
pub struct Shown {
    /// Pages of the agents that can have one, by index.
    pub people: Vec<PersonView>,
    /// The page of the supervisor.
    pub supervisor: SupervisorView,
    /// The chart of the plan.
    pub plan: Arc<Chart>,
    /// The map; `None` if there is none.
    pub map: Option<Arc<Map>>,
}

/// A running mission.
pub trait World: Send {
    /// Returns the mission time (s).
    fn time(&self) -> f64;

    /// Returns the number of records.
    fn records(&self) -> usize;

    /// Advances to this time (s), which is later than now.
    fn advance(&mut self, to: f64);

    /// Applies a journal entry again at the present time. A report that was rejected then is rejected again.
    ///
    /// # Errors
    ///
    /// The reason why the report is never valid in this mission.
    fn replay(&mut self, entry: &Entry) -> Result<(), String>;

    /// Returns the page contents; `running` is the state of the clock.
    fn shown(&self, running: bool) -> Shown;

    /// Applies a report of a person.
    ///
    /// # Errors
    ///
    /// The reason for rejecting it, in words for the person.
    fn person(&mut self, agent: usize, tells: PersonTells, note: &mut Note<'_>) -> Answer;

    /// Applies a report of the supervisor.
    ///
    /// # Errors
    ///
    /// The reason for rejecting it, in words for the supervisor.
    fn supervisor(&mut self, tells: SupervisorTells, note: &mut Note<'_>) -> Answer;
}

//! What the engine carries on: a mission of one kind or the other, with what its pages remember.

use std::sync::Arc;

use mission::kinds::{layers, schedule};
use mission::plan::Plan;

use super::engine::Answer;
use super::journal::Entry;
use super::told::{PersonTells, SupervisorTells};
use super::view::{PersonView, SupervisorView};

/// Writes an entry into the journal, before it has an effect; why that cannot be, if it cannot.
pub type Note<'n> = dyn FnMut(Entry) -> Result<(), String> + 'n;

/// What a map shows: where everything is.
#[derive(Clone, Debug)]
pub enum Ground {
    /// Depots, places and waiting places.
    Schedule(Arc<schedule::problem::Problem>),
    /// Bases, objects and where they are brought.
    Layers(Arc<layers::problem::Problem>),
}

/// What pages show of a mission.
pub struct Shown {
    /// For each agent with a page of its own kind, by index, the page of it.
    pub people: Vec<PersonView>,
    /// The page of the supervisor.
    pub supervisor: SupervisorView,
    /// What the chart shows.
    pub plan: Arc<Plan>,
    /// What the map shows; none where there is none.
    pub ground: Option<Ground>,
}

/// A mission under way.
pub trait World: Send {
    /// Time of the mission (s).
    fn time(&self) -> f64;

    /// How much has happened.
    fn records(&self) -> usize;

    /// Lets time pass until then (s), which is later than now.
    fn advance(&mut self, to: f64);

    /// Does again at the present time what a journal says was told. What was refused then is refused now.
    ///
    /// # Errors
    ///
    /// Why this could never be told of this mission.
    fn replay(&mut self, entry: &Entry) -> Result<(), String>;

    /// What pages show; `running` says whether the clock does.
    fn shown(&self, running: bool) -> Shown;

    /// Takes what a person tells.
    ///
    /// # Errors
    ///
    /// Why it cannot be, in words for the person.
    fn person(&mut self, agent: usize, tells: PersonTells, note: &mut Note<'_>) -> Answer;

    /// Takes what the supervisor tells of the mission.
    ///
    /// # Errors
    ///
    /// Why it cannot be, in words for the supervisor.
    fn supervisor(&mut self, tells: SupervisorTells, note: &mut Note<'_>) -> Answer;
}

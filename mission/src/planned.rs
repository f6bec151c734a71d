//! A plan behind the interface of all kinds: how it was found, its cost, and everything that is printed or drawn of it.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::chart::Chart;
use crate::engine::{Engine, EngineError};
use crate::map::Map;
use crate::plan::{Plan, Statistics, Status};
use crate::plan_data::{Cost, Head, PlanData, VERSION};

/// Options of a planner, as far as they mean the same for all kinds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanOptions<'o> {
    /// Name of the formulation; none: the kind chooses one that suits the mission.
    pub formulation: Option<&'o str>,
    /// Engine for mixed-integer programs.
    pub engine: Engine,
    /// Number of operations or tasks that are planned at a time; none: that of the mission.
    pub batch: Option<usize>,
    /// Time limit, without a limit of nodes; none: the usual limits of the kind.
    pub time: Option<Duration>,
}

impl PlanOptions<'_> {
    /// Returns the requested formulation among those of a kind; none: none is requested.
    ///
    /// # Errors
    /// The kind has no formulation of this name.
    pub fn formulation_among<F: Copy>(&self, all: &[F], name: fn(F) -> &'static str) -> Result<Option<F>, Refusal> {
        let Some(written) = self.formulation else { return Ok(None) };
        let found = all.iter().copied().find(|formulation| name(*formulation) == written);
        let known = || all.iter().map(|formulation| name(*formulation)).collect();
        found.map(Some).ok_or_else(|| Refusal::NoFormulation { written: written.into(), known: known() })
    }
}

/// Formulation `F` of a planning problem, and the reason for its choice.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice<F> {
    /// The formulation.
    pub formulation: F,
    /// Reason for the choice, as a sentence.
    pub why: String,
}

/// A choice with the name of the formulation.
pub type Method = Choice<&'static str>;

impl<F> Choice<F> {
    /// Returns the choice with the name of the formulation.
    pub fn named(self, name: fn(F) -> &'static str) -> Method {
        Choice { formulation: name(self.formulation), why: self.why }
    }
}

/// A plan that the validator of its kind accepted.
#[derive(Debug)]
pub struct Planned {
    /// Amount of work: `12 services`.
    pub summary: String,
    /// Formulation, and the reason for it.
    pub method: Method,
    /// Engine that found it.
    pub engine: String,
    /// Proof or gap.
    pub status: Status,
    /// Amount of search.
    pub statistics: Statistics,
    /// The cost with its parts.
    pub cost: Cost,
    /// The cost with its parts in words.
    pub cost_text: String,
    /// The plan as a table.
    pub table: Listing,
    /// Its Gantt chart.
    pub chart: Chart,
    /// Its map.
    pub map: Map,
    /// The part of its JSON that only the kind knows.
    pub data: Box<dyn PlanData>,
}

impl Planned {
    /// Creates the description of a plan, with the parts that are the same for all kinds. The kind fills in the rest.
    pub fn new<A>(plan: &Plan<A>, method: Method, chart: Chart, map: Map, data: Box<dyn PlanData>) -> Planned {
        Planned {
            summary: String::new(),
            method,
            engine: plan.engine.clone(),
            status: plan.status.clone(),
            statistics: plan.statistics,
            cost: Cost::default(),
            cost_text: String::new(),
            table: Listing::default(),
            chart,
            map,
            data,
        }
    }

    /// Returns the plan of a mission of a spec as JSON; `kind` is the name of its kind.
    ///
    /// # Errors
    /// It cannot be serialised, which the types of the kinds exclude.
    pub fn to_json(&self, spec: &str, mission: &str, kind: &'static str) -> serde_json::Result<String> {
        self.data.to_json(&Head {
            version: VERSION,
            ok: true,
            spec,
            mission,
            kind,
            formulation: self.method.formulation,
            why: &self.method.why,
            engine: &self.engine,
            valid: true,
            status: &self.status,
            statistics: self.statistics,
            cost: &self.cost,
        })
    }
}

/// A table of texts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Listing {
    /// Heads of the columns.
    pub columns: Vec<&'static str>,
    /// Number of columns of names, from the first on; numbers follow.
    pub names: usize,
    /// Rows, a text a column.
    pub rows: Vec<Vec<String>>,
    /// Units and meanings of the columns.
    pub note: &'static str,
}

/// Reason why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The kind has no formulation of the requested name.
    #[error("there is no formulation `{written}`")]
    NoFormulation {
        /// The name.
        written: String,
        /// The formulations of the kind.
        known: Vec<&'static str>,
    },
    /// The requested formulation does not suit the mission.
    #[error("{why}")]
    Formulation {
        /// Reason.
        why: String,
        /// A formulation that suits every mission of the kind.
        instead: &'static str,
    },
    /// The mission cannot be planned, for these reasons.
    #[error("the mission cannot be planned: {}", .0.join("; "))]
    Mission(Vec<String>),
    /// An engine failed.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The validator rejects the plan for these reasons: a mistake in the planner.
    #[error("the planner returned an invalid plan: {}", .0.join("; "))]
    Invalid(Vec<String>),
}

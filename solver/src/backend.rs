//! Selection of a solver by name.

use serde::{Deserialize, Serialize};

use crate::{ActiveSet, ClarabelCascade, HierarchicalSolver, Problem};

/// A solver of this crate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Backend {
    /// [`ActiveSet`]: fast, exact, warm-started, without allocation.
    #[default]
    ActiveSet,
    /// [`ClarabelCascade`]: the reference.
    Clarabel,
}

impl Backend {
    /// All backends, the default first.
    pub const ALL: [Backend; 2] = [Backend::ActiveSet, Backend::Clarabel];

    /// Returns the name that selects the backend in a spec and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Backend::ActiveSet => "active_set",
            Backend::Clarabel => "clarabel",
        }
    }

    /// Returns the backend with this name.
    pub fn from_name(name: &str) -> Option<Backend> {
        Self::ALL.into_iter().find(|b| b.name() == name)
    }

    /// Returns the other backend, for comparison.
    pub fn other(self) -> Backend {
        match self {
            Backend::ActiveSet => Backend::Clarabel,
            Backend::Clarabel => Backend::ActiveSet,
        }
    }

    /// Creates a solver with storage for problems of this shape.
    pub fn solver(self, problem: &Problem) -> Box<dyn HierarchicalSolver + Send> {
        match self {
            Backend::ActiveSet => Box::new(ActiveSet::new(problem)),
            Backend::Clarabel => Box::new(ClarabelCascade::new(problem)),
        }
    }
}

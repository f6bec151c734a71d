//! Actions of a person (the paper, Appendix A): a step to one of four neighbours, or collecting a target.

use serde::{Deserialize, Serialize};

/// An action. Rows are counted upwards, so that `North` leads to the next row.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Action {
    /// One row up.
    North,
    /// One row down.
    South,
    /// One column to the left.
    West,
    /// One column to the right.
    East,
    /// Takes a target of the own cell. Without one, the person loses the step.
    Collect,
}

impl Action {
    /// Number of actions.
    pub const COUNT: usize = 5;

    /// All actions, in the order of their numbers.
    pub const ALL: [Action; Action::COUNT] =
        [Action::North, Action::South, Action::West, Action::East, Action::Collect];

    /// The four steps.
    pub const MOVES: [Action; 4] = [Action::North, Action::South, Action::West, Action::East];

    /// Number of the action, the index of its probability in a policy.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The action with this number; `None` from `COUNT` on.
    pub fn from_index(index: usize) -> Option<Action> {
        Action::ALL.get(index).copied()
    }

    /// Name in files: `north`.
    pub fn name(self) -> &'static str {
        match self {
            Action::North => "north",
            Action::South => "south",
            Action::West => "west",
            Action::East => "east",
            Action::Collect => "collect",
        }
    }

    /// The action with this name in files.
    pub fn from_name(name: &str) -> Option<Action> {
        Action::ALL.into_iter().find(|action| action.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_lead_back() {
        for (index, action) in Action::ALL.into_iter().enumerate() {
            assert_eq!(action.index(), index);
            assert_eq!(Action::from_index(index), Some(action));
            assert_eq!(Action::from_name(action.name()), Some(action));
        }
        assert_eq!(Action::from_index(Action::COUNT), None);
    }
}

//! Missions: what a team of robots and people has to do, as it was written. Which kinds, roles and settings there are is
//! the compiler's knowledge; here every kind has the same form.

use super::{Block, Comments, Values};
use crate::span::{Span, Spanned};

/// `mission vineyard : schedule { confidence 0.9  robot m1 { .. } }`
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    /// Its name.
    pub name: Spanned<String>,
    /// What is planned: `schedule`, `layers`; empty where no kind could be read.
    pub kind: Spanned<String>,
    /// Its settings.
    pub settings: Block,
    /// Who and what takes part, in the order written; those of one role have different names.
    pub members: Vec<MissionMember>,
    /// Members that are repeated; they stand behind the others.
    pub repeats: Vec<MissionRepeat>,
}

/// `robot m1 { .. }`, `task left_foot = pick_and_place { .. }`, `layer base { task .. }`
#[derive(Clone, Debug)]
pub struct MissionMember {
    /// What it is in the mission: one of [`crate::vocabulary::ROLES`].
    pub role: Spanned<String>,
    /// Its name.
    pub name: Spanned<String>,
    /// What is done, behind the `=` of a task; a task without one was reported, and nothing else has one.
    pub action: Option<Spanned<String>>,
    /// Its settings.
    pub settings: Block,
    /// What stands in it: the tasks of a layer.
    pub members: Vec<MissionMember>,
    /// What stands in it and is repeated.
    pub repeats: Vec<MissionRepeat>,
    /// The whole member.
    pub span: Span,
    /// Comments before it and behind its first line.
    pub comments: Comments,
}

impl PartialEq for MissionMember {
    fn eq(&self, other: &Self) -> bool {
        self.role == other.role
            && self.name == other.name
            && self.action == other.action
            && self.settings == other.settings
            && self.members == other.members
            && self.repeats == other.repeats
    }
}

/// `for i in 1..4 { human h${i} { .. } }`
#[derive(Clone, Debug)]
pub struct MissionRepeat {
    /// The name that takes each value in turn.
    pub variable: Spanned<String>,
    /// The values.
    pub values: Values,
    /// What is repeated.
    pub members: Vec<MissionMember>,
    /// Repetitions inside it.
    pub repeats: Vec<MissionRepeat>,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
    /// The whole repetition.
    pub span: Span,
    /// Comments before it and behind its first line.
    pub comments: Comments,
}

impl PartialEq for MissionRepeat {
    fn eq(&self, other: &Self) -> bool {
        self.variable == other.variable
            && self.values == other.values
            && self.members == other.members
            && self.repeats == other.repeats
    }
}

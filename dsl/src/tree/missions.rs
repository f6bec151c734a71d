//! Missions as written: the work of a team of robots and people. The tree gives every kind the same form; the compiler
//! knows which kinds, roles and settings exist.

use super::{Block, Comments, Values};
use crate::span::{Span, Spanned};

/// `mission vineyard : schedule { confidence 0.9  robot m1 { .. } }`
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    /// Its name.
    pub name: Spanned<String>,
    /// Kind of planning problem: `schedule`, `layers`; empty if no kind could be read.
    pub kind: Spanned<String>,
    /// Its settings.
    pub settings: Block,
    /// Participants and other members in the order written; those of one role have different names.
    pub members: Vec<MissionMember>,
    /// Repeated members; they follow the others.
    pub repeats: Vec<MissionRepeat>,
}

/// `robot m1 { .. }`, `task left_foot = pick_and_place { .. }`, `layer base { task .. }`
#[derive(Clone, Debug)]
pub struct MissionMember {
    /// Role in the mission: one of [`crate::vocabulary::ROLES`].
    pub role: Spanned<String>,
    /// Its name.
    pub name: Spanned<String>,
    /// Action after the `=` of a task. A task without one was reported; other members have none.
    pub action: Option<Spanned<String>>,
    /// Its settings.
    pub settings: Block,
    /// Nested members: the tasks of a layer.
    pub members: Vec<MissionMember>,
    /// Repeated nested members.
    pub repeats: Vec<MissionRepeat>,
    /// The whole member.
    pub span: Span,
    /// Comments before it and at the end of its first line.
    pub comments: Comments,
}

equal_by!(MissionMember: role, name, action, settings, members, repeats);

/// `for i in 1..4 { human h${i} { .. } }`
#[derive(Clone, Debug)]
pub struct MissionRepeat {
    /// Variable that takes each value in turn.
    pub variable: Spanned<String>,
    /// The values.
    pub values: Values,
    /// Repeated members.
    pub members: Vec<MissionMember>,
    /// Repetitions inside it.
    pub repeats: Vec<MissionRepeat>,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
    /// The whole repetition.
    pub span: Span,
    /// Comments before it and at the end of its first line.
    pub comments: Comments,
}

equal_by!(MissionRepeat: variable, values, members, repeats);

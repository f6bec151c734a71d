//! Missions as they are declared in a spec: blocks that the compiler bound by the tables of their kind.
//!
//! A kind owns the tables of its blocks, [`Kind::schema`](crate::kind::Kind::schema), and reads what was bound into its
//! problem, [`Kind::build`](crate::kind::Kind::build). What it refuses is a [`Remark`] at the place of a text, which the compiler underlines.

pub mod common;
pub mod driven;
mod labels;
mod origins;
mod remark;

use blocks::{BoundBlock, Located, Origin};

pub use labels::{labels, mistaken};
pub use origins::Origins;
pub use remark::{About, Advice, Remark, RemarkLabel, Remarks};

/// A mission that a spec declares.
#[derive(Clone, Debug)]
pub struct DeclaredMission {
    /// Name.
    pub name: String,
    /// Place of the name.
    pub at: Origin,
    /// Settings.
    pub settings: BoundBlock,
    /// Members in the order written. Names of different roles are distinct, apart from roles that hold members.
    pub members: Vec<DeclaredMember>,
    /// True if a member was left out because of a mistake that was reported.
    pub incomplete: bool,
}

/// A member of a mission.
#[derive(Clone, Debug)]
pub struct DeclaredMember {
    /// Role: a word of the schema around it.
    pub role: &'static str,
    /// Name.
    pub name: String,
    /// Place of the name.
    pub at: Origin,
    /// Action behind the `=` of a task.
    pub action: Option<Located<String>>,
    /// Settings.
    pub settings: BoundBlock,
    /// Members inside it, in the order written.
    pub members: Vec<DeclaredMember>,
}

impl DeclaredMission {
    /// Returns the members of a role, in the order written.
    pub fn of(&self, role: &str) -> impl Iterator<Item = &DeclaredMember> {
        self.members.iter().filter(move |member| member.role == role)
    }
}

//! The mission that a scenario executes, as names see it: its members with their roles, and examples for messages.

use mission::kind::{Kind, Measure, Mission};

/// A mission that is executed.
#[derive(Clone, Copy)]
pub(super) struct Executed<'m> {
    /// Its name in the spec.
    pub name: &'m str,
    /// The mission.
    pub mission: &'m dyn Mission,
    /// Members whose bases controllers drive in the scenario.
    pub driven: &'m [usize],
}

/// The owner of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// The mission.
    Mission,
    /// A member, by index, with its role.
    Member(usize, &'static str),
}

impl Owner {
    /// The role; none: it is the mission.
    pub fn role(self) -> Option<&'static str> {
        match self {
            Owner::Mission => None,
            Owner::Member(_, role) => Some(role),
        }
    }

    /// The index of the member; none: it is the mission.
    pub fn member(self) -> Option<usize> {
        match self {
            Owner::Mission => None,
            Owner::Member(member, _) => Some(member),
        }
    }

    /// The owner in words: `a schedule`, `a robot of a schedule`.
    pub fn describe(self, kind: &Kind) -> String {
        self.role().map_or(kind.title.to_string(), |role| format!("a {role} of {}", kind.title))
    }
}

impl<'m> Executed<'m> {
    /// The entry of its kind.
    pub fn kind(self) -> &'static Kind {
        self.mission.kind()
    }

    /// The owner of this name: a member before the mission.
    pub fn owner(self, name: &str) -> Option<Owner> {
        let members = self.mission.members();
        let found = members.iter().position(|member| member.name == name);
        let member = found.map(|index| Owner::Member(index, members[index].role));
        member.or((name == self.name).then_some(Owner::Mission))
    }

    /// Names of all members.
    pub fn members(self) -> Vec<&'m str> {
        self.mission.members().into_iter().map(|member| member.name).collect()
    }

    /// Everything that is measured of an owner.
    pub fn measures(self, of: Owner) -> impl Iterator<Item = &'static Measure> {
        (self.kind().measures)().into_iter().filter(move |measure| measure.is_of(of.role()))
    }

    /// Two names of members, for an example.
    pub fn example(self) -> (&'m str, &'m str) {
        let members = self.members();
        let name = |i: usize| members.get(i).copied();
        (name(0).unwrap_or("m1"), name(1).or(name(0)).unwrap_or("m2"))
    }
}

//! Members of a mission whose bases are driven along the planned way by controllers of their own.

use mission::kind::Mission;
use robot::{MobileBase, Model};
use serde::{Deserialize, Serialize};

use super::check::ensure;
use super::{Program, ProgramError, ScenarioProgram, Track};

/// The signals by which a controller learns of the way, and the people of its spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveProgram {
    /// The signal, a point, that is the point of the way where the base is to go now; its height is 0.
    pub target: usize,
    /// The signal, an angle (rad), that is the direction of the way there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading: Option<usize>,
    /// The signal, a flag, that is true while the robot is on a way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub going: Option<usize>,
    /// People: index of the human of the controller, and of the member of the mission that it is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub people: Vec<(usize, usize)>,
    /// Distance (m) from the end of a way within which the base has arrived.
    pub tolerance: f64,
    /// Time (s) by which the target is ahead of the planned point.
    pub lead: f64,
    /// The most (m) that the target is ahead of the base, along the way.
    pub ahead: f64,
}

/// Returns the base that drives on the ground, if a controller moves one robot that has one.
pub fn driven_base(model: &Model) -> Option<&MobileBase> {
    model.base_at(model.root()).filter(|base| base.kind.drives())
}

/// The ways of the points of a person around the person: the first one is above the origin. Where somebody stands in a world of
/// their own does not matter.
pub fn around(tracks: &[Track]) -> Vec<Track> {
    let first = tracks.first().map_or([0.0; 3], |track| track.at(0.0).0);
    let point = |track: &Track| {
        let [x, y, z] = track.at(0.0).0;
        Track(vec![(0.0, [x - first[0], y - first[1], z])])
    };
    tracks.iter().map(point).collect()
}

impl DriveProgram {
    /// Makes sure that it can be run.
    pub(super) fn check(
        &self,
        program: &Program,
        world: &ScenarioProgram,
        mission: &dyn Mission,
        place: &str,
    ) -> Result<(), ProgramError> {
        let is = |signal: usize, kind: &str| {
            program
                .interface
                .signals
                .get(signal)
                .is_some_and(|s| s.kind == kind && !s.is_variable() && !s.is_of_person() && s.sent() == s.len)
        };
        ensure(driven_base(&program.robot.model).is_some(), place, "the robot has no base that drives on the ground")?;
        ensure(is(self.target, "point"), &format!("{place}.target"), "is no signal that is a point")?;
        let heading = self.heading.is_none_or(|signal| is(signal, "angle"));
        ensure(heading, &format!("{place}.heading"), "is no signal that is an angle")?;
        let going = self.going.is_none_or(|signal| is(signal, "flag"));
        ensure(going, &format!("{place}.going"), "is no signal that can be true")?;
        let members = mission.members().len();
        for (i, (human, member)) in self.people.iter().enumerate() {
            let again = self.people[..i].iter().any(|other| other.0 == *human);
            let script = world.world.humans.iter().any(|script| script.human == *human);
            let good = !again && *member < members && script;
            ensure(good, &format!("{place}.people"), "names somebody who does not exist, or twice")?;
        }
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let good = positive(self.tolerance) && positive(self.ahead) && self.lead.is_finite() && self.lead >= 0.0;
        ensure(good, place, "a length or a time of it is out of its range")
    }
}

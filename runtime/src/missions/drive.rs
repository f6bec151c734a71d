//! A member whose base is driven along the planned way by a controller of its own.
//!
//! Before each tick the people of its spec are put where the members that they are truly stand, the mission is told where the
//! base truly is, and the controller where it is to go. Signals are those of the tick: nothing is known of the future of people.

use mission::kind::course::{Course, GroundPose};
use mission::kind::{Execution, WorkState};
use serde::Serialize;

use crate::controller::Controller;
use crate::program::DriveProgram;
use crate::world::World;

/// Results of a driven base.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DriveRecord {
    /// Length of the way that the base has driven, in m.
    pub travelled_m: f64,
    /// Greatest distance of the base from the way that it followed, in m.
    pub off_way_m: f64,
}

/// The base of a member under way.
pub(super) struct Drive {
    program: DriveProgram,
    member: usize,
    /// Its pose at the last tick.
    pose: Option<GroundPose>,
    /// Positions of people at the last tick (m), and its time (s).
    seen: Vec<([f64; 2], f64)>,
    pub record: DriveRecord,
}

/// Values that a controller gets at a tick.
pub(super) struct Told {
    target: GroundPose,
    going: bool,
    /// The end of the way is reached.
    pub arrived: bool,
}

impl Drive {
    pub fn new(program: &DriveProgram, member: usize) -> Drive {
        let record = DriveRecord::default();
        Drive { program: program.clone(), member, pose: None, seen: Vec::new(), record }
    }

    /// A tick at a time (s) of the mission begins, with the robot at a configuration; none: the mission has no such member.
    pub fn look(
        &mut self,
        q: &[f64],
        time: f64,
        world: Option<&mut World>,
        execution: &mut dyn Execution,
    ) -> Option<Told> {
        self.look_at_people(time, world, execution);
        let [x, y, heading] = q else { return None };
        let pose = GroundPose { at: [*x, *y], heading: *heading };
        execution.drive(self.member, time, pose);
        let course = execution.course(self.member)?;
        self.note(pose, &course);
        let DriveProgram { tolerance, lead, ahead, .. } = self.program;
        let going = course.state == WorkState::Works;
        let arrived = going && course.is_reached(pose.at, tolerance, tolerance + ahead);
        Some(Told { target: course.target(time, lead, ahead), going, arrived })
    }

    /// Puts people where they truly are.
    fn look_at_people(&mut self, time: f64, world: Option<&mut World>, execution: &dyn Execution) {
        let Some(world) = world else { return };
        let first = self.seen.is_empty();
        for (i, (human, member)) in self.program.people.iter().enumerate() {
            let at = execution.pose(*member, time).map_or([f64::NAN; 2], |pose| pose.at);
            let (before, then) = self.seen.get(i).copied().unwrap_or((at, time));
            let passed = time - then;
            let velocity = [0, 1].map(|axis| if passed > 0.0 { (at[axis] - before[axis]) / passed } else { 0.0 });
            world.place_person(*human, [at[0], at[1], 0.0], [velocity[0], velocity[1], 0.0]);
            match self.seen.get_mut(i).filter(|_| !first) {
                Some(seen) => *seen = (at, time),
                None => self.seen.push((at, time)),
            }
        }
    }

    fn note(&mut self, pose: GroundPose, course: &Course<'_>) {
        let before = self.pose.replace(pose).map_or(pose.at, |pose| pose.at);
        self.record.travelled_m += f64::hypot(pose.at[0] - before[0], pose.at[1] - before[1]);
        // A base that has arrived begins the next way from near its begin.
        if course.state == WorkState::Works && course.length() > self.program.tolerance {
            self.record.off_way_m = self.record.off_way_m.max(off(pose.at, course.points));
        }
    }

    /// Passes the signals of a tick to the controller. `time` is that of its clock (s).
    pub fn tell(&self, told: &Told, controller: &mut Controller, time: f64) {
        let signals = controller.signals();
        let [x, y] = told.target.at;
        signals.set(self.program.target, &[x, y, 0.0], time);
        if let Some(heading) = self.program.heading {
            signals.set(heading, &[told.target.heading], time);
        }
        if let Some(going) = self.program.going {
            signals.set(going, &[if told.going { 1.0 } else { -1.0 }], time);
        }
    }
}

/// Distance of a point from a polyline (m).
fn off(p: [f64; 2], points: &[[f64; 2]]) -> f64 {
    let to = |[a, b]: [[f64; 2]; 2]| {
        let [u, v] = [[b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]];
        let squared = u[0] * u[0] + u[1] * u[1];
        let share = if squared > 0.0 { ((u[0] * v[0] + u[1] * v[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
        f64::hypot(v[0] - share * u[0], v[1] - share * u[1])
    };
    let single = points.first().map_or(0.0, |first| to([*first, *first]));
    points.windows(2).map(|two| to([two[0], two[1]])).reduce(f64::min).unwrap_or(single)
}

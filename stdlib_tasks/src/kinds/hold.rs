//! Keeps frames where they were when the stack became active.

use nalgebra::{Isometry3, Vector3};
use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::clik::{self, OrientationTarget, PositionTarget};
use crate::kinds::frame_pose::{pose_measures, pose_rows};
use crate::params::{Input, ParamType, Presence};
use crate::task::{BuildError, Context, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};

crate::params! {
    /// Parameters of `hold`.
    pub struct Params {
        /// The frames: links, or arms, which stand for their tips.
        frames: Vec<(String, LinkId)> = ParamType::Frames, Presence::Required;
        /// K: how fast the errors decay.
        gain: Input<2> = ParamType::Gains(&["linear", "angular"]), Presence::Default("2 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "hold",
    summary: "keeps frames at their poses at the entry of the stack",
    docs: "Six equality rows for each frame, in the world's axes: those of `frame_pose` with a constant target,\n\n\
```text\n\
J_p v = K_linear  (p_0 - p)        [m/s]\n\
J_o v = K_angular log(R_0 R^T)     [rad/s]\n\
```\n\n\
where `p_0`, `R_0` are the position and orientation of the frame in the world at the moment the stack became \
active. The other symbols, frames and units are those of `frame_pose`. The task reports the two errors of each \
frame.\n\n\
Source: thesis (3.33), (3.34) with a constant desired value.",
    example: "task still = hold(left, right)",
    positional: &["frames"],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct Hold {
    frames: Vec<(String, LinkId)>,
    targets: Vec<Isometry3<f64>>,
    gain: Input<2>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.frames.is_empty() {
        return Err(BuildError::new("frames", "no frame is named that could be held").help("name links or arms"));
    }
    let targets = vec![Isometry3::identity(); params.frames.len()];
    Ok(Box::new(Hold { frames: params.frames, targets, gain: params.gain }))
}

impl Task for Hold {
    fn rows(&self) -> Vec<RowInfo> {
        self.frames.iter().flat_map(|(name, _)| pose_rows(&format!("{name}."))).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        self.frames.iter().flat_map(|(name, _)| pose_measures(&format!("{name}."))).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn enter(&mut self, state: &State) {
        for (target, (_, link)) in self.targets.iter_mut().zip(&self.frames) {
            *target = *state.data.pose(*link);
        }
    }

    crate::task::takes_over!(targets);

    fn remembers_entry(&self) -> bool {
        true
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [linear, angular] = self.gain.of(state.values);
        for (i, (target, (_, link))) in self.targets.iter().zip(&self.frames).enumerate() {
            let position = PositionTarget { position: target.translation.vector, velocity: Vector3::zeros() };
            rows.measures[2 * i] = clik::position(state, rows, 6 * i, *link, &position, linear);
            let rotation = OrientationTarget { orientation: target.rotation, angular_velocity: Vector3::zeros() };
            rows.measures[2 * i + 1] = clik::orientation(state, rows, 6 * i + 3, *link, &rotation, angular);
        }
        Ok(())
    }
}

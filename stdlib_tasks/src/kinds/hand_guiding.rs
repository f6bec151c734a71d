//! Lets a person lead a frame by hand: a body with mass and damping that moves where it is pushed, and stays there.

use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::compliance::{Body, Damping, Impedance, Mass, Motion, Wrench, read};
use crate::dimension::{ANGULAR_VELOCITY, VELOCITY};
use crate::kinds::frame_pose::pose_rows;
use crate::params::{ParamType, Presence};
use crate::task::{BuildError, Context, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};

crate::params! {
    /// Parameters of `hand_guiding`.
    pub struct Params {
        /// The frame: a link of the robot, or an arm, which stands for its tip.
        frame: (String, LinkId) = ParamType::Frame, Presence::Required;
        /// Km: virtual mass and inertia of the frame.
        mass: BoundParams = ParamType::Group(Mass::INFO), Presence::Required;
        /// Kd: virtual damping of its motion; a steady force f moves it at `f / Kd`.
        damping: BoundParams = ParamType::Group(Damping::INFO), Presence::Required;
        /// h: wrench that a person exerts on the robot at the frame.
        wrench: BoundParams = ParamType::Group(Wrench::INFO), Presence::Required;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "hand_guiding",
    summary: "lets a person lead a frame by hand",
    docs: "Six equality rows, three for the position and three for the orientation, in the world's axes: those \
of `admittance` without a target and without stiffness,\n\n\
```text\n\
J v = (Km v_prev + T h) / (Km + T Kd)      [m/s], [rad/s]\n\n\
J       6×n  m/rad, rad/rad  Jacobian of the frame at its origin, in the world's axes, linear rows first\n\
v       n×1  rad/s or m/s    velocity of the n degrees of freedom\n\
h       N or N m             wrench at the frame's origin, exerted on the robot\n\
v_prev  m/s or rad/s         J v_stack, with the velocity v_stack that the stack returned at the last tick\n\
Km, Kd  one for each axis    mass [kg, kg m^2] and damping [N s/m, N m s/rad]\n\
T       s                    control period\n\
```\n\n\
A steady force leads to the velocity `h / Kd` within a few times `Km / Kd`, for any period T. When the force \
ends, the frame comes to rest within the same time and stays there. Without `moment`, the orientation comes to \
rest and stays. The task reports as errors the differences between the velocities that the rows require and \
those that the hierarchy returned: they are not zero if limits or more important levels hold the frame back.\n\n\
A `blend` neither pushes nor holds the frame: `v_stack` does not contain its offset. The page of `admittance` \
describes wrench, units, changes of mass and damping at run time, and faults.\n\n\
Source: thesis (4.46) with `Kp = 0`, `a_d = v_d = 0`; the signs of its right side are corrected, and the rows are not \
scaled by `Km/T + Kd`.",
    example: "task lead = hand_guiding(tool) {\n  \
mass { linear 20 kg  angular 3 kg m^2 }\n  \
damping { linear 253 N s/m  angular 27 N m s }\n  \
wrench { force [0, 10, 0] N * smoothstep(t/(1 s)) }\n}",
    positional: &["frame"],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct HandGuiding {
    body: Body,
    /// Rows of this tick, `nv` numbers each, and the velocities that they ask for.
    jacobian: Vec<f64>,
    wanted: [f64; 6],
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let mass = read("mass", &params.mass, Mass::from_bound)?;
    let damping = read("damping", &params.damping, Damping::from_bound)?;
    let wrench = read("wrench", &params.wrench, Wrench::from_bound)?;
    let body = Body::new(params.frame.1, ctx, Impedance { mass, damping, stiffness: None }, wrench)?;
    Ok(Box::new(HandGuiding { body, jacobian: vec![0.0; 6 * ctx.model.nv()], wanted: [0.0; 6] }))
}

impl Task for HandGuiding {
    fn rows(&self) -> Vec<RowInfo> {
        let dimension = |i: usize| if i < 3 { VELOCITY } else { ANGULAR_VELOCITY };
        pose_rows("").into_iter().enumerate().map(|(i, r)| RowInfo { dimension: dimension(i), ..r }).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![
            Measure { name: "linear".to_string(), dimension: VELOCITY },
            Measure { name: "angular".to_string(), dimension: ANGULAR_VELOCITY },
        ]
    }

    fn enter(&mut self, _state: &State) {
        self.body.enter();
    }

    crate::task::takes_over!(body);

    fn hand_over(&mut self) {
        self.body.hand_over();
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        self.body.update(state, rows, &Motion::default())?;
        let nv = state.model.nv();
        for (i, (kept, wanted)) in self.jacobian.chunks_exact_mut(nv.max(1)).zip(&mut self.wanted).enumerate() {
            *wanted = rows.lower[i];
            for (k, j) in kept.iter_mut().zip(rows.row(i).iter()) {
                *k = *j;
            }
        }
        Ok(())
    }

    fn observe(&self, state: &State, v: &[f64], _margins: &mut [f64], measures: &mut [f64]) {
        let rows = self.jacobian.chunks_exact(state.model.nv().max(1)).zip(&self.wanted);
        let mut squares = [0.0; 2];
        for (i, (row, wanted)) in rows.enumerate() {
            let is: f64 = row.iter().zip(v).map(|(j, v)| j * v).sum();
            squares[usize::from(i >= 3)] += (wanted - is).powi(2);
        }
        for (measure, s) in measures.iter_mut().zip(squares) {
            *measure = s.sqrt();
        }
    }
}

//! Safety field between people and the robot, and the planner that keeps it above a threshold: thesis 4.2, corrected.
//!
//! [`Field`] measures the distance of the whole robot from all observed points of a person, with exact derivatives.
//! [`Decomposition`] splits its rate into the contributions of the clock of a protected task, of deviations from its
//! path, of internal motion and of the person. [`SafetyPlanner`] decides about these inputs. [`SpeedAndSeparation`] is
//! the rule of ISO/TS 15066. The field itself and that rule belong to the task library. Nothing here depends on the
//! hierarchy: the controller passes rows in and writes the results back into its levels.
//!
//! Constructors allocate all memory; functions that run in a tick neither allocate nor panic.
//!
//! # A tick
//!
//! ```
//! use hierarq_runtime::safety::*;
//! use nalgebra::Vector3;
//! use robot::{Data, LinkId, Model, Options};
//!
//! # let text = include_str!("../../../examples/robots/arm7.urdf");
//! # let Ok((model, _)) = Model::from_urdf(text, &Options::default()) else { panic!("not a robot") };
//! // Once: which links count, and a planner for a task of three rows (a position) that may leave its path.
//! let n = model.nv();
//! let links: Vec<LinkId> = (1..model.links.len() as u32).map(LinkId).collect();
//! let mut field = Field::new(&model, Body::of_links(&model, &links)?, Chi::Distance, Over::Mean, 3)?;
//! let aside = Deviation {
//!     kind: DeviationKind::Position,
//!     row: 0,
//!     stiffness: 2.0,
//!     speed: [-0.4, 0.4],
//!     reach: Some(0.2),
//!     direction: Direction::Gradient,
//!     weight: 1.0,
//! };
//! let settings = PlannerSettings {
//!     period: 0.005,
//!     gain: 10.0,
//!     internal_gain: 1.0,
//!     internal_speed: vec![1.0; n],
//!     weights: Weights::default(),
//!     deviations: vec![aside],
//!     damping: Damping::default(),
//!     strategy: Strategy::Program,
//! };
//! let mut planner = SafetyPlanner::new(settings, 3, n, &[])?;
//! planner.restart(0.0);
//!
//! // At each tick: kinematics, people, and the task's rows with its target at the planner's clock.
//! let data = Data::new(&model);
//! let people = [HumanPoint { position: Vector3::new(0.6, 0.2, 0.8), velocity: Vector3::new(-0.5, 0.0, 0.0) }];
//! field.update(&model, &data, &people)?;
//! # let mut j = nalgebra::DMatrix::zeros(6, n);
//! # let tip = LinkId(model.links.len() as u32 - 1);
//! # data.jacobian(&model, tip, data.position(tip), &mut j);
//! # let jacobian: Vec<f64> = j.rows(0, 3).transpose().iter().copied().collect();
//! let target = *data.position(tip) + Vector3::new(0.0, 0.01, 0.0); // of the path at planner.clock()
//! let eta = [0.0, 0.1, 0.0]; // its rate there
//! let feedback = (target + planner.offset(0) - data.position(tip)) * 20.0;
//! let task = TaskRows { jacobian: &jacobian, stride: n, eta: &eta, feedback: feedback.as_slice() };
//! let frames = [Frame::default()];
//! planner.decide(&Tick { field: &field, threshold: 0.9, threshold_rate: 0.0, task, frames: &frames, above: &[] })?;
//! let plan = planner.plan();
//! // rows of the task: J v = plan.rate + feedback; a level below it: v = plan.u_n. Then:
//! assert!(plan.u_c <= 1.0 && plan.u_alpha[0] >= 0.0);
//! planner.advance(1.0);
//! # Ok::<(), SafetyError>(())
//! ```

mod decomposition;
mod deviation;
mod limited;
mod one_row;
mod planner;
mod strategy;

pub use decomposition::{Damping, Decomposition, Push, TaskRows};
pub use deviation::{Deviation, DeviationKind, Direction, Frame, towards};
pub use limited::{RowCurvature, TaskLevel};
pub use one_row::{OneRowProgram, Outcome};
pub use planner::{Plan, PlannerSettings, SafetyPlanner, Tick, Weights};
pub use stdlib_tasks::field::{
    Attached, Body, Chi, DistanceFunction, Field, GaussLegendre, HumanPoint, LinkSegment, Mean, Over, SafetyError,
    SpeedAndSeparation, Stopping, Verdict, line_mean, mean_distance,
};
pub use strategy::{Strategy, task_share};

#[cfg(test)]
#[path = "../../../stdlib_tasks/src/field/testing.rs"]
mod testing;

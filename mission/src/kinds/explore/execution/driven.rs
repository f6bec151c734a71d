//! Robots whose bases controllers of their own drive.
//!
//! The plan moves such a robot by its dynamics, and the target of its controller is a point of this motion. Contacts, connections, targets and maps know
//! the true position of the base. Plans keep the tolerance of the base in reserve: bodies are larger by it, targets and ranges smaller. A base
//! within its tolerance thus meets all constraints of the plan, and the next plan begins where the last one leads. A base that is farther
//! from it is where nobody planned it to be: the next plan begins with its true position and velocity.

use super::super::motion::State;
use super::super::polygon::{Convex, Point, distance};
use super::super::problem::Problem;
use super::{ExploreExecution, LogEntry};
use crate::kind::course::{Course, Driven, GroundPose, covered};
use crate::kind::{Work, WorkState};

/// Time over which the velocity of a base is measured (s). Ours.
const SAMPLE: f64 = 0.1;
/// Length (m) of the next part of a motion on which the nearest point to a base is looked for. Ours.
const REACH: f64 = 1.0;
/// Points of a motion in each period.
const POINTS: usize = 10;

/// The base of a robot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DrivenBase {
    /// Distance from the planned motion within which it keeps to the plan (m).
    tolerance: f64,
    /// True position and velocity.
    pub state: State,
    /// Time (s) of that.
    when: f64,
    /// The position (m) that was seen at a time (s), from which its velocity is measured.
    seen: (Point, f64),
    /// The motion that it follows (m), with the times (s) of its points.
    points: Vec<Point>,
    times: Vec<f64>,
    /// Share of it that it has covered.
    share: f64,
}

impl DrivenBase {
    /// A base that stands at the start.
    pub fn new(at: Point, tolerance: f64) -> DrivenBase {
        let state = State { at, velocity: [0.0; 2] };
        DrivenBase { tolerance, state, when: 0.0, seen: (at, 0.0), points: vec![at], times: vec![0.0], share: 1.0 }
    }
}

/// The problem of plans that keep the tolerances of driven bases in reserve.
///
/// # Errors
/// A tolerance is too large for a target or for the range, in a sentence.
pub(super) fn with_reserves(problem: &Problem, driven: &[Driven]) -> Result<Problem, String> {
    let mut kept = problem.clone();
    let square = |half: f64| Convex::rectangle([2.0 * half; 2]);
    let most = driven.iter().map(|of| of.tolerance).fold(0.0, f64::max);
    let (Some(one), Some(two)) = (square(most), square(2.0 * most)) else { return Ok(kept) };
    for of in driven {
        if let (Some(robot), Some(square)) = (kept.robots.get_mut(of.member), square(of.tolerance)) {
            robot.body = robot.body.sum(&square);
        }
    }
    for (target, of) in kept.targets.iter_mut().zip(&problem.targets) {
        target.shape = of.shape.difference(&one).ok_or_else(|| {
            format!("the target `{}` is smaller than twice the `tolerance` of a driven robot, {most} m", of.name)
        })?;
    }
    kept.connection =
        problem.connection.difference(&two).ok_or("the range is smaller than the `tolerance` of driven robots")?;
    Ok(kept)
}

impl ExploreExecution {
    /// The base of a robot is at a pose, at a time (s) between the present and the next step.
    pub(super) fn drive_base(&mut self, robot: usize, time: f64, to: GroundPose) {
        let most = self.problem.robots.get(robot).map_or(0.0, |robot| robot.speed);
        let Some(mover) = self.robots.get_mut(robot) else { return };
        let Some(base) = &mut mover.base else { return };
        mover.travelled += distance(base.state.at, to.at);
        let (from, since) = base.seen;
        if time - since >= SAMPLE - 1e-9 {
            base.state.velocity = [0, 1].map(|i| ((to.at[i] - from[i]) / (time - since)).clamp(-most, most));
            base.seen = (to.at, time);
        }
        (base.state.at, base.when) = (to.at, time);
        base.share = covered(&base.points, base.share, to.at, REACH);
    }

    /// The motion that the base of a robot follows; none: nobody drives it.
    pub(super) fn course_of(&self, robot: usize) -> Option<Course<'_>> {
        let base = self.robots.get(robot)?.base.as_ref()?;
        let end = base.points.last().copied().unwrap_or(base.state.at);
        let state = match self.base_work(robot)?.state {
            WorkState::Works if distance(end, base.state.at) <= base.tolerance => WorkState::Waits,
            own => own,
        };
        let ends = base.times.last().copied().unwrap_or(self.time);
        let (points, times) = (&base.points[..], &base.times[..]);
        Some(Course { state, points, times, share: base.share, from: [0.0, self.time], ends, heading: 0.0 })
    }

    /// The work of a driven robot.
    pub(super) fn base_work(&self, robot: usize) -> Option<Work> {
        let mover = self.robots.get(robot).filter(|mover| mover.base.is_some())?;
        let state = match (mover.active, self.done) {
            (false, _) => WorkState::Lost,
            (_, Some(_)) => WorkState::Over,
            _ => WorkState::Works,
        };
        Some(Work { state, since: 0.0 })
    }

    /// Lets the plan begin where bases truly are that have left it.
    pub(super) fn look_at_bases(&mut self) {
        let (mut left, now) = (Vec::new(), self.time);
        for (robot, mover) in self.robots.iter_mut().enumerate().filter(|(_, mover)| mover.active) {
            let Some(base) = &mover.base else { continue };
            // It was seen at the last tick of its controller.
            let State { at, velocity } = base.state;
            let at = [0, 1].map(|i| at[i] + velocity[i] * (now - base.when));
            let by = distance(at, mover.state.at);
            if by > base.tolerance {
                mover.state = State { at, velocity };
                left.push(LogEntry::OffPlan { robot, by });
            }
        }
        // Without a plan there is none that could be left.
        if !self.without_plan {
            left.into_iter().for_each(|entry| self.record(entry));
        }
    }

    /// Lays the motions that bases follow from now on: those of the plan, or of the inputs that the robots hold.
    pub(super) fn lay_motions(&mut self) {
        let (period, now) = (self.problem.period, self.time);
        let plan = self.plan.as_ref().filter(|_| !self.without_plan);
        for (robot, (mover, who)) in self.robots.iter_mut().zip(&self.problem.robots).enumerate() {
            let Some(base) = &mut mover.base else { continue };
            let inputs: Vec<Point> = match plan {
                _ if !mover.active => Vec::new(),
                Some(plan) => {
                    let inputs = &plan.trajectories.inputs[robot];
                    inputs.iter().skip(plan.step.saturating_sub(1)).copied().collect()
                }
                None => vec![mover.input],
            };
            let mut state = if mover.active { mover.state } else { base.state };
            (base.points, base.times, base.share) = (vec![state.at], vec![now], 0.0);
            for (step, input) in inputs.into_iter().enumerate() {
                for part in 1..=POINTS {
                    let passed = period * part as f64 / POINTS as f64;
                    base.points.push(who.dynamics.after(state, input, passed).at);
                    base.times.push(now + step as f64 * period + passed);
                }
                state = who.dynamics.after(state, input, period);
            }
            base.share = covered(&base.points, 0.0, base.state.at, REACH);
        }
    }
}

//! Series thin enough to plot: at most [`MAX_SAMPLES`] samples each, with the worst value of each stretch of ticks.

use robot::LinkId;
use stdlib_tasks::task::RowKind;

use super::roster::Roster;
use crate::controller::Controller;
use crate::evaluator::Member;
use crate::tick::{Recorder, Tick};

/// Largest number of samples.
pub const MAX_SAMPLES: usize = 1000;

/// Series of a run. Every `Vec<Vec<f64>>` has one inner vector per sample; numbers of tasks and levels that do not run
/// are NaN.
pub struct SeriesRecorder {
    stride: usize,
    /// Times, in s.
    pub times: Vec<f64>,
    /// True configurations.
    pub q: Vec<Vec<f64>>,
    /// Commanded velocities.
    pub command: Vec<Vec<f64>>,
    /// Magnitudes of the accelerations of the velocity that the hierarchy chose: the largest of the stretch.
    pub acceleration: Vec<Vec<f64>>,
    /// Margins: the smallest of the stretch.
    pub margins: Vec<Vec<f64>>,
    /// Errors: the largest of the stretch.
    pub measures: Vec<Vec<f64>>,
    /// Weighted norm of each level's slack: the largest of the stretch.
    pub violations: Vec<Vec<f64>>,
    /// Number of rows at a bound, for each level: the largest of the stretch.
    pub active: Vec<Vec<f64>>,
    /// Tables of signals that the controller used.
    pub signals: Vec<Vec<f64>>,
    /// Poses of the links that are drawn, seven numbers each: position, then `w x y z`.
    pub poses: Vec<Vec<f64>>,
    /// The links that are drawn.
    pub links: Vec<LinkId>,
    /// The tasks and levels.
    pub roster: Roster,
    period: f64,
    /// Velocity at the previous tick.
    before: Vec<f64>,
}

impl SeriesRecorder {
    /// Prepares for a run of so many ticks, with the links that are drawn.
    pub fn new(controller: &Controller, ticks: usize, links: Vec<LinkId>) -> Self {
        SeriesRecorder {
            stride: ticks.div_ceil(MAX_SAMPLES).max(1),
            times: Vec::new(),
            q: Vec::new(),
            command: Vec::new(),
            acceleration: Vec::new(),
            margins: Vec::new(),
            measures: Vec::new(),
            violations: Vec::new(),
            active: Vec::new(),
            signals: Vec::new(),
            poses: Vec::new(),
            links,
            roster: Roster::new(controller),
            period: controller.period(),
            before: vec![0.0; controller.velocity().len()],
        }
    }

    /// The members with rows of a kind.
    pub fn members_of(&self, row_kind: RowKind) -> impl Iterator<Item = &Member> {
        self.roster.members.iter().filter(move |m| m.row_kind == row_kind)
    }
}

fn worst(into: &mut Vec<Vec<f64>>, new: impl Iterator<Item = f64>, first: bool, pick: fn(f64, f64) -> f64) {
    match into.last_mut() {
        Some(last) if !first => last.iter_mut().zip(new).for_each(|(old, x)| *old = pick(*old, x)),
        _ => into.push(new.collect()),
    }
}

impl Recorder for SeriesRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let first = tick.index.is_multiple_of(self.stride);
        if first {
            self.times.push(tick.time);
            self.q.push(tick.q.to_vec());
            self.command.push(tick.command.to_vec());
            self.signals.push(tick.controller.signal_table().to_vec());
            let mut poses = Vec::with_capacity(7 * self.links.len());
            for &link in &self.links {
                let pose = tick.evaluator.data().pose(link);
                let (p, r) = (pose.translation.vector, pose.rotation);
                poses.extend([p.x, p.y, p.z, r.w, r.i, r.j, r.k]);
            }
            self.poses.push(poses);
        }
        let accelerations = self.before.iter().zip(tick.v).map(|(before, v)| (v - before).abs() / self.period);
        worst(&mut self.acceleration, accelerations, first, f64::max);
        self.before.copy_from_slice(tick.v);
        worst(&mut self.margins, self.roster.margins(tick).into_iter(), first, f64::min);
        worst(&mut self.measures, self.roster.measures(tick).into_iter(), first, f64::max);
        worst(&mut self.violations, self.roster.levels(tick, |l| l.violation).into_iter(), first, f64::max);
        let at_bound = |l: &solver::LevelSolution| {
            use solver::Active;
            l.active.iter().filter(|a| matches!(a, Active::Lower | Active::Upper | Active::Violated)).count() as f64
        };
        worst(&mut self.active, self.roster.levels(tick, at_bound).into_iter(), first, f64::max);
        Ok(())
    }
}

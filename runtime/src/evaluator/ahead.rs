//! Margins after a tick: those of limits on hard levels at the configuration to which the chosen velocity leads.
//!
//! With `V` a bound of the speed at which a distance may change,
//!
//! ```text
//! V  =  R sum_i |w_i|  +  sum_k |u_k|        w: rad/s of turning joints, u: m/s of sliding ones
//! ```
//!
//! and `R` the largest distance of a part from a joint that moves it, a margin that is larger than what a period can take of
//! it need not be computed again.

use robot::{Data, Drive, Joint, JointKind, Model};
use solver::Level;
use stdlib_tasks::clearance::stroke;
use stdlib_tasks::task::State;

use super::Evaluator;
use crate::fault::{MARGIN_TOLERANCE, PASSED};

/// Distance in m by which a margin may be below zero after a tick: half of what a summary counts as violated.
const TOLERANCE: f64 = 0.5 * MARGIN_TOLERANCE;

/// Factor on what a margin lacks. The velocity that gives it may lose a little more than the one before; with this
/// factor, one round nearly always suffices.
const MORE: f64 = 1.25;

/// Storage for the margins after a tick. Nothing here allocates after [`Ahead::new`].
pub(crate) struct Ahead {
    period: f64,
    /// Limits on hard levels that look ahead, as indices of members.
    members: Vec<usize>,
    /// Largest distance of a part from a joint that moves it, in m.
    reach: f64,
    /// Sums of the absolute factors with which a degree of freedom turns and slides joints.
    turns: Vec<f64>,
    slides: Vec<f64>,
    /// Configuration after the period.
    q: Vec<f64>,
    data: Data,
}

impl Ahead {
    /// Prepares for the stack of an evaluator, whose hard levels are marked.
    pub fn new(evaluator: &Evaluator, hard: &[bool], period: f64) -> Ahead {
        let model = &evaluator.model;
        let on_hard = |level: usize| hard.get(level).copied().unwrap_or(false);
        let looks = |i: &usize| on_hard(evaluator.members[*i].level) && evaluator.tasks[*i].looks_ahead();
        let members: Vec<usize> = (0..evaluator.members.len()).filter(looks).collect();
        let chain = longest_chain(model);
        let reach = members.iter().map(|&i| evaluator.tasks[i].reach(chain)).fold(0.0, f64::max);
        let (mut turns, mut slides) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
        for dof in model.bases.iter().flat_map(|base| base.dofs()) {
            let of_base = model.dofs[dof].unit.select(&mut slides, &mut turns);
            of_base[dof] += 1.0;
        }
        for joint in &model.joints {
            let (dof, factor) = match joint.drive {
                Drive::Dof(dof) => (dof, 1.0),
                Drive::Mimic { dof, multiplier, .. } => (dof, multiplier.abs()),
                Drive::Fixed | Drive::Locked(_) => continue,
            };
            match joint.kind {
                JointKind::Prismatic => slides[dof] += factor,
                _ => turns[dof] += factor,
            }
        }
        Ahead { period, reach, members, turns, slides, q: vec![0.0; model.nq()], data: Data::new(model) }
    }

    /// Returns true if no limit looks ahead.
    pub fn is_idle(&self) -> bool {
        self.members.is_empty()
    }

    /// Bound of the change of a distance in one period, in m.
    fn change(&self, v: &[f64]) -> f64 {
        let sum = |factors: &[f64]| factors.iter().zip(v).map(|(f, v)| f * v.abs()).sum::<f64>();
        let turning = sum(&self.turns);
        let turned = if turning == 0.0 { 0.0 } else { self.reach * turning };
        self.period * (turned + sum(&self.slides))
    }

    /// Writes to `short` the rows of `levels` whose margins would be too small after a period with the velocity `v` from the
    /// configuration `q`, which is that of the last update of the evaluator. Never allocates if `short` has room for all
    /// rows.
    pub fn look(&mut self, evaluator: &Evaluator, q: &[f64], v: &[f64], levels: &[Level], short: &mut Vec<ShortRow>) {
        short.clear();
        let change = self.change(v);
        let mut moved = false;
        let Evaluator { model, values, tasks, members, margins, .. } = evaluator;
        for &i in &self.members {
            let m = &members[i];
            let level = &levels[m.level];
            // A distance that moves takes up to what its row asks for besides.
            let values = &values[m.part()];
            let moves = m.slots.iter().any(|&at| values.rates.get(at).is_some_and(|r| *r != 0.0));
            for (k, row) in m.rows.clone().enumerate() {
                let (h, lower) = (margins[m.margins.start + k], level.lower[row]);
                // A row without a bound is left out, and one that was passed only leads back.
                let enough = if moves { 2.0 * change + self.period * lower.abs() } else { change };
                if !lower.is_finite() || h < -PASSED || h >= enough + TOLERANCE {
                    continue;
                }
                if !moved {
                    self.q.copy_from_slice(q);
                    model.integrate(&mut self.q, v, self.period);
                    model.forward(&self.q, &mut self.data);
                    moved = true;
                }
                let next = State {
                    model,
                    data: &self.data,
                    q: &self.q,
                    values: &values.current,
                    rates: &values.rates,
                    velocity: v,
                    stack_velocity: v,
                };
                let after = tasks[i].margin_after(&next, k, self.period);
                if after < -TOLERANCE {
                    short.push(ShortRow { level: m.level, row, rate: -MORE * after / self.period });
                }
            }
        }
    }
}

/// Row of a limit whose margin would be too small after a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShortRow {
    /// Index of its level.
    pub level: usize,
    /// Its index in the level.
    pub row: usize,
    /// Rate that it lacks, in its unit per s.
    pub rate: f64,
}

/// Largest distance (m) of the origin of a link from its base, or from the root, for all joint positions.
fn longest_chain(model: &Model) -> f64 {
    let length = |joint: &Joint| joint.origin.translation.vector.norm() + stroke(model, joint);
    let to_root = |mut link: robot::LinkId| {
        let mut sum = 0.0;
        while let Some(j) = model.link_ref(link).parent_joint.filter(|_| model.base_at(link).is_none()) {
            let joint = model.joint_ref(j);
            sum += length(joint);
            link = joint.parent;
        }
        sum
    };
    (0..model.links.len() as u32).map(|l| to_root(robot::LinkId(l))).fold(0.0, f64::max)
}

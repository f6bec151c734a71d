//! Motion that the hierarchy chooses: accelerations of joints and links, and reversals of joints.
//!
//! Expectations, which record the motion, and conditions of machines, which the controller measures, share this
//! definition. The velocities are those that the hierarchy chose, before the low-level layer adds its correction for
//! the measured position. An acceleration is the change of the velocity from a tick to the next, divided by the period.
//! The robot is at rest before the first tick. [`crate::record::joint_motion`] defines a reversal.

use nalgebra::Vector3;
use robot::{Data, LinkId, Model};

use crate::program::Measure;
use crate::record::joint_motion::Reversals;

/// Velocity of the origin of a link in the world, in m/s, at the previous tick and at this one.
struct LinkVelocity {
    link: LinkId,
    before: Vector3<f64>,
    now: Vector3<f64>,
}

/// Motion so far. All memory is allocated by `new`.
pub(crate) struct Motion {
    period: f64,
    /// Velocity of each degree of freedom at the previous tick and at this one, in rad/s or m/s.
    before: Vec<f64>,
    now: Vec<f64>,
    links: Vec<LinkVelocity>,
    reversals: Vec<Reversals>,
}

impl Motion {
    /// Prepares the given measures for a robot with a control period in s.
    pub fn new<'m>(model: &Model, period: f64, measures: impl Iterator<Item = &'m Measure>) -> Motion {
        let mut links: Vec<LinkVelocity> = Vec::new();
        for measure in measures {
            if let Measure::PointSpeed(link) | Measure::PointAcceleration(link) = measure
                && links.iter().all(|l| l.link != *link)
            {
                links.push(LinkVelocity { link: *link, before: Vector3::zeros(), now: Vector3::zeros() });
            }
        }
        Motion {
            period,
            before: vec![0.0; model.nv()],
            now: vec![0.0; model.nv()],
            links,
            reversals: model.dofs.iter().map(|d| Reversals::new(d.velocity)).collect(),
        }
    }

    /// Returns true if [`Motion::tick`] needs kinematics.
    pub fn needs_kinematics(&self) -> bool {
        !self.links.is_empty()
    }

    /// Restarts with a robot at rest.
    pub fn restart(&mut self, model: &Model) {
        self.before.fill(0.0);
        self.now.fill(0.0);
        self.links.iter_mut().for_each(|l| (l.before, l.now) = (Vector3::zeros(), Vector3::zeros()));
        self.reversals.iter_mut().zip(&model.dofs).for_each(|(r, d)| *r = Reversals::new(d.velocity));
    }

    /// Takes the velocity that the hierarchy chose at a tick, `nv` numbers, at a time in s; `data` contains the
    /// kinematics of the configuration of that tick. Never allocates.
    pub fn tick(&mut self, model: &Model, data: &Data, v: &[f64], time: f64) {
        self.before.copy_from_slice(&self.now);
        self.now.copy_from_slice(v);
        for l in &mut self.links {
            l.before = std::mem::replace(&mut l.now, data.point_velocity(model, l.link, data.position(l.link), v));
        }
        self.reversals.iter_mut().zip(v).for_each(|(r, v)| r.tick(*v, time));
    }

    /// Value of a measure of the motion at the tick; `None` for other measures. Never allocates.
    pub fn measure(&self, measure: &Measure) -> Option<f64> {
        let link = |link: &LinkId| self.links.iter().find(|l| l.link == *link);
        match measure {
            Measure::Speed(dof) => self.now.get(*dof).map(|v| v.abs()),
            Measure::LargestSpeed(dofs) => {
                Some(dofs.iter().filter_map(|d| self.now.get(*d)).fold(0.0, |most: f64, v| most.max(v.abs())))
            }
            Measure::PointSpeed(l) => link(l).map(|l| l.now.norm()),
            Measure::Acceleration(dof) => {
                let (now, before) = (self.now.get(*dof)?, self.before.get(*dof)?);
                Some((now - before).abs() / self.period)
            }
            Measure::LargestAcceleration(dofs) => {
                let change = |dof: &usize| Some((self.now.get(*dof)? - self.before.get(*dof)?).abs());
                Some(dofs.iter().filter_map(change).fold(0.0, f64::max) / self.period)
            }
            Measure::PointAcceleration(l) => link(l).map(|l| (l.now - l.before).norm() / self.period),
            Measure::Reversals(dofs) => {
                Some(dofs.iter().filter_map(|d| self.reversals.get(*d)).map(Reversals::count).sum::<usize>() as f64)
            }
            Measure::Margin(_) | Measure::Error { .. } | Measure::In(_) | Measure::Fault(_) | Measure::Initial(_) => {
                None
            }
        }
    }
}

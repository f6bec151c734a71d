//! The state of an agent while a search is executed.

use crate::kinds::search::geometry::Pose;
use crate::kinds::search::plan::Activity;
use crate::kinds::search::ways::Way;

use super::driven::DrivenBase;
use super::messages::Stray;

/// An activity under way.
#[derive(Clone, Debug)]
pub(super) struct Current {
    pub began: f64,
    /// Expected end (s); of a wait none.
    pub ends: Option<f64>,
    pub way: Option<Way>,
    /// Reward rates of the sources at the end of the way (1/s).
    pub there: Vec<f64>,
    /// Cell from which the agent sees there.
    pub seat_there: Option<u32>,
    /// Share of the way at a time (s): it grows evenly until the end.
    pub from: [f64; 2],
    /// Share of the way that its base has covered, if a controller drives it.
    pub driven: Option<f64>,
}

impl Current {
    /// Share of the way at a time (s).
    pub fn share(&self, time: f64) -> f64 {
        if let Some(share) = self.driven {
            return share;
        }
        let [share, since] = self.from;
        match self.ends {
            Some(ends) if ends > since => (share + (1.0 - share) * (time - since) / (ends - since)).clamp(0.0, 1.0),
            _ => 1.0,
        }
    }
}

/// An agent under way.
#[derive(Clone, Debug)]
pub(super) struct Member {
    /// Its activities of the present plan.
    pub queue: Vec<Activity>,
    /// Number of those that have ended: the index of the one under way.
    pub next: usize,
    pub current: Option<Current>,
    pub pose: Pose,
    /// Reward rates of the sources where it stands (1/s).
    pub rates: Vec<f64>,
    /// Cell from which it sees there, if it looks for hidden objects.
    pub seat: Option<u32>,
    /// True if it is where no activity of the plan begins.
    pub displaced: bool,
    /// Activities that have ended, with their true times.
    pub past: Vec<Activity>,
    pub travelled: f64,
    /// Its true motion, if it has left the plan without telling anybody.
    pub stray: Option<Stray>,
    /// Number of ways that have ended at their end.
    pub arrivals: usize,
    /// Its base, if a controller drives it.
    pub driven: Option<DrivenBase>,
    /// Number of ways that have begun.
    pub ways: usize,
}

impl Member {
    /// An agent that stands somewhere, with reward rates (1/s) there and these activities to come.
    pub fn new(pose: Pose, rates: Vec<f64>, seat: Option<u32>, queue: Vec<Activity>) -> Member {
        Member {
            queue,
            next: 0,
            current: None,
            pose,
            rates,
            seat,
            displaced: false,
            past: Vec::new(),
            travelled: 0.0,
            stray: None,
            arrivals: 0,
            driven: None,
            ways: 0,
        }
    }

    /// Drops the activities to come: they begin elsewhere.
    pub fn displace(&mut self, displaced: bool) {
        self.queue.clear();
        self.next = 0;
        self.displaced = displaced;
    }
}

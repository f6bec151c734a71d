//! The person under way: actions over the grid one after the other, and what the robots expect of them.

use learning::grid::Action;
use rand_pcg::Pcg64;

use super::super::foresight::{Covariance, Foresight};
use super::super::grid::Grid;
use super::super::mind::{Mind, Walk};
use super::super::polygon::Point;
use super::super::problem::Problem;
use super::Settings;
use crate::random::{stream, unit};

/// Times (s) that are nearer are the same.
const SAME: f64 = 1e-9;

/// The person.
#[derive(Debug)]
pub(in super::super) struct Walker {
    walks: Mind,
    predicted: Mind,
    /// The action under way: from where, to where, since when and until when (s).
    from: Point,
    to: Point,
    begin: f64,
    end: f64,
    action: Option<Action>,
    /// The cell in which the action ends.
    cell: usize,
    /// The last step, for predictions that go on in its direction.
    last: Option<Action>,
    /// A cell to which the person walks in place of what the model says.
    strays_to: Option<usize>,
    /// Time for which the person stands before the next action (s).
    waits: f64,
    unseen: bool,
    played: bool,
    /// The end of the walk is reached.
    arrived: bool,
    draws: Option<Pcg64>,
    /// Number of targets that the person has taken.
    pub taken: usize,
    /// Length of the way so far (m).
    pub travelled: f64,
}

/// Result of an action.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in super::super) struct Ended {
    /// A target that the person takes.
    pub takes: Option<usize>,
    /// The person is in the exit.
    pub arrives: bool,
}

impl Walker {
    /// The person at the start, about to act.
    ///
    /// # Errors
    /// A model cannot be used.
    pub fn new(problem: &Problem, grid: &Grid, settings: &Settings) -> Result<Walker, String> {
        let cell = grid.at(problem.person.start).filter(|cell| !grid.blocked[*cell]);
        let cell = cell.ok_or("the person starts in a blocked cell")?;
        let at = grid.middle(cell);
        let mut walker = Walker {
            walks: Mind::new(problem, grid, &problem.person.walks)?,
            predicted: Mind::new(problem, grid, &problem.person.predicted)?,
            from: at,
            to: at,
            begin: 0.0,
            end: 0.0,
            action: None,
            cell,
            last: None,
            strays_to: None,
            waits: 0.0,
            unseen: false,
            played: settings.played,
            arrived: false,
            draws: settings.sampled.map(|seed| stream(seed, &["walks", &problem.person.name])),
            taken: 0,
            travelled: 0.0,
        };
        if !walker.played {
            walker.act(problem, grid, &vec![true; problem.targets.len()], 0.0);
        }
        Ok(walker)
    }

    /// Position at a time (s), not before the begin of the action.
    pub fn at(&self, time: f64) -> Point {
        let share =
            if self.end > self.begin { ((time - self.begin) / (self.end - self.begin)).clamp(0.0, 1.0) } else { 1.0 };
        [0, 1].map(|i| self.from[i] + share * (self.to[i] - self.from[i]))
    }

    /// Velocity at a time (m/s).
    pub fn velocity(&self, time: f64) -> Point {
        match self.end > time && !self.played {
            true => [0, 1].map(|i| (self.to[i] - self.from[i]) / (self.end - self.begin)),
            false => [0.0; 2],
        }
    }

    /// End of the action (s).
    pub fn ends(&self) -> Option<f64> {
        (!self.played && !self.arrived).then_some(self.end)
    }

    /// True while the robots do not know where the person is.
    pub fn is_unseen(&self) -> bool {
        self.unseen
    }

    /// Loses the person out of sight, or sees the person again.
    pub fn set_unseen(&mut self, unseen: bool) -> Result<(), String> {
        if self.unseen == unseen {
            return Err(format!("the person is {} already", if unseen { "out of sight" } else { "in sight" }));
        }
        self.unseen = unseen;
        Ok(())
    }

    /// The person stands for a time (s) before the next action.
    pub fn wait(&mut self, by: f64, _now: f64) -> Result<(), String> {
        if self.played {
            return Err("the person is played, and walks as they like".into());
        }
        self.waits += by;
        Ok(())
    }

    /// The person walks to a place.
    pub fn stray(&mut self, grid: &Grid, to: Point) -> Result<(), String> {
        let cell = free_cell(grid, to)?;
        if self.played {
            return Err("the person is played, and walks as they like".into());
        }
        if grid.steps_to([cell].into_iter())[self.cell].is_none() {
            return Err("no way leads there".into());
        }
        self.strays_to = Some(cell);
        Ok(())
    }

    /// The person says where they are.
    pub fn tell(&mut self, grid: &Grid, at: Point, now: f64) -> Result<(), String> {
        let cell = free_cell(grid, at)?;
        if !self.played {
            return Err("the person is simulated, and seen".into());
        }
        self.travelled += super::super::polygon::distance(self.to, at);
        (self.from, self.to, self.begin, self.end, self.cell) = (at, at, now, now, cell);
        self.unseen = false;
        Ok(())
    }

    /// Ends the action, and begins the next one.
    pub fn end_action(&mut self, problem: &Problem, grid: &Grid, open: &[bool], now: f64) -> Ended {
        let mut ended = Ended::default();
        if self.action == Some(Action::Collect) {
            ended.takes = self.walks.target_in(self.cell, open);
            self.taken += usize::from(ended.takes.is_some());
        }
        if grid.exit[self.cell] {
            ended.arrives = true;
            self.arrived = true;
            (self.from, self.begin) = (self.to, now);
            return ended;
        }
        let mut open = open.to_vec();
        if let Some(target) = ended.takes {
            open[target] = false;
        }
        self.act(problem, grid, &open, now);
        ended
    }

    /// Begins an action.
    fn act(&mut self, problem: &Problem, grid: &Grid, open: &[bool], now: f64) {
        let here = grid.middle(self.cell);
        (self.from, self.to, self.begin) = (here, here, now);
        if self.waits > 0.0 {
            self.action = None;
            self.end = now + std::mem::take(&mut self.waits);
            return;
        }
        self.end = now + problem.person.cell / problem.person.speed;
        if self.strays_to == Some(self.cell) {
            self.strays_to = None;
        }
        let action = match self.strays_to {
            Some(goal) => toward(grid, self.cell, goal),
            None => {
                let draw = self.draws.as_mut().map(unit);
                self.walks.action(self.cell, open, self.last, draw)
            }
        };
        self.action = Some(action);
        if action != Action::Collect {
            self.last = Some(action);
        }
        if let Some(next) = beside(grid, self.cell, action) {
            self.cell = next;
            self.to = grid.middle(next);
            self.travelled += problem.person.cell;
        }
    }

    /// The prediction of the robots from a time (s) on. They see where the person is, and a step that is under way, but not the action
    /// that is about to begin.
    pub fn foresee(&self, problem: &Problem, grid: &Grid, open: &[bool], now: f64) -> Foresight {
        let here = self.at(now);
        let under_way = !self.played && self.begin < now - SAME && self.end > now + SAME && self.from != self.to;
        let (cell, since) = match under_way {
            true => (self.cell, self.end),
            false => (grid.at(here).filter(|cell| !grid.blocked[*cell]).unwrap_or(self.cell), now),
        };
        let mut points = vec![(now, here), (since, grid.middle(cell))];
        let mut spread = vec![(now, [0.0; 4])];
        let last = if under_way { self.last } else { self.last.filter(|_| self.begin < now) };
        let pace = problem.person.cell / problem.person.speed;
        let most = (problem.periods as f64 * problem.period / pace).ceil() as usize + 1;
        let Walk { steps, arrives, spread: covariances } = self.predicted.walk(cell, open, last, most);
        let square = problem.person.cell * problem.person.cell;
        let flat = |[[a, b], [c, d]]: Covariance| [a, b, c, d].map(|x| square * x);
        let timed = covariances.iter().enumerate();
        spread.extend(timed.map(|(action, of)| (since + action as f64 * pace, flat(*of))));
        let (mut time, mut visits) = (since, Vec::new());
        let number = |time: f64| ((time - now) / problem.period - 1e-6).ceil().max(1.0) as usize;
        for step in steps {
            time += pace;
            points.push((time, grid.middle(step.cell)));
            visits.extend(step.takes.map(|target| (target, number(time))));
        }
        let periods = if arrives { number(time) } else { problem.periods }.min(problem.periods);
        let position = |index: usize| along(&points, now + index as f64 * problem.period);
        let visits = visits.into_iter().filter(|(_, step)| *step <= periods).collect();
        let covariance = |index: usize| {
            let [a, b, c, d] = along(&spread, now + index as f64 * problem.period);
            [[a, b], [c, d]]
        };
        let known = if covariances.is_empty() { 0..0 } else { 0..periods + 1 };
        Foresight {
            positions: (0..=periods).map(position).collect(),
            visits,
            arrives: arrives && number(time) <= problem.periods,
            spread: known.map(covariance).collect(),
        }
    }
}

/// The values at a time (s) between timed values, as on straight lines.
fn along<const N: usize>(points: &[(f64, [f64; N])], time: f64) -> [f64; N] {
    for two in points.windows(2) {
        let ((from, a), (to, b)) = (two[0], two[1]);
        if time <= to + SAME {
            let share = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
            return std::array::from_fn(|i| a[i] + share * (b[i] - a[i]));
        }
    }
    points.last().map_or([0.0; N], |(_, at)| *at)
}

fn free_cell(grid: &Grid, at: Point) -> Result<usize, String> {
    let cell = grid.at(at).ok_or("this place is outside the grid")?;
    if grid.blocked[cell] { Err("this place is in a blocked cell".into()) } else { Ok(cell) }
}

/// The cell that a step leads to; none: it is blocked, or the action is no step.
fn beside(grid: &Grid, cell: usize, action: Action) -> Option<usize> {
    let (column, row) = (cell % grid.columns, cell / grid.columns);
    let next = match action {
        Action::North => (row + 1 < grid.rows).then(|| cell + grid.columns),
        Action::South => row.checked_sub(1).map(|_| cell - grid.columns),
        Action::West => column.checked_sub(1).map(|_| cell - 1),
        Action::East => (column + 1 < grid.columns).then_some(cell + 1),
        Action::Collect => None,
    };
    next.filter(|next| !grid.blocked[*next])
}

/// The first step of a shortest way to a cell.
fn toward(grid: &Grid, cell: usize, goal: usize) -> Action {
    let steps = grid.steps_to([goal].into_iter());
    let far = |action: &Action| beside(grid, cell, *action).and_then(|next| steps[next]).unwrap_or(usize::MAX);
    Action::MOVES.into_iter().min_by_key(far).unwrap_or(Action::Collect)
}

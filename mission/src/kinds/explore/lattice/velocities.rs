//! The velocities of a robot on a lattice, and the changes between them within a period.

use super::super::motion::Dynamics;
use super::super::polygon::Point;
use super::super::problem::Problem;
use super::ground::SAME;

/// The most steps of a velocity along an axis.
const MOST: f64 = 8.0;

/// The velocities of a robot: multiples of a step along each axis. A velocity has a code.
#[derive(Clone, Debug)]
pub(super) struct Velocities {
    /// A step (m/s).
    pace: f64,
    /// The most steps along an axis.
    fastest: i32,
    /// An acceleration leads from one to the next; otherwise the velocity is that of a whole period.
    pub accelerates: bool,
    /// By code, the codes that can follow.
    pub after: Vec<Vec<usize>>,
}

impl Velocities {
    /// The velocities of a robot on a lattice with this spacing (m).
    pub fn new(problem: &Problem, robot: usize, spacing: f64) -> Velocities {
        let (who, period) = (&problem.robots[robot], problem.period);
        let accelerates = who.dynamics == Dynamics::Acceleration;
        // An acceleration leads to the mean of both velocities.
        let pace = if accelerates { 2.0 * spacing / period } else { spacing / period };
        let fastest = (who.speed / pace + 1e-9).floor().min(MOST) as i32;
        let mut velocities = Velocities { pace, fastest, accelerates, after: Vec::new() };
        let most = who.acceleration * period + 1e-9;
        let can_follow = |a: usize, b: usize| {
            let (a, b) = (velocities.of(a), velocities.of(b));
            (0..2).all(|i| (b[i] - a[i]).abs() <= most)
        };
        let all = 0..velocities.count();
        velocities.after = all.clone().map(|a| all.clone().filter(|b| can_follow(a, *b)).collect()).collect();
        velocities
    }

    fn width(&self) -> usize {
        (2 * self.fastest + 1) as usize
    }

    /// Number of velocities.
    pub fn count(&self) -> usize {
        self.width() * self.width()
    }

    /// The code of standing still.
    pub fn still(&self) -> usize {
        self.count() / 2
    }

    /// A velocity in steps along each axis.
    pub fn steps(&self, code: usize) -> [i32; 2] {
        [(code % self.width()) as i32 - self.fastest, (code / self.width()) as i32 - self.fastest]
    }

    /// A velocity (m/s).
    pub fn of(&self, code: usize) -> Point {
        self.steps(code).map(|steps| f64::from(steps) * self.pace)
    }

    /// The code of a velocity (m/s); none: it is between velocities, or too fast.
    pub fn code(&self, velocity: Point) -> Option<usize> {
        let steps = velocity.map(|v| (v / self.pace).round());
        let is_one = (0..2)
            .all(|i| (velocity[i] - steps[i] * self.pace).abs() < SAME && steps[i].abs() <= f64::from(self.fastest));
        let place = |axis: usize| (steps[axis] as i32 + self.fastest) as usize;
        is_one.then(|| place(1) * self.width() + place(0))
    }

    /// Places by which the third point of a motion and its end are ahead of its begin.
    pub fn ahead(&self, first: usize, last: usize) -> [[i32; 2]; 2] {
        let (a, b) = (self.steps(first), self.steps(last));
        match self.accelerates {
            // Third points of accelerations are half a period's way ahead: as many places as the velocity has steps.
            true => [a, [a[0] + b[0], a[1] + b[1]]],
            false => [[0; 2], b],
        }
    }
}

//! Boxes that hold the positions and velocities of a robot at the ends of the periods, by its limits alone.

use super::super::motion::{Discrete, State};
use super::super::polygon::Point;
use super::super::problem::Robot;

/// Positions and velocities within boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The least position (m).
    pub low: Point,
    /// The greatest position (m).
    pub high: Point,
    /// The least velocity (m/s).
    pub slow: Point,
    /// The greatest velocity (m/s).
    pub fast: Point,
}

impl Reach {
    /// The boxes of one state.
    pub fn of(State { at, velocity }: State) -> Reach {
        Reach { low: at, high: at, slow: velocity, fast: velocity }
    }
}

/// Boxes of a robot now and at the end of each period (s); `region` are the corners of a box (m) in which it stays.
pub fn reach(who: &Robot, now: State, period: f64, periods: usize, region: [Point; 2]) -> Vec<Reach> {
    let discrete = who.over(period);
    let mut boxes = vec![Reach::of(now)];
    for step in 0..periods {
        boxes.push(after(&discrete, who, boxes[step], region));
    }
    boxes
}

/// The boxes after one period. For these dynamics the farthest position follows from the greatest velocity.
fn after(d: &Discrete, who: &Robot, of: Reach, [floor, ceiling]: [Point; 2]) -> Reach {
    let (speed, most) = (who.speed, who.most_input());
    let end = |v: f64, sign: f64| {
        // The greatest input that keeps the speed within its limit.
        let input = sign * most.min((speed - sign * d.velocity_velocity * v) / d.velocity_input);
        (d.position_velocity * v + d.position_input * input, d.velocity_velocity * v + d.velocity_input * input)
    };
    let mut next = of;
    for i in 0..2 {
        let (down, slower) = end(of.slow[i], -1.0);
        let (up, faster) = end(of.fast[i], 1.0);
        next.low[i] = (of.low[i] + down).max(floor[i]);
        next.high[i] = (of.high[i] + up).min(ceiling[i]);
        (next.slow[i], next.fast[i]) = (slower.max(-speed), faster.min(speed));
        if next.low[i] > next.high[i] {
            // Outside of the region with no way back in one period: the rows say so.
            (next.low[i], next.high[i]) = (of.low[i] + down, of.high[i] + up);
        }
    }
    next
}

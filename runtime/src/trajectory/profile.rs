//! Motion of one number: pieces of constant jerk, one behind the other, and rest behind the last.

/// Most pieces of a profile.
const PIECES: usize = 8;

/// Where a number is, and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// The number.
    pub position: f64,
    /// Its first derivative, per s.
    pub velocity: f64,
    /// Its second derivative, per s^2.
    pub acceleration: f64,
}

impl Motion {
    /// Standing still.
    pub fn rest(position: f64) -> Motion {
        Motion { position, velocity: 0.0, acceleration: 0.0 }
    }

    /// After a time of constant jerk.
    pub fn after(self, t: f64, jerk: f64) -> Motion {
        let Motion { position, velocity, acceleration } = self;
        Motion {
            position: position + t * (velocity + t * (acceleration / 2.0 + t * jerk / 6.0)),
            velocity: velocity + t * (acceleration + t * jerk / 2.0),
            acceleration: acceleration + t * jerk,
        }
    }
}

/// A piece of constant jerk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Piece {
    start: f64,
    from: Motion,
    jerk: f64,
}

/// The motion of one number from some state to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile {
    pieces: [Piece; PIECES],
    count: usize,
    duration: f64,
    end: Motion,
}

impl Profile {
    /// Begins in a state.
    pub(super) fn from(start: Motion) -> Profile {
        Profile { end: start, ..Profile::default() }
    }

    /// Standing still for good.
    pub(super) fn rest(position: f64) -> Profile {
        Profile::from(Motion::rest(position))
    }

    /// Goes on with an acceleration, which jumps there, and a jerk.
    pub(super) fn then(&mut self, duration: f64, acceleration: f64, jerk: f64) {
        if duration > 0.0 && self.count < PIECES {
            let from = Motion { acceleration, ..self.end };
            self.pieces[self.count] = Piece { start: self.duration, from, jerk };
            self.count += 1;
            self.duration += duration;
            self.end = from.after(duration, jerk);
        }
    }

    /// The same with the acceleration that it has.
    pub(super) fn jerk(&mut self, duration: f64, jerk: f64) {
        self.then(duration, self.end.acceleration, jerk);
    }

    /// The state after the last piece.
    pub(super) fn end(&self) -> Motion {
        self.end
    }

    /// Ends exactly in a state: what rounding left is taken off.
    pub(super) fn ending(mut self, end: Motion) -> Profile {
        self.end = end;
        self
    }

    /// How long it takes, in s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The state at a time since the beginning, in s.
    pub fn at(&self, t: f64) -> Motion {
        if t >= self.duration {
            return self.end;
        }
        let piece = self.pieces[..self.count].iter().rev().find(|p| t >= p.start).or(self.pieces[..self.count].first());
        piece.map_or(self.end, |p| p.from.after(t - p.start, p.jerk))
    }

    /// Whether all numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        let Motion { position, velocity, acceleration } = self.end;
        self.duration.is_finite() && position.is_finite() && velocity.is_finite() && acceleration.is_finite()
    }
}

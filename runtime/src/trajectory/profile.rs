//! Motion of one number: consecutive pieces of constant jerk, followed by rest.

/// Largest number of pieces of a profile.
const PIECES: usize = 8;

/// Position and motion of a number.
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
    /// State of rest.
    pub fn rest(position: f64) -> Motion {
        Motion { position, velocity: 0.0, acceleration: 0.0 }
    }

    /// State after a time of constant jerk.
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
    /// Empty profile that starts in a state.
    pub(super) fn from(start: Motion) -> Profile {
        Profile { end: start, ..Profile::default() }
    }

    /// Profile that stays at rest.
    pub(super) fn rest(position: f64) -> Profile {
        Profile::from(Motion::rest(position))
    }

    /// Appends a piece with an acceleration, which may jump, and a jerk.
    pub(super) fn then(&mut self, duration: f64, acceleration: f64, jerk: f64) {
        if duration > 0.0 && self.count < PIECES {
            let from = Motion { acceleration, ..self.end };
            self.pieces[self.count] = Piece { start: self.duration, from, jerk };
            self.count += 1;
            self.duration += duration;
            self.end = from.after(duration, jerk);
        }
    }

    /// Appends a piece with a jerk that continues the present acceleration.
    pub(super) fn jerk(&mut self, duration: f64, jerk: f64) {
        self.then(duration, self.end.acceleration, jerk);
    }

    /// State after the last piece.
    pub(super) fn end(&self) -> Motion {
        self.end
    }

    /// Sets the exact final state, which removes the rounding error.
    pub(super) fn ending(mut self, end: Motion) -> Profile {
        self.end = end;
        self
    }

    /// Duration, in s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// State at a time since the beginning, in s.
    pub fn at(&self, t: f64) -> Motion {
        if t >= self.duration {
            return self.end;
        }
        let piece = self.pieces[..self.count].iter().rev().find(|p| t >= p.start).or(self.pieces[..self.count].first());
        piece.map_or(self.end, |p| p.from.after(t - p.start, p.jerk))
    }

    /// Returns true if all numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        let Motion { position, velocity, acceleration } = self.end;
        self.duration.is_finite() && position.is_finite() && velocity.is_finite() && acceleration.is_finite()
    }
}

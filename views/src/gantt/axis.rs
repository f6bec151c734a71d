//! Time axis of a chart: its range, its unit, and its round marks.

/// An axis from `start` to `end` (s), marked at multiples of `step` (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub start: f64,
    pub end: f64,
    pub step: f64,
    pub unit: Unit,
}

/// Unit of the times on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    Second,
    Minute,
    Hour,
}

impl Unit {
    /// Returns the length of the unit (s).
    pub fn seconds(self) -> f64 {
        match self {
            Unit::Second => 1.0,
            Unit::Minute => 60.0,
            Unit::Hour => 3600.0,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Unit::Second => "s",
            Unit::Minute => "min",
            Unit::Hour => "h",
        }
    }

    fn of(span: f64) -> Unit {
        match span {
            span if span <= 3000.0 => Unit::Second,
            span if span <= 18_000.0 => Unit::Minute,
            _ => Unit::Hour,
        }
    }
}

impl Axis {
    /// Creates an axis for these instants (s), which are finite, with about `marks` marks. It begins at 0, unless more
    /// than half of it would be empty then.
    pub fn over(first: f64, last: f64, marks: usize) -> Axis {
        let from = if first > 0.0 && first < 0.5 * last { 0.0 } else { first };
        let span = last - from;
        let span =
            if span.is_finite() && span > 1e-9 * last.abs().max(1.0) { span } else { last.abs().clamp(1.0, 1e9) };
        let unit = Unit::of(span);
        let rough = span / unit.seconds() / marks.max(1) as f64;
        let power = 10f64.powi(rough.log10().floor() as i32);
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|of| of * power).find(|step| *step >= rough * (1.0 - 1e-9));
        Axis { start: from, end: from + span, step: step.unwrap_or(10.0 * power) * unit.seconds(), unit }
    }

    /// Returns the length of the axis (s), more than 0.
    pub fn span(&self) -> f64 {
        self.end - self.start
    }

    /// Returns the position of an instant: 0 at the start and 1 at the end.
    pub fn share(&self, time: f64) -> f64 {
        (time - self.start) / self.span()
    }

    /// Returns the marked instants (s) with their labels.
    pub fn marks(&self) -> Vec<(f64, String)> {
        let first = (self.start / self.step - 1e-9).ceil();
        let count = (self.span() / self.step + 1e-9).floor().clamp(0.0, 100.0) as usize;
        let instants = (0..=count).map(|k| (first + k as f64) * self.step);
        instants.filter(|t| *t <= self.end + 1e-9 * self.span()).map(|t| (t, self.written(t))).collect()
    }

    /// Formats an instant as a number of the unit, with the decimals that the marks need.
    fn written(&self, time: f64) -> String {
        let step = self.step / self.unit.seconds();
        let decimals = (-(step * (1.0 + 1e-9)).log10().floor()).clamp(0.0, 6.0) as usize;
        let number = time / self.unit.seconds();
        format!("{:.decimals$}", if number.abs() < 1e-9 * step { 0.0 } else { number })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(first: f64, last: f64) -> String {
        let axis = Axis::over(first, last, 6);
        let marks: Vec<String> = axis.marks().into_iter().map(|mark| mark.1).collect();
        format!("{} {}", marks.join(" "), axis.unit.name())
    }

    #[test]
    fn marks_are_round_numbers_of_the_unit() {
        assert_eq!(written(0.0, 2394.5), "0 500 1000 1500 2000 s");
        assert_eq!(written(30.0, 101.0), "0 20 40 60 80 100 s");
        assert_eq!(written(0.0, 7200.0), "0 20 40 60 80 100 120 min");
        assert_eq!(written(0.0, 30_000.0), "0 2 4 6 8 h");
        assert_eq!(written(0.0, 1.1), "0.0 0.2 0.4 0.6 0.8 1.0 s");
        assert_eq!(written(400.0, 500.0), "400 420 440 460 480 500 s");
        assert_eq!(written(0.0, 0.0), "0.0 0.2 0.4 0.6 0.8 1.0 s");
    }

    proptest! {
        #[test]
        fn there_are_always_a_few_marks_inside(first in -1e7..1e7f64, length in 0.0..1e7f64) {
            let axis = Axis::over(first, first + length, 6);
            let marks = axis.marks();
            prop_assert!((2..=8).contains(&marks.len()), "{axis:?} {marks:?}");
            prop_assert!(axis.start <= first && first + length <= axis.end + 1e-6 * length);
            let inside = |t: f64| (-1e-6..=1.0 + 1e-6).contains(&axis.share(t));
            prop_assert!(marks.iter().all(|mark| inside(mark.0)), "{axis:?} {marks:?}");
            prop_assert!(marks.windows(2).all(|two| two[0].0 < two[1].0 && two[0].1 != two[1].1));
        }
    }
}

//! Habits of simulated people: how often they send their pose, whose goals they follow, and what they tell robots.
//!
//! The times between the messages *My pose* of a person (TBM, srs 8.4.1) have a Weibull distribution,
//! `P(T < t) = 1 - exp(-(t / l)^k)`, that is given by its mean and by its share below a threshold. The log-normal distribution does
//! not do: with the mean of the control user of srs table 1 (60 s / 15.59) at least 91.65 % of its times are below 10 s, and the table has
//! 90.95 %. Two Weibull distributions may have the same two figures, a regular one and an irregular one: the one nearer to the exponential
//! distribution is taken (`|ln k|`), of a person who sends at random times. Inclinations are probabilities, and inputs.

use serde::{Deserialize, Serialize};

/// Habits of a simulated person, which plans do not use.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Habits {
    /// Times between the messages *My pose*; none: it sends none by itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub my_pose: Option<Intervals>,
    /// Probability of following the plan, at each decision.
    pub follows: f64,
    /// Choice of a goal of its own.
    pub own_goal: OwnGoal,
    /// Least distance of a goal that is chosen, for the person or for a robot (m).
    pub goals_beyond: f64,
    /// Probability of *My goal* before it goes to a goal of its own.
    pub my_goal: f64,
    /// Probability of *Robot goal* after *My goal*.
    pub robot_goal: f64,
    /// Probability of *Robot goal* without *My goal*.
    pub robot_goal_alone: f64,
    /// Probability of *Replan* when a way is proposed.
    pub replan: f64,
    /// Probability of sending the pose after a reminder.
    pub heeds: f64,
}

/// Choice of a goal of one's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OwnGoal {
    /// The goal with the most reward a second.
    Greedy,
    /// The nearest goal.
    Nearest,
}

impl OwnGoal {
    /// All choices.
    pub const ALL: [OwnGoal; 2] = [OwnGoal::Greedy, OwnGoal::Nearest];
    /// Their names.
    pub const NAMES: [&str; 2] = ["greedy", "nearest"];
}

/// Times between messages, by the figures that experiments report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intervals {
    /// Mean (s), more than 0.
    pub mean: f64,
    /// Share of those below the threshold; none: that of the exponential distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// The threshold (s), more than 0.
    pub below: f64,
}

/// Reminders to send one's pose, the triggers of srs 7.2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reminder {
    /// Form of the reminder.
    pub kind: ReminderKind,
    /// Time since the last pose after which a person is reminded (s), more than 0.
    pub after: f64,
    /// Factor of that time after each reminder that was not followed, 0 to 1.
    pub shorten: f64,
    /// The least time between two reminders (s), more than 0.
    pub least: f64,
}

/// Form of a reminder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReminderKind {
    /// A small message that passes.
    Toast,
    /// A window that blocks the page until the pose is sent.
    Popup,
    /// Vibration, and a blinking button.
    Multimodal,
    /// The number of its uses on each button; nobody is reminded at any time.
    Counters,
}

impl ReminderKind {
    /// All kinds.
    pub const ALL: [ReminderKind; 4] =
        [ReminderKind::Toast, ReminderKind::Popup, ReminderKind::Multimodal, ReminderKind::Counters];
    /// Their names.
    pub const NAMES: [&str; 4] = ["toast", "popup", "multimodal", "counters"];

    /// Name, as in specs.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

impl Reminder {
    /// Time from the last pose, or from the last reminder, to the next reminder (s), after a number of reminders in a row; none:
    /// nobody is reminded.
    pub fn wait(&self, reminders: usize) -> Option<f64> {
        let shortened = self.after * self.shorten.powf(reminders as f64);
        (self.kind != ReminderKind::Counters).then(|| shortened.max(self.least).min(self.after))
    }
}

/// A Weibull distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weibull {
    /// Its shape, `k`: 1 is the exponential distribution, more is more regular.
    pub shape: f64,
    /// Its scale, `l` (s).
    pub scale: f64,
}

/// Shapes that are considered, with a coefficient of variation from 16 down to 0.06.
const SHAPES: [f64; 2] = [0.2, 20.0];
/// Number of steps in which a sign change is looked for.
const STEPS: usize = 400;

impl Weibull {
    /// The distribution of a shape with this mean.
    fn of_mean(mean: f64, shape: f64) -> Weibull {
        Weibull { shape, scale: mean / gamma(1.0 + 1.0 / shape) }
    }

    /// Share below a time (s).
    pub fn below(&self, time: f64) -> f64 {
        -(-(time / self.scale).powf(self.shape)).exp_m1()
    }

    /// The time (s) at a quantile, between 0 and 1.
    pub fn quantile(&self, share: f64) -> f64 {
        self.scale * (-(-share).ln_1p()).powf(1.0 / self.shape)
    }
}

impl Intervals {
    /// The distribution with these figures.
    ///
    /// # Errors
    /// There is none: the least and the greatest share that is possible with this mean.
    pub fn distribution(&self) -> Result<Weibull, [f64; 2]> {
        let Some(share) = self.share else { return Ok(Weibull::of_mean(self.mean, 1.0)) };
        let [low, high] = SHAPES.map(f64::ln);
        let of = |x: f64| Weibull::of_mean(self.mean, x.exp()).below(self.below);
        let at = |step: usize| low + (high - low) * step as f64 / STEPS as f64;
        let shares: Vec<f64> = (0..=STEPS).map(|step| of(at(step))).collect();
        let crosses = |step: &usize| (shares[*step] < share) != (shares[*step + 1] < share);
        let root = |step: usize| {
            let (mut a, mut b) = (at(step), at(step + 1));
            let rises = shares[step] < share;
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                if (of(middle) < share) == rises { a = middle } else { b = middle }
            }
            0.5 * (a + b)
        };
        let roots = (0..STEPS).filter(crosses).map(root);
        let nearest = roots.min_by(|a, b| a.abs().total_cmp(&b.abs()));
        let range = || {
            let least = shares.iter().copied().fold(1.0, f64::min);
            [least, shares.iter().copied().fold(0.0, f64::max)]
        };
        nearest.map(|x| Weibull::of_mean(self.mean, x.exp())).ok_or_else(range)
    }
}

/// The gamma function of 1 or more, by the approximation of Lanczos with `g = 7`, relative error below 1e-13.
fn gamma(x: f64) -> f64 {
    const G: f64 = 7.0;
    const COEFFICIENTS: [f64; 8] = [
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let terms = COEFFICIENTS.iter().enumerate().map(|(i, c)| c / (x + i as f64 + 1.0));
    let sum = 0.999_999_999_999_809_9 + terms.sum::<f64>();
    let t = x + G + 0.5;
    std::f64::consts::TAU.sqrt() * t.powf(x + 0.5) * (-t).exp() * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_is_that_of_tables() {
        let mut factorial = 1.0;
        for n in 1..12 {
            assert!((gamma(f64::from(n)) / factorial - 1.0).abs() < 1e-13, "{n}");
            factorial *= f64::from(n);
        }
        assert!((gamma(1.5) - 0.5 * std::f64::consts::PI.sqrt()).abs() < 1e-14);
    }

    /// The mean and the share are computed back by quadrature over quantiles, for both users of srs table 1 and others.
    #[test]
    fn distributions_have_the_figures_that_they_are_given_by() {
        let users = [(60.0 / 15.59, 0.9095), (60.0 / 6.38, 0.7294), (60.0 / 8.06, 0.8182), (5.0, 0.99), (20.0, 0.2)];
        for (mean, share) in users {
            let found = Intervals { mean, share: Some(share), below: 10.0 }.distribution().expect("a distribution");
            let count = 2_000_000;
            let times = (0..count).map(|i| found.quantile((f64::from(i) + 0.5) / f64::from(count)));
            let (mut sum, mut under) = (0.0, 0.0);
            for time in times {
                sum += time;
                under += f64::from(u8::from(time < 10.0));
            }
            let (is, under) = (sum / f64::from(count), under / f64::from(count));
            assert!((is / mean - 1.0).abs() < 1e-3, "{mean}: {is} of {found:?}");
            assert!((under - share).abs() < 1e-5 && (found.below(10.0) - share).abs() < 1e-9, "{share}: {found:?}");
        }
        let control = Intervals { mean: 60.0 / 15.59, share: Some(0.9095), below: 10.0 }.distribution().expect("one");
        let volunteer = Intervals { mean: 60.0 / 6.38, share: Some(0.7294), below: 10.0 }.distribution().expect("one");
        assert!((0.8..0.9).contains(&control.shape) && (0.55..0.7).contains(&volunteer.shape));
    }

    #[test]
    fn impossible_figures_have_a_range() {
        let [least, most] = Intervals { mean: 3.0, share: Some(0.2), below: 10.0 }.distribution().expect_err("none");
        // The inequality of Markov: at least 70 % of times with this mean are below 10 s.
        assert!(least > 0.7 && most <= 1.0, "{least} {most}");
        let poisson = Intervals { mean: 5.0, share: None, below: 10.0 }.distribution().expect("exponential");
        assert!((poisson.below(5.0) - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn reminders_come_sooner_and_sooner() {
        let of = |kind| Reminder { kind, after: 10.0, shorten: 0.8, least: 4.0 };
        let waits: Vec<f64> = (0..7).filter_map(|n| of(ReminderKind::Toast).wait(n)).collect();
        let should = [10.0, 8.0, 6.4, 5.12, 4.096, 4.0, 4.0];
        assert!(waits.iter().zip(should).all(|(is, should)| (is - should).abs() < 1e-12), "{waits:?}");
        assert_eq!(of(ReminderKind::Counters).wait(0), None);
    }
}

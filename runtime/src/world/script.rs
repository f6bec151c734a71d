//! Values that are sent to a signal: interpolated linearly in time, with noise, delay and loss.

use rand_pcg::Pcg64;

use super::NOW;
use super::channel::{Channel, Sample};
use crate::program::{Interface, SignalProgram, SignalScript};
use crate::signals::Signals;

/// Sends the values of a script.
pub(super) struct Sender {
    signal: usize,
    path: Vec<(f64, Vec<f64>)>,
    /// True if the velocity is sent after the value, because it counts as measured.
    with_velocity: bool,
    /// Place of a tracked signal in the table of signals; `None` for other signals.
    tracked: Option<Tracked>,
    /// Time from which values are sent, in s.
    from: f64,
    /// Time until which they are sent, in s.
    to: f64,
    channel: Channel,
}

/// Place of a tracked signal in the table of signals.
struct Tracked {
    /// Index of its value.
    value: usize,
    /// Index of its rates.
    rates: usize,
    /// Index of the number that says that it counts.
    known: usize,
}

impl Sender {
    pub fn new(script: &SignalScript, interface: &Interface, random: Pcg64) -> Sender {
        let channel = Channel::new(script.sending(), random);
        let signal = interface.signals.get(script.signal);
        let place = |s: &SignalProgram| Tracked { value: s.at + 1, rates: s.velocity_at(), known: s.known_at() };
        Sender {
            signal: script.signal,
            path: script.path.clone(),
            with_velocity: signal.is_some_and(|s| s.sent() > s.len),
            tracked: signal.filter(|s| s.motion.is_some()).map(place),
            from: script.from,
            to: script.to.unwrap_or(f64::INFINITY),
            channel,
        }
    }

    /// Replaces the value and the rates of a tracked signal that the controller knows with the true ones, without noise
    /// and delay, while the script sends them. Its presence remains what the controller has.
    pub fn truth(&self, time: f64, table: &mut [f64]) {
        let Some(Tracked { value, rates, known }) = self.tracked else { return };
        if time < self.from - NOW || time >= self.to - NOW {
            return;
        }
        let numbers = at(&self.path, time);
        let Some(own) = table.get_mut(value..value + numbers.len()) else { return };
        own.copy_from_slice(&numbers);
        let slope = velocity(&self.path, time);
        for (k, rate) in table.iter_mut().skip(rates).take(numbers.len()).enumerate() {
            *rate = slope.get(k).copied().unwrap_or(0.0);
        }
        if let Some(known) = table.get_mut(known) {
            *known = 1.0;
        }
    }

    pub fn tick(&mut self, signals: &mut Signals, time: f64) {
        let Sender { signal, path, with_velocity, channel, .. } = self;
        let value = || {
            let mut numbers = at(path, time);
            let noisy = numbers.len();
            if *with_velocity {
                numbers.extend(velocity(path, time));
                // A pose does not move along a path.
                numbers.resize(if noisy == 7 { 13 } else { 2 * noisy }, 0.0);
            }
            Sample { noisy, numbers }
        };
        channel.tick(time, value, |value, arrived| {
            signals.set(*signal, value, arrived);
        });
    }
}

/// Value of a path at a time, interpolated linearly.
pub(super) fn at(path: &[(f64, Vec<f64>)], time: f64) -> Vec<f64> {
    let behind = path.partition_point(|p| p.0 <= time);
    match (behind.checked_sub(1).and_then(|i| path.get(i)), path.get(behind)) {
        (Some(a), Some(b)) => {
            let s = (time - a.0) / (b.0 - a.0);
            a.1.iter().zip(&b.1).map(|(x, y)| x + s * (y - x)).collect()
        }
        (Some(a), None) => a.1.clone(),
        (None, Some(b)) => b.1.clone(),
        (None, None) => Vec::new(),
    }
}

/// Slope of a path at a time: of a point its velocity, in m/s. Empty before and after the path.
fn velocity(path: &[(f64, Vec<f64>)], time: f64) -> Vec<f64> {
    let behind = path.partition_point(|p| p.0 <= time);
    match (behind.checked_sub(1).and_then(|i| path.get(i)), path.get(behind)) {
        (Some(a), Some(b)) => a.1.iter().zip(&b.1).map(|(x, y)| (y - x) / (b.0 - a.0)).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::stream;
    use super::*;

    fn script() -> SignalScript {
        let path = vec![(1.0, vec![0.0, 10.0]), (2.0, vec![4.0, 10.0])];
        SignalScript {
            signal: 0,
            from: 0.0,
            to: None,
            path,
            noise: 0.0,
            delay: 0.0,
            drop: 0.0,
            period: 0.0,
            nan: Vec::new(),
        }
    }

    fn signals() -> Signals {
        let point = SignalProgram {
            name: "p".into(),
            kind: "point".into(),
            at: 0,
            len: 2,
            optional: true,
            timeout: Some(0.054),
            motion: None,
            conditioning: Default::default(),
            variable: None,
            age_of: None,
        };
        Signals::new(&Interface { signals: vec![point], ..Interface::default() })
    }

    /// Values at each tick of 10 ms; `None` if the signal is absent.
    fn seen(script: &SignalScript, seed: u64, ticks: usize) -> Vec<Option<f64>> {
        let (mut sender, mut signals) = (Sender::new(script, &Interface::default(), stream(seed, 0)), signals());
        let one = |k: usize| {
            let time = k as f64 * 0.01;
            sender.tick(&mut signals, time);
            signals.at(time, |_| None);
            signals.is_present(0).then(|| signals.value(0)[0])
        };
        (0..ticks).map(one).collect()
    }

    #[test]
    fn values_lie_on_straight_lines() {
        let all = seen(&script(), 0, 300);
        assert_eq!([all[0], all[50], all[100], all[200], all[299]], [0.0, 0.0, 0.0, 4.0, 4.0].map(Some));
        assert!((all[125].unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_script_begins_and_ends_and_what_it_sent_times_out() {
        let s = SignalScript { from: 0.5, to: Some(1.0), ..script() };
        let all = seen(&s, 0, 120);
        assert_eq!((all[49], all[50].is_some(), all[99].is_some()), (None, true, true));
        // The last value was sent at 0.99 s, and is valid for 54 ms.
        assert_eq!((all[104].is_some(), all[105].is_some()), (true, false));
    }

    #[test]
    fn values_arrive_late_by_the_delay() {
        let (now, late) = (seen(&script(), 0, 300), seen(&SignalScript { delay: 0.1, ..script() }, 0, 300));
        assert!(late[..10].iter().all(Option::is_none));
        assert_eq!(now[..290], late[10..]);
    }

    #[test]
    fn values_come_once_a_period() {
        let s = SignalScript { period: 0.2, ..script() };
        let all = seen(&s, 0, 300);
        // The signal is absent from 50 ms after each value.
        for (k, x) in all.iter().enumerate() {
            assert_eq!(x.is_some(), k % 20 <= 5, "{k}");
        }
    }

    #[test]
    fn a_period_shorter_than_a_tick_is_a_tick() {
        let every = seen(&script(), 0, 300);
        for period in [1e-300, 1e-9, 0.003, 0.01] {
            assert_eq!(seen(&SignalScript { period, ..script() }, 0, 300), every, "{period}");
        }
        // At 0, 30, 50, 80, 100 ms ..: the first tick at or behind each multiple of 25 ms.
        let s = SignalScript { period: 0.025, path: vec![(0.0, vec![0.0, 0.0]), (1.0, vec![1.0, 0.0])], ..script() };
        let all: Vec<f64> = seen(&s, 0, 11).into_iter().flatten().collect();
        let sent = [0.0, 0.0, 0.0, 0.03, 0.03, 0.05, 0.05, 0.05, 0.08, 0.08, 0.1];
        assert!(all.iter().zip(sent).all(|(x, y)| (x - y).abs() < 1e-12), "{all:?}");
    }

    #[test]
    fn a_value_that_is_no_number_makes_the_signal_absent_once() {
        let s = SignalScript { nan: vec![0.5], ..script() };
        let absent: Vec<usize> =
            seen(&s, 0, 120).iter().enumerate().filter(|(_, x)| x.is_none()).map(|x| x.0).collect();
        assert_eq!(absent, [50]);
    }

    #[test]
    fn noise_has_its_deviation_and_loss_its_share() {
        let s = SignalScript { noise: 0.5, path: vec![(0.0, vec![3.0, 0.0])], ..script() };
        let all: Vec<f64> = seen(&s, 7, 20_000).into_iter().flatten().collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let variance = all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / all.len() as f64;
        // Five standard errors of the mean and of the deviation.
        assert!((mean - 3.0).abs() < 5.0 * 0.5 / 141.0 && (variance.sqrt() - 0.5).abs() < 5.0 * 0.5 / 200.0);
        let all = seen(&SignalScript { drop: 0.3, period: 0.1, ..script() }, 7, 200_000);
        // One value in ten ticks, which is valid for 54 ms.
        let arrived = all.iter().step_by(10).filter(|x| x.is_some()).count();
        assert!((arrived as f64 / 20_000.0 - 0.7).abs() < 5.0 * (0.21_f64 / 20_000.0).sqrt());
    }

    proptest! {
        #[test]
        fn the_same_seed_gives_the_same_bits(seed in any::<u64>(), drop in 0.0..1.0_f64, noise in 0.0..2.0_f64) {
            let s = SignalScript { drop, noise, ..script() };
            let (a, b) = (seen(&s, seed, 200), seen(&s, seed, 200));
            prop_assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
    }
}

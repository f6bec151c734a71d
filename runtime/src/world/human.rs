//! People in the simulated world: the true positions of their points, and the readings that the tracker sends.

use rand_pcg::Pcg64;

use super::channel::{Channel, Sample};
use crate::program::{HumanScript, Interface, SignalProgram, Track};
use crate::signals::Signals;

/// A point of a person: its signal, and its true path.
struct Point {
    index: usize,
    signal: SignalProgram,
    track: Track,
}

/// Position (m) and velocity (m/s) of something.
type Motion = ([f64; 3], [f64; 3]);

impl Point {
    /// True motion at a time; `around` is that of the person, which others move: the path is then relative to it.
    fn motion(&self, time: f64, around: Option<Motion>) -> Motion {
        let (position, velocity) = self.track.at(time);
        let Some((at, moves)) = around else { return (position, velocity) };
        ([0, 1, 2].map(|i| at[i] + position[i]), [0, 1, 2].map(|i| moves[i] + velocity[i]))
    }
}

/// A person.
pub(super) struct Person {
    /// Index of the human.
    pub human: usize,
    points: Vec<Point>,
    channel: Channel,
    /// Motion of a person whom others move.
    placed: Option<Motion>,
}

impl Person {
    /// Prepares the person of a script of a checked program.
    pub fn new(script: &HumanScript, interface: &Interface, random: Pcg64) -> Person {
        let signals = interface.humans.get(script.human).map_or(&[][..], |h| &h.points);
        let point = |(&index, track): (&usize, &Track)| {
            let signal = interface.signals.get(index)?.clone();
            Some(Point { index, signal, track: track.clone() })
        };
        let points = signals.iter().zip(&script.tracks).filter_map(point).collect();
        let channel = Channel::new(script.sending.clone(), random);
        Person { human: script.human, points, channel, placed: None }
    }

    /// The person is here from now on, and the paths of points are around this place.
    pub fn place(&mut self, at: [f64; 3], velocity: [f64; 3]) {
        self.placed = Some((at, velocity));
    }

    /// Sends readings of the points to the controller: positions, then those velocities that are measured.
    pub fn tick(&mut self, signals: &mut Signals, time: f64) {
        let Person { points, channel, placed, .. } = self;
        let value = || {
            let seen: Vec<_> =
                points.iter().map(|p| (p.motion(time, *placed), p.signal.sent() > p.signal.len)).collect();
            let positions = seen.iter().flat_map(|((x, _), _)| *x);
            let velocities = seen.iter().filter(|s| s.1).flat_map(|((_, v), _)| *v);
            Sample { numbers: positions.chain(velocities).collect(), noisy: 3 * seen.len() }
        };
        channel.tick(time, value, |value, arrived| {
            let (positions, mut velocities) = value.split_at((3 * points.len()).min(value.len()));
            for (p, position) in points.iter().zip(positions.chunks_exact(3)) {
                let mut reading = [0.0; 6];
                reading[..3].copy_from_slice(position);
                let sent = p.signal.sent().min(6);
                if let (6, Some((own, rest))) = (sent, velocities.split_at_checked(3)) {
                    reading[3..].copy_from_slice(own);
                    velocities = rest;
                }
                signals.set(p.index, &reading[..sent], arrived);
            }
        });
    }

    /// Replaces the positions and velocities that the controller knows with the true ones. Presence and uncertainty of
    /// a point remain those that the controller has.
    pub fn truth(&self, time: f64, table: &mut [f64]) {
        for p in &self.points {
            let (position, velocity) = p.motion(time, self.placed);
            let (at, there) = (p.signal.at + 1, p.signal.velocity_at());
            if let Some(numbers) = table.get_mut(at..there + 3) {
                let (x, v) = numbers.split_at_mut(there - at);
                x.copy_from_slice(&position);
                v.copy_from_slice(&velocity);
            }
            if let Some([known, uncertainty, rate]) = table.get_mut(there + 3..there + 6) {
                *known = 1.0;
                // The uncertainty of the controller is kept. If it has none, the true position is certain.
                if uncertainty.is_nan() {
                    (*uncertainty, *rate) = (0.0, 0.0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::stream;
    use super::*;
    use crate::program::{Between, HumanProgram, Lost, Sending, Tracking, Velocity};

    fn interface(velocity: Velocity, lost: Lost) -> Interface {
        let motion =
            Tracking { person: true, velocity, between: Between::Hold, max_speed: None, max_angular_speed: None, lost };
        let (mut signals, mut at) = (Vec::new(), 0);
        for name in ["walker.chest", "walker.hand"] {
            let (name, kind) = (name.to_string(), "point".to_string());
            let optional = false;
            signals.push(SignalProgram {
                name,
                kind,
                at,
                len: 3,
                optional,
                timeout: Some(0.054),
                motion: Some(motion),
                conditioning: Default::default(),
                variable: None,
                age_of: None,
            });
            at += signals[signals.len() - 1].width();
        }
        let human = HumanProgram { name: "walker".into(), points: vec![0, 1], links: vec![(0, 1)] };
        Interface { signals, humans: vec![human], events: Vec::new() }
    }

    fn walk(path: &[(f64, [f64; 3])], sending: Sending) -> HumanScript {
        let high = path.iter().map(|(t, x)| (*t, [x[0], x[1], x[2] + 0.4])).collect();
        HumanScript { human: 0, sending, tracks: vec![Track(path.to_vec()), Track(high)] }
    }

    const WALK: [(f64, [f64; 3]); 3] = [(0.0, [0.0, 0.0, 1.0]), (1.0, [0.0, 0.0, 1.0]), (3.0, [2.0, -1.0, 1.0])];

    /// Table of signals at each tick of 10 ms, and the truth.
    fn seen(interface: &Interface, script: &HumanScript, ticks: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
        let (mut person, mut signals) = (Person::new(script, interface, stream(3, 0)), Signals::new(interface));
        let one = |k: usize| {
            let time = k as f64 * 0.01;
            person.tick(&mut signals, time);
            signals.at(time, |_| None);
            let mut truth = signals.table().to_vec();
            person.truth(time, &mut truth);
            (signals.table().to_vec(), truth)
        };
        (0..ticks).map(one).collect()
    }

    #[test]
    fn a_measured_walk_is_known_as_it_is() {
        let interface = interface(Velocity::Measured, Lost::Fault);
        for (k, (table, truth)) in seen(&interface, &walk(&WALK, Sending::default()), 400).iter().enumerate() {
            assert_eq!(table, truth, "{k}");
            let hand = &interface.signals[1];
            let t = k as f64 * 0.01;
            let gone = (t - 1.0).clamp(0.0, 2.0);
            assert!((table[hand.at + 1] - gone).abs() < 1e-12 && (table[hand.at + 3] - 1.4).abs() < 1e-12);
            let moves = (1.0..3.0).contains(&t);
            assert_eq!(table[hand.velocity_at()], if moves { 1.0 } else { 0.0 }, "{t}");
        }
    }

    /// A point that is held stays at its last position, and its uncertainty grows from the time at which it was lost.
    #[test]
    fn a_lost_person_is_held_or_absent() {
        let gap = Sending { gaps: vec![(1.5, 2.0)], ..Sending::default() };
        let held = interface(Velocity::Estimated(5.0), Lost::Hold(1.6));
        let s = held.signals[0].clone();
        for (k, (table, truth)) in seen(&held, &walk(&WALK, gap.clone()), 300).iter().enumerate() {
            let t = k as f64 * 0.01;
            // The last reading came at 1.49 s, and is valid for 54 ms.
            let lost = (155..200).contains(&k);
            assert_eq!(table[s.at] < 0.0, lost, "{k}");
            assert_eq!(table[s.known_at()], 1.0);
            let (u, du) = (table[s.uncertainty_at()], table[s.uncertainty_at() + 1]);
            if lost {
                assert!((u - 1.6 * (t - 1.544)).abs() < 1e-12 && du == 1.6, "{t}: {u}");
                assert!((table[s.at + 1] - 0.49).abs() < 1e-12 && table[s.velocity_at()] == 0.0);
                assert!((truth[s.at + 1] - (t - 1.0)).abs() < 1e-12 && truth[s.at] == table[s.at]);
            } else {
                assert_eq!((u, du), (0.0, 0.0));
            }
        }
        let absent = interface(Velocity::Estimated(5.0), Lost::Fault);
        let (table, truth) = &seen(&absent, &walk(&WALK, gap), 200)[170];
        assert!(table[s.at] < 0.0 && table[s.known_at()] < 0.0 && table[s.at + 1].is_nan());
        assert!(table[s.uncertainty_at()].is_nan() && truth[s.uncertainty_at()] == 0.0);
        assert!(truth[s.at] < 0.0 && truth[s.known_at()] > 0.0 && truth[s.at + 1].is_finite());
    }

    #[test]
    fn a_reading_that_is_no_number_loses_the_point_at_once() {
        let held = interface(Velocity::Estimated(5.0), Lost::Hold(2.0));
        let bad = Sending { nan: vec![1.0], gaps: vec![(1.005, 1.2)], ..Sending::default() };
        let s = held.signals[0].clone();
        let all = seen(&held, &walk(&WALK, bad), 130);
        assert!(all[99].0[s.at] > 0.0 && all[100].0[s.at] < 0.0 && all[100].0[s.uncertainty_at()] == 0.0);
        assert!((all[110].0[s.uncertainty_at()] - 0.2).abs() < 1e-9 && all[120].0[s.at] > 0.0);
    }

    #[test]
    fn who_was_never_seen_is_nowhere() {
        let held = interface(Velocity::Estimated(5.0), Lost::Hold(1.6));
        let late = Sending { from: 1.0, ..Sending::default() };
        let all = seen(&held, &walk(&WALK, late), 110);
        let s = &held.signals[0];
        assert!(all[99].0[s.known_at()] < 0.0 && all[99].0[s.uncertainty_at()].is_nan());
        assert!(all[99].1[s.at + 1].is_finite() && all[100].0[s.known_at()] > 0.0);
    }

    proptest! {
        /// The interpolation compared with its definition: a straight line through the two waypoints around.
        #[test]
        fn a_point_is_on_the_line_between_its_waypoints(
            steps in prop::collection::vec((0.01..2.0_f64, prop::array::uniform3(-5.0..5.0_f64)), 1..8),
            time in 0.0..10.0_f64,
        ) {
            let mut t = 0.0;
            let path: Vec<(f64, [f64; 3])> = steps.iter().map(|(dt, x)| { t += dt; (t, *x) }).collect();
            let (x, v) = Track(path.clone()).at(time);
            let (first, last) = (path[0], path[path.len() - 1]);
            if time <= first.0 || time >= last.0 {
                let end = if time <= first.0 { first.1 } else { last.1 };
                prop_assert!(x.iter().zip(end).all(|(a, b)| (a - b).abs() < 1e-12));
                prop_assert!(time == first.0 || v == [0.0; 3]);
                return Ok(());
            }
            let k = (1..path.len()).find(|&k| time < path[k].0).unwrap_or(path.len() - 1);
            let ((t0, a), (t1, b)) = (path[k - 1], path[k]);
            for i in 0..3 {
                // Barycentric coordinates instead of start and displacement.
                let line = (a[i] * (t1 - time) + b[i] * (time - t0)) / (t1 - t0);
                prop_assert!((x[i] - line).abs() < 1e-9);
                prop_assert!((x[i] + v[i] * (t1 - time) - b[i]).abs() < 1e-9);
            }
        }

        #[test]
        fn the_same_seed_gives_the_same_bits(drop in 0.0..0.9_f64, noise in 0.001..0.2_f64, delay in 0.0..0.1_f64) {
            let interface = interface(Velocity::Measured, Lost::Hold(1.6));
            let script = walk(&WALK, Sending { drop, noise, delay, ..Sending::default() });
            let (a, b) = (seen(&interface, &script, 100), seen(&interface, &script, 100));
            prop_assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
    }
}

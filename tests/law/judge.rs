//! The law of a run, judged from what the robot did and what it was told, without numbers of the controller's own.

use runtime::FaultKind;

use super::cases::Built;
use super::world::{Call, Word};

/// Time over which the controller averages a margin (s), and margin from which on one counts as passed (m or rad).
const AVERAGED: f64 = 0.05;
const BEYOND: f64 = 1e-3;

/// Gain of the limits of joints, which is the largest (1/s).
const GAIN: f64 = 10.0;

/// What broke the law, in the order of time.
pub struct Broken(pub Vec<String>);

impl Broken {
    fn say(&mut self, time: f64, what: String) {
        if self.0.len() < 6 {
            self.0.push(format!("{time:.4} s: {what}"));
        }
    }
}

/// The first fault of a run, and its time.
pub fn fault(calls: &[Call]) -> Option<(f64, FaultKind, &str)> {
    calls.iter().find_map(|c| c.fault.as_ref().map(|(kind, text)| (c.time, *kind, text.as_str())))
}

/// Commands are finite, no faster than joints may be, and change no faster than they may, but for `steps` times `gain T v` of a host that calls more often
/// than the spec decides.
///
/// Of a distance and a limit of an acceleration, the distance is kept: nearer than `near` to a limit, accelerations are not judged.
pub fn commands(built: &Built, calls: &[Call], steps: f64, near: f64) -> Broken {
    let mut broken = Broken(Vec::new());
    let dofs = &built.program.robot.model.dofs;
    let mut last: Option<&Call> = None;
    let infeasible = fault(calls).filter(|f| f.1 == FaultKind::Infeasible).map_or(f64::INFINITY, |f| f.0);
    for call in calls {
        if call.u.iter().chain(&call.position).any(|x| !x.is_finite()) {
            broken.say(call.time, format!("{:?} {:?}", call.u, call.position));
        }
        for (u, d) in call.u.iter().zip(dofs) {
            if u.abs() > d.velocity * (1.0 + 1e-9) {
                broken.say(call.time, format!("{} at {u} of {}", d.name, d.velocity));
            }
        }
        // Brakes stop a robot that takes no commands. Where walls contradict the limits of accelerations, the distance is kept.
        if let (Some(before), Some(most)) = (last, &built.accelerations)
            && call.enabled
            && call.time < infeasible
            && call.seen.iter().chain(&before.seen).all(|margin| *margin >= near)
        {
            let (dt, period) = (call.time - before.time, built.program.robot.period);
            for (i, a) in most.iter().enumerate() {
                let change = (call.u[i] - before.u[i]).abs();
                let step = if dt < 0.98 * period { steps * GAIN * period * dofs[i].velocity } else { 0.0 };
                if change > a * dt * (1.0 + 1e-6) + 1e-9 + step {
                    let (name, push) = (&dofs[i].name, change / dt);
                    let text = format!(
                        "{name} changes by {change:.4} in {dt:.5} s: {push:.2} of {a:.2}; margins {:?}",
                        call.seen
                    );
                    broken.say(call.time, text);
                }
            }
        }
        last = Some(call);
    }
    broken
}

/// The true robot keeps its limits up to these reserves, until a fault says that it does not.
pub fn margins(calls: &[Call], reserves: [f64; 3]) -> Broken {
    let mut broken = Broken(Vec::new());
    let until = fault(calls).map_or(f64::INFINITY, |f| f.0);
    for call in calls.iter().take_while(|c| c.time < until) {
        for ((name, margin), reserve) in ["joints", "floor", "wall"].iter().zip(call.margins).zip(reserves) {
            if margin < -reserve {
                broken.say(call.time, format!("{name}: {:.4} mm", 1e3 * margin));
            }
        }
    }
    broken
}

/// A limit that the measured robot has passed, on the average, is told within `late` seconds.
pub fn told(calls: &[Call], late: f64) -> Broken {
    let mut broken = Broken(Vec::new());
    let until = fault(calls).map_or(f64::INFINITY, |f| f.0);
    let mut means = [f64::NAN; 3];
    let mut since = [0.0; 3];
    let mut last = 0.0;
    for call in calls.iter().take_while(|c| c.time < until) {
        let dt = call.time - last;
        last = call.time;
        for k in 0..3 {
            let h = call.seen[k];
            if means[k].is_nan() {
                if h >= 0.0 {
                    means[k] = h.min(10.0 * BEYOND);
                }
                continue;
            }
            means[k] = (means[k] + (1.0 - (-dt / AVERAGED).exp()) * (h - means[k])).min(10.0 * BEYOND);
            since[k] = if means[k] < -1.05 * BEYOND { since[k] + dt } else { 0.0 };
            if since[k] > late {
                broken.say(call.time, format!("{k}: {:.3} mm below for {:.3} s, untold", -1e3 * means[k], since[k]));
                since[k] = f64::NEG_INFINITY;
            }
        }
    }
    broken
}

/// After a stop, a fault or while it takes no commands, the robot comes to rest within `bound` seconds, and stands until it is told to go on.
pub fn rest(calls: &[Call], bound: f64) -> Broken {
    let mut broken = Broken(Vec::new());
    // Since when it is to stand; whether it takes commands, and whether it was halted, which nothing ends.
    let (mut since, mut halted): (Option<f64>, bool) = (None, false);
    let mut rested = false;
    for call in calls {
        for word in &call.words {
            match word {
                Word::Stop if since.is_none() => (since, rested) = (Some(call.time), false),
                Word::Disable => (since, rested) = (Some(f64::NEG_INFINITY), false),
                Word::Resume if call.enabled && !halted => since = None,
                _ => {}
            }
        }
        if call.fault.is_some() && !halted {
            halted = true;
            if since.is_none() {
                (since, rested) = (Some(call.time), false);
            }
        }
        let Some(from) = since else { continue };
        let moves = call.u.iter().any(|u| *u != 0.0);
        if moves && (rested || call.time > from + bound) {
            let most = call.u.iter().fold(0.0_f64, |a, u| a.max(u.abs()));
            broken.say(
                call.time,
                format!("moves at {most:.5}, told to stand at {from}, rested {rested}, bound {bound:.4}"),
            );
        }
        rested |= !moves && call.at_rest;
    }
    broken
}

/// A joint that is ill since a time is told to go no further than `most` (rad or m), forth and back, before there is a fault.
pub fn ways(calls: &[Call], joint: usize, since: f64, most: f64) -> Broken {
    let mut broken = Broken(Vec::new());
    let until = fault(calls).map_or(f64::INFINITY, |f| f.0);
    let mut way = 0.0;
    for pair in calls.windows(2).filter(|pair| pair[0].time >= since && pair[1].time < until) {
        way += pair[0].u[joint].abs() * (pair[1].time - pair[0].time);
        if way > most {
            broken.say(pair[0].time, format!("told to go {way:.3} since {since:.3} s"));
            break;
        }
    }
    broken
}

/// Largest angle by which all joints together go on within `delay` seconds, in the half second before a time (rad or m).
pub fn rush(calls: &[Call], time: f64, delay: f64) -> f64 {
    let before = calls.iter().filter(|c| c.time <= time && c.time > time - 0.5 - delay);
    before.map(|c| delay * c.u.iter().map(|u| u.abs()).sum::<f64>()).fold(0.0, f64::max)
}

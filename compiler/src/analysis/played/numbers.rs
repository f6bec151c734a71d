//! Ranges of the numbers of signals in a scenario, from the paths, values and forces of its script.

use runtime::program::{Force, HumanScript, Program, ScenarioProgram, SignalProgram};

use crate::expr::Interval;

/// Number of standard deviations beyond which noise is taken as impossible.
const DEVIATIONS: f64 = 8.0;

/// The script of a tracked point: of its person, and the index of its path.
struct PointScript<'s> {
    person: &'s HumanScript,
    point: usize,
}

/// The script of the tracked point that a signal is; `None` for other signals, and if nobody plays the person.
fn point<'s>(program: &Program, scenario: &'s ScenarioProgram, signal: usize) -> Option<PointScript<'s>> {
    let of = |h: usize| program.interface.humans[h].points.iter().position(|p| *p == signal);
    let human = (0..program.interface.humans.len()).find(|&h| of(h).is_some())?;
    let person = scenario.world.humans.iter().find(|script| script.human == human)?;
    Some(PointScript { person, point: of(human)? })
}

/// True if a signal may be received in a scenario, or is set by the controller.
pub(super) fn is_sent(program: &Program, scenario: &ScenarioProgram, signal: usize) -> bool {
    let (of, world, end) = (&program.interface.signals[signal], &scenario.world, scenario.run.duration);
    if of.variable.is_some() {
        return true;
    }
    if of.is_of_person() {
        return point(program, scenario, signal).is_some();
    }
    let by_outcome = |s: &(usize, Vec<f64>)| s.0 == signal;
    world.signals.iter().any(|s| s.signal == signal && s.drop < 1.0 && s.from <= end)
        || world.pushes.iter().any(|p| p.signal == signal)
        || world.outcomes.iter().flat_map(|o| &o.requests).any(|r| r.sets.iter().any(by_outcome))
}

/// Ranges of all numbers of the table of signals. Of signals that are not sent, only the presence is known.
pub(super) fn ranges(program: &Program, scenario: &ScenarioProgram, sent: &[bool]) -> Vec<Interval> {
    let mut out = vec![Interval::ALL; program.interface.width()];
    for (s, of) in program.interface.signals.iter().enumerate() {
        let presence = if sent[s] { Interval::within(1.0) } else { Interval::point(-1.0) };
        (out[of.at], out[of.known_at()]) = (presence, presence);
        if of.motion.is_some() {
            out[of.uncertainty_at()] = Interval::new(0.0, f64::INFINITY);
        }
        let values = match (of.variable.is_some() || !sent[s], of.is_of_person()) {
            (true, _) => None,
            (false, true) => point(program, scenario, s).and_then(|p| positions(&p, scenario.run.duration)),
            (false, false) => values(program, scenario, s),
        };
        for (k, range) in values.into_iter().flatten().enumerate().take(of.len) {
            out[of.at + 1 + k] = range;
        }
    }
    out
}

/// Range of the coordinates of a tracked point, with the noise of its readings.
fn positions(script: &PointScript, duration: f64) -> Option<Vec<Interval>> {
    let track = script.person.tracks.get(script.point)?;
    let noise = Interval::within(DEVIATIONS * script.person.sending.noise);
    let during = track.0.iter().filter(|p| p.0 > 0.0 && p.0 < duration).map(|p| p.1);
    let all: Vec<[f64; 3]> = during.chain([0.0, duration].map(|time| track.at(time).0)).collect();
    if all.iter().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    let hull = |k: usize| {
        let points = all.iter().map(|p| Interval::point(p[k]));
        points.reduce(Interval::hull).unwrap_or(Interval::ALL)
    };
    Some((0..3).map(|k| hull(k).plus(noise)).collect())
}

/// Ranges of the numbers of a signal that is no tracked point; `None` if nothing is known of them.
fn values(program: &Program, scenario: &ScenarioProgram, signal: usize) -> Option<Vec<Interval>> {
    let of: &SignalProgram = &program.interface.signals[signal];
    let tared = program.machine.iter().flat_map(|m| &m.actions).any(|a| {
        a.own.as_ref().is_some_and(|own| matches!(own, runtime::program::MachineAction::Tare(s) if *s == signal))
    });
    // Orientations are interpolated on the sphere.
    if matches!(of.len, 4 | 7) || tared || of.conditioning.bias.is_some() {
        return None;
    }
    let mut hull: Vec<Option<Interval>> = vec![None; of.len];
    let mut add = |numbers: &[f64], noise: f64| {
        for (hull, x) in hull.iter_mut().zip(numbers) {
            let more = Interval::point(*x).plus(Interval::within(DEVIATIONS * noise));
            *hull = Some(hull.map_or(more, |known| known.hull(more)));
        }
    };
    for script in scenario.world.signals.iter().filter(|s| s.signal == signal) {
        script.path.iter().for_each(|p| add(&p.1, script.noise));
    }
    for request in scenario.world.outcomes.iter().flat_map(|o| &o.requests) {
        request.sets.iter().filter(|s| s.0 == signal).for_each(|s| add(&s.1, 0.0));
    }
    let pushes: Vec<&Force> = scenario.world.pushes.iter().filter(|p| p.signal == signal).map(|p| &p.force).collect();
    if !pushes.is_empty() {
        add(&vec![0.0; of.len], 0.0);
    }
    let mut out: Vec<Interval> = hull.into_iter().collect::<Option<_>>()?;
    // Forces at the same time add up.
    for force in pushes {
        for (k, range) in out.iter_mut().enumerate() {
            let more = match force {
                Force::Constant(wrench) => {
                    Interval::point(0.0).hull(Interval::point(wrench.get(k).copied().unwrap_or(0.0)))
                }
                Force::Towards { most, .. } if k < 3 => Interval::within(*most),
                Force::Towards { .. } => Interval::point(0.0),
            };
            *range = range.plus(more);
        }
    }
    if of.conditioning.frame.is_some() {
        for part in out.chunks_mut(3) {
            let size = part.iter().map(|r| r.size().powi(2)).sum::<f64>().sqrt();
            part.fill(Interval::within(size));
        }
    }
    // A filter begins at the first value, or at rest.
    if of.conditioning.low_pass.is_some() {
        out.iter_mut().for_each(|r| *r = r.hull(Interval::point(0.0)));
    }
    Some(out)
}

//! A good sequence without a proof: jobs inserted one after the other, then moved and exchanged as long as that helps, then
//! shaken and improved again. It starts the exact planners, and stands in for them where they run out of budget.
//!
//! Candidates are compared at fixed durations, the best is re-timed exactly, and its durations are used for the next pass.
//! The shaking is by a generator with a fixed seed, and all limits are counts: the same problem gives the same sequence.

use crate::engine::EngineError;

use super::instance::{Instance, Sequence, Way};
use super::retime::{Timed, retime};
use super::timing::{self, Durations, Order};

/// Jobs placed at most in all sequences compared; keeps large problems short.
const PLACED: usize = 4_000_000;

/// Times that a sequence is shaken in vain.
const SHAKES: usize = 60;

/// Passes of moving and re-timing at most.
const PASSES: usize = 6;

/// The duration of each way of each job by each robot [s].
type Guess = Vec<Vec<[f64; 3]>>;

/// A good sequence, re-timed. The same for the same problem.
///
/// # Errors
///
/// The cone solver failed.
pub(crate) fn construct(instance: &Instance) -> Result<Timed, EngineError> {
    let nothing = || EngineError::Failed { engine: "construction".into(), message: "no sequence".into() };
    let guess = first_guess(instance);
    let mut left = PLACED / instance.jobs.len().max(1);
    let best = retime(instance, &insert(instance, &guess, &mut left))?.ok_or_else(nothing)?;
    polish(instance, guess, best, left)
}

/// A schedule improved as [`construct`] does.
///
/// # Errors
///
/// The cone solver failed.
pub(crate) fn refine(instance: &Instance, timed: Timed) -> Result<Timed, EngineError> {
    polish(instance, first_guess(instance), timed, PLACED / instance.jobs.len().max(1))
}

fn first_guess(instance: &Instance) -> Guess {
    let ways = |ways: &[Way; 3]| ways.map(|way| 0.5 * (way.low + way.cheapest()));
    instance.jobs.iter().map(|job| job.ways.iter().map(ways).collect()).collect()
}

fn polish(instance: &Instance, mut guess: Guess, mut best: Timed, mut left: usize) -> Result<Timed, EngineError> {
    for _ in 0..PASSES {
        for (m, jobs) in best.sequence.iter().enumerate() {
            jobs.iter().for_each(|job| guess[*job][m] = best.durations[*job]);
        }
        let next = shake(instance, &guess, &best.sequence, &mut left);
        let Some(next) = retime(instance, &next)? else { break };
        if next.cost >= best.cost - 1e-9 * best.cost.abs() {
            break;
        }
        best = next;
    }
    Ok(best)
}

/// What a sequence costs at these durations; infinite if it is none.
fn price(instance: &Instance, guess: &Guess, sequence: &Sequence) -> f64 {
    let Some(order) = Order::of(instance, sequence) else { return f64::INFINITY };
    let durations: Durations = order.robot.iter().enumerate().map(|(job, robot)| guess[job][*robot]).collect();
    let starts = timing::starts(instance, &order, &durations, None);
    timing::cost(instance, &order, &durations, &starts)
}

/// Jobs in the order in which they can be served, each given to the robot that serves it first.
fn insert(instance: &Instance, guess: &Guess, left: &mut usize) -> Sequence {
    let mut sequence: Sequence = vec![Vec::new(); instance.free.len()];
    let mut free = instance.free.clone();
    let mut ready: Vec<Option<f64>> =
        instance.jobs.iter().map(|job| job.previous.is_none().then_some(job.release)).collect();
    for _ in 0..instance.jobs.len() {
        let first = ready.iter().enumerate().filter_map(|(job, at)| at.map(|at| (job, at)));
        let Some((job, at)) = first.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        let start = |m: usize| at.max(free[m] + guess[job][m][0] + guess[job][m][1]);
        let end = |m: usize| start(m) + instance.serve(m) + guess[job][m][2] + instance.deposit(m);
        let Some(robot) = (0..free.len()).min_by(|a, b| end(*a).total_cmp(&end(*b))) else { break };
        let (served, home) = (start(robot) + instance.serve(robot), end(robot));
        sequence[robot].push(job);
        free[robot] = home;
        ready[job] = None;
        if let Some(next) = instance.jobs.iter().position(|other| other.previous == Some(job)) {
            ready[next] = Some(served + instance.jobs[next].nominal);
        }
    }
    improve(instance, guess, sequence, left)
}

/// Improves a sequence, and what becomes of it when some jobs are moved at random, until that helps no more.
fn shake(instance: &Instance, guess: &Guess, sequence: &Sequence, left: &mut usize) -> Sequence {
    let mut best = improve(instance, guess, sequence.clone(), left);
    let mut cost = price(instance, guess, &best);
    let mut random: u64 = 0x2545_f491_4f6c_dd1d;
    let mut below = |count: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % count.max(1)
    };
    let mut vain = 0;
    // Few sequences of few jobs: nothing to find by shaking.
    let shakes = SHAKES.min(instance.jobs.len().saturating_sub(3) * 8);
    while vain < shakes && *left > 0 {
        let mut shaken = best.clone();
        for _ in 0..2 + below(3) {
            let from = below(shaken.len());
            if shaken[from].is_empty() {
                continue;
            }
            let place = below(shaken[from].len());
            let job = shaken[from].remove(place);
            let to = below(shaken.len());
            let place = below(shaken[to].len() + 1);
            shaken[to].insert(place, job);
        }
        vain += 1;
        if Order::of(instance, &shaken).is_none() {
            continue;
        }
        let shaken = improve(instance, guess, shaken, left);
        let price = price(instance, guess, &shaken);
        if price < cost - 1e-9 {
            (best, cost, vain) = (shaken, price, 0);
        }
    }
    best
}

/// Moves a job elsewhere or exchanges two, as long as that makes the sequence cheaper.
fn improve(instance: &Instance, guess: &Guess, mut sequence: Sequence, left: &mut usize) -> Sequence {
    let mut cost = price(instance, guess, &sequence);
    loop {
        let mut best: Option<(f64, Sequence)> = None;
        let mut consider = |candidate: Sequence| {
            let price = price(instance, guess, &candidate);
            if price < best.as_ref().map_or(cost, |(price, _)| *price) - 1e-9 {
                best = Some((price, candidate));
            }
        };
        let places: Vec<(usize, usize)> =
            sequence.iter().enumerate().flat_map(|(m, jobs)| (0..jobs.len()).map(move |k| (m, k))).collect();
        for (index, &(m, k)) in places.iter().enumerate() {
            if *left == 0 {
                break;
            }
            let mut without = sequence.clone();
            let job = without[m].remove(k);
            for n in 0..sequence.len() {
                for l in 0..=without[n].len() {
                    if (n, l) != (m, k) {
                        let mut moved = without.clone();
                        moved[n].insert(l, job);
                        consider(moved);
                        *left = left.saturating_sub(1);
                    }
                }
            }
            for &(n, l) in &places[index + 1..] {
                let mut exchanged = sequence.clone();
                (exchanged[m][k], exchanged[n][l]) = (sequence[n][l], sequence[m][k]);
                consider(exchanged);
                *left = left.saturating_sub(1);
            }
        }
        match best {
            Some((price, better)) => (cost, sequence) = (price, better),
            None => return sequence,
        }
        if *left == 0 {
            return sequence;
        }
    }
}

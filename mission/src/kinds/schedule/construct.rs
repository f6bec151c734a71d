//! Heuristic search for a good sequence without a proof: jobs are inserted one after the other, then moved and
//! exchanged while that lowers the cost, then perturbed and improved again. The exact planners start from the result,
//! and return it if their budget runs out.
//!
//! Candidates are compared at fixed durations, the best one is re-timed exactly, and its durations are used in the next
//! pass. The perturbation uses a generator with a fixed seed, and limits are counts: the same problem gives the same
//! sequence unless the time limit is reached, which is checked before every sequence.

use crate::engine::{EngineError, Watch};

use super::instance::{Instance, Sequence, Way};
use super::retime::{Timed, retime};
use super::timing::{self, Durations, Order};

/// Maximum number of job placements in all compared sequences; bounds the run time for large problems.
const PLACED: usize = 4_000_000;

/// Maximum number of consecutive perturbations without improvement.
const SHAKES: usize = 60;

/// Maximum number of passes of moving and re-timing.
const PASSES: usize = 6;

/// Maximum number of jobs for which promising sequences are re-timed exactly, and number of these sequences per pass.
const EXACT_JOBS: usize = 16;
const EXACT_CANDIDATES: usize = 24;

/// Duration of each leg of each job by each robot (s).
type Guess = Vec<Vec<[f64; 3]>>;

/// Slowness of the first guesses: 0 for the greatest speeds, 1 for those of least energy.
const SLOWNESS: [f64; 3] = [0.0, 0.3, 1.0];

/// Remaining work: number of job placements to evaluate, until the time limit.
struct Work<'a> {
    left: usize,
    watch: &'a Watch,
}

impl Work<'_> {
    /// Counts one more sequence; returns false if no work is left.
    fn spend(&mut self) -> bool {
        self.left = self.left.saturating_sub(1);
        !self.is_over()
    }

    fn is_over(&self) -> bool {
        self.left == 0 || self.watch.is_over()
    }
}

/// Constructs a good, exactly timed sequence. Deterministic unless the time limit ends the search.
///
/// # Errors
///
/// The cone solver failed.
pub(crate) fn construct(instance: &Instance, watch: &Watch) -> Result<Timed, EngineError> {
    let nothing = || EngineError::Failed { engine: "construction".into(), message: "no sequence".into() };
    let mut best: Option<Timed> = None;
    let starts = if instance.is_fixed() { &SLOWNESS[..1] } else { &SLOWNESS };
    for slowness in starts {
        if best.is_some() && watch.is_over() {
            break;
        }
        let guess = first_guess(instance, *slowness);
        let mut work = Work { left: PLACED / instance.jobs.len().max(1) / starts.len(), watch };
        let timed = retime(instance, &insert(instance, &guess, &mut work), watch)?.ok_or_else(nothing)?;
        let timed = polish(instance, guess, timed, work)?;
        if best.as_ref().is_none_or(|best| timed.cost < best.cost) {
            best = Some(timed);
        }
    }
    best.ok_or_else(nothing)
}

/// Improves a schedule in the same manner as [`construct`].
///
/// # Errors
///
/// The cone solver failed.
pub(crate) fn refine(instance: &Instance, timed: Timed, watch: &Watch) -> Result<Timed, EngineError> {
    let work = Work { left: PLACED / instance.jobs.len().max(1), watch };
    polish(instance, first_guess(instance, 0.0), timed, work)
}

fn first_guess(instance: &Instance, slowness: f64) -> Guess {
    let ways = |ways: &[Way; 3]| ways.map(|way| way.low + slowness * (way.cheapest() - way.low).max(0.0));
    instance.jobs.iter().map(|job| job.ways.iter().map(ways).collect()).collect()
}

/// Returns the durations of a schedule, and for every other robot the durations of a job at the job's present speeds.
fn next_guess(instance: &Instance, timed: &Timed) -> Guess {
    let mut robot = vec![0; instance.jobs.len()];
    for (m, jobs) in timed.sequence.iter().enumerate() {
        jobs.iter().for_each(|job| robot[*job] = m);
    }
    let of = |index: usize, m: usize| {
        let (own, other) = (&instance.jobs[index].ways[robot[index]], &instance.jobs[index].ways[m]);
        let mut times = timed.durations[index];
        for (time, (own, other)) in times.iter_mut().zip(own.iter().zip(other)) {
            let same = if own.length > 0.0 { *time * other.length / own.length } else { other.low };
            *time = same.max(other.low).min(other.high);
        }
        times
    };
    let robots = instance.free.len();
    (0..instance.jobs.len()).map(|index| (0..robots).map(|m| of(index, m)).collect()).collect()
}

fn polish(instance: &Instance, mut guess: Guess, mut best: Timed, mut work: Work) -> Result<Timed, EngineError> {
    for pass in 0..PASSES {
        if work.watch.is_over() {
            return Ok(best);
        }
        let next = shake(instance, &guess, &best.sequence, &mut work);
        let Some(next) = retime(instance, &next, work.watch)? else { break };
        let better = next.cost < best.cost - 1e-9 * best.cost.abs();
        if better {
            best = next;
        } else if pass > 0 {
            break;
        }
        guess = next_guess(instance, &best);
    }
    if instance.is_fixed() || instance.jobs.len() > EXACT_JOBS { Ok(best) } else { exactly(instance, best, work.watch) }
}

/// Moves and exchanges jobs once more, with the most promising sequences re-timed exactly.
fn exactly(instance: &Instance, mut best: Timed, watch: &Watch) -> Result<Timed, EngineError> {
    for _ in 0..PASSES {
        let guess = next_guess(instance, &best);
        let mut candidates: Vec<(f64, Sequence)> = Vec::new();
        neighbours(&best.sequence, |sequence| {
            let price = price(instance, &guess, &sequence);
            if price.is_finite() {
                candidates.push((price, sequence));
            }
            !watch.is_over()
        });
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut next: Option<Timed> = None;
        for (_, sequence) in candidates.into_iter().take(EXACT_CANDIDATES) {
            if watch.is_over() {
                return Ok(next.unwrap_or(best));
            }
            let timed = retime(instance, &sequence, watch)?;
            let least = next.as_ref().map_or(best.cost - 1e-9 * best.cost.abs(), |next| next.cost);
            next = timed.filter(|timed| timed.cost < least).or(next);
        }
        match next {
            Some(next) => best = next,
            None => break,
        }
    }
    Ok(best)
}

/// Enumerates every sequence with one job moved or two exchanged, until `wanted` returns false.
fn neighbours(sequence: &Sequence, mut wanted: impl FnMut(Sequence) -> bool) {
    let places: Vec<(usize, usize)> =
        sequence.iter().enumerate().flat_map(|(m, jobs)| (0..jobs.len()).map(move |k| (m, k))).collect();
    for (index, &(m, k)) in places.iter().enumerate() {
        let mut without = sequence.clone();
        let job = without[m].remove(k);
        for n in 0..sequence.len() {
            for l in 0..=without[n].len() {
                if (n, l) != (m, k) {
                    let mut moved = without.clone();
                    moved[n].insert(l, job);
                    if !wanted(moved) {
                        return;
                    }
                }
            }
        }
        for &(n, l) in &places[index + 1..] {
            let mut exchanged = sequence.clone();
            (exchanged[m][k], exchanged[n][l]) = (sequence[n][l], sequence[m][k]);
            if !wanted(exchanged) {
                return;
            }
        }
    }
}

/// Computes the cost of a sequence at these durations; infinite if the sequence is invalid.
fn price(instance: &Instance, guess: &Guess, sequence: &Sequence) -> f64 {
    let Some(order) = Order::of(instance, sequence) else { return f64::INFINITY };
    let durations: Durations = order.robot.iter().enumerate().map(|(job, robot)| guess[job][*robot]).collect();
    let starts = timing::starts(instance, &order, &durations, None);
    timing::cost(instance, &order, &durations, &starts)
}

/// Assigns jobs in the order of their release, each to the robot that finishes its trip first, and improves the
/// resulting sequence.
fn insert(instance: &Instance, guess: &Guess, work: &mut Work) -> Sequence {
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
    improve(instance, guess, sequence, work)
}

/// Improves a sequence by local search from random perturbations, until a number of them brings no improvement.
fn shake(instance: &Instance, guess: &Guess, sequence: &Sequence, work: &mut Work) -> Sequence {
    let mut best = improve(instance, guess, sequence.clone(), work);
    let mut cost = price(instance, guess, &best);
    let mut random: u64 = 0x2545_f491_4f6c_dd1d;
    let mut below = |count: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % count.max(1)
    };
    let mut vain = 0;
    // With few jobs there are few sequences, and perturbations find nothing new.
    let shakes = SHAKES.min(instance.jobs.len().saturating_sub(3) * 8);
    while vain < shakes && !work.is_over() {
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
        let shaken = improve(instance, guess, shaken, work);
        let price = price(instance, guess, &shaken);
        if price < cost - 1e-9 {
            (best, cost, vain) = (shaken, price, 0);
        }
    }
    best
}

/// Moves one job or exchanges two, as long as the cost decreases.
fn improve(instance: &Instance, guess: &Guess, mut sequence: Sequence, work: &mut Work) -> Sequence {
    if work.is_over() {
        return sequence;
    }
    let mut cost = price(instance, guess, &sequence);
    loop {
        let mut best: Option<(f64, Sequence)> = None;
        neighbours(&sequence, |candidate| {
            let price = price(instance, guess, &candidate);
            if price < best.as_ref().map_or(cost, |(price, _)| *price) - 1e-9 {
                best = Some((price, candidate));
            }
            work.spend()
        });
        match best {
            Some((price, better)) => (cost, sequence) = (price, better),
            None => return sequence,
        }
        if work.is_over() {
            return sequence;
        }
    }
}

//! Checks at thousands of sampled postures, which take seconds: `hierarq check --deep`.
//!
//! The postures are random within the joints' limits, and the same for the same seed, however many threads there are. A
//! finding at a posture is a fact about this posture; nothing found is no proof.

mod collisions;
mod postures;

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use dsl::Diagnostic;
use robot::random::SplitMix64;
use runtime::program::Program;

use super::Checked;
use crate::sampled::{Deep, Sampled};

/// Most threads that share the work.
const THREADS: usize = 16;

/// Number of postures after which progress is told.
const STEP: usize = 64;

/// Runs the checks.
pub(super) fn check(c: &Checked, deep: &Deep, out: &mut Vec<Diagnostic>) -> Sampled {
    let stacks: Vec<usize> = c.program.run_stacks();
    let model = &c.program.robot.model;
    let moves = |s: &usize| c.program.stacks[*s].locked.len() < model.nv();
    let stacks: Vec<usize> = stacks.into_iter().filter(moves).collect();
    let work = Work { deep, done: AtomicUsize::new(0), total: deep.postures * (stacks.len() + 1) };
    let mut told: BTreeSet<Vec<usize>> = BTreeSet::new();
    let mut sampled = Sampled { seed: deep.seed, ..Sampled::default() };
    for stack in stacks {
        sampled.stacks.push(postures::check(c, &work, stack, &mut told, out));
    }
    sampled.contacts = collisions::check(c, &work, out);
    sampled
}

/// The work of all threads.
struct Work<'d> {
    deep: &'d Deep<'d>,
    done: AtomicUsize,
    total: usize,
}

impl Work<'_> {
    /// Examines all postures, in several threads: each makes a `T` by `start`, and `examine` adds the posture of a number
    /// to it. Returns them all.
    fn share<T: Send>(
        &self,
        program: &Program,
        start: impl Fn() -> T + Sync,
        examine: impl Fn(&mut T, usize, &[f64]) + Sync,
    ) -> Vec<T> {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(THREADS);
        let part = |first: usize| {
            let mut result = start();
            for k in (first..self.deep.postures).step_by(threads) {
                examine(&mut result, k, &posture(program, self.deep.seed, k));
                if k.is_multiple_of(STEP) {
                    let done = self.done.fetch_add(STEP, Ordering::Relaxed) + STEP;
                    (self.deep.progress)(done.min(self.total), self.total);
                }
            }
            result
        };
        std::thread::scope(|scope| {
            let part = &part;
            let all: Vec<_> = (0..threads).map(|first| scope.spawn(move || part(first))).collect();
            // A thread that panicked has told why; the rest of the result would be wrong without its part.
            all.into_iter().map(|t| t.join().unwrap_or_else(|why| std::panic::resume_unwind(why))).collect()
        })
    }
}

/// Posture number `k`, independent of all others. Bases stay where they are at home: limits of places decide where it may go.
fn posture(program: &Program, seed: u64, k: usize) -> Vec<f64> {
    let mut generator = SplitMix64(seed ^ (k as u64).wrapping_mul(0x2545_f491_4f6c_dd1d));
    let model = &program.robot.model;
    let mut q = model.random_configuration(&mut || generator.unit());
    model.copy_bases(&program.robot.home, &mut q);
    q
}

/// Formats a share in percent, never rounded to none or all.
pub(super) fn share(part: usize, of: usize) -> String {
    let percent = 100.0 * part as f64 / of.max(1) as f64;
    match () {
        () if part == of => "all".to_string(),
        () if percent < 0.1 => format!("{part} of {of}"),
        () if percent > 99.9 => format!("all but {} of {of}", of - part),
        () => format!("{percent:.1} %"),
    }
}

//! A host's own loop: a spec is compiled once, then `Controller::step` is called a thousand times a
//! second by the monotonic clock, against the simulated robot. Prints how late the ticks began
//! and how long the steps took.
//!
//! ```text
//! cargo run --release --example realtime -- [SPEC] [SECONDS] [RATE_HZ]
//! ```

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use hierarq::project::{Settings, compile};
use runtime::simulated_robot::SimulatedRobot;
use runtime::{Controller, Observation};

/// The operating system wakes a sleeper late; the rest of the wait is spent looking at the clock.
const SPIN: Duration = Duration::from_micros(200);

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let default = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/cooperative_motion.hq");
    let spec = arguments.next().map_or(default, PathBuf::from);
    let seconds: f64 = arguments.next().and_then(|s| s.parse().ok()).unwrap_or(5.0);
    let rate: f64 = arguments.next().and_then(|s| s.parse().ok()).unwrap_or(1000.0);
    if !(seconds > 0.0 && seconds < 3600.0 && (1.0..=20_000.0).contains(&rate)) {
        eprintln!("seconds between 0 and 3600 and a rate between 1 and 20000 Hz, please");
        return ExitCode::from(2);
    }
    let compiled = compile(&spec, &Settings::default());
    let Some(program) = compiled.program else {
        eprint!("{}", compiled.report.render(compiler::Style::Plain, 100));
        return ExitCode::FAILURE;
    };
    // The spec was checked for its own rate: a gain that is right there may overshoot at a lower one.
    let program = match program.at_period(1.0 / rate) {
        Ok(program) => program,
        Err(e) => {
            eprintln!("{e}");
            return ExitCode::FAILURE;
        }
    };
    let (mut controller, mut robot) = match Controller::new(&program) {
        Ok(controller) => (controller, SimulatedRobot::new(&program)),
        Err(e) => {
            eprintln!("{e}");
            return ExitCode::FAILURE;
        }
    };

    let ticks = (seconds * rate) as usize;
    let period = Duration::from_secs_f64(1.0 / rate);
    let (mut late, mut took) = (vec![0.0_f64; ticks], vec![0.0_f64; ticks]);
    let mut velocity = vec![0.0; robot.q().len().max(program.robot.model.nv())];
    let started = Instant::now();
    for tick in 0..ticks {
        let due = started + period * tick as u32;
        wait_until(due);
        let begin = Instant::now();
        let command = controller.step(&Observation { time: tick as f64 / rate, q: robot.measure() });
        let end = Instant::now();
        late[tick] = (begin - due).as_secs_f64() * 1e6;
        took[tick] = (end - begin).as_secs_f64() * 1e6;
        velocity[..command.velocity.len()].copy_from_slice(command.velocity);
        let (n, fault) = (command.velocity.len(), command.fault);
        if let Some(fault) = fault {
            eprintln!("fault after {tick} ticks: {}", controller.describe(&fault));
            return ExitCode::FAILURE;
        }
        robot.apply(&velocity[..n]);
    }
    let deadline = period.as_secs_f64() * 1e6;
    let missed = late.iter().zip(&took).filter(|(l, t)| **l + **t > deadline).count();
    println!("{} at {rate} Hz for {seconds} s: {ticks} ticks, {missed} finished after their period", program.name);
    histogram("late at the start", &mut late);
    histogram("step", &mut took);
    ExitCode::SUCCESS
}

fn wait_until(due: Instant) {
    loop {
        let now = Instant::now();
        if now >= due {
            return;
        }
        let left = due - now;
        if left > SPIN {
            std::thread::sleep(left - SPIN);
        } else {
            std::hint::spin_loop();
        }
    }
}

/// Counts by powers of two of a microsecond, and percentiles.
fn histogram(what: &str, sample: &mut [f64]) {
    sample.sort_by(f64::total_cmp);
    let at = |share: f64| sample[((sample.len() - 1) as f64 * share) as usize];
    println!("\n{what}: median {:.1} us, p99 {:.1} us, max {:.1} us", at(0.5), at(0.99), at(1.0));
    let mut from = 0.0;
    let mut to = 1.0;
    let mut rest = &sample[..];
    while !rest.is_empty() {
        let count = rest.partition_point(|x| *x < to);
        if count > 0 {
            let bar = "#".repeat((60.0 * count as f64 / sample.len() as f64).ceil() as usize);
            println!("{from:>8.0} to {to:>6.0} us {count:>8}  {bar}");
        }
        rest = &rest[count..];
        (from, to) = (to, 2.0 * to);
    }
}

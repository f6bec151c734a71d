//! Time that a log in MCAP adds to a tick: the controller's step and the recording of the same tick, in one run, as fast as it goes and
//! at the pace of the robot. A host drops ticks rather than wait.
//!
//! ```text
//! cargo bench -p hierarq-logs
//! ```

#![allow(missing_docs, reason = "a benchmark")]

use std::path::Path;
use std::time::{Duration, Instant};

use hierarq_logs::{About, McapRecorder, Origin, Overflow};
use runs::project::{self, Settings};
use runtime::{Recorder, Simulation, Tick};

/// Times of ticks, in us.
struct Timed {
    log: McapRecorder<std::fs::File>,
    step: Vec<f64>,
    record: Vec<f64>,
    /// Start of the run, for a run at the pace of the robot.
    pace: Option<Instant>,
}

impl Recorder for Timed {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let before = Instant::now();
        self.log.record(tick)?;
        self.record.push(before.elapsed().as_secs_f64() * 1e6);
        self.step.push(tick.elapsed * 1e6);
        if let Some(start) = self.pace {
            let next = Duration::from_secs_f64(tick.time + tick.controller.period());
            std::thread::sleep(next.saturating_sub(start.elapsed()));
        }
        Ok(())
    }
}

fn row(name: &str, mut times: Vec<f64>) {
    times.sort_by(f64::total_cmp);
    let share = |s: f64| times[((times.len() - 1) as f64 * s) as usize];
    println!("    {name:<22} median {:8.2}  p99 {:8.2}  worst {:8.2} us", share(0.5), share(0.99), share(1.0));
}

fn main() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    for name in ["hello.hq", "safety_tasks.hq", "both_arms.hq"] {
        for paced in [false, true] {
            let compiled = project::load(&examples.join(name), &Settings::default());
            let mut program = compiled.program.expect("the example has a robot");
            program.run.duration = 10.0;
            let about = About::new(&program, None, Vec::new(), Origin::Run);
            let mut simulation = Simulation::new(&program).expect("the example runs");
            let path = std::env::temp_dir().join(format!("hierarq-bench-{}.mcap", std::process::id()));
            let out = std::fs::File::create(&path).expect("a file");
            let controller = simulation.controller();
            let log = McapRecorder::new(out, &about, &program, controller, Overflow::Drop).expect("a log");
            let start = Instant::now();
            let mut timed = Timed { log, step: Vec::new(), record: Vec::new(), pace: paced.then_some(start) };
            let mut clock = || start.elapsed().as_secs_f64();
            simulation.run(&mut timed, &mut clock, &mut |_| true).expect("a run");
            let Timed { log, step, record, .. } = timed;
            let written = log.finish().expect("a file").written;
            let bytes = std::fs::metadata(&path).map(|m| m.len()).unwrap_or(0);
            let _ = std::fs::remove_file(&path);
            let pace = if paced { "at the pace of the robot" } else { "as fast as it goes" };
            println!("{name}, {pace}: {} ticks, {} dropped, {} bytes", step.len(), written.dropped, bytes);
            let with: Vec<f64> = step.iter().zip(&record).map(|(a, b)| a + b).collect();
            row("step, without a log", step);
            row("step, with a log", with);
            row("the log alone", record);
        }
    }
}

//! Experiment 4.D as a table: safety planner, evasive motion and emergency stop in the scenarios of `examples/give_way.hq`,
//! each with M1, the mean field, M2, the mean path error, and M3, the share of the time in which the task stands still,
//! beside thesis Table 4.2. Shows how a host measures a run with a recorder of its own.
//!
//! ```text
//! cargo run --release --example comparison
//! ```

use std::error::Error;
use std::path::Path;

use hierarq::project::{Settings, compile};
use runtime::program::Program;
use runtime::{Recorder, Simulation, Tick};

/// Thesis Table 4.2, its columns as the text has them (correction 10): M1, M2 in m, M3.
const THESIS: [[f64; 3]; 3] = [[0.99, 0.08, 0.0], [0.95, 0.16, 0.0], [0.86, 0.0, 0.62]];

/// Sums over the ticks of a run.
struct Means {
    /// Places of the field, the deviation and the scaling in the table of signals.
    field: usize,
    deviation: usize,
    scaling: usize,
    sums: [f64; 3],
    ticks: f64,
}

impl Means {
    fn new(program: &Program, guard: &str) -> Option<Means> {
        let place = |output: &str| {
            let signal = program.interface.signal(&format!("{guard}.{output}"))?;
            Some(program.interface.signals[signal].at + 1)
        };
        let [field, deviation, scaling] = [place("field")?, place("deviation")?, place("scaling")?];
        Some(Means { field, deviation, scaling, sums: [0.0; 3], ticks: 0.0 })
    }
}

impl Recorder for Means {
    fn tick(&mut self, t: &Tick) -> std::io::Result<()> {
        // Distances of the safe path from the nominal one, and of the hands from the safe one.
        let motion = t.evaluator.members().iter().find(|m| m.name == "motion");
        let error = motion.map_or(f64::NAN, |m| t.evaluator.measures()[m.measures.start]);
        let stands = f64::from(u8::from(t.signals[self.scaling] < 0.01));
        for (sum, x) in self.sums.iter_mut().zip([t.signals[self.field], t.signals[self.deviation] + error, stands]) {
            *sum += x;
        }
        self.ticks += 1.0;
        Ok(())
    }
}

/// Scenarios by name, each with its M1, M2 and M3.
pub type Figures = Vec<(String, [f64; 3])>;

/// M1, M2 and M3 of each scenario, in its order.
pub fn figures() -> Result<Figures, Box<dyn Error>> {
    let spec = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/give_way.hq");
    let compiled = compile(&spec, &Settings::default());
    let program = compiled.program.ok_or("the spec does not compile: see `hierarq check`")?;
    let mut figures = Vec::new();
    for (scenario, guard) in program.scenarios.iter().zip(["planner", "evasive", "stop"]) {
        let own = scenario.program(&program);
        let mut means = Means::new(&own, guard).ok_or_else(|| format!("`{guard}` tells nothing in this spec"))?;
        Simulation::in_world(&own, scenario)?.run(&mut means, &mut || 0.0, &mut |_| true)?;
        let means = means.sums.map(|s| s / means.ticks);
        if !means.iter().all(|m| m.is_finite()) {
            return Err(format!("`{guard}` or `motion` does not run all the time in \"{}\"", scenario.name).into());
        }
        figures.push((scenario.name.clone(), means));
    }
    Ok(figures)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:20} {:>17} {:>22} {:>17}", "", "M1 mean field", "M2 mean path error", "M3 stands still");
    println!("{:20} {:>8} {:>8} {:>13} {:>8} {:>8} {:>8}", "", "here", "thesis", "here", "thesis", "here", "thesis");
    for ((name, m), thesis) in figures()?.iter().zip(THESIS) {
        println!(
            "{name:20} {:>6.3} m {:>6.2} m {:>11.3} m {:>6.2} m {:>6.0} % {:>6.0} %",
            m[0],
            thesis[0],
            m[1],
            thesis[1],
            100.0 * m[2],
            100.0 * thesis[2]
        );
    }
    println!("The scenario is ours, the thesis gives no coordinates: compare the order, not the digits.");
    Ok(())
}

//! `hierarq bench SPEC`
//!
//! The closed loop runs as in `hierarq run`. In addition, the same kinematics and rows are computed once more per tick
//! and timed, and every solver solves the tick's problem, in an order that rotates from tick to tick so that no solver
//! always has warm caches.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use hierarq::project;
use runtime::program::Times as At;
use runtime::record::summary::Percentiles;
use runtime::{Controller, Evaluator, Observation, Program, SimulatedRobot, TickInputs};
use serde_json::{Value, json};
use solver::{Active, Backend, Problem, Solution, Status};

use super::backend::{Measured, Times, cells_of, json_of, microseconds, remark, table};
use super::{Outcome, SpecOptions, output};

/// Maximum number of ticks: their times need about 24 bytes per tick.
const MAX_TICKS: u64 = 10_000_000;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Number of ticks [default: those of the spec's run].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_TICKS))]
    ticks: Option<u64>,
    /// Print the figures as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let compiled = project::load(&a.spec, &a.options.settings());
    let Some(program) = compiled.program else { return output::refuse(&compiled.report, &a.spec, a.json) };
    output::show(&compiled.report);
    let whole_run = (program.run.duration / program.robot.period).round() as u64;
    let ticks = a.ticks.unwrap_or(whole_run.clamp(1, MAX_TICKS));
    let mut measured = Loop::new(&program).map_err(|e| e.to_string())?;
    measured.run(ticks);
    Ok(measured.report(&program, a.json))
}

/// A solver to be measured.
struct Candidate {
    name: &'static str,
    measured: Measured,
    us: Times,
    /// Maximum difference of a velocity from the reference's.
    dx: f64,
    failed: usize,
}

/// Row counts of a level, over all ticks.
#[derive(Clone, Default)]
struct LevelCount {
    equalities: usize,
    bound: (usize, usize),
    violated: (usize, usize),
    freedom: usize,
}

/// The closed loop with all measurements.
struct Loop {
    controller: Controller,
    robot: SimulatedRobot,
    evaluator: Evaluator,
    problem: Problem,
    period: f64,
    /// The last one is the reference for the others.
    candidates: Vec<Candidate>,
    rows: Times,
    tick: Times,
    levels: Vec<LevelCount>,
    fault: Option<String>,
}

impl Loop {
    fn new(program: &Program) -> Result<Loop, runtime::ProgramError> {
        // The first stack of a machine: the machine itself is not executed, since its transitions wait for the world.
        let stack = program.first_stack().unwrap_or(0);
        let controller = Controller::for_stack(program, stack)?.without_enabling();
        let (evaluator, _) = Evaluator::new(program, stack)?;
        let problem = controller.problem().clone();
        let candidate = |name, backend, cold| Candidate {
            name,
            measured: Measured::new(backend, cold, &problem),
            us: Times::default(),
            dx: 0.0,
            failed: 0,
        };
        Ok(Loop {
            candidates: vec![
                candidate("active_set", Backend::ActiveSet, false),
                candidate("active_set_cold", Backend::ActiveSet, true),
                candidate("clarabel", Backend::Clarabel, false),
            ],
            levels: vec![LevelCount { freedom: usize::MAX, ..LevelCount::default() }; problem.levels.len()],
            robot: SimulatedRobot::of_run(program, None)?,
            period: program.robot.period,
            rows: Times::default(),
            tick: Times::default(),
            fault: None,
            controller,
            evaluator,
            problem,
        })
    }

    /// Runs this number of ticks, or fewer if a fault ends the run.
    fn run(&mut self, ticks: u64) {
        let mut q = self.robot.q().to_vec();
        let mut reference = q.clone();
        let mut velocity = self.controller.velocity().to_vec();
        let mut stack_velocity = velocity.clone();
        for index in 0..ticks {
            let time = index as f64 * self.period;
            let times = At { t: time, time };
            let signals = self.controller.signal_table().to_vec();
            velocity.copy_from_slice(self.controller.velocity());
            stack_velocity.copy_from_slice(self.controller.stack_velocity());
            let at = TickInputs { times, signals: &signals, velocity: &velocity, stack_velocity: &stack_velocity };
            q.copy_from_slice(self.robot.measure());
            // The rows of a tick are computed at the reference, which the first tick takes from the robot.
            if index == 0 {
                reference.copy_from_slice(&q);
                self.evaluator.enter(&q, at);
            } else {
                reference.copy_from_slice(self.controller.reference());
            }
            let start = Instant::now();
            let command = self.controller.step(&Observation { time, q: &q });
            let us = microseconds(start);
            if let Some(fault) = command.fault {
                self.fault = Some(format!("at {time:.3} s: {}", self.controller.describe(&fault)));
                return;
            }
            self.robot.apply(command.velocity);
            self.tick.push(us);

            let start = Instant::now();
            let written = self.evaluator.update(&reference, at, &mut self.problem);
            self.rows.push(microseconds(start));
            debug_assert!(written.is_ok() && &self.problem == self.controller.problem(), "not the controller's rows");
            self.evaluator.observe(&reference, &self.controller.solution().x);
            self.solve(index as usize);
            self.count();
        }
    }

    /// Solves the problem of the tick with every solver, beginning with solver `index % count`.
    fn solve(&mut self, index: usize) {
        let count = self.candidates.len();
        for i in 0..count {
            let candidate = &mut self.candidates[(index + i) % count];
            let us = candidate.measured.solve(&self.problem);
            candidate.us.push(us);
            candidate.failed += usize::from(candidate.measured.solution.status != Status::Optimal);
        }
        let Some((reference, others)) = self.candidates.split_last_mut() else { return };
        // An unproven answer is no reference for the others.
        if reference.measured.solution.status != Status::Optimal {
            return;
        }
        let x = &reference.measured.solution.x;
        for other in others.iter_mut().filter(|o| o.measured.solution.status == Status::Optimal) {
            for (a, b) in other.measured.solution.x.iter().zip(x) {
                other.dx = other.dx.max((a - b).abs());
            }
        }
    }

    fn count(&mut self) {
        let solution: &Solution = self.controller.solution();
        for (l, ((count, level), solution)) in
            self.levels.iter_mut().zip(&self.problem.levels).zip(&solution.levels).enumerate()
        {
            let number = |wanted: &dyn Fn(&Active) -> bool| solution.active.iter().filter(|a| wanted(a)).count();
            let add = |sum: &mut (usize, usize), n: usize| *sum = (sum.0 + n, sum.1.max(n));
            count.equalities = count.equalities.max((0..level.rows()).filter(|i| level.is_equality(*i)).count());
            add(&mut count.bound, number(&|a| matches!(a, Active::Lower | Active::Upper)));
            add(&mut count.violated, number(&|a| *a == Active::Violated));
            count.freedom = count.freedom.min(self.controller.freedom(l));
        }
    }

    fn report(mut self, program: &Program, json: bool) -> Outcome {
        let (tick, rows) = (self.tick.percentiles(), self.rows.percentiles());
        let times: Vec<Percentiles> = self.candidates.iter_mut().map(|c| c.us.percentiles()).collect();
        let reference = times.last().map_or(0.0, |t| t.median);
        let ratio = |t: &Percentiles| if reference > 0.0 { t.median / reference } else { f64::NAN };
        let failed: usize = self.candidates.iter().map(|c| c.failed).sum();
        let bad = self.fault.is_some() || failed > 0;
        if json {
            let data = self.json(program, &tick, &rows, &times, ratio, bad);
            output::data(&format!("{data:#}\n"));
        } else {
            let text = self.text(program, &tick, &rows, &times, ratio);
            output::print(&text);
        }
        Outcome::of(!bad)
    }

    fn json(
        &self,
        program: &Program,
        tick: &Percentiles,
        rows: &Percentiles,
        times: &[Percentiles],
        ratio: impl Fn(&Percentiles) -> f64,
        bad: bool,
    ) -> Value {
        let mut solve = serde_json::Map::new();
        for (c, t) in self.candidates.iter().zip(times) {
            let figures = json!({ "us": json_of(t), "ratio_to_clarabel": ratio(t), "dx": c.dx, "failed": c.failed });
            solve.insert(c.name.to_string(), figures);
        }
        let ticks = self.tick.count();
        let mean = |sum: usize| sum as f64 / ticks.max(1) as f64;
        let level = |(l, c): (usize, &LevelCount)| {
            json!({
                "name": self.controller.level_names().get(l),
                "hard": self.problem.levels[l].hard,
                "rows": self.problem.levels[l].rows(),
                "equalities": c.equalities,
                "at_bound": { "mean": mean(c.bound.0), "most": c.bound.1 },
                "violated": { "mean": mean(c.violated.0), "most": c.violated.1 },
                "least_freedom": if ticks > 0 { json!(c.freedom) } else { Value::Null },
            })
        };
        json!({
            "version": 1,
            "program": program.name,
            "ok": !bad,
            "ticks": ticks,
            "fault": self.fault,
            "degrees_of_freedom": self.problem.n,
            "kinematics_and_rows_us": json_of(rows),
            "solve": solve,
            "tick": { "us": json_of(tick), "solver": self.controller.solver_name() },
            "levels": self.levels.iter().enumerate().map(level).collect::<Vec<_>>(),
        })
    }

    fn text(
        &self,
        program: &Program,
        tick: &Percentiles,
        rows: &Percentiles,
        times: &[Percentiles],
        ratio: impl Fn(&Percentiles) -> f64,
    ) -> String {
        let line = |name: String, t: &Percentiles, more: [String; 3]| {
            std::iter::once(name).chain(cells_of(t)).chain(more).collect::<Vec<_>>()
        };
        let empty = || [String::new(), String::new(), String::new()];
        let mut lines = vec![line("kinematics and rows".to_string(), rows, empty())];
        for (i, (c, t)) in self.candidates.iter().zip(times).enumerate() {
            let dx = if i + 1 < times.len() { format!("{:.1e}", c.dx) } else { String::new() };
            let failed = if c.failed > 0 { c.failed.to_string() } else { String::new() };
            lines.push(line(
                format!("solve, {}", c.name.replace("_cold", ", cold")),
                t,
                [format!("{:.2}", ratio(t)), dx, failed],
            ));
        }
        lines.push(line(format!("whole tick ({})", self.controller.solver_name()), tick, empty()));
        let header = ["", "median us", "p99 us", "max us", "of clarabel", "|dx| from it", "failed"];
        let ticks = self.tick.count();
        let fault = self.fault.as_ref().map_or_else(String::new, |f| format!("stopped by a fault {f}\n"));
        format!(
            "\n{}: {} degrees of freedom, {ticks} ticks\n{}\n{}{fault}{}",
            program.title,
            self.problem.n,
            table(&header, 1, lines),
            table(
                &["level", "rows", "equalities", "at a bound", "most", "violated", "most", "least freedom"],
                1,
                self.level_rows(ticks)
            ),
            remark(),
        )
    }

    fn level_rows(&self, ticks: usize) -> Vec<Vec<String>> {
        let mean = |sum: usize| format!("{:.1}", sum as f64 / ticks.max(1) as f64);
        let row = |(l, c): (usize, &LevelCount)| {
            let name = self.controller.level_names().get(l).map_or("", String::as_str);
            let hard = if self.problem.levels[l].hard { " (hard)" } else { "" };
            let freedom = if ticks > 0 { c.freedom.to_string() } else { String::new() };
            vec![
                format!("{name}{hard}"),
                self.problem.levels[l].rows().to_string(),
                c.equalities.to_string(),
                mean(c.bound.0),
                c.bound.1.to_string(),
                mean(c.violated.0),
                c.violated.1.to_string(),
                freedom,
            ]
        };
        self.levels.iter().enumerate().map(row).collect()
    }
}

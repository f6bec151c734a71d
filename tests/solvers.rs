//! The solver on real problems: ticks of every example satisfy the certificate and agree with the reference cascade;
//! random walks through the robots' configurations never fail.

use crate::common;

use robot::random::SplitMix64;
use runtime::program::Times;
use runtime::record::verify::Verifier;
use runtime::{Evaluator, Program, Recorder, RestInputs, Simulation, Tick};
use solver::{Active, ActiveSet, HierarchicalSolver, Solution, Status, certificate};

/// Passes on one of `one_in` ticks.
struct OneIn<'a> {
    one_in: usize,
    to: &'a mut dyn Recorder,
}

impl Recorder for OneIn<'_> {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        if tick.index.is_multiple_of(self.one_in) { self.to.tick(tick) } else { Ok(()) }
    }
}

/// Every 11th tick of every example and of its scenarios; `hierarq run --verify` checks all of them.
#[test]
fn examples_are_certified_and_agree_with_the_reference() {
    for name in common::EXAMPLES {
        let program = common::program(&format!("{name}.hq"));
        let mut runs = vec![(program.clone(), None)];
        runs.extend(program.scenarios.iter().map(|s| (s.program(&program), Some(s.clone()))));
        let mut ticks = 0;
        for (program, scenario) in runs {
            let simulation = match &scenario {
                Some(scenario) => Simulation::in_world(&program, scenario),
                None => Simulation::new(&program),
            };
            let mut simulation = simulation.expect("it can be executed");
            let mut verifier = Verifier::new(&program, simulation.controller());
            let mut some = OneIn { one_in: 11, to: &mut verifier };
            simulation.run(&mut some, &mut || 0.0, &mut |_| true).expect("nothing is written");
            let v = verifier.result();
            ticks += v.ticks;
            assert!(v.failed == 0, "{name}: {v:?}");
            assert!(v.max_difference < 1e-9 && v.max_certificate < 1e-10, "{name}: {v:?}");
        }
        assert!(ticks > 80, "{name}: {ticks} ticks");
    }
}

/// Counts changes of the working set, and rows whose state changed between two ticks.
struct Changes {
    solver: ActiveSet,
    solution: Solution,
    before: Vec<Active>,
    /// Ticks, rows and changes, by the number of rows: none, 1 to 8, more.
    counts: [[u64; 3]; 3],
    most: u64,
}

impl Recorder for Changes {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let done = self.solver.effort().changes;
        self.solver.solve(tick.problem, &mut self.solution);
        assert_eq!(self.solution.status, Status::Optimal);
        let made = self.solver.effort().changes - done;
        let states: Vec<Active> = self.solution.levels.iter().flat_map(|l| l.active.iter().copied()).collect();
        let rows = states.iter().zip(&self.before).filter(|(a, b)| a != b).count() as u64;
        if !self.before.is_empty() {
            let count = &mut self.counts[if rows == 0 {
                0
            } else if rows <= 8 {
                1
            } else {
                2
            }];
            (count[0], count[1], count[2]) = (count[0] + 1, count[1] + rows, count[2] + made);
            self.most = self.most.max(made);
        }
        self.before = states;
        Ok(())
    }
}

/// A tick in which few rows change their state needs few changes of the working set: hands that swap sides, targets
/// that exclude each other, a base held by walls, limits on all sides, a target that leaves the reach.
#[test]
fn few_rows_take_few_changes() {
    for name in ["hard/swapping_hands", "hard/two_wishes", "hard/held_base", "hard/out_of_reach", "safety_tasks"] {
        let mut program = common::program(&format!("{name}.hq"));
        program.run.duration = 8.0;
        let mut simulation = Simulation::new(&program).expect("it can be executed");
        let (_, problem) = Evaluator::new(&program, program.first_stack().expect("it runs a stack")).expect("a stack");
        let mut changes = Changes {
            solver: ActiveSet::new(&problem),
            solution: Solution::new(&problem),
            before: Vec::new(),
            counts: [[0; 3]; 3],
            most: 0,
        };
        simulation.run(&mut changes, &mut || 0.0, &mut |_| true).expect("nothing is written");
        let [[calm, _, idle], [_, rows, made], _] = changes.counts;
        assert!(50 * idle <= calm, "{name}: {idle} changes in {calm} ticks in which no row changed");
        assert!(rows > 10 && made <= 4 * rows, "{name}: {made} changes for {rows} rows");
        assert!(changes.most <= 80, "{name}: {} changes in one tick", changes.most);
    }
}

/// Configurations move through the whole range of the joints, also where the hierarchy would never let them: past
/// walls, into collisions, along singularities. Every tick must have a solution (or name the infeasible hard level);
/// one in 200 is checked by the certificate.
fn walk(program: &Program, ticks: usize, seed: u64) {
    let (mut evaluator, mut problem) =
        Evaluator::new(program, program.first_stack().expect("it runs a stack")).expect("it can be executed");
    let rest = RestInputs::new(program);
    let model = &program.robot.model;
    let mut solver = ActiveSet::new(&problem);
    let mut solution = Solution::new(&problem);
    let mut dice = SplitMix64(seed);
    let mut q = program.robot.home.clone();
    let mut v = vec![0.0; model.nv()];
    evaluator.enter(&q, rest.at(Times::default()));
    for k in 0..ticks {
        for (v, dof) in v.iter_mut().zip(&model.dofs) {
            let limit = if dof.velocity.is_finite() { dof.velocity } else { 1.0 };
            *v = 0.98 * *v + 0.2 * limit * (2.0 * dice.unit() - 1.0);
        }
        model.integrate(&mut q, &v, program.robot.period);
        for dof in &model.dofs {
            if let Some(at) = dof.q_index.filter(|_| dof.lower.is_finite() && dof.upper.is_finite()) {
                q[at] = q[at].clamp(dof.lower, dof.upper);
            }
        }
        let t = (k % 5000) as f64 * program.robot.period;
        if evaluator.update(&q, rest.at(Times { t, time: t }), &mut problem).is_err() {
            // Bodies overlap too deeply to have a direction: no problem to solve.
            q.copy_from_slice(&program.robot.home);
            continue;
        }
        solver.solve(&problem, &mut solution);
        match solution.status {
            Status::Optimal if k % 200 == 0 => {
                let residual = certificate(&problem, &solution.x);
                assert!(residual < 1e-8, "{}, tick {k}: {residual:e}", program.name);
            }
            Status::Optimal | Status::Infeasible { .. } => {}
            status => panic!("{}, tick {k}: {status:?}", program.name),
        }
    }
    assert_eq!(solver.effort().failures, 0, "{}", program.name);
}

/// 100,000 ticks; `HIERARQ_WALK_TICKS` overrides the number.
#[test]
fn random_walks_never_fail() {
    let ticks = std::env::var("HIERARQ_WALK_TICKS").ok().and_then(|t| t.parse().ok()).unwrap_or(100_000_usize);
    let walks = ["safety_tasks", "uncooperative_motion", "cooperative_motion", "swivel_angle"];
    for (seed, name) in walks.into_iter().enumerate() {
        walk(&common::program(&format!("{name}.hq")), ticks / walks.len(), seed as u64);
    }
}

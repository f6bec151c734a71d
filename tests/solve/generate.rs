//! Generates the ticks of the example file: the closed loop of a small arm, once free and once restricted by a wall,
//! and a few random hierarchies with all features of the format. The answers are those of the reference cascade, by
//! Clarabel.

use robot::random::SplitMix64;
use runtime::{Controller, Observation, SimulatedRobot};
use serde_json::{Value, json};
use solver::{ClarabelCascade, HierarchicalSolver, LevelShape, Problem, Solution, Status};

use crate::common;

/// `id`, `kind`, problem.
pub type Named = (String, &'static str, Problem);

/// Returns twenty ticks.
pub fn ticks() -> Vec<Named> {
    let mut all = closed_loop("free", "reach", 8, 40);
    all.extend(closed_loop("held", "held-back", 8, 104));
    all.extend((0..4).map(|seed| (format!("random-{seed}"), "random", random(&mut Dice(SplitMix64(seed))))));
    all
}

/// Returns `count` consecutive ticks of an arm from tick `from` on. It moves towards a wall, which it reaches after a
/// second.
fn closed_loop(name: &str, kind: &'static str, count: usize, from: usize) -> Vec<Named> {
    let program = common::program_of(
        "hierarq 1
         robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  points { tip tool }  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
         stack s {
           level limits hard { joint_position_limits  joint_velocity_limits }
           level wall { virtual_wall(tip) { through [[0, 0.1, 0], [1, 0.1, 0], [0, 0.1, 1]] m } }
           level motion { frame_position(tool) { position initial(position) + [0, 0.2, 0.1] m * sin(pi*t/(4 s)) } }
           level posture { joint_position { target { joint_4 1.5 rad  joint_6 1.2 rad } } }
         }
         run { duration 2 s }",
    );
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    let mut ticks = Vec::new();
    for index in 0..from + count {
        let q = robot.measure().to_vec();
        let command = controller.step(&Observation { time: index as f64 * program.robot.period, q: &q });
        assert_eq!(command.fault, None);
        robot.apply(command.velocity);
        if index >= from {
            ticks.push((format!("{name}-{index}"), kind, controller.problem().clone()));
        }
    }
    ticks
}

/// Random choices.
pub struct Dice(pub SplitMix64);

impl Dice {
    pub fn next(&mut self) -> u64 {
        self.0.bits()
    }

    /// Returns a random integer in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// Returns a random multiple of 0.01 in [-1, 1].
    fn number(&mut self) -> f64 {
        (self.below(201) as f64 - 100.0) / 100.0
    }
}

/// Six variables in a box, then weighted rows that contradict each other; randomly damped, or with a reference.
fn random(dice: &mut Dice) -> Problem {
    let n = 6;
    let damping = if dice.below(2) == 0 { 0.0 } else { 0.01 };
    let shape = |rows, hard, damping| LevelShape { rows, hard, damping };
    let mut problem = Problem::new(n, &[shape(n, true, 0.0), shape(5, false, 0.0), shape(4, false, damping)]);
    for i in 0..n {
        problem.levels[0].row_mut(i)[i] = 1.0;
        (problem.levels[0].lower[i], problem.levels[0].upper[i]) = (-1.0, 1.0);
    }
    for level in &mut problem.levels[1..] {
        for i in 0..level.rows() {
            let row: Vec<f64> = (0..n).map(|_| dice.number()).collect();
            let center = 2.0 * dice.number();
            let (lower, upper) = match dice.below(3) {
                0 => (center, center),
                1 => (center, f64::INFINITY),
                _ => (f64::NEG_INFINITY, center),
            };
            level.set(i, &row, lower, upper);
            level.weight[i] = 1.0 + dice.below(4) as f64;
        }
    }
    problem.reference.iter_mut().for_each(|r| *r = dice.number());
    problem
}

/// Returns the optimum, by the second method of the reference: Clarabel first, then the proof.
pub fn optimum(problem: &Problem) -> Vec<f64> {
    let mut solution = Solution::new(problem);
    ClarabelCascade::new(problem).with_search_first(false).solve(problem, &mut solution);
    assert_eq!(solution.status, Status::Optimal);
    solution.x
}

/// Computes for each level the norm of the distances of its rows from their intervals, independently.
pub fn violations(problem: &Problem, x: &[f64]) -> Vec<f64> {
    let mut all = Vec::new();
    for level in &problem.levels {
        let mut square = 0.0;
        for i in 0..level.rows() {
            let value: f64 = (0..problem.n).map(|j| level.entry(i, j) * x[j]).sum();
            let distance = (level.lower[i] - value).max(value - level.upper[i]).max(0.0);
            square += distance * distance;
        }
        all.push(square.sqrt());
    }
    all
}

/// Returns a tick as a line of a file.
pub fn line((id, kind, problem): &Named) -> String {
    let x = optimum(problem);
    let bound = |x: &f64| if x.is_finite() { json!(x) } else { Value::Null };
    let levels = problem.levels.iter().map(|level| {
        let rows: Vec<&[f64]> = (0..level.rows()).map(|i| level.row(i)).collect();
        let unit = |i: usize| (0..problem.n).map(|j| f64::from(u8::from(i % problem.n == j))).collect::<Vec<_>>();
        let identities = rows.len().is_multiple_of(problem.n) && rows.iter().enumerate().all(|(i, r)| *r == unit(i));
        let mut data = json!({
            "A": if identities { json!({ "identity": rows.len() / problem.n }) } else { json!(rows) },
            "lo": level.lower.iter().map(bound).collect::<Vec<_>>(),
            "up": level.upper.iter().map(bound).collect::<Vec<_>>(),
        });
        if level.hard {
            data["hard"] = json!(true);
        }
        if level.damping > 0.0 {
            data["damping"] = json!(level.damping);
        }
        if level.weight.iter().any(|w| *w != 1.0) {
            data["weight"] = json!(level.weight);
        }
        data
    });
    let mut data = json!({
        "id": id, "kind": kind, "n": problem.n, "levels": levels.collect::<Vec<_>>(),
        "x": x, "viol": violations(problem, &x),
    });
    if problem.reference.iter().any(|r| *r != 0.0) {
        data["reference"] = json!(problem.reference);
    }
    data.to_string()
}

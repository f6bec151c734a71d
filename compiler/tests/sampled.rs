//! The checks at random postures against other random postures that this test draws: shares of the postures inside limits, of
//! those at which a hard level cannot be met (by Clarabel), of those at which links touch (by the margins of a limit), and
//! ranks of targets (by their singular values).

use crate::common;

use common::{annotated, compile_text, compile_text_deep, examples, whole};
use dsl::Syntax;
use hierarq_compiler::{Compiled, Sampled};
use robot::random::units;
use runtime::program::{Program, Times};
use runtime::{Evaluator, RestInputs};
use solver::{Backend, Problem, Solution, Status};

const POSTURES: usize = 2000;

/// Number of postures where codes matter, and not shares.
const FEW: usize = 300;

/// A wall that pushes the arm away near it, which limits of accelerations forbid.
const PUSHED: &str =
    "task table = virtual_wall(gripper) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m  sampled_margin auto }
task led = frame_position(tool) { position initial(position) + [0, 0, 0.1] m * sin(2*pi*t/(20 s)) }
stack s {
  level limits hard { joint_position_limits  joint_velocity_limits  table  joint_acceleration_limits }
  level motion { led }
  level rest { joint_position { target { all 0.3 rad } } }
}
run { stack s  duration 10 s }
";

fn text(body: &str) -> String {
    whole(body, Syntax::Native, true, false)
}

fn deep(body: &str, seed: u64) -> Compiled {
    compile_text_deep(&text(body), Syntax::Native, &examples(), FEW, seed)
}

fn sampled(body: &str, postures: usize) -> Sampled {
    let compiled = compile_text_deep(&text(body), Syntax::Native, &examples(), postures, 5);
    assert!(compiled.sampled.is_some(), "{}", annotated(&compiled));
    compiled.sampled.unwrap_or_default()
}

fn program(body: &str) -> Program {
    compile_text(&text(body), Syntax::Native, &examples(), &[]).program.expect("a program")
}

/// Evaluates the first stack at random postures, which no check has drawn.
fn at_random(program: &Program, mut look: impl FnMut(&Evaluator, &Problem)) {
    let (mut evaluator, mut problem) = Evaluator::new(program, 0).expect("a stack");
    let rest = RestInputs::new(program);
    let mut unit = units(20_261_127);
    for _ in 0..POSTURES {
        let q = program.robot.model.random_configuration(&mut unit);
        evaluator.enter(&q, rest.at(Times::default()));
        evaluator.update(&q, rest.at(Times::default()), &mut problem).expect("rows");
        look(&evaluator, &problem);
    }
}

/// Some of a number of postures.
#[derive(Clone, Copy)]
struct Share {
    part: usize,
    of: usize,
}

fn share(part: usize, of: usize) -> Share {
    Share { part, of }
}

/// Asserts that two shares are the same up to four standard deviations of their difference.
fn alike(what: &str, a: Share, b: Share) {
    let (x, y) = (a.part as f64 / a.of as f64, b.part as f64 / b.of as f64);
    let p = (a.part + b.part) as f64 / (a.of + b.of) as f64;
    let deviation = (p * (1.0 - p) * (1.0 / a.of as f64 + 1.0 / b.of as f64)).sqrt();
    assert!((x - y).abs() <= 4.0 * deviation, "{what}: {x} and {y}");
}

#[test]
fn hard_levels_cannot_be_met_as_often_as_clarabel_says() {
    let program = program(PUSHED);
    let (mut inside, mut infeasible) = (0, 0);
    at_random(&program, |evaluator, problem| {
        if evaluator.margins().iter().any(|h| *h < 0.0) {
            return;
        }
        inside += 1;
        let hard = Problem { levels: problem.levels[..1].to_vec(), ..problem.clone() };
        let mut solution = Solution::new(&hard);
        Backend::Clarabel.solver(&hard).solve(&hard, &mut solution);
        infeasible += usize::from(solution.status == Status::Infeasible { level: 0 });
    });
    let found = &sampled(PUSHED, POSTURES).stacks[0];
    assert!(infeasible > 20, "{infeasible} postures");
    alike("inside", share(found.inside, POSTURES), share(inside, POSTURES));
    alike("infeasible", share(found.infeasible, found.inside), share(infeasible, inside));
}

#[test]
fn the_freedom_of_a_level_is_what_the_targets_above_leave() {
    let program = program(PUSHED);
    let mut counts = std::collections::BTreeMap::new();
    at_random(&program, |_, problem| {
        let level = &problem.levels[1];
        let rows = nalgebra::DMatrix::from_fn(level.rows(), problem.n, |i, j| level.row(i)[j]);
        *counts.entry(problem.n - rows.rank(1e-6)).or_insert(0) += 1;
    });
    let found = &sampled(PUSHED, POSTURES).stacks[0];
    let levels: Vec<&str> = found.freedom.iter().map(|f| f.level.as_str()).collect();
    assert_eq!(levels, ["limits", "motion", "rest"]);
    for level in &found.freedom[..2] {
        assert_eq!(level.quantile(0.0), Some(7), "no target is above");
    }
    let usual = counts.iter().max_by_key(|(_, n)| **n).map(|(freedom, _)| *freedom);
    assert_eq!(found.freedom[2].quantile(0.5), usual);
    assert_eq!(usual, Some(4), "a position takes three of seven");
}

#[test]
fn pairs_touch_as_often_as_their_margins_say() {
    let apart = "task apart = self_collision { between link_2  and link_5  d_min 0 m }\n";
    let stack = |limits: &str| {
        format!(
            "task led = hold(tool)\n{apart}stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits  {limits} }}  level motion {{ led }} }}\nrun {{ stack s  duration 1 s }}\n"
        )
    };
    let (mut touching, mut all) = (0, 0);
    let guarded = program(&stack("apart"));
    let place = guarded.stacks[0].levels[0].members.len() - 1;
    at_random(&guarded, |evaluator, _| {
        let m = &evaluator.members()[place];
        touching += usize::from(evaluator.margins()[m.margins.clone()].iter().any(|h| *h <= 0.0));
        all += 1;
    });
    assert!(touching > 50, "{touching} postures");
    let compiled = deep(&stack("").replace(apart, ""), 1);
    let warning = compiled.report.diagnostics.iter().find(|d| d.code == "HQ0591").expect("a warning");
    let note = warning.notes.join(" ");
    let percent = note.split("`link_2` and `link_5` (").nth(1).and_then(|rest| rest.split(" %").next());
    let percent: f64 = percent.expect("the pair in the note").parse().expect("a number");
    alike("touching", share((percent * FEW as f64 / 100.0).round() as usize, FEW), share(touching, all));
    let kept = deep(&stack("apart"), 1);
    let with_guard = kept.sampled.and_then(|s| s.contacts).map(|c| c.unguarded);
    let without = compiled.sampled.and_then(|s| s.contacts).map(|c| c.unguarded);
    assert_eq!(with_guard.map(|n| n + 1), without, "one pair less");
}

#[test]
fn the_same_seed_gives_the_same_findings() {
    let [a, b, other] = [3, 3, 4].map(|seed| deep(PUSHED, seed));
    assert_eq!(a.sampled, b.sampled);
    let told =
        |c: &Compiled| c.report.diagnostics.iter().map(|d| format!("{} {}", d.code, d.message)).collect::<Vec<_>>();
    assert_eq!(told(&a), told(&b));
    assert_ne!(a.sampled.map(|s| s.stacks), other.sampled.map(|s| s.stacks));
}

#[test]
fn an_allowance_of_a_finding_is_not_idle_without_the_postures() {
    let body = PUSHED.replace("stack s {", "stack s {\n  allow HQ0591 \"the arm is led far away from itself\"");
    let codes = |c: &Compiled| c.report.diagnostics.iter().map(|d| d.code).collect::<Vec<_>>();
    assert_eq!(codes(&compile_text(&text(&body), Syntax::Native, &examples(), &[])), [""; 0]);
    assert_eq!(codes(&deep(&body, 1)), ["HQ0590"]);
}

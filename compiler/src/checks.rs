//! Checks that look at the finished program: gains against the period, the start against the limits, freedom left.

use dsl::{Diagnostic, Span};
use runtime::program::{Program, Times};
use runtime::{Controller, Evaluator, Observation, build_tasks};
use solver::{Active, Status};
use stdlib_tasks::task::{BuildError, Nature};

use crate::lowering::Places;

/// Checks a program that has no errors so far.
pub(crate) fn program(program: &Program, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    let before = diagnostics.len();
    let mut reported: Vec<(usize, String)> = Vec::new();
    for (i, stack) in program.stacks.iter().enumerate() {
        let model = &program.robot.model;
        let built = build_tasks(model, program.robot.period, &program.values.initial, &program.tasks, stack);
        let members = stack.levels.iter().flat_map(|l| &l.members);
        let mut complete = true;
        for (task, m) in built.iter().zip(members) {
            match task {
                Ok(task) => {
                    for gain in task.gains(&program.values.initial) {
                        let once = (m.task, "gain".to_string());
                        if gain * program.robot.period > 1.0 + 1e-12 && !reported.contains(&once) {
                            reported.push(once);
                            diagnostics.push(overshoot(gain, program.robot.period, places, m.task));
                        }
                    }
                }
                Err(e) => {
                    complete = false;
                    let once = (m.task, e.param.clone());
                    if !reported.contains(&once) {
                        reported.push(once);
                        diagnostics.push(cannot_build(e, places, m.task));
                    }
                }
            }
        }
        if complete && diagnostics[before..].iter().all(|d| d.severity == dsl::Severity::Warning) {
            start(program, i, places, diagnostics);
        }
    }
}

fn place(places: &Places, task: usize, param: &str) -> Span {
    let t = &places.tasks[task];
    t.spans.get(param).copied().unwrap_or(t.span)
}

fn overshoot(gain: f64, period: f64, places: &Places, task: usize) -> Diagnostic {
    let limit = places.tasks[task].kind.nature == Nature::Limit;
    let why = if limit {
        "a barrier function is broken by a single step"
    } else {
        "the error changes its sign at every tick, and grows above 2"
    };
    Diagnostic::error(
        "HQ0501",
        place(places, task, "gain"),
        format!("this gain overshoots: {gain} /s times {period} s is {:.3}, more than 1", gain * period),
    )
    .here(format!("gain × period = {:.3}", gain * period))
    .label(places.rate, format!("a period of {period} s"))
    .note(why)
    .help(format!("keep the gain at or below {} /s, or raise the rate", 1.0 / period))
}

fn cannot_build(e: &BuildError, places: &Places, task: usize) -> Diagnostic {
    let d = Diagnostic::error("HQ0503", place(places, task, &e.param), e.message.clone());
    match &e.help {
        Some(h) => d.help(h.clone()),
        None => d,
    }
}

/// Evaluates a stack at the home configuration.
fn start(program: &Program, stack: usize, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    let mut at_stack = program.clone();
    at_stack.run.stack = stack;
    let Ok((mut evaluator, mut problem)) = Evaluator::new(&at_stack, stack) else { return };
    evaluator.enter(&program.robot.home, Times::default());
    if let Err(fault) = evaluator.update(&program.robot.home, Times::default(), &mut problem) {
        let text = Controller::new(&at_stack).map(|mut c| {
            c.step(&Observation { time: 0.0, q: &program.robot.home });
            c.describe(&fault)
        });
        let text = text.unwrap_or_else(|e| e.to_string());
        diagnostics.push(
            Diagnostic::error("HQ0502", places.home, format!("at home, {text}")).help("move the home configuration"),
        );
        return;
    }
    let mut outside = false;
    for m in evaluator.members() {
        let rows = m.row_info.iter().zip(&evaluator.margins()[m.margins.clone()]);
        // Margins of velocities exist only once a velocity was chosen: they are infinite here.
        let bad: Vec<String> =
            rows.filter(|(_, h)| **h < 0.0).map(|(r, h)| format!("{} by {:.4} {}", r.name, -h, r.dimension)).collect();
        if let Some(first) = bad.first() {
            outside = true;
            let more = if bad.len() > 1 { format!(" and {} more", bad.len() - 1) } else { String::new() };
            diagnostics.push(
                Diagnostic::error(
                    "HQ0502",
                    place(places, m.program_index, "d_min"),
                    format!("`{}` is violated at the start: {first}{more}", m.name),
                )
                .label(places.home, "the robot starts here")
                .note(format!(
                    "a barrier function keeps a limit only from inside it; violated are {}",
                    bad.iter().take(8).cloned().collect::<Vec<_>>().join(", ")
                ))
                .help("move the home configuration or the limit"),
            );
        }
    }
    if !outside {
        first_tick(&at_stack, stack, places, diagnostics);
    }
}

fn first_tick(program: &Program, stack: usize, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    let Ok(mut controller) = Controller::new(program) else { return };
    let fault = controller.step(&Observation { time: 0.0, q: &program.robot.home }).fault;
    let levels = &places.stacks[stack].1;
    if let Status::Infeasible { level } = controller.solution().status {
        let text = fault.map(|f| controller.describe(&f)).unwrap_or_default();
        diagnostics.push(
            Diagnostic::error("HQ0504", levels[level], format!("at home, {text}"))
                .label(places.home, "the robot starts here")
                .note("a hard level takes no slack, so the first tick would be a fault")
                .help("relax the level, or remove `hard`"),
        );
        return;
    }
    for (k, level) in program.stacks[stack].levels.iter().enumerate().skip(1) {
        let targets = level.members.iter().any(|m| places.tasks[m.task].kind.nature == Nature::Target);
        let above = &controller.solution().levels[k - 1];
        if targets && above.freedom == 0 && controller.solution().levels[k].active.iter().any(|a| *a != Active::Free) {
            diagnostics.push(
                Diagnostic::warning("HQ0604", levels[k], format!("level `{}` has no freedom left at home", level.name))
                    .label(levels[k - 1], "this level and those above it fix every degree of freedom")
                    .help("ask less of the levels above, or unlock joints"),
            );
        }
    }
}

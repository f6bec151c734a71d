//! Where scenarios start: whether the robot then stands inside the hard limits of the first stack, with people where they
//! truly are.

use dsl::{Diagnostic, Span};
use runtime::program::{Program, ScenarioProgram, Subject, Times};
use runtime::record::summary::MARGIN_TOLERANCE;
use runtime::world::World;
use runtime::{Evaluator, Moment};

use crate::units::shown;

/// Warns of scenarios that start outside. `places` has the place of each: of its start, or of its name.
pub(crate) fn check(program: &Program, places: &[Span], diagnostics: &mut Vec<Diagnostic>) {
    for (scenario, at) in program.scenarios.iter().zip(places) {
        diagnostics.extend(outside(program, scenario, *at));
    }
}

/// The stack that runs first.
fn first_stack(program: &Program, scenario: &ScenarioProgram) -> Option<usize> {
    match scenario.run.subject {
        Subject::Stack(stack) => Some(stack),
        Subject::Machine => program.machine.as_ref().and_then(|m| m.stack(m.leaf(0))),
    }
}

fn outside(program: &Program, scenario: &ScenarioProgram, at: Span) -> Option<Diagnostic> {
    let stack = first_stack(program, scenario)?;
    let (mut evaluator, mut problem) = Evaluator::new(program, stack).ok()?;
    let moved = scenario.start != program.robot.home;
    // Home was looked at already, as far as nobody has to be asked.
    if !moved && evaluator.needs().is_empty() {
        return None;
    }
    let mut signals = program.interface.absent();
    World::new(program, scenario).truth(0.0, &mut signals);
    let known = |s: &usize| program.interface.signals.get(*s).is_some_and(|s| signals[s.known_at()] > 0.0);
    if !evaluator.needs().iter().all(known) {
        return None;
    }
    let velocity = vec![0.0; program.robot.model.nv()];
    let moment = Moment { times: Times::default(), signals: &signals, velocity: &velocity };
    evaluator.enter(&scenario.start, moment);
    evaluator.update(&scenario.start, moment, &mut problem).ok()?;
    let hard = program.stacks[stack].levels.iter().flat_map(|l| l.members.iter().map(|_| l.hard));
    for (m, _) in evaluator.members().iter().zip(hard).filter(|(_, hard)| *hard) {
        let rows = m.row_info.iter().zip(&evaluator.margins()[m.margins.clone()]);
        let bad: Vec<(&str, String)> = rows
            .filter(|(_, h)| **h < -MARGIN_TOLERANCE)
            .map(|(r, h)| (r.name.as_str(), shown(format!("{:.2e}", -h).parse().unwrap_or(-h), r.dimension)))
            .collect();
        let Some((row, by)) = bad.first() else { continue };
        let more = if bad.len() > 1 { format!(", and {} more", bad.len() - 1) } else { String::new() };
        let text = format!("scenario `{}` starts outside `{}`: {row} by {by}{more}", scenario.name, m.name);
        return Some(
            Diagnostic::warning("HQ0806", at, text)
                .note("a barrier function keeps a limit only from inside it; from outside, the robot first has to come back")
                .help(match moved {
                    true => "move the start, or who stands there at the beginning",
                    false => "let people begin further away, or give the robot another `start`",
                }),
        );
    }
    None
}

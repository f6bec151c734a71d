//! Lowers `run` blocks, and selects the stack or machine to run.

use dsl::tree::{Block, Entry, Run};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned, Topic};
use names::{list, suggest};
use runtime::program::{RunProgram, Simulator, Subject};
use solver::Backend;
use stdlib_tasks::dimension::{ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Dimension, NONE, TIME};

use super::Lowerer;
use super::declared::Declared;
use crate::diagnostics::examples;
use crate::expr::constants::Constants;
use crate::forms::{block_of, check_keys, text_of};
use crate::robot_binding::BoundRobot;
use crate::sections::{RUN, SIMULATOR};
use crate::units;

/// Settings of a `run` block.
#[derive(Debug, Default)]
pub(super) struct RunSettings {
    stack: Option<Spanned<String>>,
    machine: Option<Spanned<String>>,
    duration: Option<f64>,
    duration_span: Option<Span>,
    title: Option<String>,
    simulator: Simulator,
    solver: Backend,
    tick_budget: Option<Spanned<f64>>,
    span: Option<Span>,
}

pub(super) fn run_settings(
    run: &Run,
    span: Span,
    constants: &mut Constants,
    diagnostics: &mut Vec<Diagnostic>,
) -> RunSettings {
    check_keys(&run.body, &RUN, diagnostics);
    let mut settings = RunSettings { span: Some(span), ..RunSettings::default() };
    for e in &run.body.entries {
        match e.key.value.as_str() {
            "stack" => match text_of(&e.value) {
                Some(name) => settings.stack = Some(Spanned::new(name.to_string(), e.value.span)),
                None => diagnostics.push(
                    Diagnostic::error("HQ0304", e.value.span, "`stack` is the name of a stack")
                        .help("write the name of the stack as declared"),
                ),
            },
            "machine" => match text_of(&e.value) {
                Some(name) => settings.machine = Some(Spanned::new(name.to_string(), e.value.span)),
                None => diagnostics.push(
                    Diagnostic::error("HQ0304", e.value.span, "`machine` is the name of a machine")
                        .help("write the name of the machine as declared"),
                ),
            },
            "duration" => {
                settings.duration = constants.scalar(&e.value, TIME, diagnostics);
                settings.duration_span = Some(e.value.span);
                if let Some(d) = settings.duration.filter(|d| *d <= 0.0) {
                    let text = format!("the duration of a run must be more than 0 s, and this is {d} s");
                    diagnostics.push(
                        Diagnostic::error("HQ0308", e.value.span, text)
                            .help(Help::write_for_instance(Snippet::entry("duration", "10 s"))),
                    );
                }
            }
            "tick_budget" => {
                let budget = constants.scalar(&e.value, TIME, diagnostics);
                if budget.is_some_and(|b| b <= 0.0) {
                    let d = Diagnostic::error("HQ0308", e.value.span, "the budget of a tick must be more than 0 s");
                    diagnostics.push(d.help(Help::with(
                        "write for instance {}, or leave it out for any time",
                        [Snippet::entry("tick_budget", "200 us")],
                    )));
                }
                settings.tick_budget = budget.map(|b| Spanned::new(b, e.value.span));
            }
            "title" => match text_of(&e.value) {
                Some(text) => settings.title = Some(text.to_string()),
                None => diagnostics.push(
                    Diagnostic::error("HQ0304", e.value.span, "a title is a text")
                        .help(Help::each("write it in quotes", "write it as a text")),
                ),
            },
            "solver" => match text_of(&e.value).and_then(Backend::from_name) {
                Some(backend) => settings.solver = backend,
                None => {
                    let names: Vec<&str> = Backend::ALL.iter().map(|b| b.name()).collect();
                    diagnostics.push(
                        Diagnostic::error("HQ0304", e.value.span, "this is not the name of a solver")
                            .help(format!("solvers are {}", list(names.iter().copied(), 8))),
                    );
                }
            },
            "simulator" => {
                if let Some(b) = block_of(&e.value, "`simulator`", diagnostics) {
                    settings.simulator = simulator(b, constants, diagnostics);
                }
            }
            _ => {}
        }
    }
    settings
}

fn simulator(block: &Block, constants: &mut Constants, diagnostics: &mut Vec<Diagnostic>) -> Simulator {
    check_keys(block, &SIMULATOR, diagnostics);
    let mut s = Simulator::default();
    for e in &block.entries {
        let wanted = match e.key.value.as_str() {
            "speed" => {
                s.speed = limit_of_actuators(e, ANGULAR_VELOCITY, constants, diagnostics);
                continue;
            }
            "acceleration" => {
                s.acceleration = limit_of_actuators(e, ANGULAR_ACCELERATION, constants, diagnostics);
                continue;
            }
            "lag" => TIME,
            "noise" => ANGLE,
            "seed" => NONE,
            _ => continue,
        };
        let Some(x) = constants.scalar(&e.value, wanted, diagnostics) else { continue };
        if x < 0.0 || (e.key.value == "seed" && (x.fract() != 0.0 || x > 9e15)) {
            let wanted = if e.key.value == "seed" { "a whole number from 0" } else { "zero or more" };
            let text = format!("`{}` is {wanted}, and this is {x}", e.key.value);
            diagnostics
                .push(Diagnostic::error("HQ0308", e.value.span, text).help(format!("write {wanted}, or leave it out")));
            continue;
        }
        // Larger values exceed those of any robot with a velocity controller.
        let (usual, help) = match e.key.value.as_str() {
            "lag" => (1.0, "actuators lag by 1 ms to 200 ms; write `ms` after the number if milliseconds are meant"),
            "noise" => {
                (0.1, "encoders err by 1e-6 rad to 1e-3 rad; this is the standard deviation of every measured position")
            }
            _ => (f64::INFINITY, ""),
        };
        if x > usual {
            let text = format!("a {} of {} is implausible", e.key.value, units::shown(x, wanted));
            let d = Diagnostic::warning("HQ0522", e.value.span, text)
                .here(format!("above {}", units::shown(usual, wanted)));
            diagnostics.push(d.help(help));
        }
        match e.key.value.as_str() {
            "lag" => s.lag = x,
            "noise" => s.noise = x,
            _ => s.seed = x as u64,
        }
    }
    s
}

/// Positive limit of an actuator.
pub(super) fn limit_of_actuators(
    e: &Entry,
    wanted: Dimension,
    constants: &mut Constants,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<f64> {
    let x = constants.scalar(&e.value, wanted, diagnostics)?;
    if x > 0.0 && x.is_finite() {
        return Some(x);
    }
    let text = format!("`{}` is above zero, and this is {}", e.key.value, units::shown(x, wanted));
    let d = Diagnostic::error("HQ0308", e.value.span, text);
    diagnostics.push(d.help("write what the actuators can do, or leave it out for any"));
    None
}

impl Lowerer<'_> {
    pub(super) fn run(
        &mut self,
        run: Option<RunSettings>,
        declared: &Declared,
        robot: Option<&BoundRobot>,
    ) -> Option<(RunProgram, String)> {
        let stacks = &declared.stacks;
        let settings = run.unwrap_or_default();
        self.machine_of(&settings, declared)?;
        let stack = match &settings.stack {
            None if declared.machine.is_some() => 0,
            Some(name) => match stacks.iter().position(|s| s.name.value == name.value) {
                Some(i) => i,
                None if declared.patterns.contains_key(&name.value) => {
                    let text = format!("stack `{}` has parameters, and no arguments are given", name.value);
                    let d = Diagnostic::error("HQ0214", name.span, text);
                    let d = d.label(declared.patterns[&name.value], "declared here");
                    let help = Help::with(
                        "make a stack from it, {}, and run that one",
                        [Snippet::each(
                            format!("stack NAME from {}(..) {{ }}", name.value),
                            format!("stacks: {{ NAME: {{ from: {}(..) }} }}", name.value),
                        )],
                    );
                    self.push(d.help(help));
                    return None;
                }
                // The stack may be one that failed to expand.
                None if stacks.is_empty() && !declared.whole => return None,
                None => {
                    let names = stacks.iter().map(|s| s.name.value.as_str());
                    let d = Diagnostic::unknown_name(name.span, format!("there is no stack `{}`", name.value));
                    let d = match suggest(&name.value, names.clone()) {
                        Some(near) => d.meant(near),
                        None => d.help(format!("declared are {}", list(names, 8))),
                    };
                    self.push(d);
                    return None;
                }
            },
            None if stacks.len() == 1 => 0,
            None if stacks.is_empty() => return None,
            None => {
                let at = settings.span.unwrap_or(stacks[1].name.span);
                self.push(
                    Diagnostic::error("HQ0603", at, "several stacks, and no `run` selects one")
                        .about(Topic::MissingDeclaration)
                        .help(Snippet::block(
                            "run",
                            [
                                Snippet::entry("stack", stacks[0].name.value.as_str()),
                                Snippet::entry("duration", "10 s"),
                            ],
                        )),
                );
                return None;
            }
        };
        let duration = settings.duration.unwrap_or(10.0);
        if let Some(robot) = robot
            && duration / robot.period > 1e9
        {
            let at = settings.duration_span.or(settings.span).unwrap_or(robot.name.span);
            let d = Diagnostic::error("HQ0605", at, "the run would have more than a thousand million ticks");
            self.push(d.label(robot.rate_span, format!("one tick is {} s", robot.period)).help("shorten the run"));
        }
        if let Some(robot) = robot
            && duration > 0.0
            && duration / robot.period < 0.5
        {
            let at = settings.duration_span.or(settings.span).unwrap_or(robot.name.span);
            let d = Diagnostic::error("HQ0308", at, "the run is shorter than one tick");
            self.push(d.label(robot.rate_span, format!("one tick is {} s", robot.period)).help("make the run longer"));
        }
        let tick_budget = settings.tick_budget.as_ref().map(|budget| budget.value);
        if let (Some(budget), Some(robot)) = (&settings.tick_budget, robot)
            && budget.value > robot.period
        {
            let d = Diagnostic::error("HQ0605", budget.span, "the budget of a tick is longer than the tick");
            let d = d.label(robot.rate_span, format!("one tick is {} s", robot.period));
            self.push(d.help("write a part of it, `us` after the number for microseconds"));
        }
        let machine = declared.machine.filter(|_| settings.stack.is_none());
        let own = machine.map(|m| &m.name).or(stacks.get(stack).map(|s| &s.name));
        let title = settings.title.or(own.map(|n| n.value.clone())).unwrap_or_default();
        let subject = if machine.is_some() { Subject::Machine } else { Subject::Stack(stack) };
        Some((
            RunProgram { subject, duration, solver: settings.solver, simulator: settings.simulator, tick_budget },
            title,
        ))
    }

    /// Checks that the machine of the run exists, and that no stack is named as well.
    fn machine_of(&mut self, settings: &RunSettings, declared: &Declared) -> Option<()> {
        let Some(name) = &settings.machine else { return Some(()) };
        if let Some(stack) = &settings.stack {
            let d = Diagnostic::unknown_key("HQ0205", stack.span, "a run has a stack or a machine, not both");
            self.push(d.label(name.span, "the machine").help("keep one of the two"));
            return None;
        }
        match declared.machine {
            Some(m) if m.name.value == name.value => Some(()),
            Some(m) => {
                let d = Diagnostic::unknown_name(name.span, format!("there is no machine `{}`", name.value));
                self.push(d.help(format!("declared is `{}`", m.name.value)));
                None
            }
            None => {
                let d = Diagnostic::unknown_name(name.span, format!("there is no machine `{}`", name.value));
                self.push(d.help(Help::with(
                    "declare it: {}",
                    [examples::machine(Snippet::parts([Snippet::entry("stack", "NAME"), Snippet::dots()]))],
                )));
                None
            }
        }
    }
}

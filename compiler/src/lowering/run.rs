//! Lowers `run` blocks, and selects the stack or machine to run.

use blocks::Located;
use dsl::{Diagnostic, Help, Snippet, Span, Topic};
use runtime::program::{RunProgram, Simulator, Subject};
use solver::Backend;
use stdlib_tasks::dimension::{ANGLE, Dimension, TIME};

use super::Lowerer;
use super::declared::Declared;
use crate::diagnostics::examples;
use crate::robot_binding::BoundRobot;
use crate::sections::{RunBlock, SimulatorBlock};
use crate::units;

impl Lowerer<'_> {
    /// Settings of the simulated robot.
    fn simulator(&mut self, block: &SimulatorBlock) -> Simulator {
        // Larger values exceed those of any robot with a velocity controller.
        self.plausible(
            ("lag", &block.lag, TIME),
            1.0,
            "actuators lag by 1 ms to 200 ms; write `ms` after the number if milliseconds are meant",
        );
        self.plausible(
            ("noise", &block.noise, ANGLE),
            0.1,
            "encoders err by 1e-6 rad to 1e-3 rad; this is the standard deviation of every measured position",
        );
        Simulator {
            lag: block.lag.value,
            noise: block.noise.value,
            seed: block.seed as u64,
            speed: block.speed,
            acceleration: block.acceleration,
            plant: None,
        }
    }

    /// Warns of a number above the `usual` ones.
    fn plausible(
        &mut self,
        (name, number, dimension): (&str, &Located<f64>, Dimension),
        usual: f64,
        help: &'static str,
    ) {
        if number.value > usual {
            let text = format!("a {name} of {} is implausible", units::shown(number.value, dimension));
            let d = Diagnostic::warning("HQ0522", self.origins.span(number.at), text);
            self.push(d.here(format!("above {}", units::shown(usual, dimension))).help(help));
        }
    }

    /// Lowers the `run` block at a span, or the default one.
    pub(super) fn run(
        &mut self,
        (run, span): (RunBlock, Option<Span>),
        declared: &Declared,
        robot: Option<&BoundRobot>,
    ) -> Option<(RunProgram, String)> {
        let mut simulator = self.simulator(&run.simulator);
        self.idle_simulator(&simulator, &run.plant);
        simulator.plant = self.plant(&run.plant, robot);
        self.machine_of(&run, declared)?;
        let stacks = &declared.stacks;
        let stack = self.stack_of(&run, span, declared)?;
        if let Some(robot) = robot {
            // The default lasts between one tick and a million, so that it needs no place.
            self.duration_fits(run.duration.value, self.origins.span(run.duration.at), robot);
        }
        if let (Some(budget), Some(robot)) = (&run.tick_budget, robot)
            && budget.value > robot.period
        {
            let at = self.origins.span(budget.at);
            let d = Diagnostic::error("HQ0605", at, "the budget of a tick is longer than the tick");
            let d = d.label(robot.rate_span, format!("one tick is {} s", robot.period));
            self.push(d.help("write a part of it, `us` after the number for microseconds"));
        }
        let machine = declared.machine.filter(|_| run.stack.is_none());
        let own = machine.map(|m| &m.name).or(stacks.get(stack).map(|s| &s.name));
        let title = run.title.or(own.map(|n| n.value.clone())).unwrap_or_default();
        let subject = if machine.is_some() { Subject::Machine } else { Subject::Stack(stack) };
        let program = RunProgram {
            subject,
            duration: run.duration.value,
            solver: Backend::from_name(run.solver).unwrap_or_default(),
            simulator,
            tick_budget: run.tick_budget.map(|budget| budget.value),
            ros: robot.and_then(|robot| Some(self.ros(&run.ros.as_ref()?.value, robot))),
        };
        Some((program, title))
    }

    /// Reports a duration of too many ticks, or of none.
    pub(super) fn duration_fits(&mut self, duration: f64, at: Span, robot: &BoundRobot) {
        let ticks = duration / robot.period;
        let tick = format!("one tick is {} s", robot.period);
        if ticks > 1e9 {
            let d = Diagnostic::error("HQ0605", at, "the run would have more than a thousand million ticks");
            self.push(d.label(robot.rate_span, tick).help("shorten the run"));
        } else if ticks < 0.5 {
            let d = Diagnostic::error("HQ0308", at, "the run is shorter than one tick");
            self.push(d.label(robot.rate_span, tick).help("make the run longer"));
        }
    }

    /// Index of the stack that runs; 0 if a machine does.
    fn stack_of(&mut self, run: &RunBlock, span: Option<Span>, declared: &Declared) -> Option<usize> {
        let stacks = &declared.stacks;
        let Some(named) = &run.stack else {
            if declared.machine.is_some() || stacks.len() == 1 {
                return Some(0);
            }
            let second = stacks.get(1)?;
            let run = Snippet::block(
                "run",
                [Snippet::entry("stack", stacks[0].name.value.as_str()), Snippet::entry("duration", "10 s")],
            );
            let at = span.unwrap_or(second.name.span);
            let d = Diagnostic::error("HQ0603", at, "several stacks, and no `run` selects one");
            self.push(d.about(Topic::MissingDeclaration).help(run));
            return None;
        };
        let (name, at) = (named.value.as_str(), self.origins.span(named.at));
        if let Some(i) = stacks.iter().position(|s| s.name.value == name) {
            return Some(i);
        }
        if let Some(pattern) = declared.patterns.get(name) {
            let text = format!("stack `{name}` has parameters, and no arguments are given");
            let d = Diagnostic::error("HQ0214", at, text).label(*pattern, "declared here");
            self.push(d.help(Help::with(
                "make a stack from it, {}, and run that one",
                [Snippet::each(
                    format!("stack NAME from {name}(..) {{ }}"),
                    format!("stacks: {{ NAME: {{ from: {name}(..) }} }}"),
                )],
            )));
            return None;
        }
        // The stack may be one that failed to expand.
        if !stacks.is_empty() || declared.whole {
            let names = stacks.iter().map(|s| s.name.value.as_str());
            let d = Diagnostic::undeclared("stack", name, at);
            self.push(d.one_of("declared are", name, names));
        }
        None
    }

    /// Checks that the machine of the run exists, and that no stack is named as well.
    fn machine_of(&mut self, run: &RunBlock, declared: &Declared) -> Option<()> {
        let Some(Located { at, value: name }) = &run.machine else { return Some(()) };
        let at = self.origins.span(*at);
        if let Some(stack) = &run.stack {
            let stack = self.origins.span(stack.at);
            let d = Diagnostic::unknown_key("HQ0205", stack, "a run has a stack or a machine, not both");
            self.push(d.label(at, "the machine").help("keep one of the two"));
            return None;
        }
        match declared.machine {
            Some(m) if m.name.value == *name => Some(()),
            Some(m) => {
                let d = Diagnostic::undeclared("machine", name, at);
                self.push(d.help(format!("declared is `{}`", m.name.value)));
                None
            }
            None => {
                let d = Diagnostic::undeclared("machine", name, at);
                self.push(d.help(Help::with(
                    "declare it: {}",
                    [examples::machine(Snippet::parts([Snippet::entry("stack", "NAME"), Snippet::dots()]))],
                )));
                None
            }
        }
    }
}

//! Working robots that run controllers: what a worker says with `runs`.

use blocks::{Block, BoundBlock};
use dsl::{Diagnostic, Help, Snippet, Span};
use mission::declare::DeclaredMission;
use mission::declare::common::RunsBlock;
use mission::kind;
use names::list;
use runtime::Program;
use runtime::program::{
    ControllerProgram, MAX_RUNNING, MAX_TICKS, MachineProgram, MissionScenarioProgram, Running, ScenarioProgram,
    Subject, Trigger, WorkerProgram, WorldProgram,
};

use super::super::Lowerer;
use super::super::states::state;

/// The machines of working robots, by agent: what expectations may name states of.
#[derive(Default)]
pub(super) struct Machines(Vec<(usize, MachineProgram)>);

impl Machines {
    /// The machines of a mission.
    pub fn of(running: &Running) -> Machines {
        let one = |w: &WorkerProgram| Some((w.member, running.controller(w)?.program.machine.clone()?));
        Machines(running.workers.iter().filter_map(one).collect())
    }

    /// Machine of a member; `None` if it runs no controller.
    pub fn of_agent(&self, agent: usize) -> Option<&MachineProgram> {
        self.0.iter().find(|m| m.0 == agent).map(|m| &m.1)
    }
}

/// The key of a member that runs a controller.
const RUNS_KEY: &str = "runs";

/// A member that runs a controller.
struct Worker<'m> {
    name: &'m str,
    /// Index among the members of the mission.
    index: usize,
    /// Number of its operations.
    operations: usize,
}

impl Lowerer<'_> {
    /// The members of a mission that run controllers; without those in which something is wrong.
    pub(super) fn running(&mut self, declared: &DeclaredMission, mission: &dyn kind::Mission) -> Running {
        let mut running = Running::default();
        for member in &declared.members {
            let Some(runs) = member.settings.block(RUNS_KEY) else { continue };
            let is = |m: &kind::Member| m.role == member.role && m.name == member.name;
            let Some(index) = mission.members().iter().position(is) else { continue };
            if running.workers.len() == MAX_RUNNING {
                let text = format!("more than {MAX_RUNNING} workers of this mission run controllers");
                let d = Diagnostic::error("HQ0933", self.origins.span(runs.at), text);
                self.push(d.help("leave `runs` out of some: their operations then take their `duration`"));
                break;
            }
            let worker = Worker { name: &member.name, index, operations: mission.work_of(index) };
            self.runs(runs, &worker, &mut running);
        }
        running
    }

    fn runs(&mut self, bound: &BoundBlock, worker: &Worker, into: &mut Running) {
        let block = RunsBlock::read(bound);
        if bound.is_wrong("spec") {
            return;
        }
        let spec = block.spec.value.as_str();
        let Some(program) = self.controller_of(spec, self.origins.span(block.spec.at)) else { return };
        let go = (!bound.is_wrong("go")).then(|| self.go(&block, &program)).flatten();
        let done = (!bound.is_wrong("done")).then(|| self.done(&block, &program, worker)).flatten();
        let world = (!bound.is_wrong("scenario")).then(|| self.world_of(&block, &program)).flatten();
        let (Some(go), Some(done), Some(mut world)) = (go, done, world) else { return };
        // What is told of operations is told by the mission alone.
        world.world.signals.retain(|s| s.signal != go);
        let known = into.controllers.iter().position(|c| c.spec == spec);
        let controller = known.unwrap_or_else(|| {
            let program = Program { scenarios: Vec::new(), ..program };
            into.controllers.push(ControllerProgram { spec: spec.to_string(), program });
            into.controllers.len() - 1
        });
        into.workers.push(WorkerProgram { member: worker.index, controller, go, done, world });
    }

    /// The signal that says that an operation goes on.
    fn go(&mut self, block: &RunsBlock, program: &Program) -> Option<usize> {
        let (name, spec) = (block.go.value.as_str(), block.spec.value.as_str());
        let at = self.origins.span(block.go.at);
        let signals = || program.interface.signals.iter().filter(|s| !s.is_variable());
        let flags: Vec<&str> = signals().filter(|s| s.kind == "flag").map(|s| s.name.as_str()).collect();
        let Some(signal) = program.interface.signals.iter().position(|s| s.name == name) else {
            let d = Diagnostic::unknown_name(at, format!("`{spec}` has no signal `{name}`"));
            let d = d.help(Help::with("declare it there: {}", [Snippet::of_type("signal", name, "flag")]));
            self.push(d.one_of("flags there are", name, flags));
            return None;
        };
        let s = &program.interface.signals[signal];
        if s.is_variable() || s.kind != "flag" {
            let what = if s.is_variable() { "a variable of the machine" } else { "no flag" };
            let d = Diagnostic::error("HQ0932", at, format!("`{name}` of `{spec}` is {what}"))
                .note("the mission sets it: true while an operation is under way, false otherwise");
            self.push(match flags.is_empty() {
                true => d.help(Help::with(
                    &format!("declare a signal for it in `{spec}`: {{}}"),
                    [Snippet::of_type("signal", "work", "flag")],
                )),
                false => d.help(format!("flags there are {}", list(flags, 12))),
            });
            return None;
        }
        if program.machine.as_ref().is_some_and(|m| !reads(m, program, s.at)) {
            self.unused_is_told(spec, name);
            let d =
                Diagnostic::warning("HQ0934", at, format!("no transition of the machine of `{spec}` reads `{name}`"))
                    .note("the robot does not react to the mission");
            self.push(
                d.help(Help::with("use it to leave the waiting state: {}", [Snippet::transition_when(name, "STATE")])),
            );
        }
        Some(signal)
    }

    /// The state that ends an operation.
    fn done(&mut self, block: &RunsBlock, program: &Program, worker: &Worker) -> Option<usize> {
        let (path, spec) = (block.done.value.as_str(), block.spec.value.as_str());
        let at = self.origins.span(block.done.at);
        let machine = program.machine.as_ref()?;
        let done = match state(machine, path, at) {
            Ok(done) => done,
            Err(mut d) => {
                d.message = format!("{} in `{spec}`", d.message);
                self.push(*d);
                return None;
            }
        };
        let Worker { name, operations, .. } = *worker;
        if operations > 1 && !is_left(machine, done) {
            let d = Diagnostic::error("HQ0932", at, format!("the machine of `{spec}` never leaves `{path}`"))
                .note(format!("`{name}` has {operations} operations, and each ends when that state is entered"))
                .help("name the state in which the robot waits for its next operation, or let this one be left");
            self.push(d);
            return None;
        }
        Some(done)
    }

    /// The world around the robot: that of a scenario of its spec, or one in which nothing happens.
    fn world_of(&mut self, block: &RunsBlock, program: &Program) -> Option<ScenarioProgram> {
        let empty = ScenarioProgram {
            name: String::new(),
            run: program.run.clone(),
            start: program.robot.home.clone(),
            world: WorldProgram::default(),
            measures: Vec::new(),
            predicates: Vec::new(),
            expectations: Vec::new(),
        };
        let Some(scenario) = &block.scenario else { return Some(empty) };
        let (name, spec) = (scenario.value.as_str(), block.spec.value.as_str());
        let at = self.origins.span(scenario.at);
        let names = || program.scenarios.iter().map(|s| s.name.as_str());
        let Some(found) = program.scenarios.iter().find(|s| s.name == name) else {
            let d = Diagnostic::unknown_name(at, format!("`{spec}` has no scenario `{name}` of its robot"));
            self.push(d.help("remove it to run without a scenario").one_of("there is", name, names()));
            return None;
        };
        if found.run.subject != Subject::Machine {
            let d = Diagnostic::error("HQ0932", at, format!("the scenario `{name}` of `{spec}` runs a stack"))
                .note("an operation ends when a machine enters a state");
            self.push(d.help("name a scenario that runs the machine, or leave it out"));
            return None;
        }
        let ScenarioProgram { name, run, start, world, .. } = found.clone();
        Some(ScenarioProgram { name, run, start, world, ..empty })
    }

    /// Refuses a run in which controllers would have too many ticks; `at` is where its duration was written.
    pub(super) fn ticks_fit(&mut self, scenario: &MissionScenarioProgram, per_second: f64, at: Span) -> bool {
        let fits = !scenario.sampled || per_second * scenario.duration <= MAX_TICKS;
        if !fits {
            let text = format!("the controllers of working robots would have more than {MAX_TICKS} ticks together");
            let d = Diagnostic::error("HQ0933", at, text);
            let longest = (MAX_TICKS / per_second).floor();
            self.push(d.help(Help::with(
                &format!("shorten the run to {longest} s, or write {{}}: then none runs"),
                [Snippet::entry("operations", "planned")],
            )));
        }
        fits
    }
}

/// True where a transition of a machine reads the signal whose place in the table of signals is `at`.
fn reads(machine: &MachineProgram, program: &Program, at: usize) -> bool {
    let conditions = machine.states.iter().flat_map(|s| &s.transitions).filter_map(|t| match &t.trigger {
        Trigger::When { condition, .. } => Some(condition),
        _ => None,
    });
    let wanted = conditions.flat_map(|c| c.inputs.iter().copied()).collect();
    program.values.tape.only(&wanted).signals().iter().any(|k| (at..=at + 1).contains(k))
}

/// True where a transition that answers no fault leads out of a state.
fn is_left(machine: &MachineProgram, state: usize) -> bool {
    let holds = |outer: usize, inner: usize| machine.path(inner).any(|s| s == outer);
    if machine.path(state).any(|s| machine.states[s].is_final) {
        return false;
    }
    let inside = (0..machine.states.len()).filter(|&s| holds(state, s) || holds(s, state));
    let mut ways = inside.flat_map(|s| &machine.states[s].transitions);
    ways.any(|t| !matches!(t.trigger, Trigger::Fault(_)) && !holds(state, t.target))
}

//! Members that run controllers: what a worker says with `runs`. Robots that are driven are in `drives`.

use blocks::{Block, BoundBlock, Located};
use dsl::{Diagnostic, Help, Snippet, Span};
use mission::declare::DeclaredMission;
use mission::declare::common::RunsBlock;
use mission::declare::driven::{DRIVEN, RUNS_KEY};
use mission::kind;
use names::list;
use runtime::Program;
use runtime::program::{
    Job, MAX_RUNNING, MAX_TICKS, MachineProgram, MissionScenarioProgram, Running, ScenarioProgram, Subject, Trigger,
    WorkerProgram, WorldProgram,
};

use super::super::Lowerer;
use super::super::states::state;
use super::drives::Robot;

/// The machines of members that run controllers, by member: what expectations may name states of.
#[derive(Default)]
pub(super) struct Machines(Vec<(usize, Option<MachineProgram>)>);

impl Machines {
    /// The machines of a mission.
    pub fn of(running: &Running) -> Machines {
        let one = |w: &WorkerProgram| Some((w.member, w.machine(&running.controller(w)?.program).cloned()));
        Machines(running.workers.iter().filter_map(one).collect())
    }

    /// Machine of a member; `None` if it runs none.
    pub fn of_agent(&self, agent: usize) -> Option<&MachineProgram> {
        self.0.iter().find(|m| m.0 == agent)?.1.as_ref()
    }

    /// True if a member runs a controller.
    pub fn has(&self, agent: usize) -> bool {
        self.0.iter().any(|m| m.0 == agent)
    }
}

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
                let (who, then) = match std::ptr::eq(runs.schema, &DRIVEN) {
                    true => ("members", "they then move as planned"),
                    false => ("workers", "their operations then take their `duration`"),
                };
                let text = format!("more than {MAX_RUNNING} {who} of this mission run controllers");
                let d = Diagnostic::error("HQ0933", self.origins.span(runs.at), text);
                self.push(d.help(format!("leave `runs` out of some: {then}")));
                break;
            }
            if std::ptr::eq(runs.schema, &DRIVEN) {
                match mission.drivable(index) {
                    Some(drivable) => {
                        let robot = Robot { name: &member.name, index, drivable };
                        self.drives(runs, &robot, (declared, mission), &mut running);
                    }
                    None => self.not_driven(runs, &member.name),
                }
                continue;
            }
            let worker = Worker { name: &member.name, index, operations: mission.work_of(index) };
            self.runs(runs, &worker, &mut running);
        }
        running
    }

    /// A member with `runs` that nothing drives.
    fn not_driven(&mut self, runs: &BoundBlock, name: &str) {
        let text = format!("`{name}` is no robot, and no controller drives it");
        let d = Diagnostic::error("HQ0964", self.origins.span(runs.at), text);
        self.push(d.help("leave `runs` out here, and let a robot run it"));
    }

    fn runs(&mut self, bound: &BoundBlock, worker: &Worker, into: &mut Running) {
        let block = RunsBlock::read(bound);
        if bound.is_wrong("spec") {
            return;
        }
        let spec = block.spec.value.as_str();
        let at = self.origins.span(block.spec.at);
        let Some(program) = self.controller_of(spec, at, "a worker") else { return };
        if !self.runs_machine(spec, &program, at) {
            return;
        }
        let go = (!bound.is_wrong("go")).then(|| self.go(&block, &program)).flatten();
        let done = (!bound.is_wrong("done")).then(|| self.done(&block, &program, worker)).flatten();
        let world =
            (!bound.is_wrong("scenario")).then(|| self.world_of(block.scenario.as_ref(), spec, &program)).flatten();
        let world = world.filter(|world| self.scenario_runs_machine(&block, world));
        let (Some(go), Some(done), Some(mut world)) = (go, done, world) else { return };
        // Messages about operations come from the mission alone.
        world.world.signals.retain(|s| s.signal != go);
        let controller = into.add(spec, program);
        into.workers.push(WorkerProgram { member: worker.index, controller, job: Job::Operations { go, done }, world });
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
    pub(super) fn world_of(
        &mut self,
        scenario: Option<&Located<String>>,
        spec: &str,
        program: &Program,
    ) -> Option<ScenarioProgram> {
        let empty = ScenarioProgram {
            name: String::new(),
            run: program.run.clone(),
            start: program.robot.home.clone(),
            world: WorldProgram::default(),
            measures: Vec::new(),
            predicates: Vec::new(),
            expectations: Vec::new(),
        };
        let Some(scenario) = scenario else { return Some(empty) };
        let name = scenario.value.as_str();
        let at = self.origins.span(scenario.at);
        let names = || program.scenarios.iter().map(|s| s.name.as_str());
        let Some(found) = program.scenarios.iter().find(|s| s.name == name) else {
            let d = Diagnostic::unknown_name(at, format!("`{spec}` has no scenario `{name}` of its robot"));
            self.push(d.help("remove it to run without a scenario").one_of("there is", name, names()));
            return None;
        };
        let ScenarioProgram { name, run, start, world, .. } = found.clone();
        Some(ScenarioProgram { name, run, start, world, ..empty })
    }

    /// Refuses a scenario in which no machine ends the operations of a worker.
    fn scenario_runs_machine(&mut self, block: &RunsBlock, world: &ScenarioProgram) -> bool {
        let Some(scenario) = block.scenario.as_ref().filter(|_| world.run.subject != Subject::Machine) else {
            return true;
        };
        let (name, spec, at) = (&scenario.value, &block.spec.value, self.origins.span(scenario.at));
        let d = Diagnostic::error("HQ0932", at, format!("the scenario `{name}` of `{spec}` runs a stack"))
            .note("an operation ends when a machine enters a state");
        self.push(d.help("name a scenario that runs the machine, or leave it out"));
        false
    }

    /// Refuses a run in which controllers would have too many ticks; `at` is where its duration was written.
    pub(super) fn ticks_fit(&mut self, scenario: &MissionScenarioProgram, per_second: f64, at: Span) -> bool {
        let fits = !scenario.sampled || per_second * scenario.duration <= MAX_TICKS;
        if !fits {
            let text = format!("the controllers of this mission would have more than {MAX_TICKS} ticks together");
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
    if machine.ends(state) {
        return false;
    }
    let inside = (0..machine.states.len()).filter(|&s| holds(state, s) || holds(s, state));
    let mut ways = inside.flat_map(|s| &machine.states[s].transitions);
    ways.any(|t| !matches!(t.trigger, Trigger::Fault(_)) && !holds(state, t.target))
}

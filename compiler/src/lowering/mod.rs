//! From a tree to a program: declarations collected, names bound, stacks laid out.

mod actions;
mod ages;
mod argument_types;
mod blocks;
mod coverage;
mod declared;
mod distances;
mod enabling;
mod expectation_checks;
mod expectation_scope;
mod expectations;
mod fields;
mod formulas;
mod human_trajectories;
mod humans;
mod inline_tasks;
mod machine;
mod measures;
mod merged_stacks;
mod missions;
mod obstacle_forms;
mod obstacles;
mod params;
mod plant;
mod predicates;
mod properties;
mod reached;
mod regions;
mod ros;
mod run;
mod scenario;
mod sensors;
mod shapes;
mod signals;
mod stack;
mod states;
mod task_outputs;
mod tracked_signals;
mod transitions;
mod triggers;
mod values;
mod variables;
mod wording;
mod world;

use std::collections::BTreeSet;
use std::path::Path;

use ::blocks::Block as _;
use dsl::tree::{Robot, Stack, TaskDefinition};
use dsl::{Diagnostic, Help, Snippet, SourceId, Span, Topic};
use runtime::program::{
    FORMAT, Interface, MachineProgram, MissionProgram, Program, RobotProgram, RunProgram, StackProgram, TaskProgram,
};

use stdlib_tasks::bound::Obstacle;
use stdlib_tasks::field::FieldProgram;

use crate::binding::{Binder, BoundTask, Table};
use crate::block_binding::Origins;
use crate::expand::Expanded;
use crate::expr::Graph;
use crate::expr::constants::{Constants, Params};
use crate::input::{CompilePart, Input, Texts};
use crate::robot_binding::{self, BoundRobot, Files};
use crate::sections::{RobotBlock, RunBlock};
use crate::source_map::{MachinePlaces, SourceMap};
pub use actions::{VERBS, Verb};
use coverage::Nameable;
use declared::Declared;
use inline_tasks::definitions;
use machine::Surroundings;
pub(crate) use missions::scenario::runs_mission;
use params::NamedValues;
pub use params::ParamValue;
pub(crate) use params::params;
pub use signals::signal_types;
use stack::Stacks;

/// A spec, lowered.
pub(crate) struct Lowered {
    /// The controller; none where there is an error, or where the spec declares missions alone.
    pub controller: Option<LoweredController>,
    /// Its missions.
    pub missions: Vec<MissionProgram>,
    /// Texts of the specs that working robots of missions run: what is said of them was said in their own syntax.
    pub foreign: BTreeSet<SourceId>,
}

/// A program, and what checks want to know of how it came to be.
pub(crate) struct LoweredController {
    /// The program.
    pub program: Program,
    /// Source spans of its parts.
    pub source_map: SourceMap,
    /// The nodes of all expressions.
    pub graph: Graph,
    /// Table of the robot's state and of captured values, which the nodes refer to.
    pub table: Table,
}

/// Inputs of lowering other than the spec.
pub(crate) struct Context<'a> {
    /// Input of the compiler.
    pub input: &'a Input<'a>,
    /// Texts in the place of those of files.
    pub texts: &'a Texts,
    /// Its text.
    pub source: SourceId,
    /// The driver, for the specs that working robots run.
    pub compile: CompilePart,
    /// False if the contents of files of bytes are not needed.
    pub reads_bytes: bool,
}

/// Lowers a spec; `empty` says that nothing could be read of it.
pub(crate) fn lower(
    context: &Context,
    expanded: &Expanded,
    empty: bool,
    sources: &mut dsl::Sources,
    diagnostics: &mut Vec<Diagnostic>,
) -> Lowered {
    let mut lowerer = Lowerer::new(context, sources, diagnostics);
    let mut missions = Vec::new();
    let lowered = lowerer.spec(expanded, empty, &mut missions);
    let Lowerer { graph, table, controllers, .. } = lowerer;
    let controller = lowered.map(|(program, source_map)| LoweredController { program, source_map, graph, table });
    Lowered { controller, missions, foreign: controllers.foreign }
}

/// Shared by all steps of lowering: the input, diagnostics, expressions and the signals that they read.
struct Lowerer<'a> {
    input: &'a Input<'a>,
    /// False if the contents of files of bytes are not needed.
    reads_bytes: bool,
    source: SourceId,
    sources: &'a mut dsl::Sources,
    diagnostics: &'a mut Vec<Diagnostic>,
    graph: Graph,
    table: Table,
    params: Params,
    /// Signals and events.
    interface: Interface,
    /// Signals and people whose ages expressions read.
    aged: BTreeSet<String>,
    /// Safety fields, their points in the table of values.
    fields: Vec<FieldProgram>,
    /// Obstacles, their poses in the table of values.
    obstacles: Vec<Obstacle>,
    /// Specs that working robots of missions run.
    controllers: missions::controllers::Controllers<'a>,
    /// Tasks that count as used without being in a stack: an expectation measures them, or a misspelt name in a stack
    /// probably meant them.
    used_tasks: BTreeSet<String>,
    /// Parts of expectations so far.
    expected: usize,
    /// Places of the texts of bound blocks.
    origins: Origins,
}

impl<'a> Lowerer<'a> {
    fn new(context: &'a Context<'a>, sources: &'a mut dsl::Sources, diagnostics: &'a mut Vec<Diagnostic>) -> Self {
        Lowerer {
            input: context.input,
            reads_bytes: context.reads_bytes,
            source: context.source,
            sources,
            diagnostics,
            graph: Graph::default(),
            table: Table::default(),
            params: Params::default(),
            interface: Interface::default(),
            aged: BTreeSet::new(),
            fields: Vec::new(),
            obstacles: Vec::new(),
            controllers: missions::controllers::Controllers::new(context),
            used_tasks: BTreeSet::new(),
            expected: 0,
            origins: Origins::default(),
        }
    }

    fn push(&mut self, d: Diagnostic) {
        self.diagnostics.push(d);
    }

    /// Creates the binder of expressions to the robot.
    fn binder<'b>(&'b mut self, robot: &'b BoundRobot) -> Binder<'b> {
        Binder {
            robot,
            tasks: &[],
            fields: self.fields.iter().map(|f| f.name.clone()).collect(),
            obstacles: &self.obstacles,
            params: &mut self.params,
            graph: &mut self.graph,
            table: &mut self.table,
            sources: self.sources,
            defaults: std::collections::BTreeMap::new(),
            numbers: Vec::new(),
            axes: std::collections::BTreeMap::new(),
            bound_axes: std::collections::BTreeMap::new(),
            deviating: crate::expr::Frame::World,
            plane: crate::expr::Frame::World,
            forms: std::collections::BTreeMap::new(),
            operands: std::collections::BTreeMap::new(),
            diagnostics: self.diagnostics,
        }
    }

    /// The program of a spec, step by step; `empty` says that nothing could be read of it. Missions need no program.
    fn spec(
        &mut self,
        expanded: &Expanded,
        empty: bool,
        missions: &mut Vec<MissionProgram>,
    ) -> Option<(Program, SourceMap)> {
        let declared = self.collect(expanded);
        // Without the imported files, all names that they declare would be reported as unknown.
        if !expanded.usable {
            return None;
        }
        let NamedValues { later, sensors, mut variables } = self.named_values(expanded, &declared);
        let robot = self.robot(&declared);
        let run = match declared.runs.first() {
            Some((run, span)) => (self.read(&run.body, *span), Some(*span)),
            None => (RunBlock::empty(), None),
        };
        if let Some(robot) = &robot {
            self.sensors(&sensors, robot);
        }
        *missions = self.missions(&expanded.missions);
        self.scenario_names(expanded);
        self.mission_scenarios(expanded, missions);
        if missions::only(expanded) {
            self.nothing_runs(expanded);
            self.unused(&declared, expanded, expanded.whole);
            return None;
        }
        // A file that could not be read at all has said so already.
        if declared.robots.is_empty() && expanded.whole && (!empty || self.diagnostics.is_empty()) {
            self.push(
                Diagnostic::error("HQ0206", Span::new(self.source, 0, 0), "this spec declares no robot")
                    .about(Topic::MissingRobot)
                    .help(Help::with(
                        "write {}, or import one",
                        [Snippet::declared(
                            "robot",
                            "NAME",
                            [Snippet::entry("urdf", "\"..\""), Snippet::entry("rate", "100 Hz")],
                        )],
                    )),
            );
        }
        self.bind_fields(expanded, robot.as_ref());
        self.bind_obstacles(expanded, robot.as_ref());
        let refused = self.given(&expanded.given);
        let definitions = definitions(&declared);
        let bound = match &robot {
            Some(robot) => self.tasks(&definitions, robot, (&later, &refused)),
            None => Vec::new(),
        };
        let stacks = self.stacks(&declared, &definitions, robot.as_ref());
        let run = self.run(run, &declared, robot.as_ref());
        let machine = match (&robot, declared.machine) {
            (Some(robot), Some(machine)) => {
                let around = Surroundings::new(&declared, &definitions, &bound, robot);
                self.machine(machine, around, &mut variables)
            }
            _ => None,
        };
        let coverage = robot.as_ref().map(|robot| {
            let tasks = definitions.iter().map(|d| d.0.as_str()).collect();
            let machine = machine.as_ref().map(|m| &m.0);
            self.coverage(expanded, &Nameable { declared: &declared, tasks, robot, machine })
        });
        let complete = robot.is_some() && bound.iter().all(Option::is_some) && expanded.whole;
        if self.errors() > 0 {
            // Scenarios are not lowered, and may use declarations that nothing else uses.
            self.unused(&declared, expanded, complete && expanded.scenarios.is_empty());
            return None;
        }
        self.never_set(expanded, &variables);
        let robot = robot?;
        let (mut program, mut source_map) =
            self.program(&robot, &definitions, bound, (&declared, stacks), (run?, machine))?;
        source_map.coverage = coverage.unwrap_or_default();
        self.merge_stacks(declared.tasks.len(), &mut program, &mut source_map);
        if self.errors() > 0 {
            self.unused(&declared, expanded, complete && expanded.scenarios.is_empty());
            return None;
        }
        program.scenarios = self.scenarios(expanded, &program, &robot, &mut source_map);
        if let (Some(machine), Some(places)) = (declared.machine, &mut source_map.machine) {
            self.properties(machine, &program, &robot, places);
        }
        self.unused(&declared, expanded, complete);
        Some((program, source_map))
    }

    /// Binds the robots to their URDFs, and makes one of them.
    fn robot(&mut self, declared: &Declared) -> Option<BoundRobot> {
        let bound: Vec<Option<BoundRobot>> = declared.robots.iter().map(|robot| self.one_robot(robot)).collect();
        let bound: Vec<BoundRobot> = bound.into_iter().collect::<Option<_>>()?;
        robot_binding::together(bound, self.diagnostics)
    }

    fn one_robot(&mut self, robot: &Robot) -> Option<BoundRobot> {
        let block: RobotBlock = self.read(&robot.body, robot.name.span);
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let mut files = Files {
            folder: self.input.folder,
            package_paths: self.input.package_paths,
            sources: self.sources,
            origins: &self.origins,
            diagnostics: self.diagnostics,
        };
        let bound = robot_binding::bind(robot, &block, &mut files, &mut constants);
        let enabling = block.enabled.as_ref().and_then(|name| self.origins.unbound(name)).cloned();
        let enabling = enabling.and_then(|name| self.enabling(&name));
        Some(BoundRobot { enabling: enabling.into_iter().collect(), ..bound? })
    }

    /// Lowers the stacks.
    fn stacks(
        &mut self,
        declared: &Declared,
        definitions: &[(String, TaskDefinition)],
        robot: Option<&BoundRobot>,
    ) -> Vec<StackProgram> {
        let names = definitions.iter().map(|d| d.0.as_str()).collect();
        let inline = declared.tasks.len();
        let mut lowering = Stacks { lowerer: self, declared, robot, names, inline };
        let stacks = declared.stacks.iter().map(|s| lowering.stack(s)).collect();
        let none = declared.stacks.is_empty() && declared.whole && declared.patterns.is_empty();
        if let (true, Some(robot)) = (none, declared.robots.first()) {
            let text = "this spec has no stack";
            self.push(
                Diagnostic::error("HQ0601", robot.name.span, text).about(Topic::MissingStack).help(Snippet::declared(
                    "stack",
                    "NAME",
                    [Snippet::level("NAME", false, "task").listed("levels")],
                )),
            );
        }
        stacks
    }

    fn program(
        &mut self,
        robot: &BoundRobot,
        definitions: &[(String, TaskDefinition)],
        bound: Vec<Option<BoundTask>>,
        (declared, stacks): (&Declared, Vec<StackProgram>),
        (run, machine): ((RunProgram, String), Option<(MachineProgram, MachinePlaces)>),
    ) -> Option<(Program, SourceMap)> {
        let (machine, machine_places) = machine.unzip();
        let level_names = |s: &&Stack| (s.name.span, s.levels.iter().map(|l| l.name.span).collect());
        let places = declared.stacks.iter().map(level_names).collect();
        let bound: Vec<BoundTask> = bound.into_iter().collect::<Option<_>>()?;
        let task = |((name, _), task): (&(String, TaskDefinition), &BoundTask)| TaskProgram {
            name: name.clone(),
            kind: task.kind.name.to_string(),
            params: task.params.clone(),
        };
        let tasks = definitions.iter().zip(&bound).map(task).collect();
        let program = Program {
            format: FORMAT,
            name: Path::new(self.input.name)
                .file_stem()
                .map_or_else(|| "spec".to_string(), |s| s.to_string_lossy().into_owned()),
            title: run.1,
            robot: RobotProgram {
                name: robot.name.value.clone(),
                urdf: robot.urdf.clone(),
                model: robot.model.clone(),
                period: robot.period,
                home: robot.home.clone(),
                deadline: robot.deadline,
                tracking_gain: robot.tracking_gain,
                lag: robot.lag,
                dead_time: robot.dead_time,
                stops_at_once: robot.stops_at_once,
                resumes_itself: robot.resumes_itself,
                enabling: robot.enabling.iter().copied().collect(),
                arms: robot.arms.clone(),
                geometries: robot.geometries.clone(),
            },
            interface: self.interface.clone(),
            values: self.values(),
            fields: std::mem::take(&mut self.fields),
            obstacles: self.obstacles.clone(),
            tasks,
            stacks,
            machine,
            run: run.0,
            scenarios: Vec::new(),
            allowed: Vec::new(),
        };
        Some((
            program,
            SourceMap {
                tasks: bound,
                stacks: places,
                machine: machine_places,
                rate: robot.rate_span,
                home: robot.home_span,
                srdf: robot.srdf.clone(),
                meshes: robot.meshes.clone(),
                coverage: Vec::new(),
                scenarios: Vec::new(),
                scenario_measures: Vec::new(),
            },
        ))
    }
}

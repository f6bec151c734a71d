//! From a tree to a program: declarations collected, names bound, stacks laid out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use dsl::tree::{Item, ItemKind, Level, MemberTask, Param, Robot, Run, Spec, Stack, Task, TaskDefinition};
use dsl::{Diagnostic, SourceId, Span, Spanned, Spelling};
use runtime::program::{
    FORMAT, LevelProgram, MemberProgram, Op, Output, Program, RobotProgram, RunProgram, Simulator, StackProgram, Tape,
    TaskProgram, ValueRange, Values,
};
use stdlib_tasks::dimension::{NONE, TIME};

use crate::binding::{Binder, BoundTask, Table};
use crate::checks;
use crate::constants::Constants;
use crate::expr::Graph;
use crate::names::{list, suggest};
use crate::report::Report;
use crate::robot_binding::{self, BoundRobot, Files, check_keys, items_of, joints, text_of};

/// What to compile.
#[derive(Clone, Debug)]
pub struct Input<'a> {
    /// How diagnostics call the text; usually the path as the user gave it.
    pub name: &'a str,
    /// The text.
    pub text: &'a str,
    /// Its spelling.
    pub spelling: Spelling,
    /// Folder that relative paths start from.
    pub folder: &'a Path,
    /// Parameters that are overridden, as `(name, value)` in the language.
    pub set: &'a [(String, String)],
    /// Where `package://` addresses are looked for, beside the usual places.
    pub package_paths: &'a [PathBuf],
}

/// The outcome: a program where there is no error, and everything there is to say.
#[derive(Debug)]
pub struct Compiled {
    /// The program.
    pub program: Option<Program>,
    /// Errors and warnings.
    pub report: Report,
}

/// Where the parts of a program were written, for checks that look at the finished program.
pub(crate) struct Places {
    /// For each task of the program.
    pub tasks: Vec<BoundTask>,
    /// For each stack, its name; for each level of it, its name.
    pub stacks: Vec<(Span, Vec<Span>)>,
    /// The robot's rate and home.
    pub rate: Span,
    /// See `rate`.
    pub home: Span,
}

/// Compiles a spec.
pub fn compile(input: &Input) -> Compiled {
    let mut report = Report::default();
    let source = report.sources.add(input.name, input.text);
    let (spec, mut diagnostics) = dsl::parse(source, input.text, input.spelling);
    let program = Lowerer::new(input, source, &mut report.sources, &mut diagnostics).spec(&spec);
    report.diagnostics = diagnostics;
    report.finish();
    let program = program.filter(|_| report.errors() == 0);
    Compiled { program, report }
}

struct Lowerer<'a> {
    input: &'a Input<'a>,
    source: SourceId,
    sources: &'a mut dsl::Sources,
    diagnostics: &'a mut Vec<Diagnostic>,
    graph: Graph,
    table: Table,
    used_params: BTreeSet<String>,
}

/// The declarations of a spec by kind.
#[derive(Default)]
struct Declared<'t> {
    params: Vec<&'t Param>,
    robots: Vec<&'t Robot>,
    tasks: Vec<&'t Task>,
    stacks: Vec<&'t Stack>,
    runs: Vec<(&'t Run, Span)>,
}

impl<'a> Lowerer<'a> {
    fn new(
        input: &'a Input<'a>,
        source: SourceId,
        sources: &'a mut dsl::Sources,
        diagnostics: &'a mut Vec<Diagnostic>,
    ) -> Self {
        Lowerer {
            input,
            source,
            sources,
            diagnostics,
            graph: Graph::default(),
            table: Table::default(),
            used_params: BTreeSet::new(),
        }
    }

    fn push(&mut self, d: Diagnostic) {
        self.diagnostics.push(d);
    }

    fn spec(&mut self, spec: &Spec) -> Option<Program> {
        let declared = self.collect(&spec.items);
        let overrides = self.overrides(&declared);
        let mut constants = Constants { graph: &mut self.graph, params: BTreeMap::new(), used: BTreeSet::new() };
        for p in &declared.params {
            let changed = overrides.get(&p.name.value);
            let param = changed.map_or_else(|| (*p).clone(), |v| Param { name: p.name.clone(), value: v.clone() });
            constants.declare(&param, self.diagnostics);
        }
        let robot = match declared.robots.first() {
            Some(r) => {
                let mut files = Files {
                    folder: self.input.folder,
                    package_paths: self.input.package_paths,
                    sources: self.sources,
                    diagnostics: self.diagnostics,
                };
                robot_binding::bind(r, &mut files, &mut constants)
            }
            None => None,
        };
        let run = declared.runs.first().map(|(r, span)| run_settings(r, *span, &mut constants, self.diagnostics));
        let Constants { params, used, .. } = constants;
        self.used_params = used;
        if declared.robots.is_empty() {
            let at = Span::new(self.source, 0, 0);
            // A file that could not be read at all has said so already.
            if !spec.items.is_empty() || self.diagnostics.is_empty() {
                self.push(
                    Diagnostic::error("HQ0206", at, "this spec declares no robot")
                        .help("write `robot NAME { urdf \"..\"  rate 100 Hz }`"),
                );
            }
        }
        let robot = robot?;
        let bound = self.tasks(&declared, &robot, &params);
        self.unused(&declared, &params);
        let (program, places) = self.program(&robot, bound, &declared, run)?;
        checks::program(&program, &places, self.diagnostics);
        Some(program)
    }

    fn collect<'t>(&mut self, items: &'t [Item]) -> Declared<'t> {
        let mut d = Declared::default();
        for item in items {
            match &item.kind {
                ItemKind::Param(p) => d.params.push(p),
                ItemKind::Robot(r) => {
                    if let Some(first) = d.robots.first() {
                        self.push(
                            Diagnostic::error("HQ0202", r.name.span, "a spec has one robot for now")
                                .label(first.name.span, "the first one")
                                .help("write one spec for each robot"),
                        );
                    } else {
                        d.robots.push(r);
                    }
                }
                ItemKind::Task(t) => {
                    if let Some(first) = d.tasks.iter().find(|o| o.name == t.name).map(|o| o.name.span) {
                        self.push(twice(&t.name, first));
                    } else {
                        d.tasks.push(t);
                    }
                }
                ItemKind::Stack(s) => {
                    if let Some(first) = d.stacks.iter().find(|o| o.name == s.name).map(|o| o.name.span) {
                        self.push(twice(&s.name, first));
                    } else {
                        d.stacks.push(s);
                    }
                }
                ItemKind::Run(r) => {
                    if let Some((_, first)) = d.runs.first() {
                        let d2 = Diagnostic::error("HQ0202", item.span, "there is already a `run`")
                            .label(*first, "the first one");
                        self.push(d2);
                    } else {
                        d.runs.push((r, item.span));
                    }
                }
            }
        }
        d
    }

    /// Values given with `--set`.
    fn overrides(&mut self, declared: &Declared) -> BTreeMap<String, dsl::tree::Value> {
        let mut out = BTreeMap::new();
        for (name, text) in self.input.set {
            let whole = format!("hierarq 1\nparam {name} = {text}\n");
            let source = self.sources.add(format!("--set {name}={text}"), whole.clone());
            let (spec, diagnostics) = dsl::parse(source, &whole, Spelling::Hq);
            self.diagnostics.extend(diagnostics);
            let param = spec.items.into_iter().find_map(|i| match i.kind {
                ItemKind::Param(p) => Some(p),
                _ => None,
            });
            let Some(param) = param else { continue };
            if declared.params.iter().any(|p| p.name.value == *name) {
                out.insert(name.clone(), param.value);
            } else {
                let names = declared.params.iter().map(|p| p.name.value.as_str());
                let d = Diagnostic::error("HQ0201", param.name.span, format!("the spec has no param `{name}`"));
                let d = match suggest(name, names.clone()) {
                    Some(near) => d.help(format!("did you mean `{near}`?")),
                    None => d.help(format!("it has {}", list(names, 12))),
                };
                self.push(d);
            }
        }
        out
    }

    /// Binds all declared tasks and those written in place: `None` for one that failed.
    fn tasks(
        &mut self,
        declared: &Declared,
        robot: &BoundRobot,
        params: &BTreeMap<String, crate::expr::Symbol>,
    ) -> Vec<(String, Option<BoundTask>)> {
        let mut definitions: Vec<(String, TaskDefinition)> =
            declared.tasks.iter().map(|t| (t.name.value.clone(), t.definition.clone())).collect();
        for s in &declared.stacks {
            for l in &s.levels {
                for m in &l.members {
                    if let Some(d) = in_place(&m.task, &declared.tasks) {
                        definitions.push((inline_name(&s.name.value, l, &d, &definitions), d));
                    }
                }
            }
        }
        let mut out = Vec::new();
        for (i, (name, d)) in definitions.iter().enumerate() {
            let mut binder = Binder {
                robot,
                params,
                used: &mut self.used_params,
                graph: &mut self.graph,
                table: &mut self.table,
                sources: self.sources,
                diagnostics: self.diagnostics,
            };
            out.push((name.clone(), binder.task(d, i)));
        }
        out
    }

    fn unused(&mut self, declared: &Declared, params: &BTreeMap<String, crate::expr::Symbol>) {
        for p in &declared.params {
            if params.contains_key(&p.name.value) && !self.used_params.contains(&p.name.value) {
                self.push(Diagnostic::warning(
                    "HQ0203",
                    p.name.span,
                    format!("param `{}` is never used", p.name.value),
                ));
            }
        }
        let members: Vec<&str> = (declared.stacks.iter().flat_map(|s| &s.levels).flat_map(|l| &l.members))
            .filter_map(|m| match &m.task {
                MemberTask::Name(n) => Some(n.value.as_str()),
                MemberTask::Inline(_) => None,
            })
            .collect();
        for t in &declared.tasks {
            if !members.contains(&t.name.value.as_str()) && !declared.stacks.is_empty() {
                self.push(
                    Diagnostic::warning("HQ0203", t.name.span, format!("task `{}` stands in no stack", t.name.value))
                        .help("add it to a level, or remove it"),
                );
            }
        }
    }

    fn program(
        &mut self,
        robot: &BoundRobot,
        bound: Vec<(String, Option<BoundTask>)>,
        declared: &Declared,
        run: Option<RunSettings>,
    ) -> Option<(Program, Places)> {
        let names: Vec<String> = bound.iter().map(|b| b.0.clone()).collect();
        let mut inline = declared.tasks.len();
        let mut stacks = Vec::new();
        let mut places = Vec::new();
        for s in &declared.stacks {
            let mut program = self.stack(s, robot, &names, &declared.tasks, &mut inline);
            program.name.clone_from(&s.name.value);
            places.push((s.name.span, s.levels.iter().map(|l| l.name.span).collect()));
            stacks.push(program);
        }
        if declared.stacks.is_empty() {
            self.push(
                Diagnostic::error(
                    "HQ0601",
                    robot.name.span,
                    "this spec has no stack, so the robot has nothing to hold to",
                )
                .help("write `stack NAME { level NAME { task } }`"),
            );
        }
        let run = self.run(run, declared, robot);
        if self.diagnostics.iter().any(|d| d.severity == dsl::Severity::Error) {
            return None;
        }
        let run = run?;
        let mut tasks = Vec::new();
        let mut task_places = Vec::new();
        for (name, task) in bound {
            let task = task?;
            tasks.push(TaskProgram { name, kind: task.kind.name.to_string(), params: task.params.clone() });
            task_places.push(task);
        }
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
                tracking_gain: robot.tracking_gain,
                arms: robot.arms.clone(),
                geometries: robot.geometries.clone(),
            },
            values: self.values(),
            tasks,
            stacks,
            run: run.0,
        };
        Some((program, Places { tasks: task_places, stacks: places, rate: robot.rate_span, home: robot.home_span }))
    }

    fn stack(
        &mut self,
        s: &Stack,
        robot: &BoundRobot,
        names: &[String],
        tasks: &[&Task],
        inline: &mut usize,
    ) -> StackProgram {
        let declared = tasks.len();
        check_keys(&s.settings, &["lock"], "a stack", self.diagnostics);
        let locked = s
            .settings
            .get("lock")
            .and_then(|e| joints(items_of(&e.value), &robot.model, &robot.joint_groups, self.diagnostics));
        if s.levels.is_empty() {
            self.push(
                Diagnostic::error("HQ0601", s.name.span, format!("stack `{}` has no level", s.name.value))
                    .help("write `level NAME { task }`"),
            );
        }
        let mut levels = Vec::new();
        let mut seen: BTreeMap<usize, Span> = BTreeMap::new();
        let mut soft: Option<Span> = None;
        for (i, l) in s.levels.iter().enumerate() {
            if let Some(first) = s.levels[..i].iter().find(|o| o.name == l.name) {
                self.push(twice(&l.name, first.name.span));
            }
            check_keys(&l.settings, &["damping"], "a level", self.diagnostics);
            let damping = l.settings.get("damping").and_then(|e| self.constant(&e.value, "the damping", 0.0, true));
            if l.members.is_empty() {
                self.push(
                    Diagnostic::error("HQ0601", l.name.span, format!("level `{}` has no task", l.name.value))
                        .help("add a task, or remove the level"),
                );
            }
            match (l.hard, soft) {
                (Some(hard), Some(soft)) => {
                    let d = Diagnostic::warning("HQ0606", hard, "this hard level stands below a soft one")
                        .label(soft, "this level is soft")
                        .note("what the soft level takes can make the hard one impossible, and that is a fault")
                        .help("put hard levels first");
                    self.push(d);
                }
                (None, None) => soft = Some(l.name.span),
                _ => {}
            }
            let mut members = Vec::new();
            for m in &l.members {
                let task = match &m.task {
                    task if in_place(task, tasks).is_some() => {
                        *inline += 1;
                        *inline - 1
                    }
                    MemberTask::Inline(_) => continue,
                    MemberTask::Name(n) => match names[..declared].iter().position(|x| *x == n.value) {
                        Some(t) => t,
                        None => {
                            self.unknown_task(n, &names[..declared]);
                            continue;
                        }
                    },
                };
                if let Some(first) = seen.insert(task, m.span) {
                    self.push(
                        Diagnostic::error(
                            "HQ0602",
                            m.span,
                            format!("task `{}` stands twice in stack `{}`", names[task], s.name.value),
                        )
                        .label(first, "first here")
                        .help("keep it where it matters most"),
                    );
                    continue;
                }
                let weight = match &m.weight {
                    Some(w) => self.constant(w, "a weight", 0.0, false).unwrap_or(1.0),
                    None => 1.0,
                };
                members.push(MemberProgram { task, weight });
            }
            levels.push(LevelProgram {
                name: l.name.value.clone(),
                hard: l.hard.is_some(),
                damping: damping.unwrap_or(0.0),
                members,
            });
        }
        StackProgram { name: String::new(), locked: locked.unwrap_or_default(), levels }
    }

    fn unknown_task(&mut self, name: &Spanned<String>, names: &[String]) {
        let d = Diagnostic::error("HQ0201", name.span, format!("there is no task `{}`", name.value));
        let d = if let Some(near) = suggest(&name.value, names.iter().map(String::as_str)) {
            d.help(format!("did you mean `{near}`?"))
        } else if let Some(near) = suggest(&name.value, stdlib_tasks::KINDS.iter().map(|k| k.name)) {
            d.help(format!("did you mean the task type `{near}`?"))
        } else if names.is_empty() {
            d.help("declare it: `task NAME = TYPE { .. }`")
        } else {
            d.help(format!("declared are {}", list(names.iter().map(String::as_str), 12)))
        };
        self.push(d);
    }

    /// A bare constant above (or at) a bound.
    fn constant(&mut self, value: &dsl::tree::Value, what: &str, min: f64, included: bool) -> Option<f64> {
        let mut constants = Constants { graph: &mut self.graph, params: BTreeMap::new(), used: BTreeSet::new() };
        let x = constants.scalar(value, NONE, self.diagnostics)?;
        if x < min || (x == min && !included) {
            let wanted = if included { "zero or more" } else { "more than zero" };
            self.push(Diagnostic::error("HQ0308", value.span, format!("{what} is {wanted}, and this is {x}")));
            return None;
        }
        Some(x)
    }

    fn run(
        &mut self,
        run: Option<RunSettings>,
        declared: &Declared,
        robot: &BoundRobot,
    ) -> Option<(RunProgram, String)> {
        let stacks = &declared.stacks;
        let settings = run.unwrap_or_default();
        let stack = match &settings.stack {
            Some(name) => match stacks.iter().position(|s| s.name.value == name.value) {
                Some(i) => i,
                None => {
                    let names = stacks.iter().map(|s| s.name.value.as_str());
                    let d = Diagnostic::error("HQ0201", name.span, format!("there is no stack `{}`", name.value));
                    let d = match suggest(&name.value, names.clone()) {
                        Some(near) => d.help(format!("did you mean `{near}`?")),
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
                    Diagnostic::error("HQ0603", at, "several stacks, and nothing says which one to run")
                        .help(format!("write `run {{ stack {}  duration 10 s }}`", stacks[0].name.value)),
                );
                return None;
            }
        };
        let duration = settings.duration.unwrap_or(10.0);
        if duration / robot.period > 1e9 {
            let at = settings.span.unwrap_or(robot.name.span);
            self.push(Diagnostic::error("HQ0605", at, "the run would have more than a thousand million ticks"));
        }
        let title = settings.title.unwrap_or_else(|| stacks[stack].name.value.clone());
        Some((RunProgram { stack, duration, simulator: settings.simulator }, title))
    }

    /// The table of values: constants folded, moving values and their rates on a tape.
    fn values(&mut self) -> Values {
        let nodes = std::mem::take(&mut self.table.nodes);
        let mut initial = Vec::with_capacity(nodes.len());
        let mut moving = Vec::new();
        for (at, &n) in nodes.iter().enumerate() {
            match self.graph.constant(n) {
                Some(x) => initial.push(x),
                None => {
                    initial.push(0.0);
                    moving.push((at, n, self.graph.rate(n)));
                }
            }
        }
        let roots: Vec<usize> = moving.iter().flat_map(|m| [m.1, m.2]).collect();
        let (ops, index) = self.graph.extract(&roots);
        let outputs = moving.iter().map(|m| Output { at: m.0, value: index[&m.1], rate: index[&m.2] }).collect();
        let tape = Tape { ops, outputs, inputs: self.table.inputs };
        let mut registers = vec![0.0; tape.ops.len()];
        let mut rates = vec![0.0; initial.len()];
        let inputs = vec![0.0; tape.inputs];
        tape.evaluate(runtime::program::Times::default(), &inputs, &mut registers, &mut initial, &mut rates);
        debug_assert!(tape.ops.iter().enumerate().all(|(i, o)| o.operands().iter().flatten().all(|&x| x < i) && !matches!(o, Op::Const(x) if x.is_nan())));
        let finite = |x: f64| x.is_finite().then_some(x);
        let ranges =
            self.table.ranges.iter().map(|&(at, min, max)| ValueRange { at, min: finite(min), max: finite(max) });
        Values { ranges: ranges.collect(), initial, tape, captures: std::mem::take(&mut self.table.captures) }
    }
}

/// The definition of a task that is written in place: with parameters, or just the name of its type.
fn in_place(task: &MemberTask, declared: &[&Task]) -> Option<TaskDefinition> {
    match task {
        MemberTask::Inline(d) => Some(d.clone()),
        MemberTask::Name(n) if declared.iter().any(|t| t.name == *n) => None,
        MemberTask::Name(n) => {
            let kind = stdlib_tasks::find(&n.value)?;
            let kind = Spanned::new(kind.name.to_string(), n.span);
            let body = dsl::tree::Block { span: n.span, ..Default::default() };
            Some(TaskDefinition { kind, args: Vec::new(), body, span: n.span })
        }
    }
}

fn twice(name: &Spanned<String>, first: Span) -> Diagnostic {
    Diagnostic::error("HQ0202", name.span, format!("`{}` is declared twice", name.value)).label(first, "first here")
}

/// The name of a task written in place: its type, with the level and the stack before it where that is not unique.
fn inline_name(stack: &str, level: &Level, d: &TaskDefinition, known: &[(String, TaskDefinition)]) -> String {
    let kind = d.kind.value.as_str();
    let candidates =
        [kind.to_string(), format!("{}.{kind}", level.name.value), format!("{stack}.{}.{kind}", level.name.value)];
    let free = |name: &String| !known.iter().any(|k| k.0 == *name);
    if let Some(name) = candidates.iter().find(|n| free(n)) {
        return name.clone();
    }
    (2..).map(|i| format!("{}.{i}", candidates[2])).find(free).unwrap_or_else(|| kind.to_string())
}

/// What a `run` block says.
#[derive(Debug, Default)]
struct RunSettings {
    stack: Option<Spanned<String>>,
    duration: Option<f64>,
    title: Option<String>,
    simulator: Simulator,
    span: Option<Span>,
}

fn run_settings(run: &Run, span: Span, constants: &mut Constants, diagnostics: &mut Vec<Diagnostic>) -> RunSettings {
    check_keys(&run.body, &["stack", "duration", "title", "simulator"], "a run", diagnostics);
    let mut settings = RunSettings { span: Some(span), ..RunSettings::default() };
    for e in &run.body.entries {
        match e.key.value.as_str() {
            "stack" => match text_of(&e.value) {
                Some(name) => settings.stack = Some(Spanned::new(name.to_string(), e.value.span)),
                None => diagnostics.push(Diagnostic::error("HQ0304", e.value.span, "`stack` is the name of a stack")),
            },
            "duration" => {
                settings.duration = constants.scalar(&e.value, TIME, diagnostics);
                if settings.duration.is_some_and(|d| d <= 0.0) {
                    diagnostics.push(Diagnostic::error("HQ0308", e.value.span, "a run lasts longer than nothing"));
                }
            }
            "title" => settings.title = text_of(&e.value).map(str::to_string),
            "simulator" => {
                if let Some(b) = robot_binding::block_of(&e.value, "`simulator`", diagnostics) {
                    settings.simulator = simulator(b, constants, diagnostics);
                }
            }
            _ => {}
        }
    }
    settings
}

fn simulator(block: &dsl::tree::Block, constants: &mut Constants, diagnostics: &mut Vec<Diagnostic>) -> Simulator {
    check_keys(block, &["lag", "noise", "seed"], "the simulator", diagnostics);
    let mut s = Simulator::default();
    for e in &block.entries {
        let wanted = match e.key.value.as_str() {
            "lag" => TIME,
            "noise" => stdlib_tasks::dimension::ANGLE,
            "seed" => NONE,
            _ => continue,
        };
        let Some(x) = constants.scalar(&e.value, wanted, diagnostics) else { continue };
        if x < 0.0 || (e.key.value == "seed" && (x.fract() != 0.0 || x > 9e15)) {
            let wanted = if e.key.value == "seed" { "a whole number from 0" } else { "zero or more" };
            diagnostics.push(Diagnostic::error(
                "HQ0308",
                e.value.span,
                format!("`{}` is {wanted}, and this is {x}", e.key.value),
            ));
            continue;
        }
        match e.key.value.as_str() {
            "lag" => s.lag = x,
            "noise" => s.noise = x,
            _ => s.seed = x as u64,
        }
    }
    s
}

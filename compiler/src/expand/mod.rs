//! From what was written, in several files, with parameters and repetition, to the plain declarations that the rest of
//! the compiler reads.
//!
//! A file that is imported is a [`module::Module`]: its declarations see each other and what the file imports, and
//! nothing of the file that imports it. A declaration gets into the program where the spec itself declares it or imports
//! it by name, and where one that is in the program uses it. The latter gets a name that nobody can write,
//! `safety.approach`.
//!
//! Everything is a substitution on trees. Each copy is an instance of its text (see [`dsl::Sources`]), so that what is
//! said of it later points at the text, and at the uses that led there.

mod arguments;
mod emit;
mod files;
mod fill;
mod levels;
mod machines;
mod missions;
mod module;
mod repeat;
mod scenarios;
mod stacks;
mod tasks;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use dsl::tree::{
    Human, Let, Level, Machine, Mission, Param, Robot, Run, SafetyField, Scenario, Signal, Spec, Stack, Task, Value,
    Variable,
};
use dsl::{Diagnostic, SourceId, Sources, Span, Spanned, Spelling};

use crate::input::{Input, Texts};
use module::Module;

pub use arguments::parameter_types;
pub(crate) use arguments::{TYPES, quantity, type_of};
pub(crate) use files::read_file;
pub(crate) use fill::parts;

/// Most nodes that copies may have together.
pub(crate) const MAX_NODES: usize = 100_000;

/// Most uses inside each other.
const MAX_DEPTH: usize = 64;

/// A named value, in an order in which each uses only earlier ones.
#[derive(Clone, Debug)]
pub(crate) enum Named {
    /// A param.
    Param(Param),
    /// A named expression.
    Let(Let),
    /// A signal.
    Signal(Signal),
    /// A human.
    Human(Human),
    /// A safety field.
    Field(SafetyField),
    /// A variable of the machine.
    Variable(Variable),
}

/// A quantity given for a parameter of a task or stack, whose type is known only when expressions are.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    /// What was given.
    pub value: Value,
    /// The parameter, and the task or stack.
    pub what: String,
    /// The name of its type.
    pub ty: Spanned<String>,
}

/// The plain declarations of a spec.
#[derive(Debug, Default)]
pub(crate) struct Expanded {
    /// Params, lets, signals, humans and safety fields, each behind those that it uses.
    pub values: Vec<Named>,
    /// Robots, without those that others are made from.
    pub robots: Vec<Robot>,
    /// Tasks.
    pub tasks: Vec<Task>,
    /// Stacks.
    pub stacks: Vec<Stack>,
    /// Machines, each with the stacks that its states name by their names in the program.
    pub machines: Vec<Machine>,
    /// Missions, their repetitions unrolled.
    pub missions: Vec<Mission>,
    /// Runs.
    pub runs: Vec<(Run, Span)>,
    /// Scenarios, each with its expectations as they were written.
    pub scenarios: Vec<(Scenario, Vec<String>)>,
    /// What the spec imports by name, each with the place of that.
    pub imported: BTreeMap<(Class, String), Span>,
    /// Tasks that stand in levels and could not be expanded; the diagnostics said why.
    pub failed: BTreeSet<String>,
    /// What was given for parameters.
    pub given: Vec<Given>,
    /// Stacks with parameters, which are no stacks until others are made from them.
    pub patterns: BTreeMap<String, Span>,
    /// False where a part of the spec is missing, so that nothing can be said of what is not there.
    pub whole: bool,
    /// False where other files are missing, or where it is too large: nothing more can be said.
    pub usable: bool,
    /// Levels of stacks that others are made from, as far as those replace or remove them.
    pub discarded: Vec<Level>,
    /// The spelling of each file.
    pub spellings: BTreeMap<SourceId, Spelling>,
}

/// The kinds of name; params, lets, signals, humans and safety fields share one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    /// Params, lets, signals, humans and safety fields.
    Value,
    /// Robots.
    Robot,
    /// Tasks.
    Task,
    /// Stacks.
    Stack,
    /// Machines.
    Machine,
    /// Missions.
    Mission,
}

impl Class {
    /// What a person calls it.
    pub fn word(self) -> &'static str {
        match self {
            Class::Value => "value",
            Class::Robot => "robot",
            Class::Task => "task",
            Class::Stack => "stack",
            Class::Machine => "machine",
            Class::Mission => "mission",
        }
    }
}

/// The state of an expansion.
pub(crate) struct Expander<'a> {
    input: &'a Input<'a>,
    /// Texts that stand for those of files.
    texts: &'a Texts,
    sources: &'a mut Sources,
    diagnostics: &'a mut Vec<Diagnostic>,
    modules: Vec<Module>,
    /// Files by their place on the disk, `None` for one that is being read.
    files: BTreeMap<PathBuf, Option<usize>>,
    out: Expanded,
    /// What is in the program, under its name there; `None` while it is worked out.
    emitted: BTreeMap<(usize, Class, String), Option<String>>,
    /// The names under which the spec itself sees what others declare.
    visible: BTreeMap<(usize, Class, String), String>,
    /// Tasks and stacks with parameters that were used.
    used: BTreeSet<(usize, Class, String)>,
    /// Uses of tasks with parameters, and the task that came of each.
    instances: Vec<tasks::Instance>,
    /// The uses of each task, by a text that equal arguments have in common.
    alike: BTreeMap<(usize, usize, String), Vec<usize>>,
    /// The names of all tasks of the program.
    task_names: BTreeSet<String>,
    /// The last number that was put behind a name which was taken.
    numbered: BTreeMap<String, usize>,
    /// What is being expanded: recursion would not end.
    active: Vec<(usize, Class, String)>,
    /// What was found to use itself.
    circles: BTreeSet<(usize, Class, String)>,
    /// Nodes that were copied so far.
    nodes: usize,
}

/// Expands the spec of an input, which stands in the text `source`.
pub(crate) fn expand(
    (input, texts): (&Input, &Texts),
    source: SourceId,
    spec: Spec,
    sources: &mut Sources,
    diagnostics: &mut Vec<Diagnostic>,
) -> Expanded {
    let mut e = Expander::new((input, texts), sources, diagnostics);
    e.spec(source, spec);
    e.out
}

/// The files that a spec reads, as far as they can be found: those that it imports, the URDFs and files of layers that are
/// named, the recordings of its scenarios, and the specs that working robots of its missions run, with all that these read.
pub fn files(input: &Input) -> Vec<PathBuf> {
    let (mut files, run) = files_and_specs(input);
    for path in run {
        if let (Some(spelling), Ok(bytes)) = (Spelling::of_path(&path), read_file(&path)) {
            let (name, text) = (path.display().to_string(), String::from_utf8_lossy(&bytes).into_owned());
            let folder = path.parent().unwrap_or(Path::new(""));
            // What these run in their turn counts for nothing.
            files.extend(files_and_specs(&Input { name: &name, text: &text, spelling, folder, set: &[], ..*input }).0);
        }
        files.push(path);
    }
    files
}

/// The files that a spec reads but for the specs that it runs, and these.
fn files_and_specs(input: &Input) -> (Vec<PathBuf>, BTreeSet<PathBuf>) {
    let (mut sources, mut diagnostics, none) = (Sources::default(), Vec::new(), Texts::new());
    let source = sources.add(input.name, input.text);
    let (spec, _) = dsl::parse(source, input.text, input.spelling);
    let mut e = Expander::new((input, &none), &mut sources, &mut diagnostics);
    e.read(source, spec);
    let mut files: Vec<PathBuf> = e.files.keys().cloned().collect();
    for module in &e.modules {
        files.extend(module.urdfs().map(|urdf| input.folder.join(&module.folder).join(urdf)));
        files.extend(module.layers().map(|layers| input.folder.join(&module.folder).join(layers)));
        files.extend(module.missing.iter().cloned());
    }
    files.extend(e.modules.first().into_iter().flat_map(Module::recordings).map(|file| input.folder.join(file)));
    let run =
        |m: &Module| m.workers().into_iter().map(|spec| input.folder.join(&m.folder).join(spec)).collect::<Vec<_>>();
    let run = e.modules.iter().flat_map(run).collect();
    (files, run)
}

impl<'a> Expander<'a> {
    fn new(
        (input, texts): (&'a Input, &'a Texts),
        sources: &'a mut Sources,
        diagnostics: &'a mut Vec<Diagnostic>,
    ) -> Self {
        Expander {
            input,
            texts,
            sources,
            diagnostics,
            modules: Vec::new(),
            files: BTreeMap::new(),
            out: Expanded { whole: true, usable: true, ..Expanded::default() },
            emitted: BTreeMap::new(),
            visible: BTreeMap::new(),
            used: BTreeSet::new(),
            instances: Vec::new(),
            alike: BTreeMap::new(),
            task_names: BTreeSet::new(),
            numbered: BTreeMap::new(),
            active: Vec::new(),
            circles: BTreeSet::new(),
            nodes: 0,
        }
    }

    fn push(&mut self, d: Diagnostic) {
        self.diagnostics.push(d);
    }

    /// Reports something that leaves a hole in the spec.
    fn fail(&mut self, d: Diagnostic) {
        self.out.whole = false;
        self.push(d);
    }

    /// Counts copied nodes; false where there are too many, which is said once.
    fn count(&mut self, at: Span) -> bool {
        self.nodes += 1;
        if self.nodes == MAX_NODES + 1 {
            self.out.usable = false;
            let d = Diagnostic::error("HQ0218", at, format!("the spec expands to more than {MAX_NODES} nodes"));
            self.fail(d.here("expanded up to here").help("repeat less, or use fewer declarations with parameters"));
        }
        self.nodes <= MAX_NODES
    }
}

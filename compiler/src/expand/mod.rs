//! Expands a spec with several files, parameters and repetitions to the plain declarations that the rest of the
//! compiler reads.
//!
//! An imported file is a [`module::Module`]: its declarations see each other and the imports of the file, and nothing
//! of the file that imports it. A declaration enters the program if the spec itself declares it or imports it by name,
//! or if another declaration of the program uses it. In the last case it has a name that users cannot write,
//! `safety.approach`.
//!
//! The expansion substitutes trees. Each copy is an instance of its text (see [`dsl::Sources`]), so later diagnostics
//! point at the text and at the uses that led there.

mod allowances;
mod arguments;
mod files;
mod instantiate;
mod levels;
mod machines;
mod missions;
mod module;
mod repeat;
mod scenarios;
mod stacks;
mod substitute;
mod tasks;
mod triggers;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use dsl::tree::{
    Coverage, ItemKind, Let, Level, Machine, Mission, NamedBlock, Param, Robot, Run, Scenario, Signal, Spec, Stack,
    Task, Value, Variable,
};
use dsl::{Diagnostic, SourceId, Sources, Span, Spanned, Syntax};

use crate::diagnostics::allowances::Allowance;
use crate::input::{Input, Texts};
use substitute::Frame;

pub use arguments::parameter_types;
pub(crate) use arguments::{TYPES, quantity, type_of};
pub(crate) use files::read_file;
pub(crate) use module::{CLASSES, Module, Target, declared};

/// Maximum number of nodes of all copies.
pub(crate) const MAX_NODES: usize = 100_000;

/// Maximum depth of nested uses.
const MAX_DEPTH: usize = 64;

/// A named value. In their order, each uses only earlier ones.
#[derive(Clone, Debug)]
pub(crate) enum Named {
    /// A param.
    Param(Param),
    /// A named expression.
    Let(Let),
    /// A signal.
    Signal(Signal),
    /// A human, a safety field, an obstacle.
    Block(NamedBlock),
    /// A variable of the machine.
    Variable(Variable),
}

/// A quantity given for a parameter of a task or stack. Its type is checked when expressions are typed.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    /// The argument.
    pub value: Value,
    /// Description of the parameter, with its task or stack.
    pub what: String,
    /// Name of the parameter's type.
    pub ty: Spanned<String>,
}

/// The plain declarations of a spec.
#[derive(Debug, Default)]
pub(crate) struct Expanded {
    /// Params, lets, signals, named blocks such as humans, and variables, each after those that it uses.
    pub values: Vec<Named>,
    /// Robots from which no other robot is derived.
    pub robots: Vec<Robot>,
    /// Tasks.
    pub tasks: Vec<Task>,
    /// Stacks.
    pub stacks: Vec<Stack>,
    /// Machines; their states name stacks by the names in the program.
    pub machines: Vec<Machine>,
    /// Missions with unrolled repetitions.
    pub missions: Vec<Mission>,
    /// Runs.
    pub runs: Vec<(Run, Span)>,
    /// Demands on limits, each with the span of its declaration.
    pub coverage: Vec<(Coverage, Span)>,
    /// Scenarios, each with the source texts of its expectations.
    pub scenarios: Vec<(Scenario, Vec<String>)>,
    /// Declarations that the spec imports by name, with the span of the import.
    pub imported: BTreeMap<(Class, String), Span>,
    /// Tasks in levels that failed to expand, with diagnostics.
    pub failed: BTreeSet<String>,
    /// Quantities given for parameters.
    pub given: Vec<Given>,
    /// Stacks with parameters, which become stacks only when they are instantiated.
    pub patterns: BTreeMap<String, Span>,
    /// False if a part of the spec is missing, so missing declarations must not be reported.
    pub whole: bool,
    /// False if other files are missing, or if the spec is too large: compilation stops.
    pub usable: bool,
    /// Levels of base stacks that derived stacks replace or remove.
    pub discarded: Vec<Level>,
    /// Warnings that the files allow.
    pub allowances: Vec<Allowance>,
    /// Syntax of each file.
    pub syntaxes: BTreeMap<SourceId, Syntax>,
}

/// Name spaces. Params, lets, signals, named blocks such as humans, and variables share one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    /// Params, lets, signals, named blocks such as humans, and variables.
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
    /// Name of the class in messages.
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

/// State of an expansion.
pub(crate) struct Expander<'a> {
    input: &'a Input<'a>,
    /// Texts that replace the contents of files.
    texts: &'a Texts,
    sources: &'a mut Sources,
    diagnostics: &'a mut Vec<Diagnostic>,
    modules: Vec<Module>,
    /// Modules of files, by canonical path; `None` while a file is being read.
    files: BTreeMap<PathBuf, Option<usize>>,
    out: Expanded,
    /// Names in the program of emitted declarations; `None` during the emission.
    emitted: BTreeMap<(usize, Class, String), Option<String>>,
    /// Names under which the spec itself sees imported declarations.
    visible: BTreeMap<(usize, Class, String), String>,
    /// Tasks and stacks with parameters that are used.
    used: BTreeSet<(usize, Class, String)>,
    /// Uses of tasks with parameters, each with the resulting task.
    instances: Vec<tasks::Instance>,
    /// Indices into `instances` for each task, by the digest of the arguments.
    alike: BTreeMap<(usize, usize, String), Vec<usize>>,
    /// Names of all tasks of the program.
    task_names: BTreeSet<String>,
    /// Last number that was appended to a name to make it unique.
    numbered: BTreeMap<String, usize>,
    /// Declarations under expansion, to detect recursion.
    active: Vec<(usize, Class, String)>,
    /// Declarations on a reported cycle of uses.
    circles: BTreeSet<(usize, Class, String)>,
    /// Number of copied nodes.
    nodes: usize,
}

/// Expands the spec of an input, which is stored in the source `source`.
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

/// Reads a spec and the files that it imports, the spec first, with the scope of each. In the declarations, missions
/// have unrolled repetitions.
pub(crate) fn read_files(
    (input, texts): (&Input, &Texts),
    source: SourceId,
    spec: Spec,
    sources: &mut Sources,
) -> Vec<Module> {
    let mut diagnostics = Vec::new();
    let mut e = Expander::new((input, texts), sources, &mut diagnostics);
    e.read(source, spec);
    for m in 0..e.modules.len() {
        for i in 0..e.modules[m].items.len() {
            if let ItemKind::Mission(mission) = &e.modules[m].items[i].kind {
                let mission = mission.clone();
                let copy = e.copied_mission(&mission, &mut Frame::of(m));
                e.modules[m].items[i].kind = ItemKind::Mission(copy);
            }
        }
    }
    e.modules
}

/// Returns the existing files that a spec reads: imported files, URDFs, files of layers, maps with their images, the recordings of its
/// scenarios, and the specs that workers of its missions run, with the files that these read.
pub fn files(input: &Input) -> Vec<PathBuf> {
    let (mut files, run) = files_and_specs(input);
    for path in run {
        if let (Some(syntax), Ok(bytes)) = (Syntax::of_path(&path), read_file(&path)) {
            let (name, text) = (path.display().to_string(), String::from_utf8_lossy(&bytes).into_owned());
            let folder = path.parent().unwrap_or(Path::new(""));
            // Specs that these run in turn are ignored.
            files.extend(files_and_specs(&Input { name: &name, text: &text, syntax, folder, set: &[], ..*input }).0);
        }
        files.push(path);
    }
    files
}

/// Files that a spec reads, and separately the specs that it runs.
fn files_and_specs(input: &Input) -> (Vec<PathBuf>, BTreeSet<PathBuf>) {
    let (mut sources, mut diagnostics, none) = (Sources::default(), Vec::new(), Texts::new());
    let source = sources.add(input.name, input.text);
    let (spec, _) = dsl::parse(source, input.text, input.syntax);
    let mut e = Expander::new((input, &none), &mut sources, &mut diagnostics);
    e.read(source, spec);
    let mut files: Vec<PathBuf> = e.files.keys().cloned().collect();
    for module in &e.modules {
        let described = module.urdfs().chain(module.srdfs());
        files.extend(described.map(|file| input.folder.join(&module.folder).join(file)));
        files.extend(module.layers().map(|layers| input.folder.join(&module.folder).join(layers)));
        for map in module.maps().map(|map| input.folder.join(&module.folder).join(map)) {
            let text = read_file(&map).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
            let image = text.ok().and_then(|text| mission::occupancy::image_path(&text));
            files.extend(image.map(|image| map.parent().unwrap_or(Path::new("")).join(image)));
            files.push(map);
        }
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

    /// Reports an error after which a part of the spec is missing.
    fn fail(&mut self, d: Diagnostic) {
        self.out.whole = false;
        self.push(d);
    }

    /// Counts copied nodes; returns false if there are too many, which is reported once.
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

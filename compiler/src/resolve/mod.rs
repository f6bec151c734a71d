//! Resolves the names of a spec to symbols, also in a text with errors.
//!
//! [`resolve`] returns every symbol that the spec, its imports and the specs of its workers declare, and every
//! reference of the spec itself. Imports and the names of declarations come from the scopes of `expand`, which the
//! compilation uses too; the tables of [`crate::sections`] say which keys hold names. A name that nothing declares is
//! recorded as unknown. Parts of the tree that could not be parsed are skipped.

mod context;
mod declare;
mod expressions;
mod imports;
mod machines;
mod missions;
mod people;
mod robots;
mod sections;
mod several_robots;
mod srdf;
mod stacks;
mod symbols;
mod tasks;
mod urdf;
mod vocabulary;
mod walk;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use dsl::tree::{Spec, Unit, Value};
use dsl::{Diagnostic, SourceId, Sources, Syntax};
use stdlib_tasks::params::ParamInfo;
use stdlib_tasks::task::{TaskKind, TaskOutput};

use crate::expand::{Class, read_files};
use crate::input::{Input, Texts};
use crate::lowering::Verb;
use crate::sections::{Argument, Key};

pub use context::{CURSOR, CompletionContext, Offered};
pub use symbols::{FileId, Formal, Symbol, SymbolId, SymbolKind};
pub use urdf::{Urdf, UrdfPart, read_urdf};
pub use vocabulary::{BUILT_IN, FAULTS, FRAME_FIELDS, MEASURED, PRESENT, TRIGGERS, VALUE_FIELDS, Word, built_in};

/// Meaning of a word.
#[derive(Clone, Debug)]
pub enum Meaning {
    /// A symbol; for a name that an import renames, the [`SymbolId`] of the import.
    Symbol(SymbolId),
    /// A name that nothing declares, where a symbol of this kind is expected.
    Unknown(SymbolKind, String),
    /// The path of a file; `None` if it cannot be read.
    File(Option<FileId>),
    /// A task type.
    TaskType(&'static TaskKind),
    /// A parameter of a task type.
    Parameter(&'static TaskKind, &'static ParamInfo),
    /// An output of a task type.
    Output(&'static TaskKind, &'static TaskOutput),
    /// An argument of a function.
    Argument(&'static Argument),
    /// A key or keyword.
    Key(&'static Key),
    /// A built-in function or name.
    BuiltIn(String),
    /// A verb of an action.
    Verb(&'static Verb),
    /// The unit of a quantity, with the whole quantity.
    Unit(Unit, Value),
}

/// An occurrence of a word in the spec, with its meaning.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Range of bytes.
    pub place: Range<usize>,
    /// False if the range is a whole YAML scalar of which the word is only a part, or if the word is written with
    /// holes.
    pub exact: bool,
    /// True if this is the declaration.
    pub declares: bool,
    /// Meaning.
    pub meaning: Meaning,
}

/// A file with symbols.
#[derive(Clone, Debug)]
pub struct File {
    /// Path; that of the input for the spec itself.
    pub path: PathBuf,
    /// The text in [`Resolution::sources`].
    pub source: SourceId,
    /// Syntax; `None` for a URDF or an SRDF.
    pub syntax: Option<Syntax>,
}

/// Symbols and references of a spec.
#[derive(Debug)]
pub struct Resolution {
    /// The syntax tree of the spec.
    pub spec: Rc<Spec>,
    /// Syntax errors of the spec.
    pub diagnostics: Vec<Diagnostic>,
    /// The spec, the files that it imports, the specs that its workers run with their imports, and the URDF.
    pub files: Vec<File>,
    /// Texts of the files.
    pub sources: Sources,
    /// Imported files and specs of workers that could not be found.
    pub missing: Vec<PathBuf>,
    /// Symbols of all files.
    pub symbols: Vec<Symbol>,
    /// References of the spec, in source order. An imported name that several symbols have is one reference for each.
    pub references: Vec<Reference>,
    /// Completion context at [`CURSOR`], if the text contains it.
    pub context: Option<CompletionContext>,
    /// Names that the spec sees.
    names: BTreeMap<SymbolKind, BTreeSet<(String, SymbolId)>>,
}

impl Resolution {
    /// Returns the word that contains a byte or ends there; the shortest if several overlap.
    pub fn at(&self, byte: usize) -> Option<&Reference> {
        let holds = |r: &&Reference| r.place.start <= byte && byte <= r.place.end;
        self.references.iter().filter(holds).min_by_key(|r| (r.place.len(), usize::from(r.place.end == byte)))
    }

    /// Returns a symbol.
    pub fn symbol(&self, id: SymbolId) -> &Symbol {
        &self.symbols[id.0]
    }

    /// Returns the declared symbol behind imports that rename it.
    pub fn origin(&self, id: SymbolId) -> SymbolId {
        symbols::origin(&self.symbols, id)
    }

    /// Returns the file of a symbol.
    pub fn file_of(&self, id: SymbolId) -> &File {
        &self.files[self.symbol(id).file.0]
    }

    /// Returns the text of a file.
    pub fn text(&self, file: &File) -> &str {
        self.sources.get(file.source).map_or("", |s| &s.text)
    }

    /// Returns the names of this kind that the spec sees, with their symbols, in alphabetical order.
    pub fn visible(&self, kind: SymbolKind) -> impl Iterator<Item = (&str, SymbolId)> {
        self.names.get(&kind).into_iter().flatten().map(|(name, id)| (name.as_str(), *id))
    }

    /// Returns the symbol of a kind that the spec sees under a name.
    pub fn named(&self, kind: SymbolKind, name: &str) -> Option<SymbolId> {
        self.visible(kind).find(|(n, _)| *n == name).map(|(_, id)| id)
    }

    /// Returns the name of a symbol with those of its containers, `harvest.work.near`.
    pub fn path(&self, id: SymbolId) -> String {
        let symbol = self.symbol(id);
        match symbol.container {
            Some(outer) => format!("{}.{}", self.path(outer), symbol.name),
            None => symbol.name.clone(),
        }
    }
}

/// Resolves the names of a spec. `texts` replaces the contents of files, and `urdf` reads the URDF of the robot.
pub fn resolve(input: &Input, texts: &Texts, urdf: &dyn Fn(&Path) -> Option<Rc<Urdf>>) -> Resolution {
    let mut sources = Sources::default();
    let source = sources.add(input.name, input.text);
    let (spec, diagnostics) = dsl::parse(source, input.text, input.syntax);
    let whole = Rc::new(spec.clone());
    let modules = read_files((input, texts), source, spec, &mut sources);
    let spec = modules.first().map(|m| m.spec.clone()).unwrap_or_default();
    let out = Resolution {
        spec: whole,
        diagnostics,
        files: Vec::new(),
        sources,
        missing: modules.iter().flat_map(|m| m.missing.iter().cloned()).collect(),
        symbols: Vec::new(),
        references: Vec::new(),
        context: None,
        names: BTreeMap::new(),
    };
    let mut resolver = Resolver::new(out, input);
    resolver.add(&modules, input);
    modules.iter().take(1).for_each(|own| resolver.workers(own, input, texts));
    resolver.urdf(&modules, input, urdf);
    resolver.srdf(&modules, input);
    resolver.spec(&spec);
    resolver.holes();
    resolver.finish()
}

/// Names that a file sees.
#[derive(Debug, Default)]
struct Scope {
    /// Declared and imported names.
    declared: BTreeMap<(Class, String), SymbolId>,
    /// Parts of the robots that it declares or imports.
    parts: BTreeMap<(SymbolKind, String), SymbolId>,
    /// Events that actions of its machines raise.
    raised: BTreeMap<String, SymbolId>,
}

/// State of a resolution.
struct Resolver<'t> {
    out: Resolution,
    /// Text of the spec.
    text: &'t str,
    syntax: Syntax,
    /// Scope of each file.
    scopes: Vec<Scope>,
    /// Contained symbols, by the container and the name.
    inside: BTreeMap<(SymbolId, String), Vec<SymbolId>>,
    /// Contained symbols, in source order.
    children: BTreeMap<SymbolId, Vec<SymbolId>>,
    /// The stack from which a stack is derived.
    bases: BTreeMap<SymbolId, SymbolId>,
    /// Specs that workers run.
    controllers: BTreeMap<SymbolId, FileId>,
    /// Files that the spec names, by the path as written.
    named_files: BTreeMap<String, FileId>,
    /// Links and joints of the URDF; `None` if it cannot be read.
    links: Option<BTreeMap<String, SymbolId>>,
    joints: Option<BTreeMap<String, SymbolId>>,
    /// The SRDF, if it can be read.
    srdf: Option<FileId>,
    /// Names of coordinates and degrees of freedom of the robots' bases.
    base_names: BTreeSet<&'static str>,
    /// Parameters and variables of repetitions in scope, innermost last.
    bound: Vec<(String, SymbolId)>,
    /// The same, each with the part of the text in which it fills holes.
    holes: Vec<(Range<usize>, String, SymbolId)>,
    /// Context of the current part of the spec.
    around: Around,
}

/// Context of the current part of a spec.
#[derive(Clone, Debug, Default)]
struct Around {
    /// True inside an expression that may depend on the robot's current state.
    state: bool,
    /// True inside an expectation.
    expected: bool,
    /// True inside a condition of a machine.
    condition: bool,
    /// True inside a mission, or a scenario that executes one.
    of_mission: bool,
    /// The mission of the scenario, if it is known.
    mission: Option<SymbolId>,
    /// Roles of its members that can be named; all if there are none.
    roles: &'static [&'static str],
    /// The machine or state; in a scenario, its machine.
    holder: Option<SymbolId>,
    /// Arguments of the function around.
    arguments: &'static [Argument],
    /// The human that a block is of.
    human: Option<SymbolId>,
    /// The spec that the enclosing worker runs.
    controller: Option<FileId>,
}

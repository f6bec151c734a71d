//! A first project for a robot: what `hierarq init` proposes.
//!
//! A URDF says how a robot is built, and not what it is for. What a spec says beyond it is proposed here from the tree of
//! joints, their limits and their names: arms and tool frames, a base, a home configuration, a stack of limits and a small
//! motion. All of it is a guess that compiles, and stands in the spec for the user to change.

mod files;
mod home;
mod limbs;
mod names;
mod spec;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use compiler::{Compiled, Input, Report};
use dsl::{SourceId, Spelling};
use robot::{Base, Model, Options};

use files::Place;
use spec::Plan;

/// The arm that stands in where no URDF is given.
static EXAMPLE: &str = include_str!("../../examples/robots/arm7.urdf");

/// Largest URDF that is read, in bytes: as large as one that a spec names.
const MAX_URDF: u64 = 64 << 20;

/// What is asked for.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// The folder of the project.
    pub folder: PathBuf,
    /// The URDF; an example arm where there is none.
    pub urdf: Option<PathBuf>,
    /// What carries the root link; a guess where nothing is said.
    pub base: Option<Base>,
    /// Write YAML instead of the native spelling.
    pub yaml: bool,
    /// Where `package://` addresses are looked for, beside the usual places.
    pub package_paths: Vec<PathBuf>,
}

/// A project that could be written.
#[derive(Clone, Debug)]
pub struct Project {
    /// Files by their path, with their text; the spec is the last.
    pub files: Vec<(PathBuf, String)>,
    /// What the compiler says of the spec: warnings, if anything.
    pub report: Report,
    /// What was decided, a line each, for the user to judge.
    pub remarks: Vec<String>,
}

/// Why there is no project.
#[derive(Clone, Debug)]
pub enum Refusal {
    /// The URDF, or every spec that was proposed for it, has errors.
    Wrong(Box<Report>),
    /// Something else, in words.
    Trouble(String),
}

/// Proposes a project. Writes nothing.
///
/// # Errors
/// The URDF cannot be read, or no spec that was proposed for it compiles.
pub fn propose(request: &Request) -> Result<Project, Refusal> {
    let (text, place) = match &request.urdf {
        None => (EXAMPLE.to_string(), Place::example(&request.folder)),
        Some(path) => {
            let bytes = ::files::read(path, MAX_URDF)
                .map_err(|e| Refusal::Trouble(format!("cannot read the URDF {}: {e}", path.display())))?;
            let text = String::from_utf8(bytes)
                .map_err(|_| Refusal::Trouble(format!("{} is not UTF-8 text", path.display())))?;
            let place = Place::of(path, &text, request).map_err(Refusal::Trouble)?;
            (text, place)
        }
    };
    let spelling = if request.yaml { Spelling::Yaml } else { Spelling::Hq };
    let mut first = None;
    for variant in variants(request, &text) {
        let Some(plan) = Plan::new(&text, &variant) else { continue };
        let compiled = place.source.as_ref().map(|source| compile(&plan.text(source, None), &place, request));
        let report = match compiled {
            Some(Compiled { program: None, report, .. }) => {
                first.get_or_insert(report);
                continue;
            }
            Some(Compiled { report, .. }) => report,
            // The example: there is no file of it yet, and a test compiles what is written.
            None => Report::default(),
        };
        let written = plan.text(&place.written, place.package_path.as_deref());
        let (tree, _) = dsl::parse(SourceId(0), &written, Spelling::Hq);
        let ending = if request.yaml { "yaml" } else { "hq" };
        let mut files: Vec<(PathBuf, String)> = place.copy.iter().map(|to| (to.clone(), text.clone())).collect();
        files.push((request.folder.join(format!("{}.{ending}", plan.name)), dsl::print(&tree, spelling)));
        return Ok(Project { files, report, remarks: plan.remarks() });
    }
    Err(Refusal::Wrong(Box::new(first.unwrap_or_else(|| complaint(&place, request)))))
}

/// Ways to read a robot, the most helpful first; the next is tried where one does not compile.
fn variants(request: &Request, text: &str) -> Vec<Variant> {
    let fixed = Base::Fixed;
    let read = |base, lock: &BTreeMap<String, f64>| {
        Model::from_urdf(text, &Options { base, lock: lock.clone(), ..Options::default() }).ok().map(|m| m.0)
    };
    let none = BTreeMap::new();
    let (guess, wheels) = match read(fixed, &none) {
        Some(model) => limbs::carried(&model),
        None => (fixed, BTreeMap::new()),
    };
    let base = request.base.unwrap_or(guess);
    let on_wheels = matches!(base, Base::Planar | Base::Unicycle);
    let lock = if on_wheels { wheels } else { none };
    let guessed = request.base.is_none();
    let mut out = Vec::new();
    for (base, lock) in [(base, lock), (fixed, BTreeMap::new())] {
        for arms in [true, false] {
            out.push(Variant { base, guessed, lock: lock.clone(), arms });
        }
        if !guessed {
            break;
        }
    }
    out
}

/// A way to read a robot.
#[derive(Clone, Debug)]
struct Variant {
    base: Base,
    guessed: bool,
    lock: BTreeMap<String, f64>,
    arms: bool,
}

fn compile(text: &str, place: &Place, request: &Request) -> Compiled {
    let mut package_paths = request.package_paths.clone();
    package_paths.extend(place.package_folder.clone());
    compiler::compile(&Input {
        name: "the proposed spec",
        text,
        spelling: Spelling::Hq,
        folder: Path::new(""),
        set: &[],
        package_paths: &package_paths,
    })
}

/// What the compiler says of a URDF that is no robot.
fn complaint(place: &Place, request: &Request) -> Report {
    let urdf = spec::quoted(place.source.as_deref().unwrap_or_default());
    let text = format!("hierarq 1\nrobot robot {{ urdf {urdf}  rate 100 Hz }}\nstack s {{ level l {{ x }} }}\n");
    let mut report = compile(&text, place, request).report;
    // What the stand-in lacks is nobody's mistake.
    report.diagnostics.retain(|d| d.code.starts_with("HQ04"));
    report
}

//! Proposes a first project for a robot, for `hierarq init`.
//!
//! A URDF describes how a robot is built, and not its purpose. The other parts of a spec are guessed from the tree of
//! joints, their limits and their names: arms and tool frames, a base, a home configuration, a stack of limits and a
//! small motion. The result compiles, and the user is expected to change it.

mod files;
mod home;
mod limbs;
mod names;
mod spec;
mod srdf;
mod xacro;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use compiler::{Compiled, Input, Report};
use dsl::{SourceId, Syntax};
use robot::{Base, Model, Options};

use files::Place;
use spec::Plan;

/// Example arm, used if no URDF is given.
static EXAMPLE: &str = include_str!("../../examples/robots/arm7.urdf");

/// Maximum size of a URDF (bytes), the same as for a URDF of a spec.
const MAX_URDF: u64 = 64 << 20;

/// Request for a project.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Folder of the project.
    pub folder: PathBuf,
    /// URDF; the example arm if `None`.
    pub urdf: Option<PathBuf>,
    /// SRDF; one that is found beside the URDF if `None`.
    pub srdf: Option<PathBuf>,
    /// Base of the robot; guessed if `None`.
    pub base: Option<Base>,
    /// Writes YAML instead of `*.hq` syntax.
    pub yaml: bool,
    /// Folders in which `package://` addresses are searched, besides the usual ones.
    pub package_paths: Vec<PathBuf>,
    /// Arguments for the expansion of a URDF or an SRDF that is a xacro file: `NAME:=VALUE`.
    pub xacro_arguments: Vec<String>,
}

/// A proposed project.
#[derive(Clone, Debug)]
pub struct Project {
    /// Files with their paths and texts; the spec is the last.
    pub files: Vec<(PathBuf, String)>,
    /// Report of the compiler for the spec, which may contain warnings.
    pub report: Report,
    /// Decisions for the user to review, one per line.
    pub remarks: Vec<String>,
}

/// Reason why no project is proposed.
#[derive(Clone, Debug)]
pub enum Refusal {
    /// The URDF, or every spec proposed for it, has errors.
    Wrong(Box<Report>),
    /// Another problem.
    Trouble(String),
}

/// Proposes a project, without writing files.
///
/// # Errors
/// The URDF cannot be read, or no spec proposed for it compiles.
pub fn propose(request: &Request) -> Result<Project, Refusal> {
    let mut expanded = None;
    let (text, place) = match &request.urdf {
        None => (EXAMPLE.to_string(), Place::example(&request.folder)),
        Some(path) if xacro::is_xacro(path) => {
            let made = xacro::expand(path, &request.xacro_arguments, "urdf").map_err(Refusal::Trouble)?;
            let place = Place::expanded(path, &made, request).map_err(Refusal::Trouble)?;
            (expanded.insert(made).text.clone(), place)
        }
        Some(path) => {
            let bytes = ::files::read(path, MAX_URDF)
                .map_err(|e| Refusal::Trouble(format!("cannot read the URDF {}: {e}", path.display())))?;
            let text = String::from_utf8(bytes)
                .map_err(|_| Refusal::Trouble(format!("{} is not UTF-8 text", path.display())))?;
            let place = Place::of(path, &text, request).map_err(Refusal::Trouble)?;
            (text, place)
        }
    };
    let srdf = described(request).map_err(Refusal::Trouble)?;
    let syntax = if request.yaml { Syntax::Yaml } else { Syntax::Native };
    let mut first = None;
    for variant in variants(request, &text) {
        let Some(mut plan) = Plan::new(&text, &variant) else { continue };
        let compile_plan =
            |plan: &Plan| place.source.as_ref().map(|source| compile(&plan.text(source, None, None), &place, request));
        let mut compiled = compile_plan(&plan);
        let mut unused = None;
        if let (Some(of), Some(Compiled { program: Some(_), .. })) = (&srdf, &compiled) {
            match srdf::add(&mut plan, of, |plan| compile_plan(plan).unwrap_or_default()) {
                Ok(better) => compiled = Some(better),
                Err(wrong) if of.given => return Err(Refusal::Wrong(wrong)),
                // The user did not ask for it.
                Err(_) => {
                    unused = Some(format!("{} has errors, and is not used", of.place.written));
                    plan = Plan::new(&text, &variant).unwrap_or(plan);
                }
            }
        }
        let report = match compiled {
            Some(Compiled { program: None, report, .. }) => {
                first.get_or_insert(report);
                continue;
            }
            Some(Compiled { report, .. }) => report,
            // The example's URDF is not on disk yet, and a test compiles its spec.
            None => Report::default(),
        };
        let described = srdf.as_ref().map(|of| of.place.written.as_str());
        let written = plan.text(&place.written, described, place.package_path.as_deref());
        let (tree, _) = dsl::parse(SourceId(0), &written, Syntax::Native);
        let ending = if request.yaml { "yaml" } else { "hq" };
        let mut files: Vec<(PathBuf, String)> = place.copy.iter().map(|to| (to.clone(), text.clone())).collect();
        let copied = srdf.iter().filter(|_| unused.is_none());
        files.extend(copied.filter_map(|of| Some((of.place.copy.clone()?, of.text.clone()))));
        files.push((request.folder.join(format!("{}.{ending}", plan.name)), dsl::print(&tree, syntax)));
        return Ok(Project { files, report, remarks: plan.remarks().into_iter().chain(unused).collect() });
    }
    Err(Refusal::Wrong(Box::new(first.unwrap_or_else(|| complaint(&place, request)))))
}

/// The SRDF of the request, or the one beside its URDF.
fn described(request: &Request) -> Result<Option<srdf::Source>, String> {
    let beside = request.urdf.as_deref().and_then(srdf::beside);
    let Some(path) = request.srdf.clone().or(beside) else { return Ok(None) };
    let given = request.srdf.is_some();
    if xacro::is_xacro(&path) {
        let made = match xacro::expand(&path, &request.xacro_arguments, "srdf") {
            Ok(made) => made,
            Err(text) if given => return Err(text),
            // The user did not ask for it.
            Err(_) => return Ok(None),
        };
        let place = Place::expanded(&path, &made, request)?;
        return Ok(Some(srdf::Source { place, text: made.text.clone(), given, expanded: Some(made) }));
    }
    let text = srdf::read(&path)?;
    // The text of an SRDF names no meshes: it is copied unless it is in the project.
    let place = Place::of(&path, "", request)?;
    Ok(Some(srdf::Source { place, text, given, expanded: None }))
}

/// Interpretations of a robot, the most helpful first; the next one is tried if one does not compile.
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

/// An interpretation of a robot.
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
        syntax: Syntax::Native,
        folder: Path::new(""),
        set: &[],
        package_paths: &package_paths,
    })
}

/// Diagnostics of the compiler for an invalid URDF.
fn complaint(place: &Place, request: &Request) -> Report {
    let urdf = spec::quoted(place.source.as_deref().unwrap_or_default());
    let text = format!("hierarq 1\nrobot robot {{ urdf {urdf}  rate 100 Hz }}\nstack s {{ level l {{ x }} }}\n");
    let mut report = compile(&text, place, request).report;
    // Errors of the placeholder spec itself are not shown.
    report.diagnostics.retain(|d| d.code.starts_with("HQ04"));
    report
}

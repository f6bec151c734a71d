//! The SRDF of a project: found beside the URDF or given, its posture for home, and a limit that keeps the robot from touching
//! itself.

use std::path::{Path, PathBuf};

use compiler::{Compiled, Report, RobotFacts, robot_facts};
use robot::{Model, Srdf};

use super::files::Place;
use super::spec::{Plan, named};
use super::xacro::{Expanded, is_xacro};

/// Maximum size of an SRDF (bytes), the same as for an SRDF of a spec.
const MAX_SRDF: u64 = 64 << 20;

/// Words in the names of postures that suit home, in order of preference.
static HOMES: &[&str] = &["home", "ready", "default", "initial", "half_sitting", "standing", "rest"];

/// Most pairs that are named in `except`.
const EXCEPTED: usize = 8;

/// Most rows of the proposed limit.
const ROWS: usize = 400;

/// An SRDF of a project.
pub(super) struct Source {
    /// Its source, and the place of its copy.
    pub(super) place: Place,
    pub(super) text: String,
    /// True if the user named it.
    pub(super) given: bool,
    /// The file of its text, if it was expanded, which must outlive the proposal.
    #[expect(dead_code, reason = "the file is removed with it")]
    pub(super) expanded: Option<Expanded>,
}

/// The file beside a URDF that may be its SRDF: of the same name there, or in the folder `srdf` beside that of the URDF.
pub(super) fn beside(urdf: &Path) -> Option<PathBuf> {
    let stem = urdf.file_stem()?;
    let name = Path::new(if is_xacro(urdf) { Path::new(stem).file_stem()? } else { stem }).with_extension("srdf");
    let expandable = name.with_extension("srdf.xacro");
    let folder = urdf.parent().unwrap_or(Path::new(""));
    let names = [Some(&name), is_xacro(urdf).then_some(&expandable)];
    let places = names.into_iter().flatten().flat_map(|name| {
        let other = folder.parent().map(|above| above.join("srdf").join(name));
        [Some(folder.join(name)), other].into_iter().flatten()
    });
    places.into_iter().find(|path| path.is_file())
}

/// Reads an SRDF.
///
/// # Errors
/// It cannot be read as text.
pub(super) fn read(path: &Path) -> Result<String, String> {
    let bytes = ::files::read(path, MAX_SRDF).map_err(|e| format!("cannot read the SRDF {}: {e}", path.display()))?;
    String::from_utf8(bytes).map_err(|_| format!("{} is not UTF-8 text", path.display()))
}

/// Names of postures to start in, the most fitting first.
pub(super) fn homes(text: &str, model: &Model) -> Vec<String> {
    let Ok((srdf, _)) = Srdf::read(text, model) else { return Vec::new() };
    let rank = |name: &str| HOMES.iter().position(|home| name.to_lowercase().contains(home)).unwrap_or(HOMES.len());
    let mut names: Vec<String> = Vec::new();
    for posture in srdf.postures {
        if !names.contains(&posture.name) {
            names.push(posture.name);
        }
    }
    names.sort_by_key(|name| rank(name));
    names
}

/// Adds the SRDF to a plan that compiles: with a posture as home if one holds there, and a limit on the whole robot if it holds.
/// `compile` compiles the text of a plan.
///
/// # Errors
/// The plan does not compile with the SRDF.
pub(super) fn add(
    plan: &mut Plan,
    source: &Source,
    mut compile: impl FnMut(&Plan) -> Compiled,
) -> Result<Compiled, Box<Report>> {
    let mut choices: Vec<Option<String>> = homes(&source.text, plan.model()).into_iter().map(Some).collect();
    choices.push(None);
    let mut found: Option<Compiled> = None;
    for home in choices {
        plan.describe(source.place.source.clone().unwrap_or_default(), home);
        let compiled = compile(plan);
        if compiled.is_good() {
            found = Some(compiled);
            break;
        }
        if found.is_none() && plan.home().is_none() {
            return Err(Box::new(compiled.report));
        }
    }
    let Some(compiled) = found else { return Err(Box::default()) };
    if let Some(program) = &compiled.program {
        plan.start_at(&program.robot.model, &program.robot.home);
        let facts = robot_facts(program, compiled.srdf.as_ref());
        plan.note_groups(facts.groups.iter().map(|group| group.name.clone()).collect());
        if let Some(limit) = limit(&facts) {
            plan.keep_apart(Some(limit));
            let guarded = compile(plan);
            if guarded.is_good() {
                return Ok(guarded);
            }
            plan.keep_apart(None);
        }
    }
    Ok(compile(plan))
}

/// A limit that keeps all pairs of links apart that do not touch at home; `None` if it would have too many rows, or exceptions.
fn limit(facts: &RobotFacts) -> Option<String> {
    let touching: Vec<&[String; 2]> =
        facts.apart.iter().filter(|pair| pair.at_home <= 0.0).map(|pair| &pair.links).collect();
    if facts.open == 0 || facts.rows > ROWS || touching.len() > EXCEPTED || touching.len() == facts.open {
        return None;
    }
    let rest = facts.apart.iter().map(|pair| pair.at_home).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    let d_min = runtime::text::number((500.0 * rest).floor().clamp(0.0, 20.0));
    let except = match touching.is_empty() {
        true => String::new(),
        false => {
            let pairs: Vec<String> = touching.iter().map(|[a, b]| format!("[{}, {}]", named(a), named(b))).collect();
            format!("  except [{}]", pairs.join(", "))
        }
    };
    Some(format!("self_collision {{ between all{except}  d_min {d_min} mm }}"))
}

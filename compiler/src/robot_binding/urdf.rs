//! URDF of a robot: finds the file, reads it, and removes the joints that the spec locks.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, SourceId, Span, Spanned};
use robot::{Base, Model, ReadUrdf, UrdfCode};

use super::home::Home;
use super::lookup::joints;
use super::{Files, JointGroups};
use crate::expr::constants::{Constants, joint_dimension};
use crate::forms::text_of;
use crate::paths::instead_of;
use crate::units;

/// Maximum size of a URDF (bytes).
const MAX_URDF_BYTES: u64 = 64 << 20;

/// Locked joints, each with the position if one is written.
pub(super) type Locks = Vec<(Spanned<String>, Option<Value>)>;

/// Reads `lock [head_pan]` or `lock { head_pan 0.1 rad }`.
pub(super) fn locks(lock: Option<&Value>, diagnostics: &mut Vec<Diagnostic>) -> Locks {
    let Some(lock) = lock else { return Vec::new() };
    match &lock.kind {
        ValueKind::Block(block) => block.entries.iter().map(|e| (e.key.clone(), Some(e.value.clone()))).collect(),
        _ => lock
            .items()
            .iter()
            .filter_map(|v| {
                let name = text_of(v);
                if name.is_none() && !matches!(v.kind, ValueKind::Missing) {
                    let d = Diagnostic::error("HQ0304", v.span, "the name of a joint is needed here");
                    diagnostics.push(match &v.kind {
                        ValueKind::Binary(..) => d.help(super::lookup::pattern_in_quotes()),
                        _ => d.help(Help::with(
                            "write {}, or {}",
                            [
                                Snippet::entry("lock", "[head_pan]"),
                                Snippet::block("lock", [Snippet::entry("head_pan", "0.1 rad")]),
                            ],
                        )),
                    });
                }
                Some((Spanned::new(name?.to_string(), v.span), None))
            })
            .collect(),
    }
}

/// Text of a URDF, with the options for its conversion to a model.
pub(super) struct Urdf {
    text: String,
    source: SourceId,
    span: Span,
    options: robot::Options,
}

/// The entry that names a URDF.
pub(super) fn urdf_example() -> Snippet {
    Snippet::each("urdf \"robots/arm7.urdf\"", "urdf: robots/arm7.urdf")
}

/// Finds the URDF that a robot names, and reads its text.
pub(super) fn open(
    Spanned { value: path_text, span }: &Spanned<String>,
    (base, shapes): (Base, robot::Shapes),
    package_path: Option<&str>,
    files: &mut Files,
) -> Option<Urdf> {
    let span = *span;
    if path_text.trim().is_empty() {
        let d = Diagnostic::error("HQ0401", span, "this names no file").here("an empty text");
        files.diagnostics.push(d.help(Help::with("write the path of the robot's URDF, such as {}", [urdf_example()])));
        return None;
    }
    let path = files.folder.join(path_text);
    let bytes = match read(&path) {
        Ok(b) => b,
        Err(why) => {
            let d = Diagnostic::error("HQ0401", span, format!("cannot read `{path_text}`: {why}"))
                .note("paths are relative to the file that names them");
            files.diagnostics.push(instead_of(d, path_text, &path));
            return None;
        }
    };
    let text = match String::from_utf8(bytes) {
        Ok(t) => t,
        Err(e) => {
            let at = e.utf8_error().valid_up_to();
            files.diagnostics.push(
                Diagnostic::error("HQ0402", span, format!("`{path_text}` is not UTF-8 text: byte {at} is invalid"))
                    .help("save the URDF as UTF-8"),
            );
            return None;
        }
    };
    let source = files.sources.add(path_text, text.clone());
    let mut package_paths: Vec<PathBuf> = files.package_paths.to_vec();
    package_paths.splice(0..0, package_path.map(|path| files.folder.join(path)));
    let urdf_dir = path.parent().map(Path::to_path_buf);
    let cache = Some(files.folder.to_path_buf());
    let options =
        robot::Options { base, urdf_dir, package_paths, read_meshes: true, shapes, cache, ..robot::Options::default() };
    Some(Urdf { text, source, span, options })
}

impl Urdf {
    /// Builds the model with all joints, and returns its warnings. If `to_be_locked`, meshes and warnings are left to
    /// [`Urdf::locked`].
    pub(super) fn whole(&self, to_be_locked: bool, diagnostics: &mut Vec<Diagnostic>) -> Option<ReadUrdf> {
        let options = robot::Options { read_meshes: !to_be_locked, ..self.options.clone() };
        let read = self.model(&options, diagnostics)?;
        Some(if to_be_locked { ReadUrdf { warnings: Vec::new(), ..read } } else { read })
    }

    /// Builds the model with the given joints fixed at the given positions.
    pub(super) fn locked(&self, at: BTreeMap<String, f64>, diagnostics: &mut Vec<Diagnostic>) -> Option<ReadUrdf> {
        self.model(&robot::Options { lock: at, ..self.options.clone() }, diagnostics)
    }

    /// Reports warnings about the file, without those about limits that the spec gives: `model` has the limits of the spec.
    pub(super) fn warn(&self, warnings: &[robot::UrdfMessage], model: &Model, diagnostics: &mut Vec<Diagnostic>) {
        let given = |m: &&robot::UrdfMessage| {
            let dof = m.joint.as_ref().and_then(|j| model.dofs.iter().find(|d| d.name == *j));
            dof.is_some_and(|d| match m.code {
                robot::UrdfCode::NoVelocityLimit => d.velocity.is_finite(),
                robot::UrdfCode::NoLimits => d.lower.is_finite() && d.upper.is_finite(),
                _ => false,
            })
        };
        diagnostics.extend(warnings.iter().filter(|m| !given(m)).map(|m| self.convert(m, false)));
    }

    fn model(&self, options: &robot::Options, diagnostics: &mut Vec<Diagnostic>) -> Option<ReadUrdf> {
        match robot::urdf::read(&self.text, options) {
            Ok(read) => Some(read),
            Err(errors) => {
                diagnostics.extend(errors.iter().map(|m| self.convert(m, true)));
                None
            }
        }
    }

    fn convert(&self, m: &robot::UrdfMessage, error: bool) -> Diagnostic {
        let place = Span::new(self.source, m.span.start, m.span.end);
        let d = if error {
            Diagnostic::error("HQ0402", place, m.text.clone()).label(self.span, "this robot reads it")
        } else {
            let code = match m.code {
                UrdfCode::MeshPieces => "HQ0584",
                UrdfCode::MeshEntry => "HQ0585",
                _ => "HQ0403",
            };
            Diagnostic::warning(code, place, m.text.clone())
        };
        match &m.help {
            Some(h) => d.help(h.clone()),
            None => d,
        }
    }
}

/// Positions of the locked joints, by name: the value of `lock`, or of `home`, or zero; clamped to the joint's limits.
pub(super) fn positions(
    locks: &Locks,
    (whole, groups): (&Model, &JointGroups),
    home: &Home,
    constants: &mut Constants,
    diagnostics: &mut Vec<Diagnostic>,
) -> BTreeMap<String, f64> {
    let mut at: BTreeMap<String, f64> = BTreeMap::new();
    for (name, value) in locks {
        let item = Value { kind: ValueKind::Text(name.value.clone()), span: name.span };
        let Some(found) = joints(std::slice::from_ref(&item), whole, groups, diagnostics) else { continue };
        let dofs: Vec<usize> = found.into_iter().filter(|&i| whole.dofs[i].joint.is_some()).collect();
        if dofs.is_empty() {
            let d = Diagnostic::unknown_name(name.span, "the base cannot be locked here");
            diagnostics.push(d.help(Help::with(
                "write {} for a robot that does not move, or {} in a stack",
                [Snippet::entry("base", "fixed"), Snippet::entry("lock", "[base]")],
            )));
        }
        let values = match value {
            Some(value) => constants.per_joint(value, &dofs, whole, diagnostics).unwrap_or_default(),
            None => Vec::new(),
        };
        let mut outside: BTreeSet<Span> = BTreeSet::new();
        for (k, &i) in dofs.iter().enumerate() {
            let d = &whole.dofs[i];
            // `home` may set the position of a locked joint.
            let (x, written) = match values.get(k) {
                Some((x, span)) => (*x, Some(*span)),
                None => home.of(&d.name).map_or((0.0, None), |(x, span)| (x, Some(span))),
            };
            if let Some(span) = written.filter(|_| x < d.lower || x > d.upper)
                && outside.insert(span)
            {
                let unit = joint_dimension(whole, i);
                let text = format!("`{}` is locked at {}, outside its limits", d.name, units::shown(x, unit));
                let allowed = units::shown_range(d.lower, d.upper, unit);
                let mut error = Diagnostic::error("HQ0404", span, text).here(format!("allowed are {allowed}"));
                if !(name.span.start <= span.start && span.start <= name.span.end) && value.is_none() {
                    error = error.label(name.span, "locked here");
                }
                diagnostics.push(error.help("lock it inside its limits"));
            }
            at.insert(d.name.clone(), x.max(d.lower).min(d.upper));
        }
    }
    at
}

/// Reads a file, or returns the reason why it cannot be read.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, &'static str> {
    files::read(path, MAX_URDF_BYTES).map_err(|e| match e.kind() {
        std::io::ErrorKind::FileTooLarge => "it is larger than 64 MiB",
        _ => files::reason(&e),
    })
}

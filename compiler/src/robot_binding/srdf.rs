//! SRDF of a robot: finds the file, reads it, and converts its messages.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet, SourceId, Span, Spanned};
use names::suggest;
use robot::srdf::VirtualMotion;
use robot::{Drive, Model, Srdf, SrdfCode, SrdfMessage};

use super::Files;
use super::urdf::read;
use crate::paths::instead_of;

/// The SRDF of a robot, with its text.
#[derive(Clone, Debug)]
pub(crate) struct RobotSrdf {
    /// The content.
    pub srdf: Srdf,
    /// Its text.
    pub source: SourceId,
    /// Its path in the spec.
    pub span: Span,
}

impl RobotSrdf {
    /// Place of a part of the text.
    pub fn place(&self, range: &std::ops::Range<usize>) -> Span {
        Span::new(self.source, range.start, range.end)
    }
}

/// The entry that names an SRDF.
fn srdf_example() -> Snippet {
    Snippet::each("srdf \"robots/arm7.srdf\"", "srdf: robots/arm7.srdf")
}

/// Finds the SRDF that a robot names, and reads it. `model` has the name of the robot in its URDF.
pub(super) fn open(
    Spanned { value: path_text, span }: &Spanned<String>,
    model: &Model,
    files: &mut Files,
) -> Option<RobotSrdf> {
    let span = *span;
    if path_text.trim().is_empty() {
        let d = Diagnostic::error("HQ0401", span, "this names no file").here("an empty text");
        let help = Help::with("write the path of the robot's SRDF, such as {}, or leave the key out", [srdf_example()]);
        files.diagnostics.push(d.help(help));
        return None;
    }
    let path = files.folder.join(path_text);
    let bytes = match read(&path) {
        Ok(bytes) => bytes,
        Err(why) => {
            let d = Diagnostic::error("HQ0401", span, format!("cannot read `{path_text}`: {why}"))
                .note("paths are relative to the file that names them");
            files.diagnostics.push(instead_of(d, path_text, &path));
            return None;
        }
    };
    let Ok(text) = String::from_utf8(bytes) else {
        let d = Diagnostic::error("HQ0408", span, format!("`{path_text}` is not UTF-8 text"));
        files.diagnostics.push(d.help("save the SRDF as UTF-8"));
        return None;
    };
    let source = files.sources.add(path_text, text.clone());
    let convert = |m: &SrdfMessage, error: bool| message(m, error, model, Origin { file: source, named: span });
    match Srdf::read(&text, model) {
        Ok((srdf, warnings)) => {
            files.diagnostics.extend(warnings.iter().map(|m| convert(m, false)));
            Some(RobotSrdf { srdf, source, span })
        }
        Err(errors) => {
            files.diagnostics.extend(errors.iter().map(|m| convert(m, true)));
            None
        }
    }
}

/// An SRDF, and the place in the spec that names it.
#[derive(Clone, Copy)]
struct Origin {
    file: SourceId,
    named: Span,
}

fn message(m: &SrdfMessage, error: bool, model: &Model, origin: Origin) -> Diagnostic {
    let place = Span::new(origin.file, m.span.start, m.span.end);
    let d = match error {
        true => Diagnostic::error("HQ0408", place, m.text.clone()).label(origin.named, "this robot reads it"),
        false => Diagnostic::warning("HQ0409", place, m.text.clone()).label(origin.named, "this robot reads it"),
    };
    let links = || model.links.iter().map(|l| l.name.as_str());
    let joints = || model.joints.iter().map(|j| j.name.as_str());
    // The text is not one of the spec, so that the name is proposed in words alone.
    let near = m.unknown.as_deref().and_then(|name| match m.code {
        SrdfCode::UnknownLink => suggest(name, links()),
        SrdfCode::UnknownJoint => suggest(name, joints()),
        _ => None,
    });
    match (&m.help, near, m.code) {
        (Some(help), _, _) => d.help(help.clone()),
        (None, Some(near), _) => d.help(format!("did you mean `{near}`?")),
        (None, None, SrdfCode::UnknownJoint) if !error => d.help("remove it from the posture, or correct its name"),
        (None, None, SrdfCode::UnknownLink) if !error => d.help("remove what names it, or correct its name"),
        (None, None, SrdfCode::UnknownLink | SrdfCode::UnknownJoint) => {
            d.help("correct the name, or take it out of the SRDF")
        }
        (None, None, SrdfCode::UnknownGroup) => d.help("declare the group, or correct its name"),
        (None, None, SrdfCode::Missing) => d.help("write the attribute"),
        (None, None, SrdfCode::BadNumber) => d.help("write the position in rad or m"),
        (None, None, _) => d.help("correct the SRDF"),
    }
}

/// Names of the passive joints that have a degree of freedom and that `lock` does not name, in the order of the file. Warns of
/// them: they are held still.
pub(super) fn passive(
    of: &RobotSrdf,
    model: &Model,
    locked: &BTreeSet<String>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Spanned<String>> {
    let mut found: Vec<Spanned<String>> = Vec::new();
    for passive in &of.srdf.passive {
        let joint = model.joint_ref(passive.joint);
        let moves = matches!(joint.drive, Drive::Dof(_));
        if moves && !locked.contains(&joint.name) && found.iter().all(|known| known.value != joint.name) {
            found.push(Spanned::new(joint.name.clone(), of.place(&passive.span)));
        }
    }
    let Some(first) = found.first() else { return found };
    let names: Vec<&str> = found.iter().map(|joint| joint.value.as_str()).collect();
    let text = match names.len() {
        1 => format!("joint `{}` has no motor, and is held still at home", names[0]),
        _ => format!("joints without a motor are held still at home: {}", names::list(names.iter().copied(), 8)),
    };
    let d = Diagnostic::warning("HQ0410", first.span, text)
        .label(of.span, "this robot reads it")
        .note("no command moves a passive joint, so the model keeps it at its position at home; a real one may move");
    let lock = Snippet::entry("lock", format!("[{}]", names.join(", ")));
    diagnostics.push(d.help(Help::with("if that is meant, write {} in the robot", [lock])));
    found
}

/// Warns of a virtual joint that lets the base move, if the spec does not say what carries it.
pub(super) fn base(of: &RobotSrdf, model: &Model, is_written: bool, diagnostics: &mut Vec<Diagnostic>) {
    let root = of.srdf.virtual_joints.iter().find(|joint| joint.child == model.root());
    let moving = root.filter(|joint| !is_written && model.bases.is_empty() && joint.motion != VirtualMotion::Fixed);
    let Some(joint) = moving else { return };
    let (word, base) = match joint.motion {
        VirtualMotion::Planar => ("planar", "planar"),
        _ => ("floating", "floating"),
    };
    let text = format!("the SRDF says that the base is {word}, and the spec that it is fixed, since it has no `base`");
    let d = Diagnostic::warning("HQ0411", of.span, text)
        .label(of.place(&joint.span), format!("the virtual joint `{}`", joint.name))
        .note("without `base` nothing moves the root link, and all that a base could do is missing in every task");
    diagnostics.push(d.help(Help::with(
        "write {}, or {} if this robot does not drive",
        [Snippet::entry("base", base), Snippet::entry("base", "fixed")],
    )));
}

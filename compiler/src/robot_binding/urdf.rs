//! The URDF of a robot: found, read, and reduced by the joints that the spec locks.

use std::path::{Path, PathBuf};

use dsl::tree::{Block, Robot, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use robot::{Base, Model};

use super::Files;
use super::lookup::{glob, unknown_joint};
use crate::constants::{Constants, joint_dimension};
use crate::forms::{items_of, text_of};
use crate::names::suggest;

/// Joints that the spec takes out of the model, each with the value it is held at where one is written.
pub(super) type Locks = Vec<(Spanned<String>, Option<Value>)>;

/// Reads `lock [head_pan]` or `lock { head_pan 0.1 rad }`.
pub(super) fn locks(body: &Block, diagnostics: &mut Vec<Diagnostic>) -> Locks {
    let Some(entry) = body.get("lock") else { return Vec::new() };
    match &entry.value.kind {
        ValueKind::Block(block) => block.entries.iter().map(|e| (e.key.clone(), Some(e.value.clone()))).collect(),
        _ => items_of(&entry.value)
            .iter()
            .filter_map(|v| {
                let name = text_of(v);
                if name.is_none() && !matches!(v.kind, ValueKind::Missing) {
                    let d = Diagnostic::error("HQ0304", v.span, "the name of a joint is needed here");
                    diagnostics.push(d.help("write `lock [head_pan]`, or `lock { head_pan 0.1 rad }`"));
                }
                Some((Spanned::new(name?.to_string(), v.span), None))
            })
            .collect(),
    }
}

/// Reads the URDF twice where needed: once to learn the joints that patterns in `lock` mean, then reduced.
pub(super) fn read(
    (path_text, span): (&str, Span),
    base: Base,
    locks: &Locks,
    robot: &Robot,
    constants: &mut Constants,
    files: &mut Files,
) -> Option<Model> {
    let path = files.folder.join(path_text);
    let bytes = match std::fs::read(&path) {
        Ok(b) => b,
        Err(e) => {
            let d = Diagnostic::error("HQ0401", span, format!("cannot read `{path_text}`: {}", io_reason(&e)))
                .note("paths are relative to the file that names them")
                .help(match nearby(&path) {
                    _ if path.is_dir() => "name a file inside it".to_string(),
                    Some(near) => near,
                    None => format!("looked for {}", path.display()),
                });
            files.diagnostics.push(d);
            return None;
        }
    };
    let text = match String::from_utf8(bytes) {
        Ok(t) => t,
        Err(e) => {
            let at = e.utf8_error().valid_up_to();
            files.diagnostics.push(
                Diagnostic::error("HQ0402", span, format!("`{path_text}` is not UTF-8 text: byte {at} is none"))
                    .help("save the URDF as UTF-8"),
            );
            return None;
        }
    };
    let urdf_source = files.sources.add(path_text, text.clone());
    let mut package_paths: Vec<PathBuf> = files.package_paths.to_vec();
    if let Some(e) = robot.body.get("package_path") {
        match text_of(&e.value) {
            Some(p) => package_paths.insert(0, files.folder.join(p)),
            None => files.diagnostics.push(
                Diagnostic::error("HQ0304", e.value.span, "`package_path` is the path of a folder, in quotes")
                    .help("write for instance `package_path \"..\"`"),
            ),
        }
    }
    let mut options = robot::Options {
        base,
        urdf_dir: path.parent().map(Path::to_path_buf),
        package_paths,
        read_meshes: true,
        ..robot::Options::default()
    };
    let convert = |m: &robot::UrdfMessage, error: bool| {
        let place = Span::new(urdf_source, m.span.start, m.span.end);
        let code = if error { "HQ0402" } else { "HQ0403" };
        let d = if error {
            Diagnostic::error(code, place, m.text.clone())
        } else {
            Diagnostic::warning(code, place, m.text.clone())
        };
        let d = if error { d.label(span, "this robot reads it") } else { d };
        match &m.help {
            Some(h) => d.help(h.clone()),
            None => d,
        }
    };
    let first = Model::from_urdf(&text, &options);
    let full = match first {
        Ok((model, warnings)) if locks.is_empty() => {
            files.diagnostics.extend(warnings.iter().map(|m| convert(m, false)));
            return Some(model);
        }
        Ok((model, _)) => model,
        Err(errors) => {
            files.diagnostics.extend(errors.iter().map(|m| convert(m, true)));
            return None;
        }
    };
    let home = robot.body.get("home").and_then(|h| match &h.value.kind {
        ValueKind::Block(b) => Some(b),
        _ => None,
    });
    for (name, value) in locks {
        let matched: Vec<usize> =
            (0..full.nv()).filter(|&i| full.dofs[i].joint.is_some() && glob(&name.value, &full.dofs[i].name)).collect();
        if matched.is_empty() {
            files.diagnostics.push(unknown_joint(&full, &name.value, name.span, &[]));
        }
        for i in matched {
            let d = &full.dofs[i];
            // The home configuration may say where a locked joint stands.
            let value = value.as_ref().or_else(|| Some(&home?.get(&d.name)?.value));
            let x = value.and_then(|v| {
                let x = constants.scalar(v, joint_dimension(&full, i), files.diagnostics)?;
                if x < d.lower || x > d.upper {
                    let text =
                        format!("`{}` is locked at {x}, outside its limits of {} to {}", d.name, d.lower, d.upper);
                    files.diagnostics.push(Diagnostic::error("HQ0404", v.span, text).help("lock it inside its limits"));
                }
                Some(x)
            });
            options.lock.insert(d.name.clone(), x.unwrap_or(0.0).max(d.lower).min(d.upper));
        }
    }
    match Model::from_urdf(&text, &options) {
        Ok((model, warnings)) => {
            files.diagnostics.extend(warnings.iter().map(|m| convert(m, false)));
            Some(model)
        }
        Err(errors) => {
            files.diagnostics.extend(errors.iter().map(|m| convert(m, true)));
            None
        }
    }
}

fn io_reason(e: &std::io::Error) -> &'static str {
    match e.kind() {
        std::io::ErrorKind::NotFound => "there is no such file",
        std::io::ErrorKind::PermissionDenied => "permission denied",
        std::io::ErrorKind::IsADirectory => "it is a folder",
        _ => "the system refuses",
    }
}

/// A file of nearly this name in the same folder.
fn nearby(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_str()?.to_string();
    let mut names: Vec<String> = std::fs::read_dir(path.parent()?)
        .ok()?
        .take(1000)
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    suggest(&wanted, names.iter().map(String::as_str)).map(|n| format!("did you mean `{n}`?"))
}

//! Location of the URDF for the project: copied into it, or referred to if it has meshes.

use std::path::{Component, Path, PathBuf};

use super::Request;
use super::xacro::Expanded;

/// Location of the project's URDF.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Absolute path of the original URDF; `None` for the example.
    pub(super) source: Option<String>,
    /// Path in the spec.
    pub(super) written: String,
    /// Destination of the copy, if the URDF is copied.
    pub(super) copy: Option<PathBuf>,
    /// Folder for `package://` addresses, as in the spec.
    pub(super) package_path: Option<String>,
    /// The same folder as an absolute path.
    pub(super) package_folder: Option<PathBuf>,
}

impl Place {
    /// The example arm.
    pub(super) fn example(folder: &Path) -> Place {
        Place {
            source: None,
            written: "robots/arm7.urdf".to_string(),
            copy: Some(folder.join("robots").join("arm7.urdf")),
            package_path: None,
            package_folder: None,
        }
    }

    /// A URDF of the user. It is copied, unless it is in the project or has meshes, which are relative to its folder.
    pub(super) fn of(path: &Path, text: &str, request: &Request) -> Result<Place, String> {
        let real = path.canonicalize().map_err(|e| format!("cannot find {}: {e}", path.display()))?;
        let name = real.file_name().and_then(|n| n.to_str()).ok_or("the name of the URDF is not UTF-8")?.to_string();
        let source = Some(utf8(&real)?);
        let folder = absolute(&request.folder)?;
        let meshes = text.contains("<mesh");
        let inside = real.starts_with(&folder);
        if !meshes && !inside {
            let copy = Some(request.folder.join("robots").join(&name));
            let written = format!("robots/{name}");
            return Ok(Place { source, written, copy, package_path: None, package_folder: None });
        }
        let (package_path, package_folder) = package_folder(&real, text, request)?;
        let written = utf8(&relative(&folder, &real))?;
        Ok(Place { source, written, copy: None, package_path, package_folder })
    }

    /// A file that was expanded from `original`: copied in any case.
    pub(super) fn expanded(original: &Path, made: &Expanded, request: &Request) -> Result<Place, String> {
        let real = original.canonicalize().map_err(|e| format!("cannot find {}: {e}", original.display()))?;
        let name = made.file.file_name().and_then(|n| n.to_str()).unwrap_or("robot.urdf");
        let (package_path, package_folder) = package_folder(&real, &made.text, request)?;
        Ok(Place {
            source: Some(utf8(&made.file)?),
            written: format!("robots/{name}"),
            copy: Some(request.folder.join("robots").join(name)),
            package_path,
            package_folder,
        })
    }
}

/// Folder for `package://` addresses of a text, as in the spec and as an absolute path.
fn package_folder(real: &Path, text: &str, request: &Request) -> Result<(Option<String>, Option<PathBuf>), String> {
    if !text.contains("package://") {
        return Ok((None, None));
    }
    let given = request.package_paths.first().map(|p| absolute(p)).transpose()?;
    let found = given.or_else(|| packages(real, text));
    let folder = absolute(&request.folder)?;
    let written = found.as_deref().map(|p| utf8(&relative(&folder, p))).transpose()?;
    Ok((written, found))
}

fn utf8(path: &Path) -> Result<String, String> {
    let text = path.to_str().ok_or_else(|| format!("the path {} is not UTF-8", path.display()))?;
    Ok(if text.is_empty() { ".".to_string() } else { text.to_string() })
}

/// Absolute path of a folder, with symbolic links resolved for the part that exists.
fn absolute(path: &Path) -> Result<PathBuf, String> {
    let full = std::path::absolute(path).map_err(|e| format!("cannot find {}: {e}", path.display()))?;
    let mut rest = Vec::new();
    let mut there = full.as_path();
    loop {
        if let Ok(real) = there.canonicalize() {
            return Ok(rest.into_iter().rev().fold(real, |p: PathBuf, name| p.join(name)));
        }
        match (there.parent(), there.file_name()) {
            (Some(parent), Some(name)) => {
                rest.push(name.to_os_string());
                there = parent;
            }
            _ => return Ok(full),
        }
    }
}

/// Path from a folder to a file, both absolute; the absolute path of the file if they have no folder in common.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let (a, b): (Vec<Component>, Vec<Component>) = (from.components().collect(), to.components().collect());
    let common = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let named = |c: &Component| matches!(c, Component::Normal(_));
    if !a[..common].iter().any(named) {
        return to.to_path_buf();
    }
    let up = std::iter::repeat_n(Component::ParentDir, a.len() - common);
    up.chain(b[common..].iter().copied()).collect()
}

/// Folder above the URDF in which a `package://` address of its text resolves to a file.
fn packages(urdf: &Path, text: &str) -> Option<PathBuf> {
    text.split("package://").skip(1).find_map(|rest| {
        let address = rest.split(['"', '\'']).next()?;
        let (package, inside) = address.split_once('/')?;
        urdf.ancestors().skip(1).find_map(|folder| {
            if folder.join(package).join(inside).is_file() {
                return Some(folder.to_path_buf());
            }
            let is_it = folder.file_name().is_some_and(|n| n == package) && folder.join(inside).is_file();
            if is_it { folder.parent().map(Path::to_path_buf) } else { None }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_between_folders() {
        let of = |a: &str, b: &str| relative(Path::new(a), Path::new(b)).display().to_string();
        assert_eq!(of("/home/me/cell", "/home/me/robots/a.urdf"), "../robots/a.urdf");
        assert_eq!(of("/home/me", "/home/me/a.urdf"), "a.urdf");
        assert_eq!(of("/home/me", "/opt/a.urdf"), "/opt/a.urdf");
    }
}

//! Where the URDF stands, seen from the project: copied into it, or referred to where it has meshes beside it.

use std::path::{Component, Path, PathBuf};

use super::Request;

/// How the project comes to its URDF.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The URDF as it is, absolute; none for the example.
    pub(super) source: Option<String>,
    /// What the spec says.
    pub(super) written: String,
    /// Where a copy goes, if one does.
    pub(super) copy: Option<PathBuf>,
    /// The folder for `package://` addresses, as the spec says it.
    pub(super) package_path: Option<String>,
    /// The same folder, absolute.
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

    /// A URDF of the user's. One with meshes stays where it is, because their addresses begin there.
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
        let given = request.package_paths.first().map(|p| absolute(p)).transpose()?;
        let package_folder = given.or_else(|| packages(&real, text));
        let package_path = package_folder.as_deref().map(|p| utf8(&relative(&folder, p))).transpose()?;
        let written = utf8(&relative(&folder, &real))?;
        Ok(Place { source, written, copy: None, package_path, package_folder })
    }
}

fn utf8(path: &Path) -> Result<String, String> {
    let text = path.to_str().ok_or_else(|| format!("the path {} is not UTF-8", path.display()))?;
    Ok(if text.is_empty() { ".".to_string() } else { text.to_string() })
}

/// The absolute path of a folder that need not exist, without links as far as it does.
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

/// The path from a folder to a file; both are absolute. Absolute where they share nothing.
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

/// The folder above the URDF in which the first `package://` address that can be found is found.
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

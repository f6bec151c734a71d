//! Location of mesh files. Reads the file system and two environment variables, and runs no programs.

use std::env;
use std::path::{Path, PathBuf};

use super::Options;

/// Returns the path of the file for a mesh address, or advice on how to make it findable.
pub(super) fn find(address: &str, options: &Options) -> Result<PathBuf, String> {
    if let Some(rest) = address.strip_prefix("package://").or(address.strip_prefix("model://")) {
        let (package, inside) = rest.split_once('/').unwrap_or((rest, ""));
        return in_package(package, inside, options);
    }
    let path = match address.strip_prefix("file://") {
        Some(rest) => PathBuf::from(unescape(rest.strip_prefix("localhost").unwrap_or(rest))),
        None if address.contains("://") => {
            return Err("only `package://`, `file://` and plain paths are read".into());
        }
        None => PathBuf::from(address),
    };
    let path = match &options.urdf_dir {
        Some(dir) if path.is_relative() => dir.join(path),
        None if path.is_relative() => {
            return Err("the path is relative, and the folder of the URDF was not given".into());
        }
        _ => path,
    };
    if path.is_file() { Ok(path) } else { Err(format!("there is no file `{}`", path.display())) }
}

fn in_package(package: &str, inside: &str, options: &Options) -> Result<PathBuf, String> {
    let variable =
        |name: &str| -> Vec<PathBuf> { env::var_os(name).map(|v| env::split_paths(&v).collect()).unwrap_or_default() };
    let mut folders = options.package_paths.clone();
    folders.extend(variable("ROS_PACKAGE_PATH"));
    let shares = variable("AMENT_PREFIX_PATH").into_iter().map(|prefix| prefix.join("share"));
    folders.extend(shares);
    // A file that stands in its package needs no path. Links are kept: a workspace may install its files as links.
    let above = options.urdf_dir.as_ref().and_then(|dir| std::path::absolute(dir).ok());
    folders.extend(above.iter().flat_map(|dir| dir.ancestors()).map(Path::to_path_buf));
    let inside = unescape(inside);
    for folder in &folders {
        let mut candidates = vec![folder.join(package)];
        if names(folder, package) {
            candidates.push(folder.clone());
        }
        for candidate in candidates {
            let path = candidate.join(&inside);
            if path.is_file() {
                return Ok(path);
            }
        }
    }
    Err(format!("give the folder that contains `{package}` as a package path, or set ROS_PACKAGE_PATH"))
}

fn names(folder: &Path, package: &str) -> bool {
    folder.file_name().is_some_and(|name| name.to_str() == Some(package))
}

/// Decodes percent escapes such as `%20`; invalid escapes stay as they are.
fn unescape(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let code = (bytes[i] == b'%')
            .then(|| bytes.get(i + 1..i + 3))
            .flatten()
            .and_then(|hex| std::str::from_utf8(hex).ok())
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        match code {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8(out).unwrap_or_else(|_| text.to_owned())
}

//! Expansion of xacro files by the program `xacro`, for `hierarq init`: the project gets the expanded file, so that its spec
//! needs no other program.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Folders for expanded files that this process made.
static MADE: AtomicUsize = AtomicUsize::new(0);

/// An expanded file in a folder of its own, which is removed with this value.
#[derive(Debug)]
pub(super) struct Expanded {
    /// The expanded text.
    pub(super) text: String,
    /// The file, named as the original one without `.xacro`.
    pub(super) file: PathBuf,
    folder: PathBuf,
}

impl Drop for Expanded {
    fn drop(&mut self) {
        // A file that is left in the system's folder for temporary files harms nobody.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Returns true for a file that has to be expanded, by its name.
pub(super) fn is_xacro(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "xacro")
}

/// Name of the expanded file: `ur.urdf` of `ur.urdf.xacro`, and `ur.urdf` of `ur.xacro` with the ending `urdf`.
pub(super) fn expanded_name(path: &Path, ending: &str) -> Option<String> {
    let stem = Path::new(path.file_stem()?);
    let whole = if stem.extension().is_some() { stem.to_path_buf() } else { stem.with_extension(ending) };
    whole.to_str().map(str::to_string)
}

/// Expands a file with arguments of the form `NAME:=VALUE`.
///
/// # Errors
/// The program `xacro` is not installed or refuses the file, or the result cannot be stored.
pub(super) fn expand(path: &Path, arguments: &[String], ending: &str) -> Result<Expanded, String> {
    let shown = path.display();
    let name = expanded_name(path, ending).ok_or_else(|| format!("the name of {shown} is not UTF-8"))?;
    let output = Command::new("xacro").arg(path).args(arguments).stdin(Stdio::null()).output().map_err(|e| {
        let to_do = format!("install it (`python3 -m pip install xacro`), or give the file that it makes of {shown}");
        match e.kind() {
            std::io::ErrorKind::NotFound => {
                format!("{shown} needs the program `xacro`, which is not installed: {to_do}")
            }
            _ => format!("cannot start `xacro` for {shown}: {e}"),
        }
    })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let lines: Vec<&str> = said.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
        let last = lines[lines.len().saturating_sub(6)..].join("\n  ");
        let undefined = said.contains("Undefined substitution argument");
        let help = if undefined { "\ngive it a value by `--xacro-arg NAME:=VALUE`" } else { "" };
        return Err(format!("`xacro` refuses {shown}:\n  {last}{help}"));
    }
    let text =
        String::from_utf8(output.stdout).map_err(|_| format!("what `xacro` makes of {shown} is not UTF-8 text"))?;
    let number = MADE.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("hierarq-xacro-{}-{number}", std::process::id()));
    let failed = |e: std::io::Error| format!("cannot store what `xacro` makes of {shown}: {e}");
    std::fs::create_dir(&folder).map_err(failed)?;
    let made = Expanded { text, file: folder.join(name), folder };
    ::files::create(&made.file, &made.text).map_err(failed)?;
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expanded_files_keep_the_name() {
        let named = |path: &str| expanded_name(Path::new(path), "urdf").unwrap_or_default();
        assert_eq!(named("/ws/ur.urdf.xacro"), "ur.urdf");
        assert_eq!(named("ur.xacro"), "ur.urdf");
        assert!(is_xacro(Path::new("a.xacro")) && !is_xacro(Path::new("a.urdf")));
    }
}

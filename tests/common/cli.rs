//! The program as a user runs it: from the root of the project, without colours, in a terminal of one hundred columns.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Prepares a call. It is independent of engines and keys of this machine.
pub fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
    command.args(args).env("NO_COLOR", "1").env("COLUMNS", "100").env("HIERARQ_HIGHS", "/nowhere");
    command.env_remove("HIERARQ_API_KEY").current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

pub fn hierarq(args: &[&str]) -> Output {
    command(args).output().expect("the binary runs")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns a new, empty folder for a test.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("writable");
    path
}

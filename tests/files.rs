//! User files: no file of the user is lost, and no endless file is read.

use crate::common::cli;

mod read;
mod results;
mod single_crate;
mod sweeps;
mod written;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use cli::command;

/// Maximum duration of a call that must be rejected at once, or of waiting for a child.
const PATIENCE: Duration = Duration::from_secs(60);

fn folder(name: &str) -> PathBuf {
    cli::folder(&format!("files_{name}"))
}

fn utf8(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn contents(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Returns the names in a folder, including hidden ones.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Returns the result of a call: exit code, standard output, standard error. A call that does not end is killed, and
/// fails the test.
fn call(args: &[&str]) -> (Option<i32>, String, String) {
    ended(command(args))
}

fn ended(mut command: Command) -> (Option<i32>, String, String) {
    // Wide enough that messages are not wrapped within the searched texts.
    command.env("COLUMNS", "160");
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary runs");
    let id = child.id();
    let (done, waits) = std::sync::mpsc::channel::<()>();
    let watch = std::thread::spawn(move || {
        let late = waits.recv_timeout(PATIENCE).is_err();
        if late {
            let _ = Command::new("kill").args(["-KILL", &id.to_string()]).status();
        }
        late
    });
    let (out, err) = (child.stdout.take(), child.stderr.take());
    let read = |mut from: Box<dyn std::io::Read + Send>| {
        std::thread::spawn(move || {
            let mut text = Vec::new();
            let _ = from.read_to_end(&mut text);
            text
        })
    };
    let out = read(Box::new(out.expect("piped")));
    let err = read(Box::new(err.expect("piped")));
    let status = child.wait().expect("it ends");
    let _ = done.send(());
    assert!(!watch.join().expect("a thread"), "it does not end");
    let Output { status, stdout, stderr } =
        Output { status, stdout: out.join().expect("a thread"), stderr: err.join().expect("a thread") };
    (status.code(), cli::text(&stdout), cli::text(&stderr))
}

/// Waits until a condition is true.
fn until(what: &str, mut so: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !so() {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Copies a spec of two joints that runs at once, with one joint named `name`.
fn arm(folder: &Path, name: &str, duration: &str) -> PathBuf {
    let quoted = name.replace('&', "&amp;").replace('"', "&quot;").replace('\n', "&#10;");
    let urdf = format!(
        "<robot name=\"two\"><link name=\"base\"/><link name=\"a\"/><link name=\"b\"/>\
         <joint name=\"{quoted}\" type=\"revolute\"><parent link=\"base\"/><child link=\"a\"/><axis xyz=\"0 0 1\"/>\
         <limit lower=\"-3\" upper=\"3\" velocity=\"2\" effort=\"1\"/></joint>\
         <joint name=\"second\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><origin xyz=\"1 0 0\"/>\
         <axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\" velocity=\"2\" effort=\"1\"/></joint></robot>"
    );
    std::fs::write(folder.join("two.urdf"), urdf).expect("writable");
    let spec = folder.join("two.hq");
    let text = format!(
        "hierarq 1\n\nrobot two {{\n  urdf \"two.urdf\"\n  rate 100 Hz\n}}\n\nstack s {{\n  level limits hard {{\n    joint_velocity_limits\n  }}\n  \
         level posture {{\n    joint_position {{\n      target {{ second 1 rad }}\n    }}\n  }}\n}}\n\nrun {{ duration {duration} }}\n"
    );
    std::fs::write(&spec, text).expect("writable");
    spec
}

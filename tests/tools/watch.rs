//! `hierarq watch` as a separate process, with changing files.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use super::{command, folder, text, utf8};

/// Generous for a busy machine; a successful test never waits this long.
const PATIENCE: Duration = Duration::from_secs(60);

/// A process that is killed at the end of the test, and the lines of both its outputs.
struct Watching {
    child: Child,
    lines: Receiver<String>,
    seen: Vec<String>,
}

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read(from: impl Read + Send + 'static, to: Sender<String>) {
    std::thread::spawn(move || {
        for line in BufReader::new(from).lines().map_while(Result::ok) {
            if to.send(line).is_err() {
                return;
            }
        }
    });
}

impl Watching {
    fn new(args: &[&str]) -> Watching {
        let mut child = command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary runs");
        let (sender, lines) = channel();
        read(child.stdout.take().expect("piped"), sender.clone());
        read(child.stderr.take().expect("piped"), sender);
        Watching { child, lines, seen: Vec::new() }
    }

    /// Waits until each of these has occurred in a new line. The two outputs come in any order.
    fn expect(&mut self, wanted: &[&str]) {
        let mut wanted = wanted.to_vec();
        let end = Instant::now() + PATIENCE;
        while !wanted.is_empty() {
            match self.lines.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(line) => {
                    wanted.retain(|w| !line.contains(w));
                    self.seen.push(line);
                }
                Err(_) => panic!("{wanted:?} did not come:\n{}", self.seen.join("\n")),
            }
        }
    }
}

fn spec(gain: &str) -> String {
    format!(
        "hierarq 1\nrobot arm {{ urdf \"arm.urdf\"  rate 100 Hz  home {{ all 0.5 rad }} }}\n\
         stack s {{ level l {{ frame_position(tool) {{ position initial(position)  gain {gain} }} }} }}\n\
         run {{ duration 0.1 s }}\n"
    )
}

fn write(path: &Path, text: &str) {
    std::fs::write(path, text).expect("writable");
}

fn urdf() -> String {
    std::fs::read_to_string("examples/robots/arm7.urdf").expect("readable")
}

#[test]
fn every_save_of_spec_or_urdf_is_checked() {
    let dir = folder("watch");
    let (path, robot) = (dir.join("a.hq"), dir.join("arm.urdf"));
    write(&robot, &urdf());
    write(&path, &spec("2 /s"));
    let mut watching = Watching::new(&["watch", utf8(&path)]);
    watching.expect(&["a.hq: good; waiting for changes"]);

    write(&path, &spec("2 m"));
    watching.expect(&["HQ0301", "a.hq: 1 error; waiting"]);

    // As many editors save: a new file replaces the old one.
    let beside = dir.join("a.hq.new");
    write(&beside, &spec("3 /s"));
    std::fs::rename(&beside, &path).expect("the same folder");
    watching.expect(&["a.hq: good; waiting"]);

    write(&robot, &urdf().replace("<child link=\"link_2\"/>", "<child link=\"lnk_2\"/>"));
    watching.expect(&["there is no link `lnk_2`", "error; waiting"]);
    write(&robot, &urdf());
    watching.expect(&["a.hq: good; waiting"]);

    // The watch survives the deletion of the file, and detects its return.
    std::fs::remove_file(&path).expect("it was there");
    watching.expect(&["a.hq: 1 error; waiting"]);
    write(&path, &spec("4 /s"));
    watching.expect(&["a.hq: good; waiting"]);
}

#[test]
fn a_save_of_an_imported_file_is_checked() {
    let dir = folder("watch_import");
    write(&dir.join("arm.urdf"), &urdf());
    let library = dir.join("lib");
    std::fs::create_dir_all(&library).expect("a folder");
    let path = dir.join("a.hq");
    let spec = spec("5 /s").replace("hierarq 1\n", "hierarq 1\nimport \"lib/b.yaml\" { limits }\n");
    write(&path, &spec.replace("level l {", "level first { limits }  level l {"));
    let mut watching = Watching::new(&["watch", utf8(&path)]);
    watching.expect(&["HQ0211", "a.hq: 1 error; waiting"]);
    // The file is created, has a mistake, and is corrected.
    write(&library.join("b.yaml"), "hierarq: 1\ntasks: { limits: { joint_velocity_limits: { max: 1 m } } }\n");
    watching.expect(&["a.hq: 1 error; waiting"]);
    write(&library.join("b.yaml"), "hierarq: 1\ntasks: { limits: joint_velocity_limits }\n");
    watching.expect(&["a.hq: good; waiting"]);
}

#[test]
fn a_file_that_stays_as_it_was_is_not_checked_again() {
    let dir = folder("watch_same");
    let path = dir.join("a.hq");
    write(&dir.join("arm.urdf"), &urdf());
    write(&path, &spec("2 /s"));
    let mut watching = Watching::new(&["watch", utf8(&path)]);
    watching.expect(&["good; waiting"]);
    // Replaced atomically: a file written in place is empty for a moment, which would be a change.
    let replace = |text: &str| {
        let beside = dir.join("beside");
        write(&beside, text);
        std::fs::rename(&beside, &path).expect("the same folder");
    };
    for i in 0..5 {
        write(&dir.join(format!("other_{i}.txt")), "noise");
        replace(&spec("2 /s"));
        std::thread::sleep(Duration::from_millis(150));
    }
    replace(&spec("2 m"));
    watching.expect(&["error; waiting"]);
    let checks = watching.seen.iter().filter(|l| l.contains("waiting for changes")).count();
    assert_eq!(checks, 2, "{:?}", watching.seen);
}

#[test]
fn a_good_spec_is_run_each_time() {
    let dir = folder("watch_run");
    let (path, out) = (dir.join("a.hq"), dir.join("out"));
    write(&dir.join("arm.urdf"), &urdf());
    write(&path, &spec("2 m"));
    let mut watching = Watching::new(&["watch", utf8(&path), "--run", "--out", utf8(&out)]);
    watching.expect(&["1 error; waiting"]);
    assert!(!out.exists());
    for gain in ["2 /s", "3 /s"] {
        write(&path, &spec(gain));
        watching.expect(&["good; waiting"]);
        watching.expect(&["wrote "]);
        assert!(out.join("summary.json").exists());
    }
}

#[test]
fn an_interrupt_ends_it() {
    let dir = folder("watch_end");
    let path = dir.join("a.hq");
    write(&dir.join("arm.urdf"), &urdf());
    write(&path, &spec("2 /s"));
    let mut watching = Watching::new(&["watch", utf8(&path)]);
    watching.expect(&["good; waiting"]);
    let kill = std::process::Command::new("kill").args(["-INT", &watching.child.id().to_string()]).status();
    assert!(kill.expect("there is `kill`").success());
    let end = Instant::now() + PATIENCE;
    while watching.child.try_wait().expect("our child").is_none() {
        assert!(Instant::now() < end, "it went on");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_folder_that_is_not_there_is_said() {
    let out = command(&["watch", "no/such/folder/a.hq"]).output().expect("the binary runs");
    assert_eq!(out.status.code(), Some(2));
    assert!(text(&out.stderr).contains("cannot watch"), "{}", text(&out.stderr));
}

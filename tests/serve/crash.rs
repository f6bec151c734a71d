//! Servers that are killed at any instant, and full disks: confirmed reports are never lost.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::time::Duration;

use serde_json::{Value as Json, json};

use super::client::Client;

/// A person with a long operation, who can be reported at another position at any time: each position is reported once.
const SPEC: &str = "hierarq 1
mission field : schedule {
  robot m1 { depot [0, 0] m  speed 0.5 m/s  proximity_speed 0.5 m/s  serve 5 s  deposit 1 s }
  human anna { place [0, 5] m  operations 1  duration 2000 s  wait_distance 1 m }
}
";

/// Creates a folder with a spec, and returns the paths of the spec and of a journal.
fn files(name: &str) -> (PathBuf, PathBuf) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("serve_{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("writable");
    std::fs::write(folder.join("field.hq"), SPEC).expect("writable");
    (folder.join("field.hq"), folder.join("field.journal"))
}

fn serve(mut command: Command, spec: &Path, journal: &Path) -> Child {
    command.arg("serve").arg(spec).arg("--journal").arg(journal).args(["--begin", "--speed", "1"]);
    command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("it runs")
}

fn plain() -> Command {
    Command::new(env!("CARGO_BIN_EXE_hierarq"))
}

/// Returns the output up to the waiting message.
fn greeting(child: &mut Child) -> String {
    let mut out = BufReader::new(child.stdout.take().expect("piped"));
    let mut all = String::new();
    while !all.contains("Ctrl-C") {
        assert_ne!(out.read_line(&mut all).expect("text"), 0, "{all}");
    }
    all
}

/// Returns a client that has opened the link of this name.
fn open(greeting: &str, who: &str) -> Client {
    let lines = greeting.lines().filter_map(|line| line.trim().split_once("  "));
    let link = lines.filter(|(name, _)| *name == who).find_map(|(_, url)| url.trim().strip_prefix("http://"));
    let (host, path) = link.and_then(|link| link.split_once('/')).expect("a link");
    let mut client = Client::new(host.parse().expect("an address"));
    client.open(&format!("/{path}"));
    client
}

fn moved(number: u64) -> Json {
    json!({ "what": "moved", "member": 1, "to": [number as f64 / 1000.0, 5.0] })
}

/// Returns the numbers of the moves in a journal, in order. Every line must be complete.
fn noted(journal: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(journal).expect("readable");
    let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
    let lines = whole.lines().skip(1).map(|line| serde_json::from_str::<Json>(line).expect("a line is whole"));
    lines
        .filter_map(|line| Some((line["entry"]["request"]["body"]["to"][0].as_f64()? * 1000.0).round() as u64))
        .collect()
}

/// Returns true if all numbers of `of` occur in `all`, in order.
fn has_all(all: &[u64], of: &[u64]) -> bool {
    let mut all = all.iter();
    of.iter().all(|number| all.any(|other| other == number))
}

fn end(mut child: Child) {
    child.kill().expect("killed");
    child.wait().expect("dead");
}

#[test]
fn fifty_deaths_lose_nothing_that_was_answered() {
    let (spec, journal) = files("deaths");
    let mut child = serve(plain(), &spec, &journal);
    let supervisor = open(&greeting(&mut child), "supervisor");
    end(child);
    let answered = Mutex::new(Vec::new());
    let (mut number, mut random) = (0, 20_231_u64);
    for death in 0..50 {
        let mut child = serve(plain(), &spec, &journal);
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let instant = random >> 40;
        // Some are killed before they listen, while they replay the journal or write their address.
        if death % 5 == 4 {
            std::thread::sleep(Duration::from_micros(instant % 300_000));
            end(child);
            continue;
        }
        // The session was opened once, before the first kill.
        let said = greeting(&mut child);
        let known = answered.lock().expect("whole").is_empty() || said.contains("continues at");
        assert!(known && said.contains("still signed in") && !said.contains("differs"), "{said}");
        std::thread::scope(|scope| {
            scope.spawn(|| {
                loop {
                    number += 1;
                    match supervisor.attempt(moved(number)) {
                        0 => break,
                        200 => answered.lock().expect("whole").push(number),
                        429 => std::thread::sleep(Duration::from_millis(5)),
                        other => panic!("{other}"),
                    }
                }
            });
            std::thread::sleep(Duration::from_micros(instant % 120_000));
            end(child);
        });
        let answered = answered.lock().expect("whole");
        assert!(has_all(&noted(&journal), &answered), "after death {death}: {:?} {answered:?}", noted(&journal));
    }
    let answered = answered.into_inner().expect("whole");
    assert!(answered.len() > 50, "{}", answered.len());
    let mut child = serve(plain(), &spec, &journal);
    let said = greeting(&mut child);
    assert!(said.contains("continues at") && !said.contains("differs"), "{said}");
    assert!(has_all(&noted(&journal), &answered));
    assert_eq!(supervisor.attempt(moved(number + 1)), 200);
    let last = format!("anna moves to ({}, 5) m", (number + 1) as f64 / 1000.0);
    assert!(supervisor.state()["events"].to_string().contains(&last), "{last}");
    end(child);
}

/// Files with a size limit, as on a full disk: the line that does not fit is written partially.
#[cfg(unix)]
#[test]
fn a_full_disk_loses_nothing_that_was_answered() {
    let (spec, journal) = files("full");
    let mut full = Command::new("sh");
    // Without the trap the system would kill a process that exceeds the limit.
    full.args(["-c", "trap '' XFSZ; ulimit -f 4; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_hierarq")]);
    let mut child = serve(full, &spec, &journal);
    let said = greeting(&mut child);
    let (anna, supervisor) = (open(&said, "anna"), open(&said, "supervisor"));
    let (mut answered, mut number) = (Vec::new(), 0);
    let refused = loop {
        number += 1;
        let answer = supervisor.tell(moved(number));
        match answer.status {
            200 => answered.push(number),
            429 => std::thread::sleep(Duration::from_millis(200)),
            409 => break answer.said(),
            other => panic!("{other} {answer:?}"),
        }
        assert!(number < 500, "it is never full");
    };
    assert!(refused.starts_with("Nothing was changed, because the journal cannot be written"), "{refused}");
    assert!(answered.len() > 5, "{answered:?}");
    // A crash at this point leaves complete lines only, with exactly the confirmed reports.
    let bytes = std::fs::read(&journal).expect("readable");
    assert_eq!((noted(&journal), bytes.last()), (answered.clone(), Some(&b'\n')));
    std::thread::sleep(Duration::from_secs(1));
    let note = |state: Json, of: &str| state[of].as_str().unwrap_or_default().to_string();
    let (told, person) = (note(supervisor.state(), "note"), note(anna.state()["person"].clone(), "note"));
    assert!(told.contains("the journal cannot be written"), "{told}");
    assert!(person.contains("cannot record your input"), "{person}");
    assert_eq!(supervisor.attempt(moved(number + 1)), 409, "and so is the next");
    assert_eq!(std::fs::read(&journal).expect("readable"), bytes);
    end(child);
    // With space again the mission continues, and all confirmed reports are there.
    for more in 2..4 {
        let mut child = serve(plain(), &spec, &journal);
        let said = greeting(&mut child);
        assert!(said.contains("continues at") && !said.contains("differs"), "{said}");
        assert_eq!(supervisor.attempt(moved(number + more)), 200);
        answered.push(number + more);
        assert_eq!(noted(&journal), answered);
        end(child);
    }
}

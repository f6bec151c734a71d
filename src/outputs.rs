//! Kinds of files that Hierarq writes, identified by their first bytes: only a file of the same kind may be
//! overwritten.

use files::Kind;

/// A drawing of a machine, a plan or a map.
pub const PICTURE: Kind = Kind { name: "a picture", begins: picture };

/// `log.csv` of a run of a robot, a schedule or layers.
pub const LOG: Kind = Kind { name: "the log of a run", begins: log };

/// `log.mcap` of a run of a robot.
pub const MCAP: Kind = Kind { name: "the log of a run in MCAP", begins: mcap };

/// `summary.json`.
pub const SUMMARY: Kind = Kind { name: "the summary of a run", begins: summary };

/// `report.html`.
pub const REPORT: Kind = Kind { name: "the report of a run", begins: report };

/// The problems of a run, one per line.
pub const PROBLEMS: Kind = Kind { name: "a file of the problems of a run", begins: problems };

/// The answers to problems.
pub const ANSWERS: Kind = Kind { name: "a file of answers", begins: answers };

/// Test results in JUnit's format.
pub const JUNIT: Kind = Kind { name: "a file of test results", begins: junit };

/// The layers of a mission, or a plan of them.
pub const LAYERS: Kind = Kind { name: "a file of layers", begins: layers };

/// A trained policy.
pub const POLICY: Kind = Kind { name: "a policy", begins: policy };

/// A training that can be continued.
pub const CHECKPOINT: Kind = Kind { name: "a checkpoint of a training", begins: checkpoint };

/// The files of a run in its folder, in the order of writing.
pub const RESULTS: [(&str, Kind); 4] =
    [("log.csv", LOG), ("log.mcap", MCAP), ("report.html", REPORT), ("summary.json", SUMMARY)];

fn picture(head: &[u8]) -> bool {
    let svg = b"<svg xmlns=\"http://www.w3.org/2000/svg\" ";
    head.starts_with(svg) || head.starts_with(b"%% machine ") || head.starts_with(b"digraph ")
}

fn log(head: &[u8]) -> bool {
    // Recordings of people begin with the time too.
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let names = |name: &[u8]| line.windows(name.len()).any(|part| part == name);
    head.starts_with(b"time,") && (names(b",q.") || names(b".stage") || names(b".doing"))
}

fn mcap(head: &[u8]) -> bool {
    // The header of the file: its profile, and the program that wrote it.
    let head = head.strip_prefix(b"\x89MCAP0\r\n\x01").and_then(|rest| rest.get(8..)).unwrap_or_default();
    head.starts_with(b"\x04\0\0\0ros2") && head.get(12..).is_some_and(|name| name.starts_with(b"hierarq "))
}

fn summary(head: &[u8]) -> bool {
    head.starts_with(b"{\n  \"program\": ") || head.starts_with(b"{\n  \"mission\": ")
}

fn report(head: &[u8]) -> bool {
    // Reports of missions had no generator in early versions.
    let says = |mark: &[u8]| head.windows(mark.len()).any(|part| part == mark);
    let written = says(b"<meta name=\"generator\" content=\"hierarq\">") || says(b"\n/* The report of a mission. ");
    head.starts_with(b"<!doctype html>\n") && written
}

fn problems(head: &[u8]) -> bool {
    // The first tick of the first state.
    let known = |text: &str| text.starts_with("{\"id\":\"") && text.contains("-0\",\"kind\":\"");
    known(&String::from_utf8_lossy(head))
}

fn answers(head: &[u8]) -> bool {
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let head = String::from_utf8_lossy(line);
    head.starts_with("{\"id\":\"") && (head.contains("\",\"x\":[") || head.contains("\",\"x\":null"))
}

fn junit(head: &[u8]) -> bool {
    head.starts_with(b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n")
}

fn layers(head: &[u8]) -> bool {
    head.starts_with(b"{\n  \"layers\": [\n    {\n      \"name\": ")
}

fn policy(head: &[u8]) -> bool {
    trained(head, "policy")
}

fn checkpoint(head: &[u8]) -> bool {
    trained(head, "checkpoint")
}

/// A file of the format safetensors with the metadata of Hierarq, behind the eight bytes of the header's length.
fn trained(head: &[u8], format: &str) -> bool {
    let begin = format!("{{\"__metadata__\":{{\"hierarq\":\"{{\\\"format\\\":\\\"{format}\\\"");
    head.get(8..).is_some_and(|header| header.starts_with(begin.as_bytes()))
}

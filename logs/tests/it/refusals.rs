//! Files that are no logs, or not logs of this spec: one message each, and no panic.

use std::collections::BTreeMap;

use hierarq_logs::decode::Schema;
use hierarq_logs::replay::replay;
use hierarq_logs::topics::Topic;
use hierarq_logs::{Log, LogError, csv};
use mcap::WriteOptions;
use mcap::records::Metadata;

use crate::runs::{recorded, simulation};

fn refusal(bytes: &[u8]) -> String {
    match Log::read(bytes) {
        Ok(_) => "good".to_string(),
        Err(e) => e.to_string(),
    }
}

/// A file without messages, with these metadata.
fn other(metadata: &[(&str, &[(&str, &str)])]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = WriteOptions::new().profile("ros2").create(&mut bytes).expect("memory");
    for (name, pairs) in metadata {
        let metadata: BTreeMap<String, String> = pairs.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
        writer.write_metadata(&Metadata { name: name.to_string(), metadata }).expect("memory");
    }
    writer.finish().expect("memory");
    drop(writer);
    bytes.into_inner()
}

#[test]
fn what_is_no_log_is_refused_with_its_reason() {
    assert!(refusal(b"time,q.a\n0,1\n").contains("no log in MCAP"));
    assert!(refusal(b"").contains("no log in MCAP"));
    assert!(refusal(&other(&[])).contains("log of another program"));
    let version = other(&[("hierarq", &[("version", "2")])]);
    assert!(refusal(&version).contains("have version 2, and this build of Hierarq reads version 1"));
    let empty = other(&[("hierarq", &[("version", "1")])]);
    assert!(refusal(&empty).contains("no attachment `program.json`"));
}

#[test]
fn a_log_that_was_cut_off_or_damaged_never_panics() {
    let run = recorded("hello.hq", None, 0.1);
    assert!(Log::read(&run.mcap).is_ok());
    let step = (run.mcap.len() / 60).max(1);
    for end in (1..run.mcap.len()).step_by(step) {
        assert!(Log::read(&run.mcap[..end]).is_err(), "cut at {end}");
    }
    let cut = &run.mcap[..run.mcap.len() / 2];
    assert!(matches!(Log::read(cut), Err(LogError::Truncated)), "{}", refusal(cut));
    for at in (0..run.mcap.len()).step_by(step / 3 + 1) {
        let mut bytes = run.mcap.clone();
        bytes[at] ^= 0x55;
        if let Ok(log) = Log::read(&bytes) {
            let _ = replay(&log, &mut |_| true);
            let _ = csv::write(&log, &mut Vec::new());
        }
    }
}

#[test]
fn a_message_that_was_cut_off_never_panics() {
    let run = recorded("room.hq", Some("through the room"), 0.02);
    for message in mcap::MessageStream::new(&run.mcap).expect("MCAP") {
        let message = message.expect("a message");
        let topic = Topic::ALL.into_iter().find(|t| t.name() == message.channel.topic).expect("a channel of ours");
        let schema = Schema::new(&topic.definition().text());
        assert!(schema.decode(&message.data).is_ok());
        for end in (0..message.data.len()).step_by(7) {
            assert!(schema.decode(&message.data[..end]).is_err(), "{}: {end}", topic.name());
        }
    }
}

#[test]
fn a_log_in_csv_of_something_else_is_refused() {
    let run = recorded("hello.hq", None, 0.05);
    let simulation = simulation(&run.program, None);
    let refusal = |text: &str| match csv::Rows::new(text, &run.program, simulation.controller(), usize::MAX) {
        Err(e) => e.to_string(),
        Ok(mut rows) => rows.find_map(Result::err).map(|e| e.to_string()).unwrap_or_else(|| "good".to_string()),
    };
    assert_eq!(refusal(&run.csv), "good");
    assert!(refusal("").contains("empty"));
    assert!(refusal("a,b\n1,2\n").contains("no `log.csv` of a run"));
    let first = run.program.robot.q_names()[0].clone();
    let renamed = run.csv.replacen(&first, "other_joint", 1);
    let text = refusal(&renamed);
    assert!(text.contains("`q.other_joint`") && text.contains(&format!("`q.{first}`")), "{text}");
    let short: String = run.csv.lines().map(|l| format!("{}\n", l.rsplit_once(',').expect("cells").0)).collect();
    assert!(refusal(&short).contains("columns"), "{}", refusal(&short));
    let cut = &run.csv[..run.csv.len() - 40];
    assert!(refusal(cut).contains("cut off or damaged"), "{}", refusal(cut));
    let word = run.csv.replacen("\n0,", "\nzero,", 1);
    assert!(refusal(&word).contains("line 2: `zero` in column `time` is not a number"), "{}", refusal(&word));
    let mut lines: Vec<String> = run.csv.lines().map(str::to_string).collect();
    lines[3].push_str("broken");
    assert!(refusal(&lines.join("\n")).contains("line 4: there is no fault `broken`"));
}

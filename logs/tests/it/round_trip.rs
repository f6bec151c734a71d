//! The content of a log against the run: rows against `log.csv`, poses against kinematics computed anew, closest points against
//! margins, the URDF against the model that it was written from.

use std::collections::BTreeMap;

use hierarq_logs::about::sha256;
use hierarq_logs::decode::{Leaf, Schema, Value};
use hierarq_logs::{Log, csv};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use robot::{Data, LinkId, Model, Options};

use crate::runs::recorded;

/// A message with its values.
struct Read {
    topic: String,
    time: u64,
    leaves: Vec<Leaf>,
}

fn messages(bytes: &[u8]) -> Vec<Read> {
    let mut all = Vec::new();
    for message in mcap::MessageStream::new(bytes).expect("MCAP") {
        let message = message.expect("a message");
        let schema = message.channel.schema.as_ref().expect("each channel has a definition");
        assert_eq!((message.channel.message_encoding.as_str(), schema.encoding.as_str()), ("cdr", "ros2msg"));
        assert!(message.channel.metadata.contains_key("offered_qos_profiles"));
        let schema = Schema::new(std::str::from_utf8(&schema.data).expect("text"));
        let leaves = schema.decode(&message.data).expect("a message of its definition");
        all.push(Read { topic: message.channel.topic.clone(), time: message.log_time, leaves });
    }
    all
}

impl Read {
    fn numbers(&self, prefix: &str) -> Vec<f64> {
        let number = |leaf: &Leaf| match leaf.value {
            Value::Number(x) => Some(x),
            _ => None,
        };
        self.leaves.iter().filter(|leaf| leaf.path.starts_with(prefix)).filter_map(number).collect()
    }

    fn text(&self, path: &str) -> Option<&str> {
        self.leaves.iter().find(|leaf| leaf.path == path).and_then(|leaf| match &leaf.value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }
}

#[test]
fn csv_from_mcap_is_the_log_of_the_run() {
    for (name, scenario, seconds) in [
        ("safety_tasks.hq", None, 0.3),
        ("room.hq", Some("through the room"), 0.4),
        ("protective_stop.hq", Some("comes near and leaves"), 6.0),
        ("free_flyer.hq", None, 0.2),
        ("handover.hq", None, 0.5),
    ] {
        let run = recorded(name, scenario, seconds);
        let log = Log::read(&run.mcap).expect("a log");
        let mut text = Vec::new();
        let ticks = csv::write(&log, &mut text).expect("memory");
        assert_eq!(ticks, log.ticks, "{name}");
        assert!(String::from_utf8(text).expect("text") == run.csv, "{name}: the texts differ");
    }
}

#[test]
fn a_log_says_what_ran() {
    let run = recorded("protective_stop.hq", Some("comes near and leaves"), 0.1);
    let log = Log::read(&run.mcap).expect("a log");
    assert_eq!(log.program, run.about.program);
    assert_eq!(log.scenario(), run.scenario.as_ref());
    let summary = mcap::Summary::read(&run.mcap).expect("MCAP").expect("a summary");
    let names: Vec<&str> = summary.attachment_indexes.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["program.json", "source/protective_stop.hq"]);
    let spec = mcap::read::attachment(&run.mcap, &summary.attachment_indexes[1]).expect("an attachment");
    let about = mcap::read::metadata(&run.mcap, &summary.metadata_indexes[0]).expect("metadata").metadata;
    assert_eq!(about["spec_sha256"], sha256(&spec.data));
    assert_eq!(spec.data, run.about.sources[0].text.as_bytes());
    assert_eq!((about["scenario"].as_str(), about["seed"].as_str()), ("comes near and leaves", "0"));
    // FIPS 180-4, example of one block.
    assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

fn isometry(numbers: &[f64]) -> Isometry3<f64> {
    let [x, y, z, i, j, k, w] = *numbers else { panic!("a pose has seven numbers: {numbers:?}") };
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)))
}

/// Poses of links in the world, from all transforms up to a time.
fn world(frames: &BTreeMap<String, (String, Isometry3<f64>)>, link: &str) -> Isometry3<f64> {
    match frames.get(link) {
        Some((parent, pose)) => world(frames, parent) * pose,
        None => Isometry3::identity(),
    }
}

#[test]
fn transforms_lead_to_the_poses_of_all_links() {
    for (name, scenario) in [("room.hq", Some("through the room")), ("free_flyer.hq", None), ("handover.hq", None)] {
        let run = recorded(name, scenario, 0.2);
        let model = &run.program.robot.model;
        let mut data = Data::new(model);
        let (mut frames, mut rows, mut compared) = (BTreeMap::new(), BTreeMap::new(), 0);
        for message in messages(&run.mcap) {
            if message.topic == "/hierarq/columns" {
                rows.insert(message.time, message.numbers("data"));
            }
            if !message.topic.starts_with("/tf") {
                continue;
            }
            let mut i = 0;
            while let Some(child) = message.text(&format!("transforms[{i}].child_frame_id")) {
                let parent = message.text(&format!("transforms[{i}].header.frame_id")).expect("a parent").to_string();
                let pose = isometry(&message.numbers(&format!("transforms[{i}].transform")));
                frames.insert(child.to_string(), (parent, pose));
                i += 1;
            }
            let Some(row) = rows.get(&message.time).filter(|_| message.topic == "/tf") else { continue };
            model.forward(&row[1..1 + model.nq()], &mut data);
            for (i, link) in model.links.iter().enumerate() {
                let expected = data.pose(LinkId(i as u32));
                let found = world(&frames, &link.name);
                assert!(
                    (found.translation.vector - expected.translation.vector).norm() < 1e-9,
                    "{name}: {}",
                    link.name
                );
                assert!(found.rotation.angle_to(&expected.rotation) < 1e-7, "{name}: {}", link.name);
                compared += 1;
            }
        }
        assert!(compared >= 5 * model.links.len(), "{name}: {compared}");
    }
}

#[test]
fn the_closest_line_of_a_limit_is_as_long_as_its_margin_and_distance() {
    // d_min of the walls and of the pairs in the examples.
    for (name, scenario, task, d_min) in [
        ("safety_tasks.hq", None, "arms_apart", 0.2),
        ("safety_tasks.hq", None, "head_clear", 0.5),
        ("room.hq", Some("through the room"), "clear", 0.05),
        ("room.hq", Some("through the room"), "above_floor", 0.02),
    ] {
        let run = recorded(name, scenario, 0.1);
        let names: Vec<&str> = run.csv.lines().next().expect("a header").split(',').collect();
        let column = names.iter().position(|n| *n == format!("margin.{task}")).expect("a margin");
        let all = messages(&run.mcap);
        let rows = all.iter().filter(|m| m.topic == "/hierarq/columns").map(|m| (m.time, m.numbers("data")));
        let rows: BTreeMap<u64, Vec<f64>> = rows.collect();
        // There is no state: the row and the columns of the file are the same but for the fault.
        let mut compared = 0;
        for message in all.iter().filter(|m| m.topic == "/closest_points") {
            let marker = (0..).take_while(|i| message.text(&format!("markers[{i}].ns")).is_some());
            let marker = marker.into_iter().find(|i| message.text(&format!("markers[{i}].ns")) == Some(task));
            let marker = marker.expect("a marker of the task");
            let points = message.numbers(&format!("markers[{marker}].points"));
            let points: Vec<Vector3<f64>> = points.chunks(3).map(Vector3::from_column_slice).collect();
            let least = points.chunks(2).map(|p| (p[1] - p[0]).norm()).fold(f64::INFINITY, f64::min);
            let margin = rows[&message.time][column - usize::from(names[1] == "state")];
            assert!((least - d_min - margin).abs() < 1e-9, "{task}: {least} and {margin}");
            compared += 1;
        }
        assert!(compared >= 5, "{task}: {compared}");
    }
}

#[test]
fn the_description_has_the_same_kinematics() {
    for name in ["safety_tasks.hq", "hello.hq", "rover.hq"] {
        let run = recorded(name, None, 0.02);
        let message = messages(&run.mcap).into_iter().find(|m| m.topic == "/robot_description").expect("a description");
        let model = &run.program.robot.model;
        let options = Options { base: model.root_base(), ..Options::default() };
        let (again, _) = Model::from_urdf(message.text("data").expect("a text"), &options).expect("a URDF");
        let (mut a, mut b) = (Data::new(model), Data::new(&again));
        let mut q = run.program.robot.home.clone();
        assert_eq!((model.nq(), model.nv()), (again.nq(), again.nv()), "{name}");
        for step in 0..5 {
            let free = model.root_base().nq();
            q[free..].iter_mut().enumerate().for_each(|(i, x)| *x += 0.1 * f64::from(step) * ((i % 3) as f64 - 1.0));
            model.forward(&q, &mut a);
            again.forward(&q, &mut b);
            for (i, link) in model.links.iter().enumerate() {
                let other = again.link(&link.name).expect("the same links");
                let (x, y) = (a.pose(LinkId(i as u32)), b.pose(other));
                assert!((x.translation.vector - y.translation.vector).norm() < 1e-9, "{name}: {}", link.name);
                assert!(x.rotation.angle_to(&y.rotation) < 1e-7, "{name}: {}", link.name);
            }
        }
    }
}

#[test]
fn states_and_people_are_told_when_they_change() {
    let run = recorded("protective_stop.hq", Some("comes near and leaves"), 8.0);
    let all = messages(&run.mcap);
    let states: Vec<&str> = all.iter().filter(|m| m.topic == "/state").filter_map(|m| m.text("data")).collect();
    let mut expected: Vec<&str> = run.csv.lines().skip(1).filter_map(|l| l.split(',').nth(1)).collect();
    expected.dedup();
    assert!(states.len() > 1 && states == expected, "{states:?} {expected:?}");
    let people = all.iter().filter(|m| m.topic == "/people").filter(|m| !m.numbers("markers[0].points").is_empty());
    assert!(people.count() > 10);
    let diagnostics = all.iter().find(|m| m.topic == "/diagnostics").expect("diagnostics");
    assert!(diagnostics.leaves.iter().any(|l| l.value == Value::Text("at_bound".to_string())));
}

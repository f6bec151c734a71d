//! Logs read by libraries of others: `rosbags` and `mcap-ros2-support` from PyPI, in an interpreter that `HIERARQ_PYTHON` names;
//! `.ci/python` makes one.

use std::path::Path;
use std::process::Command;

use crate::runs::recorded;

#[test]
fn other_libraries_read_the_same_numbers() {
    let Some(python) = std::env::var_os("HIERARQ_PYTHON") else {
        println!("not run: HIERARQ_PYTHON names no interpreter with rosbags and mcap-ros2-support");
        return;
    };
    let imports =
        Command::new(&python).args(["-c", "import rosbags, mcap_ros2"]).output().expect("the interpreter runs");
    if !imports.status.success() {
        println!("not run: {}", String::from_utf8_lossy(&imports.stderr));
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (name, scenario) in
        [("safety_tasks", None), ("room", Some("through the room")), ("protective_stop", Some("comes near and leaves"))]
    {
        let run = recorded(&format!("{name}.hq"), scenario, 3.0);
        let (mcap, csv) = (folder.join(format!("{name}.mcap")), folder.join(format!("{name}.csv")));
        std::fs::write(&mcap, &run.mcap).expect("a file");
        std::fs::write(&csv, &run.csv).expect("a file");
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_back.py");
        let mut command = Command::new(&python);
        let output = command.arg(script).args([&mcap, &csv]).env("PYTHONDONTWRITEBYTECODE", "1").output();
        let output = output.expect("the interpreter runs");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{name}: {text}\n{}", String::from_utf8_lossy(&output.stderr));
        println!("{text}");
    }
}

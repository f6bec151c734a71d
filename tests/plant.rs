//! Runs with masses and drives: the examples in both spellings, and what is said where MuJoCo is missing.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn with(library: Option<&str>, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
    command.args(arguments);
    if let Some(library) = library {
        command.env("HIERARQ_MUJOCO", library);
    }
    command.output().expect("it runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_run_with_a_plant_says_how_to_install_its_physics() {
    let out = with(Some("/nowhere"), &["test", "physics/examples/hand_guiding.hq"]);
    let said = text(&out.stdout) + &text(&out.stderr);
    assert_eq!(out.status.code(), Some(2), "{said}");
    let words: Vec<&str> = said.split(|c: char| c.is_whitespace() || c == '│').filter(|w| !w.is_empty()).collect();
    let said = words.join(" ");
    assert!(said.contains("MuJoCo is not installed"), "{said}");
    assert!(said.contains("python3 -m pip install mujoco"), "{said}");
    // It is checked without.
    let out = with(Some("/nowhere"), &["check", "--strict", "physics/examples/hand_guiding.hq"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
}

/// Loss of distance to the person in a scenario of 4.C with a parameter, until the person leans over (m), and the expectations that fail. The scenario expects at
/// most `most`.
fn lost(scenario: &str, most: f64, parameter: &str) -> (f64, Vec<String>) {
    let spec = "physics/examples/beside_harvest.hq";
    let out = with(None, &["test", spec, "--scenario", scenario, "--set", parameter, "--json"]);
    let results: serde_json::Value = serde_json::from_str(&text(&out.stdout)).expect("JSON");
    let expectations = results["scenarios"][0]["expectations"].as_array().expect("expectations");
    let label = |e: &serde_json::Value| e["label"].as_str().unwrap_or_default().to_owned();
    let failed = expectations.iter().filter(|e| e["verdict"] != "holds").map(label).collect();
    let kept =
        expectations.iter().find(|e| label(e).starts_with("no more than")).unwrap_or_else(|| panic!("{results}"));
    (most - kept["margin"].as_f64().expect("a margin"), failed)
}

#[test]
fn a_declared_lag_makes_up_for_the_drives() {
    if std::env::var_os("HIERARQ_MUJOCO").is_none() {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo");
        return;
    }
    // Nobody having declared the drives, 4, 3 and 18 mm are lost, which the scenarios expect. The spec's reserve is half a millimetre.
    for (scenario, most, lag, but) in [
        ("drives of 50 ms", 5e-3, "lag=50ms", "but 3 mm is"),
        ("position drives of 10 ms", 4e-3, "lag=20ms", "but 2 mm is"),
        ("position drives of 50 ms", 19e-3, "lag=100ms", "but 16 mm is"),
    ] {
        let (lost, failed) = lost(scenario, most, lag);
        assert!(lost < 0.7e-3, "{scenario}: {lost} m");
        assert_eq!(failed, [but]);
    }
}

#[test]
fn a_reserve_makes_up_for_drives_that_nobody_declared() {
    if std::env::var_os("HIERARQ_MUJOCO").is_none() {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo");
        return;
    }
    let (lost, failed) = lost("position drives of 50 ms", 19e-3, "reserve=20mm");
    assert!(lost < 20e-3, "{lost} m");
    assert_eq!(failed, [""; 0]);
}

#[test]
fn the_examples_do_with_masses_what_they_say() {
    if std::env::var_os("HIERARQ_MUJOCO").is_none() {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo");
        return;
    }
    let out = with(None, &["test", "physics/examples"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{said}\n{}", text(&out.stderr));
    assert!(!said.contains("FAILS") && said.contains("position drives"), "{said}");
}

/// An empty folder of its own.
fn empty(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("plant_{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// A folder of its own with a spec, whose drives have no limit of torque and are far faster than the time step.
fn diverging(name: &str) -> PathBuf {
    let folder = empty(name);
    let robot = std::fs::read_to_string("physics/tests/robots/pendulum.urdf").expect("a robot");
    std::fs::write(folder.join("pendulum.urdf"), robot.replace("effort=\"200\"", "effort=\"0\"")).expect("written");
    let spec = "hierarq 1
robot r { urdf \"pendulum.urdf\"  rate 500 Hz  home { shoulder 0.4 rad  elbow -0.7 rad } }
task swing = joint_velocity { velocity 0.5*sin(time/(0.3 s)) rad/s }
stack s { level l hard { joint_velocity_limits }  level motion { swing } }
run { stack s  duration 2 s  plant mujoco { actuators position  response 0.01 ms  step 2 ms } }
scenario wild { stack s  duration 2 s  expect always speed(all) < 100 rad/s }
";
    std::fs::write(folder.join("wild.hq"), spec).expect("written");
    folder
}

#[test]
fn a_run_that_diverges_says_so_and_keeps_what_it_recorded() {
    if std::env::var_os("HIERARQ_MUJOCO").is_none() {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo");
        return;
    }
    let folder = diverging("run");
    let (spec, out) = (folder.join("wild.hq"), folder.join("out"));
    let (spec, out) = (spec.display().to_string(), out.display().to_string());
    let ran = with(None, &["run", &spec, "--out", &out]);
    let said = text(&ran.stdout);
    assert_eq!(ran.status.code(), Some(1), "{said}\n{}", text(&ran.stderr));
    assert!(said.contains("FAILED") && said.contains("has diverged: a shorter `step` than 2 ms"), "{said}");
    assert!(
        said.contains("MuJoCo ") && said.contains("moved the robot, in steps of 2 ms, by drives of positions"),
        "{said}"
    );
    let summary = std::fs::read_to_string(format!("{out}/summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["ok"], false);
    let why = summary["diverged"].as_str().expect("a reason");
    assert!(why.starts_with("at 0.") && why.contains("has diverged"), "{why}");
    assert!(summary["plant"]["engine"].as_str().is_some_and(|name| name.starts_with("MuJoCo ")), "{summary}");
    assert_eq!((&summary["plant"]["step_s"], &summary["plant"]["actuators"]), (&0.002.into(), &"position".into()));
    // All ticks until then are in the log, and the report tells the reason.
    let ticks = summary["ticks"].as_u64().expect("a number") as usize;
    assert!((1..1000).contains(&ticks), "{ticks}");
    let log = std::fs::read_to_string(format!("{out}/log.csv")).expect("a log");
    assert_eq!(log.lines().count(), ticks + 1);
    let report = std::fs::read_to_string(format!("{out}/report.html")).expect("a report");
    assert!(report.contains("The run ended early: at 0.") && report.contains("moved the robot"), "no reason");
    // MuJoCo leaves no log of its own in the working folder.
    assert!(!Path::new("MUJOCO_LOG.TXT").exists());
}

#[test]
fn a_scenario_that_diverges_fails_whatever_it_expects() {
    if std::env::var_os("HIERARQ_MUJOCO").is_none() {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo");
        return;
    }
    let spec = diverging("test").join("wild.hq").display().to_string();
    let ran = with(None, &["test", &spec]);
    let said = text(&ran.stdout);
    assert_eq!(ran.status.code(), Some(1), "{said}");
    assert!(said.contains("FAILS") && said.contains("ended early") && said.contains("moved the robot"), "{said}");
}

#[test]
fn a_member_of_a_mission_whose_simulation_diverges_breaks_down() {
    if std::env::var_os("HIERARQ_MUJOCO").is_none() {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo");
        return;
    }
    let folder = empty("mission");
    std::fs::create_dir(folder.join("robots")).expect("a folder");
    let read = |name: &str| std::fs::read_to_string(format!("examples/{name}")).expect("an example");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    write("vineyard_picker.hq", &read("vineyard_picker.hq"));
    let plant = "scenario \"two boxes\" { plant mujoco { actuators position  response 0.05 ms  step 10 ms }";
    write("picker.hq", &read("picker.hq").replacen("scenario \"two boxes\" {", plant, 1));
    // Without limits of torques.
    let robot = read("robots/arm7.urdf");
    let efforts: Vec<&str> = robot.split("effort=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let strong = efforts.iter().fold(robot.clone(), |text, n| text.replace(&format!("effort=\"{n}\""), "effort=\"0\""));
    write("robots/arm7.urdf", &strong);
    let spec = folder.join("vineyard_picker.hq").display().to_string();
    let ran = with(None, &["test", &spec, "--scenario", "the arm picks", "--json"]);
    let results: serde_json::Value = serde_json::from_str(&text(&ran.stdout)).expect("JSON");
    let worker = &results["scenarios"][0]["mission"]["workers"][0];
    let why = worker["broke_down"]["why"].as_str().unwrap_or_else(|| panic!("{results}\n{}", text(&ran.stderr)));
    assert!(why.contains("MuJoCo") && why.contains("has diverged"), "{why}");
    assert_eq!(ran.status.code(), Some(1), "{results}");
}

#[test]
fn a_plant_is_missing_in_a_sentence() {
    let out = with(Some("/nowhere"), &["run", "physics/examples/hand_guiding.hq", "--scenario", "drives of 5 ms"]);
    let said = text(&out.stderr);
    let words: Vec<&str> = said.split(|c: char| c.is_whitespace() || c == '│').filter(|w| !w.is_empty()).collect();
    let said = words.join(" ");
    assert!(said.contains("this run has a `plant`, and MuJoCo is not installed"), "{said}");
    assert!(!said.contains("run.simulator"), "{said}");
}

/// Folder of robots of the package `example-robot-data`, beside the interpreter of the tests.
fn robots_of_others() -> Option<PathBuf> {
    let python = PathBuf::from(std::env::var_os("HIERARQ_PYTHON")?);
    let versions = std::fs::read_dir(python.parent()?.parent()?.join("lib")).ok()?;
    let robots = |lib: std::fs::DirEntry| lib.path().join("site-packages/cmeel.prefix/share/example-robot-data/robots");
    versions.flatten().map(robots).find(|folder| folder.is_dir())
}

/// Arms of others are told to go 15 cm through a hard floor: one of 6 joints at 125 Hz, and one of 7 at 1 kHz.
#[test]
fn arms_of_others_hold_a_hard_floor() {
    let Some(robots) = robots_of_others().filter(|_| std::env::var_os("HIERARQ_MUJOCO").is_some()) else {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo, or HIERARQ_PYTHON no interpreter with example-robot-data");
        return;
    };
    let ur10 = (
        "ur_description/urdf/ur10_robot.urdf",
        125,
        "tool0",
        "wrist_3_link",
        "all [0, -1.2, 1.6, -1.97, -1.57, 0] rad",
    );
    let home = "panda_joint2 -0.785 rad  panda_joint4 -2.356 rad  panda_joint6 1.571 rad  panda_joint7 0.785 rad";
    let panda = ("panda_description/urdf/panda.urdf", 1000, "panda_hand", "panda_hand", home);
    let folder = empty("arms");
    for (k, (urdf, rate, tip, link, home)) in [ur10, panda].into_iter().enumerate() {
        let urdf = robots.join(urdf);
        // Servos of positions as they are, that nobody compensates for weights; servos of velocities fall with them.
        let servos = [
            "response 20 ms".to_owned(),
            "actuators position  response 20 ms".to_owned(),
            format!("actuators position  response 20 ms  gravity uncompensated  payload {{ link {link}  mass 2 kg }}"),
        ];
        let scenario = |(i, servo): (usize, &String)| {
            format!(
                "scenario s{i} {{ plant mujoco {{ {servo} }}
  expect always margin(floor) >= -0.5 mm  expect eventually margin(floor) < 1 mm  expect never fault }}\n"
            )
        };
        let spec = format!(
            "hierarq 1
robot arm {{ urdf \"{}\"  rate {rate} Hz  home {{ {home} }} }}
task floor = keep(frame({tip}).position.z) {{ min initial(frame({tip}).position.z) - 0.15 m  gain 5 /s }}
task down = frame_position({tip}) {{ position initial(position) + [0, 0, -0.3] m * min(1, time/(3 s))  gain 4 /s }}
stack s {{
  level l hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits {{ max 15 rad/s^2 }} }}
  level f hard {{ floor }}
  level m {{ down }}
}}
run {{ stack s  duration 6 s }}
{}",
            urdf.display(),
            servos.iter().enumerate().map(scenario).collect::<String>()
        );
        let path = folder.join(format!("arm_{k}.hq"));
        std::fs::write(&path, spec).expect("written");
        let out = with(None, &["test", &path.display().to_string()]);
        assert_eq!(out.status.code(), Some(0), "{}\n{}", text(&out.stdout), text(&out.stderr));
    }
}

//! The command line for users and scripts: exit codes, files, JSON.

use crate::common;
use crate::common::cli;

use cli::{folder, hierarq, text};

#[test]
fn check_says_good_or_what_is_wrong() {
    let good = hierarq(&["check", "examples/hello.hq", "examples/hello.yaml"]);
    assert_eq!(good.status.code(), Some(0), "{}", text(&good.stderr));
    assert_eq!(text(&good.stdout), "examples/hello.hq: good\nexamples/hello.yaml: good\n");

    let missing = hierarq(&["check", "examples/helo.hq"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(text(&missing.stderr).contains("did you mean `examples/hello.hq`?"), "{}", text(&missing.stderr));

    let usage = hierarq(&["check"]);
    assert_eq!(usage.status.code(), Some(2));
}

#[test]
fn check_json_has_codes_and_places() {
    let dir = folder("check_json");
    let spec = dir.join("bad.hq");
    std::fs::write(&spec, "hierarq 1\nstack s { level l { frame_pos(tool) } }\n").expect("writable");
    let out = hierarq(&["check", "--json", spec.to_str().expect("UTF-8")]);
    assert_eq!(out.status.code(), Some(1));
    let data: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!(data["ok"], false);
    assert!(data["errors"].as_u64() >= Some(1));
    let first = &data["diagnostics"][0];
    assert!(first["code"].as_str().expect("a code").starts_with("HQ"));
    assert!(first["place"]["line"].as_u64() >= Some(1));
}

#[test]
fn check_fix_mends_what_is_certain() {
    let dir = folder("check_fix");
    let urdf = crate::common::example("robots/arm7.urdf");
    let good = format!(
        "hierarq 1\n\nrobot arm {{\n  urdf \"{}\"\n  rate 100 Hz\n  tracking_gain 0.5 /s\n}}\n\n\
         task go = hold(tool) // stay\n\nstack s {{ level limits hard {{ joint_acceleration_limits }}  level l {{ go }} }}\n",
        urdf.display()
    );
    // Each is a slip with one reading; all of them stand in the text at once.
    let slips = [
        ("hierarq 1\n\n", ""),
        ("robot arm {", "robot arm"),
        ("rate 100", "rate: 100"),
        ("gain 0.5", "gain .5"),
        ("go =", "go :"),
        ("// stay", "# stay"),
    ];
    let bad = slips.iter().fold(good.clone(), |text, (right, wrong)| text.replace(right, wrong));
    for (name, before) in [("spec.hq", bad.clone()), ("marked.hq", format!("\u{feff}{bad}"))] {
        let spec = dir.join(name);
        std::fs::write(&spec, &before).expect("writable");
        // Plain `check` names the option, and leaves the file as it is.
        let out = hierarq(&["check", spec.to_str().expect("UTF-8")]);
        assert!(
            text(&out.stdout).ends_with("of them have a certain fix: `hierarq check --fix` applies them\n"),
            "{}",
            text(&out.stdout)
        );
        assert_eq!(std::fs::read_to_string(&spec).expect("readable"), before);
        let out = hierarq(&["check", "--fix", spec.to_str().expect("UTF-8")]);
        assert_eq!(out.status.code(), Some(0), "{}{}", text(&out.stdout), text(&out.stderr));
        let (mended, mark) = (std::fs::read_to_string(&spec).expect("readable"), before.starts_with('\u{feff}'));
        assert_eq!(mended, format!("{}{}", if mark { "\u{feff}" } else { "" }, good.replacen("1\n\n", "1\n", 1)));
        let said = text(&out.stdout);
        assert_eq!(said.lines().count(), slips.len() + 1, "{said}");
        assert!(said.ends_with(": good\n") && said.contains(":3: Delete `:`\n"), "{said}");
    }

    // A misspelt name may mean something else, so that the file stays as it is.
    let doubtful = good.replace("hold(tool)", "hold(tol)");
    let spec = dir.join("doubtful.hq");
    std::fs::write(&spec, &doubtful).expect("writable");
    let out = hierarq(&["check", "--fix", "--json", spec.to_str().expect("UTF-8")]);
    assert_eq!(out.status.code(), Some(1));
    assert_eq!(std::fs::read_to_string(&spec).expect("readable"), doubtful);
    let data: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!(data["applied"], serde_json::json!([]));
    let fix = &data["diagnostics"][0]["fixes"][0];
    assert_eq!((&fix["title"], &fix["certain"]), (&"Write `tool`".into(), &false.into()));
    assert_eq!(fix["edits"][0]["new"], "tool");
    let place = &fix["edits"][0]["place"];
    let range = ["start", "end"].map(|k| place[k].as_u64().expect("a byte") as usize);
    assert_eq!(&doubtful[range[0]..range[1]], "tol");
}

#[test]
fn check_fix_mends_yaml() {
    let dir = folder("check_fix_yaml");
    let spec = dir.join("spec.yaml");
    let example = std::fs::read_to_string(crate::common::example("hello.yaml")).expect("readable");
    let urdf = crate::common::example("robots/arm7.urdf");
    let good = example.replace("robots/arm7.urdf", urdf.to_str().expect("UTF-8"));
    let quoted = "\"initial(position) + [0, 0.2, 0.1] m * sin(pi*t/(4 s))\"";
    assert_eq!(good.matches(quoted).count(), 1);
    std::fs::write(&spec, good.replace(quoted, quoted.trim_matches('"'))).expect("writable");
    let out = hierarq(&["check", "--fix", spec.to_str().expect("UTF-8")]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(text(&out.stdout).contains(": Put it in quotes\n"), "{}", text(&out.stdout));
    assert_eq!(std::fs::read_to_string(&spec).expect("readable"), good);
}

#[test]
fn run_writes_its_three_files_and_prints_the_summary() {
    let dir = folder("run");
    let out = dir.join("out");
    let path = out.to_str().expect("UTF-8");
    let run = hierarq(&["run", "examples/cooperative_motion.yaml", "--duration", "0.5", "--json", "--out", path]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!(summary["program"], "cooperative_motion");
    assert_eq!(summary["ticks"], 50);
    assert_eq!(summary["duration_s"], 0.5);
    assert_eq!(summary["faults"], serde_json::json!([]));
    assert!(summary["tasks"]["deck"]["min_margin"].as_f64() > Some(0.0));
    assert!(summary["tasks"]["motion"]["max_error"].as_f64() < Some(1e-3));
    assert!(summary["tasks"]["motion"]["final_error"].is_number());
    for key in ["median", "p99", "max"] {
        assert!(summary["tick_us"][key].is_number());
    }
    assert_eq!(summary["outputs"].as_array().map(Vec::len), Some(3));
    let written: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).expect("written")).expect("JSON");
    assert_eq!(written, summary);

    let log = std::fs::read_to_string(out.join("log.csv")).expect("written");
    let mut lines = log.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    for column in [
        "time",
        "q.base_x",
        "q.arm_left_4",
        "v.base_forward",
        "cmd.torso_lift",
        "margin.deck",
        "error.motion",
        "error.motion.absolute.position",
    ] {
        assert!(header.contains(&column), "{column} in {header:?}");
    }
    let rows: Vec<Vec<&str>> = lines.map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 50);
    assert!(rows.iter().all(|r| r.len() == header.len()));
    assert_eq!(rows[49][0].parse::<f64>().expect("a number"), 0.49);

    let html = std::fs::read_to_string(out.join("report.html")).expect("written");
    assert!(!html.contains("@@HIERARQ_DATA@@") && html.contains("\"program\":\"cooperative_motion\""));
    let data =
        html.split("id=\"hierarq-data\">").nth(1).and_then(|s| s.split("</script>").next()).expect("the data element");
    let data: serde_json::Value = serde_json::from_str(data).expect("the data is JSON");
    assert_eq!(data["ticks"], 50);
    assert!(data["plots"].as_array().is_some_and(|p| p.len() > 5));
}

#[test]
fn a_compiled_program_runs_without_its_source_and_to_the_last_bit() {
    let dir = folder("compiled");
    let file = dir.join("hello.json");
    let compiled = hierarq(&["compile", "examples/hello.hq", "--format", "json"]);
    assert_eq!(compiled.status.code(), Some(0));
    std::fs::write(&file, &compiled.stdout).expect("writable");
    let mut logs = Vec::new();
    for (i, spec) in ["examples/hello.hq", file.to_str().expect("UTF-8"), "examples/hello.yaml"].iter().enumerate() {
        let out = dir.join(format!("out{i}"));
        let run = hierarq(&["run", spec, "--duration", "1", "--out", out.to_str().expect("UTF-8")]);
        assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
        logs.push(std::fs::read(out.join("log.csv")).expect("written"));
    }
    assert_eq!(logs[0], logs[1]);
    assert_eq!(logs[0], logs[2]);
}

#[test]
fn broken_programs_and_unwritable_places_are_said() {
    let dir = folder("broken");
    let file = dir.join("p.json");
    std::fs::write(&file, "{\"format\": 1}").expect("writable");
    let run = hierarq(&["run", file.to_str().expect("UTF-8")]);
    assert_eq!(run.status.code(), Some(1));
    assert!(text(&run.stderr).contains("HQ0607"), "{}", text(&run.stderr));

    let blocker = dir.join("file");
    std::fs::write(&blocker, "").expect("writable");
    let run = hierarq(&["run", "examples/hello.hq", "--out", blocker.join("x").to_str().expect("UTF-8")]);
    assert_eq!(run.status.code(), Some(2));
    assert!(text(&run.stderr).contains("cannot create"), "{}", text(&run.stderr));

    for (time, ticks) in [("50ms", "5 ticks"), ("0.1 s", "10 ticks"), ("0.2", "20 ticks")] {
        let out = dir.join("short");
        let run = hierarq(&["run", "examples/hello.hq", "--duration", time, "--out", out.to_str().expect("UTF-8")]);
        assert!(text(&run.stdout).contains(&format!("\n{ticks}")), "{time}: {}", text(&run.stdout));
    }
    for wrong in ["-3", "0", "2 m", "soon", "1e400", "nan"] {
        let run = hierarq(&["run", "examples/hello.hq", "--duration", wrong]);
        assert_eq!(run.status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn a_run_that_fails_exits_with_one() {
    let dir = folder("fails");
    let spec = dir.join("fails.hq");
    let urdf = common::example("robots/arm7.urdf");
    let body = format!(
        "hierarq 1\nrobot arm {{ urdf \"{}\"  rate 100 Hz  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}\n\
         stack s {{ level motion {{ frame_position(tool) {{ position initial(position) + [0, 0, 0.01] m / (0.5 - t/(1 s)) }} }} }}\n\
         run {{ duration 1 s }}\n",
        urdf.display()
    );
    std::fs::write(&spec, body).expect("writable");
    let out = dir.join("out");
    let run = hierarq(&["run", spec.to_str().expect("UTF-8"), "--out", out.to_str().expect("UTF-8")]);
    assert_eq!(run.status.code(), Some(1), "{}", text(&run.stdout));
    assert!(text(&run.stdout).contains("FAILED"), "{}", text(&run.stdout));
    assert!(out.join("report.html").exists() && out.join("log.csv").exists(), "what happened is kept");
}

#[test]
fn tasks_and_explain() {
    let list = text(&hierarq(&["tasks"]).stdout);
    for kind in stdlib_tasks::KINDS {
        assert!(list.contains(kind.name));
        let page = hierarq(&["tasks", kind.name]);
        assert_eq!(page.status.code(), Some(0));
        assert!(text(&page.stdout).contains("Source:"), "{}", kind.name);
    }
    assert_eq!(hierarq(&["tasks", "virtual_wal"]).status.code(), Some(2));
    assert!(text(&hierarq(&["tasks", "virtual_wal"]).stderr).contains("`virtual_wall`"));
    for code in compiler::codes::all() {
        assert_eq!(hierarq(&["explain", code.code]).status.code(), Some(0));
    }
    assert_eq!(hierarq(&["explain", "HQ9999"]).status.code(), Some(2));
}

#[test]
fn fmt_changes_the_file_only_when_it_can_read_all_of_it() {
    let dir = folder("fmt");
    let spec = dir.join("a.hq");
    let name = spec.to_str().expect("UTF-8");
    std::fs::write(&spec, "hierarq 1\n\n// kept\nparam   a=1 m\n").expect("writable");
    assert_eq!(hierarq(&["fmt", "--check", name]).status.code(), Some(1));
    assert_eq!(hierarq(&["fmt", name]).status.code(), Some(0));
    assert_eq!(std::fs::read_to_string(&spec).expect("readable"), "hierarq 1\n\n// kept\nparam a = 1 m\n");
    assert_eq!(hierarq(&["fmt", "--check", name]).status.code(), Some(0));

    let broken = "hierarq 1\nparam a = \nstack { \n";
    std::fs::write(&spec, broken).expect("writable");
    assert_eq!(hierarq(&["fmt", name]).status.code(), Some(1));
    assert_eq!(std::fs::read_to_string(&spec).expect("readable"), broken, "nothing of the user's is lost");
}

#[test]
fn set_overrides_a_parameter() {
    let dir = folder("set");
    let spec = dir.join("p.hq");
    let urdf = common::example("robots/arm7.urdf");
    let body = format!(
        "hierarq 1\nparam speed = 0.1 rad/s\nrobot arm {{ urdf \"{}\"  rate 100 Hz }}\n\
         stack s {{ level l {{ joint_velocity {{ velocity {{ joint_1 speed }} }} }} }}\nrun {{ duration 1 s }}\n",
        urdf.display()
    );
    std::fs::write(&spec, body).expect("writable");
    let name = spec.to_str().expect("UTF-8");
    assert!(text(&hierarq(&["compile", name]).stdout).contains("joint_1 0.1"));
    assert!(text(&hierarq(&["compile", name, "--set", "speed=20 deg/s"]).stdout).contains("joint_1 0.349066"));
    let wrong = hierarq(&["check", name, "--set", "speed=2 m"]);
    assert_eq!(wrong.status.code(), Some(1));
    let unknown = hierarq(&["check", name, "--set", "sped=2 rad/s"]);
    assert!(text(&unknown.stderr).contains("did you mean `speed`?"), "{}", text(&unknown.stderr));
    assert_eq!(hierarq(&["check", name, "--set", "speed"]).status.code(), Some(2));
}

/// An interruption ends the run, and the written files are readable.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_whole_files() {
    let out = folder("interrupted");
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_hierarq"))
        .args(["run", "examples/hello.hq", "--duration", "100000", "--out"])
        .arg(&out)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("it starts");
    // The run has started once the log has a few rows on the disk.
    let log = out.join("log.csv");
    while std::fs::metadata(out.join("log.csv.part")).map_or(0, |m| m.len()) < 100_000 {
        assert_eq!(child.try_wait().expect("a child"), None, "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("there is a `kill`").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(1));
    let log = std::fs::read_to_string(log).expect("a log");
    let columns = |line: &str| line.split(',').count();
    let wanted = columns(log.lines().next().expect("a header"));
    assert!(log.ends_with('\n') && log.lines().all(|l| columns(l) == wanted));
    let summary = std::fs::read_to_string(out.join("summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["interrupted"], true);
    assert_eq!(summary["ticks"].as_u64(), Some(log.lines().count() as u64 - 1));
    assert!(std::fs::read_to_string(out.join("report.html")).expect("a report").ends_with("</html>\n"));
}

/// Each optional command needs a feature, `full` is all of them, and each has an answer in a build without it.
#[test]
fn features_are_commands() {
    let text = |path: &str| std::fs::read_to_string(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path));
    let manifest: toml_edit::Document<String> = text("Cargo.toml").expect("readable").parse().expect("TOML");
    let features = manifest["features"].as_table().expect("a table");
    let single: Vec<&str> = features.iter().map(|(name, _)| name).filter(|name| *name != "full").collect();
    let full: Vec<&str> =
        features["full"].as_array().expect("a list").iter().filter_map(|name| name.as_str()).collect();
    assert_eq!(full, single);
    let (absent, help) = (text("src/cli/absent.rs").expect("readable"), hierarq(&["--help"]));
    for name in single {
        let of_feature = format!(" = \"{name}\"");
        let list = absent.split("absent!(").nth(1).and_then(|rest| rest.split(");").next()).expect("a list");
        let commands: Vec<&str> = list.split(',').filter_map(|entry| entry.trim().strip_suffix(&of_feature)).collect();
        // Physics adds no command: it is for all that run something.
        assert_eq!(commands.is_empty(), name == "physics", "{name}");
        for command in commands {
            assert!(self::text(&help.stdout).contains(&format!("\n  {} ", command.trim())), "{command}");
        }
    }
    assert!(!self::text(&help.stdout).contains("does not contain"), "tests are of a build with all features");
}

/// Allowed warnings of a spec are counted and listed wherever its warnings would be, with the reason, and stay in the compiled program.
#[test]
fn allowed_warnings_are_listed() {
    let dir = folder("allowed");
    let spec = dir.join("carry.hq");
    let urdf = common::example("robots/arm7.urdf");
    let body = format!(
        "hierarq 1\nrobot arm {{ urdf \"{}\"  rate 100 Hz  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}\n\
         stack s {{\n  level limits hard {{ joint_velocity_limits }}\n  level tray {{ hold(tool) }}\n  \
         level gentle hard {{ allow HQ0606 \"soft on purpose\"  joint_acceleration_limits }}\n}}\n\
         run {{ duration 0.1 s }}\n",
        urdf.display()
    );
    std::fs::write(&spec, &body).expect("writable");
    let path = spec.to_str().expect("UTF-8");
    let check = hierarq(&["check", "--strict", path]);
    assert_eq!(check.status.code(), Some(0));
    let said = text(&check.stdout);
    assert!(said.contains("carry.hq:6:16: allowed HQ0606") && said.contains("  soft on purpose\n"), "{said}");
    assert!(said.ends_with("carry.hq: good, 1 warning allowed\n"), "{said}");
    let data: serde_json::Value = serde_json::from_slice(&hierarq(&["check", "--json", path]).stdout).expect("JSON");
    assert_eq!(data["warnings"], 0);
    assert_eq!(data["allowed"][0]["reason"], "soft on purpose");
    assert_eq!((&data["allowed"][0]["place"]["line"], &data["allowed"][0]["by"]["line"]), (&6.into(), &6.into()));
    let program = text(&hierarq(&["compile", path]).stdout);
    assert!(program.contains("allowed 1 warning\n  HQ0606 ") && program.contains("\"soft on purpose\""), "{program}");
    let compiled = dir.join("carry.json");
    std::fs::write(&compiled, hierarq(&["compile", "--format", "json", path]).stdout).expect("writable");
    let out = dir.join("out");
    let out = out.to_str().expect("UTF-8");
    // A compiled program runs without its spec, and still says so.
    for of in [path, compiled.to_str().expect("UTF-8")] {
        let run = hierarq(&["run", of, "--out", out]);
        assert!(
            text(&run.stdout).contains("The spec allows a warning: HQ0606 (soft on purpose)."),
            "{}",
            text(&run.stdout)
        );
        for file in ["report.html", "summary.json"] {
            let held = std::fs::read_to_string(dir.join("out").join(file)).expect("written");
            assert!(held.contains("soft on purpose"), "{file}");
        }
    }
    // Without the reason it is an error, and with an error there is no program.
    std::fs::write(&spec, body.replace("\"soft on purpose\"", "")).expect("writable");
    assert_eq!(hierarq(&["check", path]).status.code(), Some(1));
}

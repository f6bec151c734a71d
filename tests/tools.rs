//! The commands around a spec: `init`, `watch`, `schema`, `completions`, `man`, as a user meets them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

#[path = "tools/init.rs"]
mod init;
#[path = "tools/schema.rs"]
mod schema;
#[cfg(unix)]
#[path = "tools/watch.rs"]
mod watch;

fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
    command.args(args).env("NO_COLOR", "1").env("COLUMNS", "100").current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

fn hierarq(args: &[&str]) -> Output {
    command(args).output().expect("the binary runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn utf8(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// A folder of this test's own, empty at the start.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("tools").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("writable");
    path
}

/// The commands, as `--help` lists them.
fn commands() -> Vec<String> {
    let help = text(&hierarq(&["--help"]).stdout);
    let list = help.split("Commands:").nth(1).and_then(|t| t.split("Options:").next()).expect("a list of commands");
    let names = list.lines().filter(|l| l.starts_with("  ") && !l.starts_with("   "));
    names.filter_map(|l| l.split_whitespace().next()).filter(|n| *n != "help").map(str::to_string).collect()
}

#[test]
fn completions_name_every_command() {
    let commands = commands();
    assert!(commands.len() >= 13, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let out = hierarq(&["completions", shell]);
        assert_eq!(out.status.code(), Some(0), "{shell}");
        let script = text(&out.stdout);
        for name in &commands {
            assert!(script.contains(name), "{shell}: {name}");
        }
        assert!(script.contains("package-path"), "{shell}: options too");
    }
    assert_eq!(hierarq(&["completions", "tcsh"]).status.code(), Some(2));
}

#[test]
fn bash_reads_its_completions() {
    let script = text(&hierarq(&["completions", "bash"]).stdout);
    let ask = format!(
        "{script}\nCOMP_WORDS=(hierarq wat) COMP_CWORD=1\n_hierarq hierarq wat hierarq\necho \"${{COMPREPLY[@]}}\"\n"
    );
    let Ok(out) = Command::new("bash").args(["--norc", "-c", &ask]).output() else { return };
    assert_eq!(text(&out.stdout).trim(), "watch", "{}", text(&out.stderr));
}

#[test]
fn man_pages_name_every_command_and_its_options() {
    let page = text(&hierarq(&["man"]).stdout);
    assert!(page.contains(".TH") && page.contains("hierarq"), "{page}");
    for name in commands() {
        assert!(page.contains(&format!("hierarq\\-{name}(1)")), "{name}:\n{page}");
        let own = hierarq(&["man", &name]);
        assert_eq!(own.status.code(), Some(0), "{name}");
        assert!(text(&own.stdout).contains(&format!("hierarq\\-{name} \\-")), "{}", text(&own.stdout));
    }
    assert!(text(&hierarq(&["man", "run"]).stdout).contains("\\-\\-duration"));
    let wrong = hierarq(&["man", "chek"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(text(&wrong.stderr).contains("`check`"), "{}", text(&wrong.stderr));
}

//! The commands `init`, `watch`, `schema`, `completions` and `man` for users.

use std::path::Path;
use std::process::Command;

use cli::{command, folder, hierarq, text};

use crate::common::cli;
mod init;
mod robot;
mod schema;
#[cfg(unix)]
mod watch;

fn utf8(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Returns the commands listed by `--help`.
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

//! `hierarq watch SPEC`
//!
//! Watches the folders of the spec, of its imports and of its URDFs, because editors replace files as often as they
//! write them. Only the content counts: an event in a folder without a changed file has no effect.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use clap::Args;
use hierarq::project;
use notify::event::{AccessKind, AccessMode};
use notify::{Event, EventKind, RecursiveMode, Watcher};

use super::{Outcome, SpecOptions, interruption, output};

/// Saving a file causes several events; it is complete after this time without one.
const QUIET: Duration = Duration::from_millis(100);

/// Maximum waiting time in a folder with permanent events.
const PATIENCE: Duration = Duration::from_secs(1);

/// Maximum size of a file whose content is compared (bytes): that of a URDF.
const MAX_WATCHED: u64 = 64 << 20;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`).
    spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Run the spec each time that it compiles; a change of a file ends the current run.
    #[arg(long)]
    run: bool,
    /// Folder for the results of the runs [default: out/NAME].
    #[arg(long, value_name = "DIR", requires = "run")]
    out: Option<PathBuf>,
    /// Duration of the run, in place of the spec's: `2s`, `500ms`; a number without a unit is in seconds.
    #[arg(long, value_name = "TIME", value_parser = super::duration, allow_hyphen_values = true, requires = "run")]
    duration: Option<f64>,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    // Also if interruptions were ignored at the start, as shells do for background jobs.
    let _ = interruption::answer(|| std::process::exit(130));
    let (sender, events) = channel();
    let mut watcher = notify::recommended_watcher(sender).map_err(|e| format!("cannot watch files: {e}"))?;
    let mut watched = BTreeSet::new();
    loop {
        let files = files(&a.spec);
        for folder in folders(&files) {
            if watched.contains(&folder) {
                continue;
            }
            match watcher.watch(&folder, RecursiveMode::NonRecursive) {
                Ok(()) => {
                    watched.insert(folder);
                }
                Err(e) if watched.is_empty() => {
                    return Err(format!("cannot watch {}: {e}", folder.display()));
                }
                // The folder of a URDF may not exist yet; the report says so.
                Err(_) => {}
            }
        }
        // Read before the check: a change during the check is detected.
        let before = contents(&files);
        let mut running = report(a)?;
        let changed = wait(&events, || contents(&files) != before);
        if let Some(child) = &mut running {
            // Fails if the run has ended already, which is fine.
            let _ = child.kill();
            let _ = child.wait();
        }
        changed?;
    }
}

/// Returns the spec, the files that it imports, and their URDFs, as far as all these are readable.
fn files(spec: &Path) -> Vec<PathBuf> {
    let mut files = vec![spec.to_path_buf()];
    let Ok((syntax, text)) = project::read(spec) else { return files };
    files.extend(compiler::files(&compiler::Input {
        name: &spec.display().to_string(),
        text: &text,
        syntax,
        folder: spec.parent().unwrap_or(Path::new("")),
        set: &[],
        package_paths: &[],
    }));
    files
}

/// Returns the folders of the files, and the folders to which links to them lead.
fn folders(files: &[PathBuf]) -> Vec<PathBuf> {
    let real = files.iter().filter_map(|f| f.canonicalize().ok());
    let parent = |f: PathBuf| {
        let folder = f.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf())
    };
    files.iter().cloned().chain(real).map(parent).collect()
}

fn contents(files: &[PathBuf]) -> Vec<Option<Vec<u8>>> {
    files.iter().map(|f| files::read(f, MAX_WATCHED).ok()).collect()
}

/// Checks the spec, prints the result, and starts a run if requested.
fn report(a: &Arguments) -> Result<Option<Child>, String> {
    let compiled = project::compile(&a.spec, &a.options.settings());
    let runs = compiled.program.is_some();
    // A run prints the report of its own compilation.
    if !(a.run && runs) {
        output::show(&compiled.report);
    }
    let mut state = output::count(&compiled.report).unwrap_or_else(|| "good".to_string());
    if a.run && !runs && compiled.is_good() {
        state += ", only missions, nothing to run";
    }
    output::print(&format!("{}: {state}; waiting for changes, Ctrl-C ends\n", a.spec.display()));
    if !(a.run && runs) {
        return Ok(None);
    }
    let program = std::env::current_exe().map_err(|e| format!("cannot find this program: {e}"))?;
    let mut command = Command::new(program);
    command.arg("run").arg(&a.spec).stdin(Stdio::null());
    for (name, value) in &a.options.set {
        command.arg("--set").arg(format!("{name}={value}"));
    }
    for path in &a.options.package_path {
        command.arg("--package-path").arg(path);
    }
    if let Some(out) = &a.out {
        command.arg("--out").arg(out);
    }
    if let Some(duration) = a.duration {
        command.arg("--duration").arg(duration.to_string());
    }
    command.spawn().map(Some).map_err(|e| format!("cannot start the run: {e}"))
}

/// Returns true for events that may change a text; reading a file causes events too.
fn stirs(event: &Event) -> bool {
    !matches!(event.kind, EventKind::Access(kind) if kind != AccessKind::Close(AccessMode::Write))
}

/// Waits until a file has changed and no further events occur.
fn wait(events: &Receiver<notify::Result<Event>>, changed: impl Fn() -> bool) -> Result<(), String> {
    let lost = |e: &dyn std::fmt::Display| format!("cannot watch files any longer: {e}");
    loop {
        match events.recv() {
            Ok(Ok(event)) if stirs(&event) => {}
            Ok(Ok(_)) => continue,
            Ok(Err(e)) => return Err(lost(&e)),
            Err(e) => return Err(lost(&e)),
        }
        let (mut last, first) = (Instant::now(), Instant::now());
        while first.elapsed() < PATIENCE {
            match events.recv_timeout(QUIET.saturating_sub(last.elapsed())) {
                Ok(Ok(event)) if stirs(&event) => last = Instant::now(),
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => break,
                Err(e) => return Err(lost(&e)),
            }
        }
        if changed() {
            return Ok(());
        }
    }
}

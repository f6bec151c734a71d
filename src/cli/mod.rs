//! The command line: arguments of all commands, and the exit code.
//!
//! 0 success, 1 the spec or the run failed, 2 wrong usage or a file that cannot be written.

#[cfg_attr(feature = "full", allow(dead_code, reason = "no command is absent"))]
mod absent;
mod backend;
mod bench;
mod check;
mod compile;
mod completions;
#[cfg(feature = "context")]
mod context;
#[cfg(feature = "mcap")]
mod convert;
mod coverage;
mod diff;
mod explain;
mod fmt;
mod graph;
mod init;
mod interruption;
mod learn;
#[cfg(feature = "lsp")]
mod lsp;
mod man;
#[cfg(feature = "mcap")]
mod mcap_log;
mod output;
mod plan;
#[cfg(feature = "mcap")]
mod replay;
mod robot;
#[cfg(feature = "ros")]
mod ros;
mod run;
mod run_mission;
mod sampled;
mod schema;
#[cfg(feature = "serve")]
mod serve;
mod solve;
#[cfg(feature = "sweep")]
mod sweep;
mod table;
mod tasks;
mod test;
#[cfg(feature = "watch")]
mod watch;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use hierarq::project::Settings;

#[cfg(not(feature = "context"))]
use self::absent::context;
#[cfg(not(feature = "lsp"))]
use self::absent::lsp;
#[cfg(not(feature = "ros"))]
use self::absent::ros;
#[cfg(not(feature = "serve"))]
use self::absent::serve;
#[cfg(not(feature = "sweep"))]
use self::absent::sweep;
#[cfg(not(feature = "watch"))]
use self::absent::watch;
#[cfg(not(feature = "mcap"))]
use self::absent::{convert, mcap_log, replay};

/// Task hierarchies for robots that work beside people: check a spec, compile it, run it.
#[derive(Parser)]
#[command(name = "hierarq", version, about, max_term_width = 100, after_help = absent::listed())]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Create a project: a spec that runs, for a URDF or for an example arm.
    Init(init::Arguments),
    /// Check specs and report all errors and warnings.
    Check(check::Arguments),
    /// Print the compiled program.
    Compile(compile::Arguments),
    /// Show the robot of a spec: groups, named postures, and pairs of links that are not kept apart.
    Robot(robot::Arguments),
    /// Compare the behaviour of two specs, or of a spec and a compiled program.
    Diff(diff::Arguments),
    /// Draw the machine of a spec: Mermaid, Graphviz or SVG.
    Graph(graph::Arguments),
    /// Run a spec, or a compiled program, on the simulated robot.
    Run(run::Arguments),
    /// Run a spec on a robot with ROS 2: a node that reads joints and sensors, and sends commands.
    Ros(ros::Arguments),
    /// Run the program in a log in MCAP again, and compare every bit.
    Replay(replay::Arguments),
    /// Convert the log of a run: `log.csv` to MCAP, or MCAP to `log.csv`.
    Convert(convert::Arguments),
    /// Run the scenarios of specs and evaluate their expectations.
    Test(test::Arguments),
    /// Generate the layers of a mission with a language model, until they pass all checks.
    Context(context::Arguments),
    /// Plan a mission: assignments, times and speeds.
    Plan(plan::Arguments),
    /// Train a policy of the person of a mission, from demonstrations or from rewards.
    Learn(learn::Arguments),
    /// Run a scenario over ranges of params and over seeds, and write a row for each run.
    Sweep(sweep::Arguments),
    /// List the task types, or describe one in full.
    Tasks(tasks::Arguments),
    /// Explain a diagnostic code.
    Explain(explain::Arguments),
    /// Format specs, or convert them to the other syntax.
    Fmt(fmt::Arguments),
    /// Serve web pages of a mission: one for each person, and one for the supervisor.
    Serve(serve::Arguments),
    /// Solve a file of hierarchical problems; check and time the solutions.
    Solve(solve::Arguments),
    /// Measure the time of the closed loop of a spec, and of the solvers on its problems.
    Bench(bench::Arguments),
    /// Run the language server over standard input and output.
    Lsp(lsp::Arguments),
    /// Check a spec, and optionally run it, each time that it or its URDF is saved.
    Watch(watch::Arguments),
    /// Print a JSON Schema: of the YAML syntax, for editors, or of plans.
    Schema(schema::Arguments),
    /// Print the completions of commands and options for a shell.
    Completions(completions::Arguments),
    /// Print a manual page.
    Man(man::Arguments),
}

/// Options of compilation.
#[derive(Args, Clone, Debug)]
struct SpecOptions {
    /// Override a `param` of the spec, such as `--set approach=0.2m`. May be repeated.
    #[arg(long, value_name = "NAME=VALUE", value_parser = name_value)]
    set: Vec<(String, String)>,
    /// Folder in which `package://` addresses of a URDF are searched. May be repeated.
    #[arg(long, value_name = "DIR")]
    package_path: Vec<PathBuf>,
}

impl SpecOptions {
    fn settings(&self) -> Settings {
        Settings { set: self.set.clone(), package_paths: self.package_path.clone() }
    }
}

/// Parses a time in s: `2`, `2s`, `2 s`, `500ms`.
fn duration(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E');
    let unit = compiler::units::time(text[number.len()..].trim());
    let seconds = number.trim().parse::<f64>().ok().zip(unit).map(|(x, unit)| x * unit);
    seconds.filter(|s| s.is_finite()).ok_or_else(|| "write a time such as `2`, `2s`, `500ms` or `1min`".to_string())
}

fn name_value(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=VALUE")?;
    let (name, value) = (name.trim(), value.trim());
    let plain =
        name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') && !name.starts_with(|c: char| c.is_ascii_digit());
    if name.is_empty() || !plain || value.is_empty() || value.contains(['\n', '\r']) {
        return Err("write NAME=VALUE on one line, with a name of letters, digits and `_`".to_string());
    }
    Ok((name.to_string(), value.to_string()))
}

/// Result of a command. Another failure, which has not been reported yet, is the text of an error.
enum Outcome {
    /// Success.
    Good,
    /// The spec or the run failed; the reason has been reported.
    Failed,
}

impl Outcome {
    fn of(good: bool) -> Outcome {
        if good { Outcome::Good } else { Outcome::Failed }
    }
}

/// Parses the command line and runs the command.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => return told(&e),
    };
    #[cfg(feature = "physics")]
    physics::provide();
    let outcome = match cli.command {
        Command::Init(a) => init::run(&a),
        Command::Check(a) => check::run(&a),
        Command::Compile(a) => compile::run(&a),
        Command::Robot(a) => robot::run(&a),
        Command::Diff(a) => diff::run(&a),
        Command::Graph(a) => graph::run(&a),
        Command::Run(a) => run::run(&a),
        Command::Replay(a) => replay::run(&a),
        Command::Convert(a) => convert::run(&a),
        Command::Test(a) => test::run(&a),
        Command::Context(a) => context::run(&a),
        Command::Plan(a) => plan::run(&a),
        Command::Learn(a) => learn::run(&a),
        Command::Sweep(a) => sweep::run(&a),
        Command::Tasks(a) => tasks::run(&a),
        Command::Explain(a) => explain::run(&a),
        Command::Fmt(a) => fmt::run(&a),
        Command::Ros(a) => ros::run(&a),
        Command::Serve(a) => serve::run(&a),
        Command::Solve(a) => solve::run(&a),
        Command::Bench(a) => bench::run(&a),
        Command::Lsp(a) => lsp::run(&a),
        Command::Watch(a) => watch::run(&a),
        Command::Schema(a) => schema::run(&a),
        Command::Completions(a) => completions::run(&a),
        Command::Man(a) => man::run(&a),
    };
    let code = match outcome {
        Ok(Outcome::Good) => 0,
        Ok(Outcome::Failed) => 1,
        Err(text) => {
            output::error_line(&text);
            2
        }
    };
    exit_code(code)
}

/// Prints the help, or the error of an invalid command line.
fn told(e: &clap::Error) -> ExitCode {
    let shown = e.print();
    if !e.use_stderr() {
        output::printed(shown.and_then(|()| std::io::stdout().flush()));
    }
    exit_code(u8::try_from(e.exit_code()).unwrap_or(2))
}

/// Returns the exit code; 2 for any command whose output was lost.
fn exit_code(code: u8) -> ExitCode {
    match output::unwritten() {
        None => ExitCode::from(code),
        Some(text) => {
            output::error_line(text);
            ExitCode::from(2)
        }
    }
}

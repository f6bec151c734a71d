//! `hierarq context SPEC [MISSION]`

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use context::answer::part;
use context::endpoint::{Chat, Endpoint};
use context::generate::{Bounds, GenerateError};
use context::layers::layers;
use context::prompt::{Wish, prompt};
use context::transcript::{self, Exchange, Replay};
use files::Target;
use hierarq::{outputs, planned, project};
use mission::layers::json::{Imported, Mode, export, export_plan};
use runtime::program::MissionKind;

use super::{Outcome, SpecOptions, output};

/// The variable in which a key is looked for.
const KEY: &str = "HIERARQ_API_KEY";

/// Largest transcript that is replayed, in bytes.
const MAX_TRANSCRIPT: u64 = 256 << 20;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    spec: PathBuf,
    /// The mission, one of layers; may be left out where the spec declares one alone.
    mission: Option<String>,
    #[command(flatten)]
    options: SpecOptions,
    /// The server, with the interface of OpenAI's chat completions: `http://127.0.0.1:8080/v1`. A key is taken from the
    /// environment, HIERARQ_API_KEY.
    #[arg(long, value_name = "URL", required_unless_present_any = ["replay", "prompt"], requires = "model")]
    endpoint: Option<String>,
    /// The name of the model at that server.
    #[arg(long, value_name = "NAME")]
    model: Option<String>,
    /// Take the answers from a transcript instead of a server.
    #[arg(long, value_name = "FILE", conflicts_with = "endpoint")]
    replay: Option<PathBuf>,
    /// Print what the model is told, and ask nobody.
    #[arg(long)]
    prompt: bool,
    /// What the mission is, instead of the `instruction` of the spec.
    #[arg(long, value_name = "TEXT")]
    instruction: Option<String>,
    /// What the model decides.
    #[arg(long, value_enum, default_value_t = Decides::Layers)]
    decides: Decides,
    /// Write the layers into this file instead of printing them: `layers_from` reads it, unless the model decided everything.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Keep everything that is said in this file [default: MISSION.transcript.jsonl, except with --replay]. Where there is one
    /// already, a number is put into the name.
    #[arg(long, value_name = "FILE")]
    transcript: Option<PathBuf>,
    /// Answers that are looked at.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100))]
    attempts: u32,
    /// The longest time that one answer may take.
    #[arg(long, value_name = "TIME", default_value = "120s", value_parser = super::duration)]
    timeout: f64,
    /// Temperature of the model's sampling; the server's where left out.
    #[arg(long, value_name = "X")]
    temperature: Option<f64>,
}

/// How much is left to the model.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Decides {
    /// Tasks and their layers; the rest is optimised.
    Layers,
    /// Also who does each task with which object; speeds and times are optimised.
    Allocation,
    /// Everything; nothing is optimised.
    Everything,
}

impl Decides {
    fn mode(self) -> Mode {
        match self {
            Decides::Layers => Mode::Context,
            Decides::Allocation => Mode::Allocated,
            Decides::Everything => Mode::Scheduled,
        }
    }
}

pub fn run(a: &Arguments) -> Outcome {
    let compiled = project::load(&a.spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, &a.spec, false);
    }
    output::show(&compiled.report);
    let mission = match planned::find(&compiled.missions, a.mission.as_deref()) {
        Ok(mission) => mission,
        Err(message) => return Outcome::Trouble(format!("{}: {message}", a.spec.display())),
    };
    let MissionKind::Layers(program) = &mission.kind else {
        let text = format!(
            "the mission `{}` is a schedule; a model is asked for the layers of a mission of layers",
            mission.name
        );
        return Outcome::Trouble(text);
    };
    let Some(instruction) = a.instruction.as_deref().or(program.instruction.as_deref()) else {
        let text = format!(
            "nobody says what is to be done: write `instruction \"..\"` in `{}`, or `--instruction`",
            mission.name
        );
        return Outcome::Trouble(text);
    };
    let wish = Wish { problem: &program.problem, instruction, directives: &program.directives, mode: a.decides.mode() };
    if a.prompt {
        for message in prompt(&wish) {
            output::print(&format!("--- {:?}\n{}\n", message.role, message.content));
        }
        return Outcome::Good;
    }
    // Before anybody is asked.
    let sources = [a.spec.clone()];
    let target = a.out.as_deref().map(|path| Target::new("--out", path, outputs::LAYERS, &sources)).transpose();
    let target = match target {
        Ok(target) => target,
        Err(trouble) => return Outcome::Trouble(trouble),
    };
    match ask(a, &mission.name, &wish) {
        Ok(imported) => finish(target, &imported),
        Err(outcome) => outcome,
    }
}

/// Asks the server, or the transcript.
fn ask(a: &Arguments, mission: &str, wish: &Wish) -> Result<Imported, Outcome> {
    let mut chat: Box<dyn Chat> = match (&a.replay, &a.endpoint) {
        (Some(path), _) => {
            let said = files::read(path, MAX_TRANSCRIPT)
                .map_err(|e| Outcome::Trouble(format!("cannot read `{}`: {e}", path.display())))?;
            let exchanges =
                transcript::read(said.as_slice()).map_err(|e| Outcome::Trouble(format!("{}: {e}", path.display())))?;
            Box::new(Replay::new(exchanges))
        }
        (None, endpoint) => Box::new(server(a, endpoint.as_deref().unwrap_or_default())?),
    };
    let path = match (&a.transcript, &a.replay) {
        (Some(path), Some(from)) if path == from || files::is_same(path, from) => {
            let text = format!("`{}` is replayed: name another file for `--transcript`", path.display());
            return Err(Outcome::Trouble(text));
        }
        (Some(path), _) => Some(path.clone()),
        (None, Some(_)) => None,
        (None, None) => Some(PathBuf::from(format!("{mission}.transcript.jsonl"))),
    };
    let mut kept = path.map(|path| files::begin(&path)).transpose().map_err(Outcome::Trouble)?;
    let attempts = usize::try_from(a.attempts).unwrap_or(usize::MAX);
    let pause = if a.replay.is_some() { Duration::ZERO } else { Bounds::default().pause };
    let bounds = Bounds { attempts, pause, ..Bounds::default() };
    let answered = layers(chat.as_mut(), wish, &bounds, |exchange| {
        say(exchange);
        kept.as_mut().map_or(Ok(()), |(file, _)| transcript::write(file, exchange))
    });
    if let Some((_, path)) = &kept {
        output::eprint(&format!("everything that was said: {}\n", path.display()));
    }
    answered.map_err(|error| {
        let reasons = match &error {
            GenerateError::Refused { reasons, .. } => reasons.iter().map(|reason| format!("\n  {reason}")).collect(),
            _ => String::new(),
        };
        output::eprint(&format!("{error}{reasons}\n"));
        Outcome::Failed
    })
}

fn server(a: &Arguments, address: &str) -> Result<Endpoint, Outcome> {
    let timeout = Duration::try_from_secs_f64(a.timeout).ok().filter(|t| !t.is_zero());
    let timeout = timeout.ok_or_else(|| Outcome::Trouble("--timeout: a time above zero".to_string()))?;
    let key = std::env::var(KEY).ok().filter(|key| !key.is_empty());
    let endpoint = Endpoint::new(address, a.model.as_deref().unwrap_or_default(), key.as_deref(), timeout)
        .map_err(|error| Outcome::Trouble(error.to_string()))?;
    Ok(match a.temperature {
        Some(temperature) => endpoint.with_temperature(temperature),
        None => endpoint,
    })
}

/// What became of an attempt, for who waits.
fn say(exchange: &Exchange) {
    let Exchange { attempt, seconds, answered, refused, .. } = exchange;
    let text = match answered {
        Err(error) => format!("attempt {attempt}: {error}"),
        Ok(_) if refused.is_empty() => format!("attempt {attempt}: taken ({seconds:.1} s)"),
        Ok(text) => {
            let reasons: String = refused.iter().map(|reason| format!("\n  {reason}")).collect();
            let lines = part(text).and_then(|part| part.lines());
            let read = lines.map(|(from, to)| format!("; read were lines {from} to {to}")).unwrap_or_default();
            format!("attempt {attempt}: refused ({seconds:.1} s){read}{reasons}")
        }
    };
    output::eprint(&(text + "\n"));
}

/// Writes the layers, or the whole plan.
fn finish(target: Option<Target>, imported: &Imported) -> Outcome {
    let text = match &imported.plan {
        None => export(&imported.problem),
        Some(plan) => export_plan(&imported.problem, plan),
    };
    let Some(target) = target else {
        output::data(&text);
        return Outcome::Good;
    };
    let path = target.path().to_path_buf();
    if let Err(trouble) = target.write(&text) {
        return Outcome::Trouble(trouble);
    }
    let what = match &imported.plan {
        None => "",
        Some(_) => ", a whole plan, with times; `layers_from` reads layers, without `start` and `end`",
    };
    output::eprint(&format!("wrote {}{what}\n", path.display()));
    Outcome::Good
}

//! `hierarq context SPEC [MISSION]`

mod trials;

use std::fs::File;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use context::answer::part;
use context::endpoint::{Chat, Endpoint};
use context::generate::{Bounds, GenerateError, Wish, prompt, tasks};
use context::transcript::{self, Exchange, Replay};
use files::Target;
use hierarq::{outputs, project};
use mission::kind::Kind;
use mission::kind::generation::{self, Generated, Generation};

use super::{Outcome, SpecOptions, output, plan};

/// Name of the environment variable for the key.
const KEY: &str = "HIERARQ_API_KEY";

/// Maximum size of a replayed transcript (bytes).
const MAX_TRANSCRIPT: u64 = 256 << 20;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    spec: PathBuf,
    /// The mission, of the kind `layers`; may be omitted if the spec declares only one.
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
    /// Print the prompt, without a request to a model.
    #[arg(long)]
    prompt: bool,
    /// Instruction of the mission, in place of that of the spec.
    #[arg(long, value_name = "TEXT")]
    instruction: Option<String>,
    /// Decisions that the model makes; with --trials several, one after the other: `layers,allocation,everything`.
    #[arg(long, value_enum, default_values_t = [Decides::Layers], value_delimiter = ',')]
    decides: Vec<Decides>,
    /// Write the layers into this file instead of printing them: `layers_from` reads it, unless the model decided everything.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a transcript to this file [default: MISSION.transcript.jsonl, except with --replay]. If it exists, a number is
    /// added to the name.
    #[arg(long, value_name = "FILE")]
    transcript: Option<PathBuf>,
    /// Maximum number of answers [default: 5, with --trials 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    attempts: Option<u32>,
    /// Number of independent conversations; plans each result and prints a table of valid plans, costs and times.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), conflicts_with_all = ["out", "prompt", "json"])]
    trials: Option<u32>,
    /// Print the plan of a model that decided everything as JSON, as `hierarq plan --json` does.
    #[arg(long)]
    json: bool,
    /// Time limit for one answer.
    #[arg(long, value_name = "TIME", default_value = "120s", value_parser = super::duration)]
    timeout: f64,
    /// Sampling temperature of the model [default: the server's].
    #[arg(long, value_name = "X")]
    temperature: Option<f64>,
}

/// Decisions of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Decides {
    /// The tasks and their layers; the rest is optimised.
    Layers,
    /// Also the agent and object of each task; speeds and times are optimised.
    Allocation,
    /// Everything; nothing is optimised.
    Everything,
}

impl Decides {
    /// The same for the interface of missions.
    fn generation(self) -> generation::Decides {
        match self {
            Decides::Layers => generation::Decides::Tasks,
            Decides::Allocation => generation::Decides::Allocation,
            Decides::Everything => generation::Decides::Everything,
        }
    }
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let compiled = project::load(&a.spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, &a.spec, false);
    }
    output::show(&compiled.report);
    let mission = project::mission(&compiled.missions, a.mission.as_deref())
        .map_err(|message| format!("{}: {message}", a.spec.display()))?;
    let Some(of) = mission.kind.generation() else {
        let title = mission.kind.kind().title;
        return Err(format!("the mission `{}` is {title}, which takes no tasks from a model", mission.name));
    };
    let Some(instruction) = a.instruction.as_deref().or(of.instruction()) else {
        let text = format!(
            "the mission has no instruction: write `instruction \"..\"` in `{}`, or `--instruction`",
            mission.name
        );
        return Err(text);
    };
    let wish_of = |decides: Decides| Wish { mission: of, instruction, decides: decides.generation() };
    if let Some(trials) = a.trials {
        return trials::run(a, &mission.name, trials, &wish_of);
    }
    let [decides] = a.decides[..] else {
        let text = "several `--decides` need `--trials N`, which compares them";
        return Err(text.to_string());
    };
    if a.json && decides != Decides::Everything {
        let text = "`--json` prints a plan and needs `--decides everything`; to plan layers, use `hierarq plan --json`";
        return Err(text.to_string());
    }
    let wish = wish_of(decides);
    if a.prompt {
        for message in prompt(&wish) {
            output::print(&format!("--- {:?}\n{}\n", message.role, message.content));
        }
        return Ok(Outcome::Good);
    }
    // Checked before the model is asked.
    let sources = [a.spec.clone()];
    let target = a.out.as_deref().map(|path| Target::new("--out", path, outputs::LAYERS, &sources)).transpose()?;
    let Some(generated) = ask(a, &mission.name, &wish)? else { return Ok(Outcome::Failed) };
    finish(a, target, &Subject { name: &mission.name, kind: mission.kind.kind(), of }, &generated)
}

/// Asks the server, or replays the transcript. `None`: there is no answer, and the reason has been reported.
fn ask(a: &Arguments, mission: &str, wish: &Wish) -> Result<Option<Generated>, String> {
    let mut talk = talk(a, mission)?;
    let answered =
        tasks(talk.chat.as_mut(), wish, &bounds(a, 5), |exchange| talk.kept.keep(exchange, wish.mission.answer_keys()));
    talk.kept.tell();
    Ok(answered.map(Some).unwrap_or_else(|error| {
        let reasons = match &error {
            GenerateError::Refused { reasons, .. } => reasons.iter().map(|reason| format!("\n  {reason}")).collect(),
            _ => String::new(),
        };
        output::eprint(&format!("{error}{reasons}\n"));
        None
    }))
}

/// The model, and the writer of the transcript.
struct Talk {
    chat: Box<dyn Chat>,
    kept: Kept,
}

/// File and path of the written transcript, if any.
struct Kept(Option<(File, PathBuf)>);

impl Kept {
    /// Reports the result of an exchange, and writes it.
    fn keep(&mut self, exchange: &Exchange, answer_keys: &[&str]) -> std::io::Result<()> {
        say(exchange, answer_keys);
        self.0.as_mut().map_or(Ok(()), |(file, _)| transcript::write(file, exchange))
    }

    /// Reports the path of the transcript.
    fn tell(&self) {
        if let Some((_, path)) = &self.0 {
            output::eprint(&format!("transcript: {}\n", path.display()));
        }
    }
}

/// Returns the limits of a conversation; `usual` is the default number of attempts.
fn bounds(a: &Arguments, usual: u32) -> Bounds {
    let attempts = usize::try_from(a.attempts.unwrap_or(usual)).unwrap_or(usize::MAX);
    let pause = if a.replay.is_some() { Duration::ZERO } else { Bounds::default().pause };
    Bounds { attempts, pause, ..Bounds::default() }
}

/// Opens the server or the transcript, and the file of a new transcript.
fn talk(a: &Arguments, mission: &str) -> Result<Talk, String> {
    let chat: Box<dyn Chat> = match (&a.replay, &a.endpoint) {
        (Some(path), _) => {
            let said =
                files::read(path, MAX_TRANSCRIPT).map_err(|e| format!("cannot read `{}`: {e}", path.display()))?;
            let exchanges = transcript::read(said.as_slice()).map_err(|e| format!("{}: {e}", path.display()))?;
            Box::new(Replay::new(exchanges))
        }
        (None, endpoint) => Box::new(server(a, endpoint.as_deref().unwrap_or_default())?),
    };
    let path = match (&a.transcript, &a.replay) {
        (Some(path), Some(from)) if path == from || files::is_same(path, from) => {
            let text = format!("`{}` is replayed: name another file for `--transcript`", path.display());
            return Err(text);
        }
        (Some(path), _) => Some(path.clone()),
        (None, Some(_)) => None,
        (None, None) => Some(PathBuf::from(format!("{mission}.transcript.jsonl"))),
    };
    let kept = path.map(|path| files::begin(&path)).transpose()?;
    Ok(Talk { chat, kept: Kept(kept) })
}

fn server(a: &Arguments, address: &str) -> Result<Endpoint, String> {
    let timeout = Duration::try_from_secs_f64(a.timeout).ok().filter(|t| !t.is_zero());
    let timeout = timeout.ok_or_else(|| "--timeout: the time must be more than 0 s".to_string())?;
    let key = std::env::var(KEY).ok().filter(|key| !key.is_empty());
    let endpoint = Endpoint::new(address, a.model.as_deref().unwrap_or_default(), key.as_deref(), timeout)
        .map_err(|error| error.to_string())?;
    Ok(match a.temperature {
        Some(temperature) => endpoint.with_temperature(temperature),
        None => endpoint,
    })
}

/// Reports the result of an attempt.
fn say(exchange: &Exchange, answer_keys: &[&str]) {
    let Exchange { attempt, seconds, answered, refused, .. } = exchange;
    let text = match answered {
        Err(error) => format!("attempt {attempt}: {error}"),
        Ok(_) if refused.is_empty() => format!("attempt {attempt}: taken ({seconds:.1} s)"),
        Ok(text) => {
            let reasons: String = refused.iter().map(|reason| format!("\n  {reason}")).collect();
            let lines = part(text, answer_keys).and_then(|part| part.lines());
            let read = lines.map(|(from, to)| format!("; lines {from} to {to} were read")).unwrap_or_default();
            format!("attempt {attempt}: refused ({seconds:.1} s){read}{reasons}")
        }
    };
    output::eprint(&(text + "\n"));
}

/// A mission whose tasks a model wrote.
struct Subject<'s> {
    name: &'s str,
    kind: &'static Kind,
    of: &'s dyn Generation,
}

/// Writes the tasks, or the complete plan with its cost.
fn finish(
    a: &Arguments,
    target: Option<Target>,
    subject: &Subject<'_>,
    generated: &Generated,
) -> Result<Outcome, String> {
    if let Some(plan) = &generated.planned {
        let end = plan.chart.end().unwrap_or(0.0);
        output::eprint(&format!("all done after {end:.1} s; {}\n", plan.cost_text));
        if a.json {
            output::data(&plan::data(plan, &a.spec.display().to_string(), subject.name, subject.kind));
        }
    }
    let Some(target) = target else {
        if !a.json {
            output::data(&generated.text);
        }
        return Ok(Outcome::Good);
    };
    let path = target.path().to_path_buf();
    target.write(&generated.text)?;
    let what = match &generated.planned {
        None => String::new(),
        Some(_) => {
            let (key, noun) = (subject.of.key(), subject.of.noun());
            format!(", a complete plan with times; `{key}` takes {noun} without `start` and `end`")
        }
    };
    output::eprint(&format!("wrote {}{what}\n", path.display()));
    Ok(Outcome::Good)
}

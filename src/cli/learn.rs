//! `hierarq learn SPEC [MISSION]`: trains a policy of the person of a mission, from demonstrations or from rewards.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::Args;
use files::{Target, is_same};
use hierarq::{outputs, project};
use learning::demonstrations::{self, Trajectory};
use learning::grid::{Rewards, World};
use learning::training::{Progress, Run, Settings, Stage};

use super::{Outcome, SpecOptions, interruption, output};

/// Maximum size of demonstrations and checkpoints (bytes).
const MAX_READ: u64 = 256 << 20;
/// Steps between two progress lines, and between two checkpoints.
const LINE: u64 = 50_000;
/// Maximum number of steps of a training.
const MAX_STEPS: u64 = 1_000_000_000;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    spec: PathBuf,
    /// The mission; may be omitted if the spec declares only one.
    mission: Option<String>,
    #[command(flatten)]
    options: SpecOptions,
    /// Recorded ways of the person, one JSON object a line (`*.jsonl`). Without it, a synthetic person is trained on
    /// rewards first, and gives the demonstrations.
    #[arg(long, value_name = "FILE")]
    demonstrations: Option<PathBuf>,
    /// Values of the types of targets for the synthetic person; their number is the number of types of the policy.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', default_value = "0.5,1")]
    values: Vec<f64>,
    /// Least and greatest number of targets in the random environments.
    #[arg(long, value_name = "A..B", value_parser = range, default_value = "0..4")]
    targets: Range,
    /// Seed of all random numbers.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=9_000_000_000_000_000))]
    seed: u64,
    /// Steps of the training from demonstrations.
    #[arg(long, value_name = "N", default_value_t = 3_500_000, value_parser = clap::value_parser!(u64).range(1..=MAX_STEPS))]
    steps: u64,
    /// Steps of the training of the synthetic person.
    #[arg(long, value_name = "N", default_value_t = 1_600_000, value_parser = clap::value_parser!(u64).range(1..=MAX_STEPS))]
    surrogate_steps: u64,
    /// Demonstrations that the synthetic person gives.
    #[arg(long, value_name = "N", default_value_t = 8000, conflicts_with = "demonstrations", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    trajectories: u64,
    /// File of the policy [default: out/NAME/policy.safetensors].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the policy of the synthetic person to this file.
    #[arg(long, value_name = "FILE", conflicts_with = "demonstrations")]
    surrogate: Option<PathBuf>,
    /// Write a checkpoint to this file, again and again; Ctrl-C writes a last one.
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Continue from the checkpoint. The result is the same as without the interruption.
    #[arg(long, requires = "checkpoint")]
    resume: bool,
}

/// Least and greatest number of targets.
#[derive(Clone, Copy, Debug)]
struct Range {
    least: usize,
    most: usize,
}

fn range(text: &str) -> Result<Range, String> {
    let parsed = text.split_once("..").and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    let range = parsed.map(|(least, most)| Range { least, most });
    range.filter(|r| r.least <= r.most).ok_or_else(|| "write a range such as `0..4`".to_string())
}

/// The files that a training writes, checked before it begins.
struct Files {
    policy: Target,
    surrogate: Option<Target>,
    checkpoint: Option<Target>,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    // A spec may name the policies that are trained here, which do not exist yet or are of another grid.
    let compiled = project::load_unread(&a.spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, &a.spec, false);
    }
    output::show(&compiled.report);
    let mission = project::mission(&compiled.missions, a.mission.as_deref())
        .map_err(|message| format!("{}: {message}", a.spec.display()))?;
    let world = mission.kind.grid_world(a.values.len()).ok_or_else(|| {
        format!(
            "mission `{}` is {}, which has no person with a learned policy",
            mission.name,
            mission.kind.kind().title
        )
    })??;
    let files = Files::new(a, &mission.name, &project::sources(&a.spec, &compiled.report))?;
    let mut training = begin(a, &world)?;
    let name = &mission.name;
    output::eprint(&format!(
        "mission {name}: {} x {} cells, {} types of targets\n",
        world.columns(),
        world.rows(),
        world.types()
    ));
    train(a, &mut training, &files)
}

/// The training at its first step, or where its checkpoint left it.
fn begin(a: &Arguments, world: &World) -> Result<Run, String> {
    let rewards = Rewards { targets: a.values.clone(), ..Rewards::paper() };
    let settings = Settings {
        seed: a.seed,
        least_targets: a.targets.least,
        most_targets: a.targets.most,
        rewards,
        surrogate_steps: a.surrogate_steps,
        demonstrations: a.trajectories as usize,
        recovery_steps: a.steps,
        ..Settings::paper()
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let demonstrations = a.demonstrations.as_deref().map(|file| read(file, world)).transpose()?;
    if let Some(file) = a.checkpoint.as_deref().filter(|_| a.resume) {
        let bytes = files::read(file, MAX_READ).map_err(|e| format!("cannot read {}: {e}", file.display()))?;
        let run = Run::resume(&bytes).map_err(|e| format!("cannot continue from {}: {e}", file.display()))?;
        let differs = if run.world() != world {
            Some("world")
        } else if *run.settings() != settings {
            Some("settings")
        } else if demonstrations.as_deref().is_some_and(|of| of != run.demonstrations()) {
            Some("demonstrations")
        } else {
            None
        };
        return match differs {
            Some(what) => Err(format!("{} belongs to another training: its {what} differ", file.display())),
            None => Ok(run.with_threads(threads)),
        };
    }
    let run = match demonstrations {
        Some(demonstrations) => Run::from_demonstrations(world, settings, demonstrations),
        None => Run::new(world, settings),
    };
    run.map(|run| run.with_threads(threads)).map_err(|e| e.to_string())
}

fn read(file: &Path, world: &World) -> Result<Vec<Trajectory>, String> {
    let shown = file.display();
    let bytes = files::read(file, MAX_READ).map_err(|e| format!("cannot read {shown}: {e}"))?;
    let text = String::from_utf8(bytes).map_err(|_| format!("{shown} is not UTF-8 text"))?;
    demonstrations::read(world, &text).map_err(|e| format!("{shown}: {e}"))
}

/// Trains to the end, or until it is interrupted, and writes the policies.
fn train(a: &Arguments, training: &mut Run, files: &Files) -> Result<Outcome, String> {
    let interrupted = interruption::flag();
    let mut out = std::io::stderr();
    while !training.is_done() && !interrupted.load(Ordering::Relaxed) {
        // Short pieces, so that an interruption is answered within a second.
        let before = training.progress().clone();
        training.step(1).map_err(|e| e.to_string())?;
        let progress = training.progress();
        let told = if progress.stage != before.stage {
            format!("the synthetic person has given {} demonstrations", training.demonstrations().len())
        } else if progress.steps / LINE != before.steps / LINE || training.is_done() {
            line(progress)
        } else {
            continue;
        };
        // A closed terminal does not end a training.
        let _ = writeln!(out, "{told}");
        files.save(training)?;
    }
    files.save(training)?;
    if let (Some(policy), Some(target)) = (training.surrogate(), &files.surrogate) {
        bytes(target, &policy.to_bytes())?;
    }
    if !training.is_done() {
        let help = match &a.checkpoint {
            Some(file) => {
                format!("the training is stored in {}; the same command with `--resume` continues", file.display())
            }
            None => "nothing is stored; with `--checkpoint FILE` a training can be continued".to_string(),
        };
        output::error_line(&format!("interrupted: {help}"));
        return Ok(Outcome::Failed);
    }
    let policy = training.recovered().ok_or("the training has no policy")?;
    bytes(&files.policy, &policy.to_bytes())?;
    output::print(&format!("{}\n", files.policy.path().display()));
    Ok(Outcome::Good)
}

/// A line of progress.
fn line(p: &Progress) -> String {
    let stage = match p.stage {
        Stage::Surrogate => "synthetic person",
        Stage::Recovery => "demonstrations",
    };
    let collected: Vec<String> = p.episodes.collected.iter().map(|mean| format!("{mean:.2}")).collect();
    let accuracy =
        p.discriminator.map_or_else(String::new, |d| format!(", discriminator right in {:.0} %", 100.0 * d.accuracy));
    format!(
        "{stage}: {} of {} steps; episodes of {:.1} steps, collected {}, {:.2} collisions, {:.1} % failed{accuracy}",
        p.steps,
        p.of,
        p.episodes.length,
        collected.join(" and "),
        p.episodes.collisions,
        100.0 * p.episodes.failures,
    )
}

impl Files {
    fn new(a: &Arguments, mission: &str, sources: &[PathBuf]) -> Result<Files, String> {
        let out = a.out.clone().unwrap_or_else(|| Path::new("out").join(mission).join("policy.safetensors"));
        let mut sources = sources.to_vec();
        sources.extend(a.demonstrations.clone());
        let named =
            [("--out", Some(&out)), ("--surrogate", a.surrogate.as_ref()), ("--checkpoint", a.checkpoint.as_ref())];
        for (i, (one, first)) in named.iter().enumerate() {
            for (other, second) in &named[..i] {
                if let (Some(first), Some(second)) = (first, second)
                    && (first == second || is_same(first, second))
                {
                    return Err(format!("{other} and {one} name the same file, `{}`", first.display()));
                }
            }
        }
        if let Some(folder) = out.parent().filter(|p| !p.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(|e| format!("cannot create {}: {e}", folder.display()))?;
        }
        let target = |option: &str, path: Option<&PathBuf>, kind| {
            path.map(|path| Target::new(option, path, kind, &sources)).transpose()
        };
        Ok(Files {
            policy: Target::new("--out", &out, outputs::POLICY, &sources)?,
            surrogate: target("--surrogate", a.surrogate.as_ref(), outputs::POLICY)?,
            checkpoint: target("--checkpoint", a.checkpoint.as_ref(), outputs::CHECKPOINT)?,
        })
    }

    /// Writes the checkpoint, if one is requested.
    fn save(&self, training: &Run) -> Result<(), String> {
        self.checkpoint.as_ref().map_or(Ok(()), |target| bytes(target, &training.checkpoint()))
    }
}

fn bytes(target: &Target, bytes: &[u8]) -> Result<(), String> {
    let mut output = target.clone().begin()?;
    output.write_all(bytes).map_err(|e| output.cannot(&e))?;
    output.finish()
}

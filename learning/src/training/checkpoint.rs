//! Checkpoints: a run between two iterations as a file of the format safetensors. Networks, the moments of their optimisers,
//! running episodes and counters are in it; random numbers need no place, because each iteration has streams of its own.

use super::{Part, Run, Settings, TrainingError};
use crate::demonstrations::{DemonstrationError, read, write};
use crate::grid::{Cell, StateError, Target, World};
use crate::network::Adam;
use crate::policy::{Policy, PolicyError, PolicyFileError};
use crate::ppo::{Learner, Running};
use crate::tensor_file::{FloatArray, TensorFile, TensorFileError};
use serde::{Deserialize, Serialize};

const FORMAT: &str = "checkpoint";
const VERSION: u32 = 1;
const SURROGATE: &str = "surrogate";
const DEMONSTRATIONS: &str = "demonstrations";

/// Kind and version of a file, which are read before anything else.
#[derive(Serialize, Deserialize)]
struct Kind {
    format: String,
    version: u32,
}

/// Text of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    version: u32,
    world: World,
    settings: Settings,
    recovers: bool,
    iteration: u64,
    steps: u64,
    /// Steps of each optimiser, in the order of `learners`.
    optimisers: Vec<u64>,
    running: Vec<Option<Episode>>,
}

/// A running episode.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Episode {
    cell: Cell,
    targets: Vec<Target>,
    steps: u32,
}

/// Reason why a file is not a checkpoint.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The container, or an array in it.
    #[error(transparent)]
    File(#[from] TensorFileError),
    /// The text cannot be read.
    #[error("the metadata of the file cannot be read: {0}")]
    Text(String),
    /// A file of Hierarq that is not a checkpoint.
    #[error("the file is a {0} and not a checkpoint")]
    Format(String),
    /// A later version.
    #[error("the file has version {0} of the format; this program reads version {VERSION}")]
    Version(u32),
    /// Settings that do not fit the world.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// The policy of the synthetic person.
    #[error("the synthetic person: {0}")]
    Surrogate(#[from] PolicyFileError),
    /// The synthetic person is of another world.
    #[error("the synthetic person: {0}")]
    OtherWorld(#[from] PolicyError),
    /// The demonstrations.
    #[error("the demonstrations: {0}")]
    Demonstrations(#[from] DemonstrationError),
    /// The demonstrations are absent, or not text.
    #[error("the checkpoint holds no demonstrations")]
    NoDemonstrations,
    /// A running episode.
    #[error("a running episode: {0}")]
    Episode(#[from] StateError),
    /// A running episode that has ended.
    #[error("a running episode has ended")]
    Ended,
    /// A list of another length.
    #[error("the checkpoint has {found} {what}; {expected} are expected")]
    Count {
        /// Quantity.
        what: &'static str,
        /// Number in the file.
        found: usize,
        /// Number that is needed.
        expected: usize,
    },
}

impl Run {
    /// The run as a file. The same run gives the same bytes.
    pub fn checkpoint(&self) -> Vec<u8> {
        let phase = match &self.part {
            Part::Surrogate(phase) | Part::Recovery(phase, _) => phase,
        };
        let episode = |running: Running| Episode {
            cell: running.state.cell(),
            targets: running.state.targets().to_vec(),
            steps: running.steps,
        };
        let learners = learners(&self.part);
        let header = Header {
            format: FORMAT.to_string(),
            version: VERSION,
            world: self.world().clone(),
            settings: self.settings.clone(),
            recovers: matches!(self.part, Part::Recovery(..)),
            iteration: phase.iteration,
            steps: phase.steps,
            optimisers: learners.iter().map(|(_, learner)| learner.adam.steps()).collect(),
            running: phase.running.iter().map(|running| running.map(episode)).collect(),
        };
        let text = serde_json::to_string(&header).expect("numbers and texts are JSON");
        let mut file = TensorFile { text, ..TensorFile::default() };
        for (name, learner) in learners {
            let arrays = [
                ("parameters", learner.network.parameters()),
                ("mean", learner.adam.mean()),
                ("square", learner.adam.square()),
            ];
            for (array, data) in arrays {
                let data = FloatArray { shape: vec![data.len()], data: data.to_vec() };
                file.floats.insert(format!("{name}.{array}"), data);
            }
        }
        if let Some(surrogate) = &self.surrogate {
            file.bytes.insert(SURROGATE.to_string(), surrogate.to_bytes());
        }
        if header.recovers {
            let text = write(self.world(), &self.demonstrations);
            file.bytes.insert(DEMONSTRATIONS.to_string(), text.into_bytes());
        }
        file.to_bytes()
    }

    /// Goes on from a checkpoint.
    pub fn resume(file: &[u8]) -> Result<Run, CheckpointError> {
        let mut file = TensorFile::from_bytes(file)?;
        let text = |e: serde_json::Error| CheckpointError::Text(e.to_string());
        let kind: Kind = serde_json::from_str(&file.text).map_err(text)?;
        if kind.format != FORMAT {
            return Err(CheckpointError::Format(kind.format));
        }
        if kind.version != VERSION {
            return Err(CheckpointError::Version(kind.version));
        }
        let header: Header = serde_json::from_str(&file.text).map_err(text)?;
        let world = &header.world;
        let mut run = Run::new(world, header.settings)?;
        if let Some(surrogate) = file.bytes.remove(SURROGATE) {
            let surrogate = Policy::from_bytes(&surrogate)?;
            surrogate.check(world)?;
            run.surrogate = Some(surrogate);
        }
        if header.recovers {
            let text = file.bytes.remove(DEMONSTRATIONS).and_then(|bytes| String::from_utf8(bytes).ok());
            let demonstrations = read(world, &text.ok_or(CheckpointError::NoDemonstrations)?)?;
            run.recover(demonstrations)?;
        }
        let mut learners = learners_mut(&mut run.part);
        check_count("optimisers", header.optimisers.len(), learners.len())?;
        for ((name, learner), steps) in learners.iter_mut().zip(header.optimisers) {
            let count = [learner.network.parameters().len()];
            let mut take = |array| file.take(&format!("{name}.{array}"), &count);
            learner.network.parameters_mut().copy_from_slice(&take("parameters")?);
            let (mean, square) = (take("mean")?, take("square")?);
            learner.adam = Adam::resumed(mean, square, steps).expect("both have the length of the parameters");
        }
        let (Part::Surrogate(phase) | Part::Recovery(phase, _)) = &mut run.part;
        check_count("environments", header.running.len(), phase.running.len())?;
        phase.running = header.running.into_iter().map(|episode| running(world, episode)).collect::<Result<_, _>>()?;
        (phase.iteration, phase.steps) = (header.iteration, header.steps);
        run.progress.steps = header.steps;
        Ok(run)
    }
}

fn running(world: &World, episode: Option<Episode>) -> Result<Option<Running>, CheckpointError> {
    let Some(episode) = episode else { return Ok(None) };
    let state = world.state(episode.cell, &episode.targets)?;
    if world.is_exit(state.cell()) || episode.steps >= world.step_limit() {
        return Err(CheckpointError::Ended);
    }
    Ok(Some(Running { state, steps: episode.steps }))
}

fn check_count(what: &'static str, found: usize, expected: usize) -> Result<(), CheckpointError> {
    if found == expected { Ok(()) } else { Err(CheckpointError::Count { what, found, expected }) }
}

fn learners(part: &Part) -> Vec<(&'static str, &Learner)> {
    let (Part::Surrogate(phase) | Part::Recovery(phase, _)) = part;
    let mut learners = vec![("actor", &phase.networks.actor), ("critic", &phase.networks.critic)];
    if let Part::Recovery(_, discriminator) = part {
        learners.extend([("reward", &discriminator.reward), ("shaping", &discriminator.shaping)]);
    }
    learners
}

fn learners_mut(part: &mut Part) -> Vec<(&'static str, &mut Learner)> {
    let (phase, discriminator) = match part {
        Part::Surrogate(phase) => (phase, None),
        Part::Recovery(phase, discriminator) => (phase, Some(discriminator)),
    };
    let mut learners = vec![("actor", &mut phase.networks.actor), ("critic", &mut phase.networks.critic)];
    if let Some(discriminator) = discriminator {
        learners.extend([("reward", &mut discriminator.reward), ("shaping", &mut discriminator.shaping)]);
    }
    learners
}

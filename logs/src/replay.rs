//! A run that is done again from its log, message by message, until one differs.

use std::io::{Error, Result};
use std::sync::Arc;

use mcap::{Channel, Message};
use runtime::{Program, Recorder, RunError, Simulation, Tick};

use crate::about::{COLUMNS, DEGREES_OF_FREEDOM, Origin};
use crate::decode::{Leaf, Schema, Value};
use crate::messages::Messages;
use crate::read::{Log, LogError};
use crate::snapshot::{Camera, Snapshot, as_in_csv};
use crate::topics::Topic;

/// The first difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Index of the tick, from 0; none for what is written before the first one.
    pub tick: Option<usize>,
    /// Time of the tick, in s.
    pub time: f64,
    /// Name of the channel.
    pub channel: String,
    /// The number or the text, with the name of the joint, link or task that it is of: "`position[3]` of `elbow`".
    pub place: String,
    /// Value in the log, as a text.
    pub logged: String,
    /// Value now, as a text.
    pub now: String,
}

/// Result of a replay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replayed {
    /// Ticks that were compared.
    pub ticks: usize,
    /// Messages that agree bit for bit.
    pub messages: usize,
    /// The first difference, if there is one.
    pub difference: Option<Difference>,
}

/// Reason why a replay cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The log cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The program cannot be executed.
    #[error("its program cannot be run: {0}")]
    Run(String),
}

/// Runs the program of a log again and compares every message, until `go_on` returns false at a tick.
///
/// # Errors
/// The log cannot be used.
pub fn replay(log: &Log, go_on: &mut dyn FnMut(usize) -> bool) -> std::result::Result<Replayed, ReplayError> {
    if log.dropped > 0 {
        return Err(LogError::Dropped(log.dropped).into());
    }
    let program = &log.program;
    let simulation = match log.scenario() {
        Some(scenario) => Simulation::in_world(program, scenario),
        None => Simulation::new(program),
    };
    let mut simulation = simulation.map_err(|e| ReplayError::Run(e.to_string()))?;
    let mut messages = Messages::new(program, simulation.controller());
    let mut comparison = Comparison { logged: Box::new(log.messages()?), broken: None, result: Replayed::default() };
    let begun = messages.begin(&mut |topic, time, message| comparison.compare(None, topic, time, message));
    if begun.is_ok() {
        let camera = Camera::new(program, simulation.controller());
        let (ticks, last) = (log.ticks, simulation.ticks());
        let mut run = Run {
            program,
            origin: log.origin,
            camera,
            messages,
            comparison: &mut comparison,
            tick: Snapshot::default(),
        };
        let ran = simulation.run(&mut run, &mut || 0.0, &mut |tick| tick < ticks && go_on(tick));
        if let Err(RunError::Program(e)) = ran {
            return Err(ReplayError::Run(e.to_string()));
        }
        comparison.end(ticks, last);
    }
    match comparison.broken {
        Some(e) => Err(e.into()),
        None => Ok(comparison.result),
    }
}

/// The messages of the log against those of the run.
struct Comparison<'l> {
    logged: Box<dyn Iterator<Item = std::result::Result<Message<'l>, LogError>> + 'l>,
    broken: Option<LogError>,
    result: Replayed,
}

/// The run that is compared.
struct Run<'r, 'l> {
    program: &'r Program,
    origin: Origin,
    camera: Camera,
    messages: Messages,
    comparison: &'r mut Comparison<'l>,
    tick: Snapshot,
}

impl Recorder for Run<'_, '_> {
    fn tick(&mut self, tick: &Tick) -> Result<()> {
        self.camera.take(tick, &mut self.tick);
        if self.origin == Origin::Csv {
            as_in_csv(&mut self.tick, &self.program.interface, self.messages.signals_at());
        }
        let Run { messages, comparison, tick, .. } = self;
        messages.tick(tick, &mut |topic, time, message| comparison.compare(Some(tick.index), topic, time, message))?;
        comparison.result.ticks += 1;
        Ok(())
    }
}

impl Comparison<'_> {
    /// Compares a message of the run with the next one of the log. An error ends the run.
    fn compare(&mut self, tick: Option<usize>, topic: Topic, time: u64, message: &[u8]) -> Result<()> {
        let differ = |channel: &str, place: String, logged: String, now: String| Difference {
            tick,
            time: time as f64 * 1e-9,
            channel: channel.to_string(),
            place,
            logged,
            now,
        };
        let difference = match self.logged.next() {
            Some(Err(e)) => {
                self.broken = Some(e);
                return Err(Error::other("the log is damaged"));
            }
            None => differ(topic.name(), "a message".into(), "missing".into(), "there".into()),
            Some(Ok(m)) if m.channel.topic != topic.name() => {
                differ(topic.name(), "the next message".into(), format!("one of `{}`", m.channel.topic), "this".into())
            }
            Some(Ok(m)) if m.log_time != time => {
                differ(topic.name(), "the time".into(), format!("{} ns", m.log_time), format!("{time} ns"))
            }
            Some(Ok(m)) if *m.data != *message => {
                let Found { place, logged, now } = first_difference(&m.channel, &m.data, message);
                differ(topic.name(), place, logged, now)
            }
            Some(Ok(_)) => {
                self.result.messages += 1;
                return Ok(());
            }
        };
        self.result.difference = Some(difference);
        Err(Error::other("the run differs"))
    }

    /// Looks for messages that the run did not make. The log has `ticks` ticks, and a run of the program at most `last`.
    fn end(&mut self, ticks: usize, last: usize) {
        let done = self.result.difference.is_some() || self.broken.is_some();
        if done || self.result.ticks < ticks.min(last) {
            return;
        }
        match self.logged.next() {
            None => {}
            Some(Err(e)) => self.broken = Some(e),
            Some(Ok(m)) => {
                self.result.difference = Some(Difference {
                    tick: Some(self.result.ticks),
                    time: m.log_time as f64 * 1e-9,
                    channel: m.channel.topic.clone(),
                    place: "a message".to_string(),
                    logged: "there".to_string(),
                    now: "missing".to_string(),
                });
            }
        }
    }
}

/// The first value of two messages that differs.
struct Found {
    place: String,
    logged: String,
    now: String,
}

fn first_difference(channel: &Arc<Channel>, logged: &[u8], now: &[u8]) -> Found {
    let schema = channel.schema.as_ref().map(|s| Schema::new(&String::from_utf8_lossy(&s.data)));
    let leaves = |message: &[u8]| schema.as_ref().and_then(|s| s.decode(message).ok());
    let unknown = || Found { place: "the bytes".into(), logged: bytes(logged), now: bytes(now) };
    let (Some(old), Some(new)) = (leaves(logged), leaves(now)) else { return unknown() };
    let same = |a: &Value, b: &Value| match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.to_bits() == b.to_bits(),
        (a, b) => a == b,
    };
    let differs = |(a, b): &(&Leaf, &Leaf)| a.path != b.path || !same(&a.value, &b.value);
    match old.iter().zip(&new).find(differs) {
        Some((a, b)) if a.path == b.path => {
            let name = label(channel, &new, &a.path).map(|name| format!(" of `{name}`")).unwrap_or_default();
            Found { place: format!("`{}`{name}", a.path), logged: a.value.to_string(), now: b.value.to_string() }
        }
        Some((a, b)) => Found {
            place: "the number of values".to_string(),
            logged: format!("`{}` is next", a.path),
            now: format!("`{}` is next", b.path),
        },
        None => unknown(),
    }
}

fn bytes(message: &[u8]) -> String {
    format!("{} bytes", message.len())
}

/// Name of the joint, link, task or column that a path is of.
fn label(channel: &Channel, leaves: &[Leaf], path: &str) -> Option<String> {
    let (array, rest) = path.split_once('[')?;
    let index = rest.split(']').next()?;
    let text = |path: String| {
        leaves.iter().find(|leaf| leaf.path == path).map(|leaf| match &leaf.value {
            Value::Text(text) => text.clone(),
            other => other.to_string(),
        })
    };
    let names = [COLUMNS, DEGREES_OF_FREEDOM].iter().find_map(|key| channel.metadata.get(*key));
    let listed = || {
        let names: Vec<String> = serde_json::from_str(names?).ok()?;
        names.get(index.parse::<usize>().ok()?).cloned()
    };
    let of_element = ["child_frame_id", "name", "ns"].iter().find_map(|key| text(format!("{array}[{index}].{key}")));
    of_element.or_else(|| text(format!("name[{index}]"))).or_else(|| listed().filter(|_| array == "data"))
}

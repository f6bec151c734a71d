//! The messages of a log, made of snapshots: what `run` writes, what `convert` makes of `log.csv`, and what `replay` compares.
//!
//! Joint states, commands and the numbers of `log.csv` are written at each tick, the state and the fault when they change, poses,
//! markers and diagnostics at most fifty times a second.

use std::io::Result;

use robot::{Drive, LinkId, Model};
use runtime::record::columns::Columns;
use runtime::record::roster::Roster;
use runtime::{Controller, Program};
use stdlib_tasks::task::RowKind;

use crate::cdr::Cdr;
use crate::description::urdf;
use crate::markers::{self, Marker, header, quaternion, vector};
use crate::scene::{Scene, Source};
use crate::snapshot::Snapshot;
use crate::topics::Topic;

/// Largest number of poses, markers and diagnostics in a second.
const SCENES: f64 = 50.0;
/// Violation of a hard level that is told, in the unit of its rows.
const VIOLATED: f64 = 1e-6;

/// Receives a message: its channel, its time in ns, its bytes.
pub type Emit<'a> = dyn FnMut(Topic, u64, &[u8]) -> Result<()> + 'a;

/// A number of a task in a row.
struct TaskNumber {
    name: String,
    column: usize,
    limit: bool,
}

/// A level.
struct LevelName {
    name: String,
    hard: bool,
}

/// Makes messages.
pub struct Messages {
    scene: Scene,
    columns: Vec<String>,
    command: Vec<String>,
    /// Names of the joints, with the places of their positions and velocities in a row.
    joints: Vec<String>,
    positions: Vec<usize>,
    velocities: Vec<usize>,
    command_at: std::ops::Range<usize>,
    /// First number of a signal in a row.
    signals_at: usize,
    tasks: Vec<TaskNumber>,
    levels: Vec<LevelName>,
    robot: String,
    title: String,
    /// Ticks from one scene to the next.
    every: usize,
    state: Option<String>,
    fault: Option<String>,
    /// Time of the messages at the start of the run, in ns.
    epoch: u64,
    cdr: Cdr,
}

/// Time of a tick in ns.
pub fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}

/// The numbers of tasks from a column on, which is moved behind the last one.
fn task_numbers(roster: &Roster, column: &mut usize) -> Vec<TaskNumber> {
    let number = |m: &runtime::evaluator::Member| {
        let limit = m.row_kind == RowKind::Inequality;
        let task = TaskNumber { name: m.name.clone(), column: *column, limit };
        // The norm of an error is followed by those of its parts.
        *column += if limit || m.measure_info.len() < 2 { 1 } else { 1 + m.measure_info.len() };
        task
    };
    roster.members.iter().map(number).collect()
}

fn is_fixed(model: &Model, link: LinkId) -> bool {
    let drive = model.link_ref(link).parent_joint.map(|j| model.joint_ref(j).drive);
    model.base_at(link).is_none() && matches!(drive, None | Some(Drive::Fixed | Drive::Locked(_)))
}

impl Messages {
    /// Prepares messages of a program. The controller is one of the same program.
    pub fn new(program: &Program, controller: &Controller) -> Messages {
        let (model, roster) = (&program.robot.model, Roster::new(controller));
        let (nq, nv) = (model.nq(), model.nv());
        let mut numbers_of_tasks = 1 + nq + 2 * nv..1 + nq + 2 * nv;
        let tasks = task_numbers(&roster, &mut numbers_of_tasks.end);
        let limits = roster.members.iter().zip(&tasks).filter(|(_, t)| t.limit);
        let source = |(m, t): (&'_ runtime::evaluator::Member, &TaskNumber)| (m.program_index, t.column);
        let places: Vec<(usize, usize)> = limits.clone().map(source).collect();
        let sources: Vec<Source> = limits
            .zip(&places)
            .filter_map(|((m, t), (index, column))| {
                let rows = m.row_info.iter().map(|r| r.name.as_str()).collect();
                Some(Source { name: &t.name, params: &program.tasks.get(*index)?.params, rows, column: *column })
            })
            .collect();
        let joints = model.dofs.iter().enumerate().filter_map(|(i, d)| Some((i, d.q_index?, d.name.clone())));
        let joints: Vec<(usize, usize, String)> = joints.collect();
        let level = |l: &runtime::record::roster::RosterLevel| {
            let stack = program.stacks.get(l.stack).map_or("", |s| s.name.as_str());
            LevelName { name: format!("{stack}/{}", l.name), hard: l.hard }
        };
        Messages {
            scene: Scene::new(program, &sources),
            columns: Columns::new(program, controller).names(program),
            command: model.dofs.iter().map(|d| d.name.clone()).collect(),
            positions: joints.iter().map(|j| 1 + j.1).collect(),
            velocities: joints.iter().map(|j| 1 + nq + j.0).collect(),
            joints: joints.into_iter().map(|j| j.2).collect(),
            command_at: 1 + nq + nv..1 + nq + 2 * nv,
            levels: roster.levels.iter().map(level).collect(),
            signals_at: numbers_of_tasks.end,
            tasks,
            robot: program.robot.name.clone(),
            title: program.title.clone(),
            every: (1.0 / (SCENES * program.robot.period)).round().max(1.0) as usize,
            state: None,
            fault: None,
            epoch: 0,
            cdr: Cdr::default(),
        }
    }

    /// Messages in a frame for the world other than `world`, whose times begin at `epoch`, in ns.
    pub fn among_others(mut self, world: &str, epoch: u64) -> Messages {
        self.scene.name_world(world);
        self.epoch = epoch;
        self
    }

    /// Names of the columns of a row.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Names of the numbers of a command.
    pub fn command(&self) -> &[String] {
        &self.command
    }

    /// Index in a row of the first number of a signal.
    pub fn signals_at(&self) -> usize {
        self.signals_at
    }

    /// Makes the messages that are written once, at the start.
    ///
    /// # Errors
    /// Those of `emit`.
    pub fn begin(&mut self, emit: &mut Emit) -> Result<()> {
        let start = self.epoch;
        let urdf = urdf(self.scene.model());
        self.text(Topic::RobotDescription, start, &urdf, emit)?;
        // Fixed links have the same pose relative to their parents at any configuration.
        let mut zero = vec![f64::NAN; self.columns.len()];
        let neutral = self.scene.model().neutral();
        zero[1..=neutral.len()].copy_from_slice(&neutral);
        let signals = self.scene.absent_signals();
        self.scene.update(&Snapshot { row: zero, signals, ..Snapshot::default() });
        self.transforms(Topic::FixedTransforms, start, emit)?;
        let walls = self.scene.walls();
        self.markers(Topic::Walls, start, &walls, emit)?;
        let keep_out = self.scene.keep_out();
        self.markers(Topic::KeepOut, start, &keep_out, emit)
    }

    /// Makes the messages of a tick.
    ///
    /// # Errors
    /// Those of `emit`.
    pub fn tick(&mut self, tick: &Snapshot, emit: &mut Emit) -> Result<()> {
        let time = self.epoch + nanoseconds(tick.time);
        self.joint_states(time, &tick.row, emit)?;
        let command = tick.row.get(self.command_at.clone()).unwrap_or_default();
        numbers(&mut self.cdr, "degree of freedom", command);
        emit(Topic::Command, time, self.cdr.message())?;
        numbers(&mut self.cdr, "column", &tick.row);
        emit(Topic::Columns, time, self.cdr.message())?;
        if self.state.as_ref() != Some(&tick.state) {
            self.state = Some(tick.state.clone());
            self.text(Topic::State, time, &tick.state, emit)?;
        }
        if self.fault.as_ref() != Some(&tick.fault) {
            self.fault = Some(tick.fault.clone());
            self.text(Topic::Fault, time, &tick.fault, emit)?;
        }
        if !tick.index.is_multiple_of(self.every) {
            return Ok(());
        }
        self.scene.update(tick);
        self.transforms(Topic::Transforms, time, emit)?;
        let obstacles = self.scene.obstacles();
        self.markers(Topic::Obstacles, time, &obstacles, emit)?;
        let people = self.scene.people(tick);
        self.markers(Topic::People, time, &people, emit)?;
        let lines = self.scene.closest_points(tick);
        self.markers(Topic::ClosestPoints, time, &lines, emit)?;
        self.diagnostics(time, tick, emit)
    }

    fn text(&mut self, topic: Topic, time: u64, text: &str, emit: &mut Emit) -> Result<()> {
        self.cdr.begin();
        self.cdr.text(text);
        emit(topic, time, self.cdr.message())
    }

    /// Markers; a channel on which there is nothing has no messages.
    fn markers(&mut self, topic: Topic, time: u64, all: &[Marker], emit: &mut Emit) -> Result<()> {
        if all.is_empty() {
            return Ok(());
        }
        self.cdr.begin();
        markers::write(all, time, &mut self.cdr);
        emit(topic, time, self.cdr.message())
    }

    fn joint_states(&mut self, time: u64, row: &[f64], emit: &mut Emit) -> Result<()> {
        let out = &mut self.cdr;
        out.begin();
        header(time, "", out);
        out.texts(&self.joints);
        for places in [&self.positions, &self.velocities] {
            out.count(places.len());
            places.iter().for_each(|i| out.f64(row.get(*i).copied().unwrap_or(f64::NAN)));
        }
        out.count(0);
        emit(Topic::JointStates, time, out.message())
    }

    /// Poses of links relative to their parents: of the fixed ones, or of those that move. The first link is in the world.
    fn transforms(&mut self, topic: Topic, time: u64, emit: &mut Emit) -> Result<()> {
        let (model, data) = (self.scene.model(), self.scene.data());
        let links = (0..model.links.len()).map(|i| LinkId(i as u32));
        let is_root = |l: LinkId| model.parent(l).is_none();
        let wanted = |l: &LinkId| {
            (topic == Topic::FixedTransforms) == is_fixed(model, *l)
                && !(is_root(*l) && model.link_ref(*l).name == self.scene.world())
        };
        let links: Vec<LinkId> = links.filter(wanted).collect();
        if links.is_empty() {
            return Ok(());
        }
        let out = &mut self.cdr;
        out.begin();
        out.count(links.len());
        for link in links {
            let (parent, pose) = match model.parent(link) {
                Some(parent) => (model.link_ref(parent).name.as_str(), data.pose(parent).inv_mul(data.pose(link))),
                None => (self.scene.world(), *data.pose(link)),
            };
            header(time, parent, out);
            out.text(&model.link_ref(link).name);
            vector(&pose.translation.vector, out);
            quaternion(&pose, out);
        }
        emit(topic, time, out.message())
    }

    fn diagnostics(&mut self, time: u64, tick: &Snapshot, emit: &mut Emit) -> Result<()> {
        let at = |column: usize| tick.row.get(column).copied().filter(|x| !x.is_nan());
        let running: Vec<(&TaskNumber, f64)> = self.tasks.iter().filter_map(|t| Some((t, at(t.column)?))).collect();
        let out = &mut self.cdr;
        out.begin();
        header(time, "", out);
        out.count(1 + running.len() + tick.levels.len());
        let mut status = |bad: bool, name: &str, message: &str, values: &[(&str, String)]| {
            out.u8(if bad { 2 } else { 0 });
            [name, message, &self.robot].into_iter().for_each(|text| out.text(text));
            out.count(values.len());
            for (key, value) in values {
                out.text(key);
                out.text(value);
            }
        };
        let message = if tick.fault.is_empty() { "no fault" } else { &tick.fault };
        let state: Vec<(&str, String)> =
            if tick.state.is_empty() { Vec::new() } else { vec![("state", tick.state.clone())] };
        status(!tick.fault.is_empty(), &self.title, message, &state);
        for (task, x) in running {
            let (kind, bad) = if task.limit { ("margin", x < -VIOLATED) } else { ("error", false) };
            let message = if bad { "below zero" } else { "" };
            status(bad, &format!("{kind}/{}", task.name), message, &[(kind, x.to_string())]);
        }
        for (i, level) in tick.levels.iter().enumerate() {
            let (name, hard) = self.levels.get(tick.first_level + i).map_or(("", false), |l| (l.name.as_str(), l.hard));
            let bad = hard && level.violation > VIOLATED;
            let values = [("violation", level.violation.to_string()), ("at_bound", level.at_bound.to_string())];
            status(bad, &format!("level/{name}"), if bad { "not met" } else { "" }, &values);
        }
        emit(Topic::Diagnostics, time, out.message())
    }
}

/// Numbers in a row, in one dimension.
fn numbers(out: &mut Cdr, label: &str, all: &[f64]) {
    out.begin();
    out.count(1);
    out.text(label);
    out.count(all.len());
    out.count(all.len());
    out.u32(0);
    out.f64s(all);
}

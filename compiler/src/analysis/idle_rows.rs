//! Proof that some rows of limits can never become active. The controller leaves these rows out while a program runs.
//!
//! A row `h' >= -φ (h - δ)` is redundant if `h` cannot fall faster than the row allows. With a bound `s_j` of
//! `|dh/dq_j|` for each joint, `h` falls by at most `sum_j s_j v_j` at the speeds `v_j` that hard levels permit; around
//! a configuration, the bound of the row changes by at most `φ sum_j s_j |Δq_j|`. The box of all joint positions is
//! therefore cut into cells until each cell is proven by its centre, a centre shows that the row can act, or the limit
//! of cells is reached. The controller takes such a row out only while the joints are inside that box.

use std::collections::BinaryHeap;

use robot::{Data, Drive, JointKind, Model};
use runtime::program::{IdleRow, TaskProgram};
use runtime::{Built, LIMIT_TOLERANCE, Program, build_tasks};
use stdlib_tasks::Task;
use stdlib_tasks::task::{Rows, State};

/// Maximum number of cells per row. With fewer, rows that are close to acting cannot be proven.
const CELLS: usize = 1000;

/// Number of sampled configurations that filter the rows of a task before a proof is attempted.
const SAMPLES: usize = 100;

/// Finds the rows of all stacks that can never become active, and notes them in the program.
pub fn mark_idle_rows(program: &mut Program) {
    for s in 0..program.stacks.len() {
        let p = &*program;
        let built = build_tasks(p, &p.stacks[s]);
        let tasks: Vec<usize> = p.stacks[s].levels.iter().flat_map(|l| &l.members).map(|m| m.task).collect();
        let found: Vec<Vec<IdleRow>> =
            built.into_iter().zip(tasks).map(|(b, t)| rows(p, &p.tasks[t], b, false).unwrap_or_default()).collect();
        let members = program.stacks[s].levels.iter_mut().flat_map(|l| &mut l.members);
        for (member, idle) in members.zip(found) {
            member.idle = idle;
        }
    }
}

/// True if every row of a task is idle. Ends at the first sample at which a row can act.
pub(crate) fn all(program: &Program, task: &TaskProgram, built: Built) -> bool {
    let number = built.task.as_ref().map_or(0, |t| t.rows().len());
    let idle = |all: bool| rows(program, task, built, all).is_some_and(|idle| idle.len() == number);
    number > 0 && idle(true)
}

/// Returns the idle rows of a task; `None` if a parameter moves with time, or if no row stays inactive at all samples, or
/// not all do and `all` are asked for.
fn rows(program: &Program, task: &TaskProgram, built: Built, all: bool) -> Option<Vec<IdleRow>> {
    let moves = |at: usize| program.values.tape.outputs.iter().any(|o| o.at == at);
    if task.params.values().flat_map(|b| b.slots()).any(|s| (s.at..s.at + s.len).any(moves)) {
        return None;
    }
    let mut task = built.task.ok()?;
    let slopes = task.gradient_bounds(&program.robot.model);
    let [gain] = task.gains(&program.values.initial)[..] else { return None };
    let mut view = View::new(program, task.as_mut(), slopes.len())?;
    let wanted = if all { slopes.len() } else { 1 };
    let mut open: Vec<Candidate> = slopes
        .into_iter()
        .enumerate()
        .filter_map(|(row, s)| Candidate::new(program, row, s, &built.speed, gain))
        .collect();
    for k in 0..SAMPLES {
        if open.len() < wanted {
            return None;
        }
        view.scatter(&program.robot.model, k);
        view.look()?;
        open.retain(|c| view.lower[c.row] < -c.fastest);
    }
    Some(open.iter().filter_map(|c| c.prove(&mut view)).collect())
}

/// Evaluates the rows of a task at any configuration.
struct View<'a> {
    program: &'a Program,
    task: &'a mut dyn Task,
    data: Data,
    q: Vec<f64>,
    rates: Vec<f64>,
    velocity: Vec<f64>,
    idle: Vec<bool>,
    jacobian: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    margins: Vec<f64>,
}

impl<'a> View<'a> {
    fn new(program: &'a Program, task: &'a mut dyn Task, rows: usize) -> Option<Self> {
        let (model, values) = (&program.robot.model, &program.values.initial);
        (rows > 0 && rows == task.rows().len()).then(|| View {
            data: Data::new(model),
            q: program.robot.home.clone(),
            rates: vec![0.0; values.len()],
            velocity: vec![0.0; model.nv()],
            idle: Vec::new(),
            jacobian: vec![0.0; rows * model.nv()],
            lower: vec![0.0; rows],
            upper: vec![0.0; rows],
            margins: vec![0.0; rows],
            program,
            task,
        })
    }

    /// Moves to the `k`-th configuration of a low-discrepancy sequence in the box: multiples of irrational steps.
    fn scatter(&mut self, model: &Model, k: usize) {
        for (j, d) in model.dofs.iter().enumerate() {
            if let (Some(i), Some((low, high))) = (d.q_index, range(model, j)) {
                let step = ((j + 2) as f64).sqrt() * 0.754_877_666;
                self.q[i] = low + (high - low) * (step * (k + 1) as f64).fract();
            }
        }
    }

    /// Evaluates the lower bounds of all rows; `None` if the task fails there.
    fn look(&mut self) -> Option<()> {
        let model = &self.program.robot.model;
        model.forward(&self.q, &mut self.data);
        self.jacobian.fill(0.0);
        let state = State {
            model,
            data: &self.data,
            q: &self.q,
            values: &self.program.values.initial,
            rates: &self.rates,
            velocity: &self.velocity,
            stack_velocity: &self.velocity,
        };
        let mut rows = Rows {
            jacobian: &mut self.jacobian,
            stride: model.nv(),
            lower: &mut self.lower,
            upper: &mut self.upper,
            margins: &mut self.margins,
            measures: &mut [],
            undefined: &mut false,
            idle: &self.idle,
            trial: true,
        };
        self.task.update(&state, &mut rows).ok()
    }
}

/// A row that may be idle.
struct Candidate {
    row: usize,
    /// Fastest possible decrease of `h` at the permitted joint speeds.
    fastest: f64,
    /// Joints that move the row: index in the configuration, lower and upper end of the range, and the largest change
    /// of the row's lower bound per unit of the joint.
    joints: Vec<(usize, f64, f64, f64)>,
}

/// A box of joint positions, with its centre, its half widths, and an upper bound of the row's lower bound inside it.
struct Cell {
    worst: f64,
    centre: Vec<f64>,
    half: Vec<f64>,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.worst.total_cmp(&other.worst)
    }
}

impl Candidate {
    fn new(program: &Program, row: usize, slopes: Vec<f64>, speed: &[f64], gain: f64) -> Option<Self> {
        let model = &program.robot.model;
        let mut joints = Vec::new();
        let mut fastest = 0.0;
        for (dof, &slope) in slopes.iter().enumerate().filter(|(_, s)| **s > 0.0) {
            let (low, high) = range(model, dof)?;
            joints.push((model.dofs[dof].q_index?, low, high, gain * slope));
            fastest += slope * speed[dof];
        }
        (gain > 0.0 && f64::is_finite(fastest)).then_some(Candidate { row, fastest, joints })
    }

    /// Cuts the box into cells until all are proven; `None` if that fails.
    fn prove(&self, view: &mut View) -> Option<IdleRow> {
        let centre = self.joints.iter().map(|j| 0.5 * (j.1 + j.2)).collect();
        let half = self.joints.iter().map(|j| 0.5 * (j.2 - j.1)).collect();
        let mut cells = BinaryHeap::from([self.cell(centre, half, view)?]);
        // The margin covers rounding errors, which are far smaller.
        let enough = -self.fastest - 1e-9 * (1.0 + self.fastest);
        for _ in 0..CELLS / 2 {
            let worst = cells.pop()?;
            if worst.worst < enough {
                return Some(IdleRow { row: self.row, fastest: self.fastest, allowed: -worst.worst });
            }
            let weight = |k: &usize| self.joints[*k].3 * worst.half[*k];
            let widest = (0..self.joints.len()).max_by(|a, b| weight(a).total_cmp(&weight(b)))?;
            for side in [-0.5, 0.5] {
                let (mut centre, mut half) = (worst.centre.clone(), worst.half.clone());
                centre[widest] += side * half[widest];
                half[widest] *= 0.5;
                cells.push(self.cell(centre, half, view)?);
            }
        }
        None
    }

    /// Builds a cell; `None` if the row can act at its centre.
    fn cell(&self, centre: Vec<f64>, half: Vec<f64>, view: &mut View) -> Option<Cell> {
        for (j, q) in self.joints.iter().zip(&centre) {
            view.q[j.0] = *q;
        }
        view.look()?;
        let here = view.lower[self.row];
        let around: f64 = self.joints.iter().zip(&half).map(|(j, h)| j.3 * h).sum();
        (here < -self.fastest).then_some(Cell { worst: here + around, centre, half })
    }
}

/// Range of a joint: its limits, or one full turn for a continuous joint without limits that no mimic joint follows.
fn range(model: &Model, dof: usize) -> Option<(f64, f64)> {
    let d = &model.dofs[dof];
    if d.lower.is_finite() && d.upper.is_finite() {
        return Some((d.lower - LIMIT_TOLERANCE, d.upper + LIMIT_TOLERANCE));
    }
    let endless = model.joint_ref(d.joint?).kind == JointKind::Continuous && d.lower == -d.upper;
    let followed = model.joints.iter().any(|j| matches!(j.drive, Drive::Mimic { dof: of, .. } if of == dof));
    (endless && !followed).then_some((-std::f64::consts::PI, std::f64::consts::PI))
}

//! Measures of the motion in conditions of the machine: accelerations, reversals and speeds, as values that the machine keeps.
//!
//! They are measured at the end of a tick, of the velocity that the hierarchy chose, and conditions read them at the next one.

use robot::{Data, Model};

use crate::motion::Motion;
use crate::program::{MachineProgram, MeasuredProgram, Program};
use crate::signals::Signals;

/// A measure of a condition.
struct Measured {
    program: MeasuredProgram,
    /// How many times its state had been entered when it was last looked at.
    entries: u64,
    /// What had been counted when its state was entered.
    base: f64,
}

/// The measures of a machine. All memory is allocated when they are made.
pub(super) struct MeasuredMotion {
    all: Vec<Measured>,
    motion: Motion,
    model: Model,
    data: Data,
}

impl MeasuredMotion {
    /// Those of a checked machine; none where it has none.
    pub fn new(program: &Program, machine: &MachineProgram) -> Option<Box<MeasuredMotion>> {
        if machine.measured.is_empty() {
            return None;
        }
        let model = program.robot.model.clone();
        let measures = machine.measured.iter().map(|m| &m.measure);
        Some(Box::new(MeasuredMotion {
            motion: Motion::new(&model, program.robot.period, measures),
            all: machine.measured.iter().map(|m| Measured { program: m.clone(), entries: 0, base: 0.0 }).collect(),
            data: Data::new(&model),
            model,
        }))
    }

    /// Begins anew.
    pub fn restart(&mut self) {
        self.motion.restart(&self.model);
        self.all.iter_mut().for_each(|m| (m.entries, m.base) = (0, 0.0));
    }

    /// Measures a tick: the velocity that the hierarchy chose, `nv` numbers, at an observed configuration and a time in s.
    /// `entries` are those of the machine's states. Never allocates.
    pub fn tick(&mut self, signals: &mut Signals, entries: &[u64], q: &[f64], v: &[f64], time: f64) {
        for m in &mut self.all {
            let Some(entered) = m.program.since.and_then(|s| entries.get(s)) else { continue };
            if m.entries != *entered {
                (m.entries, m.base) = (*entered, self.motion.measure(&m.program.measure).unwrap_or(0.0));
            }
        }
        // Where the observation is of no use there is a fault, and nothing moves.
        if self.motion.needs_kinematics() && q.len() == self.model.nq() && q.iter().all(|x| x.is_finite()) {
            self.model.forward(q, &mut self.data);
        }
        self.motion.tick(&self.model, &self.data, v, time);
        for m in &self.all {
            let value = self.motion.measure(&m.program.measure).map(|x| x - m.base);
            if !value.is_some_and(|x| signals.assign(m.program.signal, &[x])) {
                signals.forget(m.program.signal);
            }
        }
    }
}

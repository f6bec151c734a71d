//! Measures of the motion that conditions of the machine read (accelerations, reversals, speeds), stored as signals.
//!
//! They are computed at the end of a tick from the velocity that the hierarchy chose. Conditions read them at the next
//! tick.

use robot::{Data, Model};

use crate::motion::Motion;
use crate::program::{MachineProgram, MeasuredProgram, Program};
use crate::signals::Signals;

/// Measure of a condition.
struct Measured {
    program: MeasuredProgram,
    /// Number of entries into its state when it was last updated.
    entries: u64,
    /// Value of the measure when its state was entered.
    base: f64,
}

/// Measures of a machine. All memory is allocated by [`MeasuredMotion::new`].
pub(super) struct MeasuredMotion {
    all: Vec<Measured>,
    motion: Motion,
    model: Model,
    data: Data,
}

impl MeasuredMotion {
    /// Prepares the measures of a checked machine; `None` if it has none.
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

    /// Restarts all measures.
    pub fn restart(&mut self) {
        self.motion.restart(&self.model);
        self.all.iter_mut().for_each(|m| (m.entries, m.base) = (0, 0.0));
    }

    /// Updates the measures with the velocity that the hierarchy chose (`nv` numbers), the observed configuration and
    /// the time (s). `entries` are the numbers of entries into the machine's states. Never allocates.
    pub fn tick(&mut self, signals: &mut Signals, entries: &[u64], q: &[f64], v: &[f64], time: f64) {
        for m in &mut self.all {
            let Some(entered) = m.program.since.and_then(|s| entries.get(s)) else { continue };
            if m.entries != *entered {
                (m.entries, m.base) = (*entered, self.motion.measure(&m.program.measure).unwrap_or(0.0));
            }
        }
        // An observation that is unusable is a fault, and the robot does not move.
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

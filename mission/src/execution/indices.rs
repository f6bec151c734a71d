//! Whether what people ask for is given to them: what they said, and what the next service was like.

use crate::schedule::adaptation_index::{Quantity, adaptation_index};

use super::Execution;

/// What a person asked for after an operation, and is still waited for.
#[derive(Clone, Copy, Debug)]
struct Asked {
    operation: usize,
    quantity: Quantity,
    feedback: f64,
}

/// Adaptation indices of people.
#[derive(Clone, Debug)]
pub(super) struct Indices {
    asked: Vec<Vec<Asked>>,
    wait: Vec<f64>,
    speed: Vec<f64>,
}

impl Indices {
    pub fn new(agents: usize) -> Indices {
        Indices { asked: vec![Vec::new(); agents], wait: vec![1.0; agents], speed: vec![1.0; agents] }
    }

    /// What a person said of an operation; what was said of it before no longer counts.
    pub fn ask(&mut self, agent: usize, operation: usize, wait: f64, speed: f64) {
        let asked = &mut self.asked[agent];
        asked.retain(|asked| asked.operation != operation);
        asked.push(Asked { operation, quantity: Quantity::Wait, feedback: wait });
        asked.push(Asked { operation, quantity: Quantity::Speed, feedback: speed });
    }

    /// Indices of waits and of speeds.
    pub fn of(&self, agent: usize) -> (f64, f64) {
        (self.wait[agent], self.speed[agent])
    }
}

impl Execution {
    /// Something has become known of an agent's services.
    pub(super) fn heed(&mut self, agent: usize) {
        let state = &self.agents[agent];
        let Indices { asked, wait, speed } = &mut self.indices;
        asked[agent].retain(|asked| {
            let (known, index) = match asked.quantity {
                Quantity::Wait => (&state.waits, &mut wait[agent]),
                Quantity::Speed => (&state.speeds, &mut speed[agent]),
            };
            let (Some(before), Some(after)) = (known.get(asked.operation), known.get(asked.operation + 1)) else {
                return true;
            };
            *index = adaptation_index(*index, asked.quantity, asked.feedback, *before, *after);
            false
        });
    }
}

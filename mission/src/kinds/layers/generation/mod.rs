//! Layers from a language model, thesis 6.3.1: the prompt, and the answer that the same checks judge as layers that people
//! write.

pub mod prompt;
mod rules;

use crate::kind::generation::{Decides, Generated, Generation, Prompt};
use crate::planned::Method;

use super::json::{Mode, export, export_plan, import};
use super::mission::Layers;
use super::planned::planned;
use prompt::{VERSION, Wish, prompt};

/// The formulation of a plan in which the model decided everything.
const GIVEN: &str = "given";

fn mode(decides: Decides) -> Mode {
    match decides {
        Decides::Tasks => Mode::Context,
        Decides::Allocation => Mode::Allocated,
        Decides::Everything => Mode::Scheduled,
    }
}

impl Generation for Layers {
    fn noun(&self) -> &'static str {
        "layers"
    }

    fn key(&self) -> &'static str {
        "layers_from"
    }

    fn answer_keys(&self) -> &'static [&'static str] {
        &["layers", "tasks"]
    }

    fn version(&self) -> u32 {
        VERSION
    }

    fn instruction(&self) -> Option<&str> {
        self.instruction.as_deref()
    }

    fn prompt(&self, decides: Decides, instruction: &str) -> Prompt {
        let (problem, directives) = (&self.problem, &self.directives);
        prompt(&Wish { problem, instruction, directives, mode: mode(decides) })
    }

    fn read(&self, answer: &str, decides: Decides) -> Result<Generated, Vec<String>> {
        let imported = import(answer, &self.problem, mode(decides))
            .map_err(|faults| faults.iter().map(ToString::to_string).collect::<Vec<_>>())?;
        let (problem, plan) = (imported.problem, imported.plan);
        let method = || Method { formulation: GIVEN, why: "the model decided everything".into() };
        let described = plan.as_ref().map(|plan| planned(&problem, plan, method())).transpose();
        Ok(Generated {
            text: plan.map_or_else(|| export(&problem), |plan| export_plan(&problem, &plan)),
            planned: described.map_err(|refusal| vec![refusal.to_string()])?,
            mission: Box::new(Layers { problem, ..self.clone() }),
        })
    }
}

//! Lowers `plant` blocks: the simulated robot as a body with masses and drives.

use blocks::Located;
use dsl::{Diagnostic, Span};
use robot::{Base, LinkId, Model};
use runtime::program::{Actuators, Gravity, Payload, PlantProgram, Simulator};

use super::Lowerer;
use crate::robot_binding::{BoundRobot, unknown_link};
use crate::sections::{MujocoBlock, PayloadBlock, PlantBlock};

/// Longest time step of a plant (s), if none is written.
const USUAL_STEP: f64 = 1e-3;

impl Lowerer<'_> {
    /// Settings of a physical robot; `None` if the block has none, or one that was refused.
    pub(super) fn plant(&mut self, block: &PlantBlock, robot: Option<&BoundRobot>) -> Option<PlantProgram> {
        let Located { at, value: mujoco } = block.mujoco.as_ref()?;
        let at = self.origins.span(*at);
        let robot = robot?;
        if let Some(d) = without_drives(&robot.model, at) {
            self.push(d);
            return None;
        }
        if let Some(step) = mujoco.step.as_ref().filter(|step| step.value > robot.period) {
            let span = self.origins.span(step.at);
            let d = Diagnostic::error("HQ0821", span, "the time step of the plant is longer than the tick");
            let tick = format!("one tick is {} s", robot.period);
            self.push(d.label(robot.rate_span, tick).help("write a part of the tick: 1 ms is common"));
            return None;
        }
        if let Some(step) = mujoco.step.as_ref().filter(|step| step.value > mujoco.response.value) {
            let (step, response) = (self.origins.span(step.at), self.origins.span(mujoco.response.at));
            let d = Diagnostic::warning("HQ0826", step, "the drives are faster than the time step of the plant");
            let d = d.label(response, "time constant of the drives");
            self.push(
                d.note("a drive then is as slow as the step").help("leave `step` out, or write a part of `response`"),
            );
        }
        let payload = match &mujoco.payload {
            Some(payload) => Some(self.payload(payload, robot)?),
            None => None,
        };
        if mujoco.contacts {
            // Links touch all of them, also those that no task knows.
            let bodies: Vec<String> = self.params.obstacles.iter().chain(self.params.humans.keys()).cloned().collect();
            self.params.used.extend(bodies);
        }
        Some(settings(mujoco, payload, robot.period))
    }

    fn payload(&mut self, block: &PayloadBlock, robot: &BoundRobot) -> Option<Payload> {
        let (named, mass) = (block.link.as_ref()?, block.mass?);
        let arm = robot.arms.iter().find(|a| a.name == named.value).map(|a| a.tip);
        let Some(link) = arm.or_else(|| robot.model.link(&named.value)) else {
            let span = self.origins.span(named.at);
            self.push(unknown_link(&robot.model, &named.value, span, &robot.arms));
            return None;
        };
        if robot.model.support(link).iter().all(|s| robot.model.dofs[s.dof as usize].joint.is_none()) {
            let span = self.origins.span(named.at);
            let text = format!("no drive moves `{}`, so that the payload has no effect", named.value);
            self.push(Diagnostic::warning("HQ0826", span, text).help("write the link that carries the load"));
        }
        Some(Payload { link, mass, at: block.at })
    }

    /// Warns of settings of the simulator that have no effect on a robot that its drives move.
    pub(super) fn idle_simulator(&mut self, simulator: &Simulator, block: &PlantBlock) {
        let written = [
            (simulator.lag > 0.0, "lag"),
            (simulator.speed.is_some(), "speed"),
            (simulator.acceleration.is_some(), "acceleration"),
        ];
        let names: Vec<&str> = written.iter().filter(|(is, _)| *is).map(|(_, name)| *name).collect();
        let (Some(of), false) = (&block.mujoco, names.is_empty()) else { return };
        let verb = if names.len() == 1 { "has" } else { "have" };
        let text =
            format!("{} of the simulator {verb} no effect beside a plant", names::list(names.iter().copied(), 3));
        let d = Diagnostic::warning("HQ0822", self.origins.span(of.at), text);
        self.push(d.help("leave that out: drives lag by their `response`, and are as fast as their torques allow"));
    }
}

fn settings(block: &MujocoBlock, payload: Option<Payload>, period: f64) -> PlantProgram {
    PlantProgram {
        actuators: if block.actuators == "position" { Actuators::Position } else { Actuators::Velocity },
        response: block.response.value,
        gravity: match block.gravity {
            "uncompensated" => Gravity::Uncompensated,
            "none" => Gravity::None,
            _ => Gravity::Compensated,
        },
        friction: block.friction,
        payload,
        contacts: block.contacts,
        self_contact: block.self_contact,
        person_radius: block.person_radius,
        step: block.step.as_ref().map_or(USUAL_STEP.min(period).min(block.response.value), |step| step.value),
    }
}

/// Diagnostic for a robot that has no drives, or nothing that they move.
fn without_drives(model: &Model, at: Span) -> Option<Diagnostic> {
    if model.bases.iter().any(|base| base.kind == Base::Floating) {
        let d = Diagnostic::error("HQ0821", at, "a floating base has no drive, and would fall");
        return Some(d.help("a `plant` needs a base that is fixed or has wheels; leave it out for this robot"));
    }
    let moved = |link: usize, dof: usize| model.support(LinkId(link as u32)).iter().any(|s| s.dof as usize == dof);
    let mass = |dof: usize| -> f64 {
        model.links.iter().enumerate().filter(|(k, _)| moved(*k, dof)).map(|(_, link)| link.mass).sum()
    };
    let weightless = model.dofs.iter().enumerate().find(|(dof, d)| d.joint.is_some() && mass(*dof) <= 0.0);
    weightless.map(|(_, d)| {
        Diagnostic::error("HQ0821", at, format!("joint `{}` moves links without a mass", d.name))
            .note("a drive without a mass has no motion that physics could compute")
            .help("write the `<inertial>` of these links into the URDF, or lock the joint")
    })
}

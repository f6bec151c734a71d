//! The robot of a run as MuJoCo moves it.

use std::sync::{Arc, OnceLock};

use robot::{Base, Model};
use runtime::physics::{Around, Drives, Physics};
use runtime::program::{Actuators, Program, ScenarioProgram};

use crate::library::{LibraryError, MuJoCo, Scene};
use crate::mjcf::{self, Mjcf};
use crate::room::Room;

/// Reason why a program has no physical robot.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
pub enum PlantError {
    /// The run asks for none.
    #[error("the run has no `plant`")]
    None,
    /// Its base floats, and nothing holds it in the air.
    #[error("a floating base has no drive, and would fall: `plant` needs a base that is fixed or has wheels")]
    Floating,
    /// MuJoCo cannot be used, or refuses the robot.
    #[error(transparent)]
    Library(#[from] LibraryError),
}

/// A robot in MuJoCo.
pub struct Plant {
    scene: Scene,
    mjcf: Mjcf,
    room: Room,
    name: String,
    model: Model,
    data: robot::Data,
    actuators: Actuators,
    /// Positions of the model's joints.
    positions: Vec<f64>,
    velocities: Vec<f64>,
    controls: Vec<f64>,
    /// Positions that the drives are asked for, by degree of freedom (rad or m).
    wanted: Vec<f64>,
    /// Position and orientation of each body that is placed from outside: those of the room, then the bases.
    positions_placed: Vec<f64>,
    orientations_placed: Vec<f64>,
    started: bool,
}

/// The library, found once.
fn library() -> Result<Arc<MuJoCo>, LibraryError> {
    static FOUND: OnceLock<Result<Arc<MuJoCo>, LibraryError>> = OnceLock::new();
    FOUND.get_or_init(MuJoCo::find).clone()
}

impl Plant {
    /// Prepares the robot of a checked program, at rest.
    ///
    /// # Errors
    /// The run has no plant, the base floats, or MuJoCo cannot be used.
    pub fn new(program: &Program, scenario: Option<&ScenarioProgram>) -> Result<Plant, PlantError> {
        let settings = program.run.simulator.plant.as_ref().ok_or(PlantError::None)?;
        let model = program.robot.model.clone();
        if model.bases.iter().any(|base| base.kind == Base::Floating) {
            return Err(PlantError::Floating);
        }
        let library = library()?;
        let truth = scenario.and_then(|s| s.true_program(program));
        let room = Room::new(truth.as_ref().unwrap_or(program), scenario, settings.contacts, settings.person_radius);
        let mjcf = mjcf::write(program, &room, settings);
        let scene = Scene::new(&library, &mjcf.xml)?;
        let placed = room.moving() + model.bases.len();
        let counts = [scene.joints(), scene.actuators(), scene.placed()];
        let written = [mjcf.joints.len(), mjcf.drives.len(), placed];
        if counts != written {
            let text = format!("it has {counts:?} joints, drives and placed bodies of the {written:?} written");
            return Err(LibraryError::Refused(text).into());
        }
        Ok(Plant {
            name: format!("MuJoCo {}", library.version()),
            positions: vec![0.0; mjcf.joints.len()],
            velocities: vec![0.0; mjcf.joints.len()],
            controls: vec![0.0; mjcf.drives.len()],
            wanted: vec![0.0; model.nv()],
            data: robot::Data::new(&model),
            actuators: settings.actuators,
            positions_placed: vec![0.0; 3 * placed],
            orientations_placed: [1.0, 0.0, 0.0, 0.0].repeat(placed),
            started: false,
            scene,
            mjcf,
            room,
            model,
        })
    }

    /// The model as MuJoCo was given it.
    pub fn mjcf(&self) -> &Mjcf {
        &self.mjcf
    }

    /// Velocities of the model's joints after the last period (rad/s or m/s), in the order of [`Mjcf::joints`].
    pub fn velocities(&self) -> &[f64] {
        &self.velocities
    }

    /// Places the robot at rest in a configuration.
    fn start(&mut self, q: &[f64]) {
        for (dof, d) in self.model.dofs.iter().enumerate() {
            self.wanted[dof] = d.q_index.map_or(0.0, |i| q[i]);
        }
        for (at, joint) in self.positions.iter_mut().zip(&self.mjcf.joints) {
            *at = joint.multiplier * self.wanted[joint.dof] + joint.offset;
        }
        self.scene.set_positions(&self.positions);
        self.place(q, 0.0);
        self.scene.forward();
        self.started = true;
    }

    /// Places the bases where the configuration has them, and what is around so many seconds after the tick.
    fn place(&mut self, q: &[f64], after: f64) {
        let Plant { positions_placed: positions, orientations_placed: orientations, .. } = self;
        if positions.is_empty() {
            return;
        }
        self.room.place(after, positions, orientations);
        let others = self.room.moving();
        let places = positions[3 * others..].chunks_exact_mut(3).zip(orientations[4 * others..].chunks_exact_mut(4));
        if !self.model.bases.is_empty() {
            self.model.forward(q, &mut self.data);
        }
        for (base, (position, orientation)) in self.model.bases.iter().zip(places) {
            let pose = self.data.pose(base.link);
            let (p, r) = (&pose.translation, &pose.rotation);
            position.copy_from_slice(&[p.x, p.y, p.z]);
            orientation.copy_from_slice(&[r.w, r.i, r.j, r.k]);
        }
        self.scene.place(positions, orientations);
    }
}

impl Physics for Plant {
    fn name(&self) -> &str {
        &self.name
    }

    fn step(&self) -> f64 {
        self.mjcf.step
    }

    fn advance(&mut self, q: &mut [f64], drives: Drives, period: f64, around: Option<&Around>) -> Result<(), String> {
        self.room.tick(around);
        if !self.started {
            self.start(q);
        }
        let steps = self.mjcf.steps;
        let before = self.scene.time();
        for k in 0..steps {
            for (control, &dof) in self.controls.iter_mut().zip(&self.mjcf.drives) {
                *control = match self.actuators {
                    Actuators::Velocity => drives.velocity[dof],
                    Actuators::Position => {
                        let d = &self.model.dofs[dof];
                        let goal = d.q_index.map_or(0.0, |i| drives.position[i]);
                        let left = (steps - k) as f64;
                        self.wanted[dof] =
                            (self.wanted[dof] + (goal - self.wanted[dof]) / left).clamp(d.lower, d.upper);
                        self.wanted[dof]
                    }
                };
            }
            self.scene.set_controls(&self.controls);
            self.place(q, k as f64 * self.mjcf.step);
            self.scene.step();
        }
        self.scene.positions(&mut self.positions);
        self.scene.velocities(&mut self.velocities);
        // MuJoCo begins again at time zero when a number has become too large.
        let went_on = self.scene.time() > before + 0.5 * period;
        let finite = self.positions.iter().chain(&self.velocities).all(|x| x.is_finite());
        if !went_on || !finite {
            let ms = (self.mjcf.step * 1e6).round() / 1e3;
            return Err(format!(
                "the simulation in {} has diverged: a shorter `step` than {ms} ms, or a longer `response`, keeps it stable",
                self.name
            ));
        }
        for (at, joint) in self.positions.iter().zip(&self.mjcf.joints).filter(|(_, joint)| joint.own) {
            if let Some(i) = self.model.dofs[joint.dof].q_index {
                q[i] = *at;
            }
        }
        Ok(())
    }
}

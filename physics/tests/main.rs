//! The physical robot beside what is known of it without MuJoCo: the equation of a drive, potential energy by differences, a wall.

mod bodies;

use std::path::Path;

use hierarq_physics::library::{LibraryError, MuJoCo};
use hierarq_physics::plant::Plant;
use hierarq_physics::{self as physics, mjcf};
use nalgebra::Point3;
use robot::{Data, LinkId, Model};
use runtime::physics::{Drives, Physics};
use runtime::program::Program;

/// False, with a message, where there is no MuJoCo. `.ci/run` installs one and names it.
fn installed() -> bool {
    match MuJoCo::find() {
        Ok(_) => true,
        Err(LibraryError::Missing { .. }) if std::env::var_os("HIERARQ_MUJOCO").is_none() => {
            println!("not run: MuJoCo is not installed");
            false
        }
        Err(e) => panic!("{e}"),
    }
}

fn compiled(text: &str) -> Program {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let compiled = compiler::compile(&compiler::Input {
        name: "plant.hq",
        text,
        syntax: dsl::Syntax::Native,
        folder: &folder,
        set: &[],
        package_paths: &[],
    });
    assert!(compiled.is_good(), "{}", compiled.report.render(compiler::Style::Plain, 100));
    compiled.program.expect("a robot")
}

/// Two links at 500 Hz, with a plant of these settings.
fn pendulum(settings: &str, more: &str) -> Program {
    compiled(&format!(
        "hierarq 1
robot r {{ urdf \"robots/pendulum.urdf\"  rate 500 Hz  home {{ shoulder 0.4 rad  elbow -0.7 rad }} }}
{more}
task still = joint_velocity {{ velocity 0 rad/s }}
stack s {{ level l hard {{ joint_velocity_limits }}  level motion {{ still }} }}
run {{ duration 1 s  plant mujoco {{ {settings} }} }}
"
    ))
}

/// Velocities of the joints after these seconds under a constant command from rest at home, with the configuration then.
fn after(program: &Program, command: &[f64], seconds: f64) -> (Vec<f64>, Vec<f64>) {
    let mut plant = Plant::new(program, None).expect("a plant");
    let mut q = program.robot.home.clone();
    let period = program.robot.period;
    let mut position = q.clone();
    for _ in 0..(seconds / period).round() as usize {
        program.robot.model.integrate(&mut position, command, period);
        let drives = Drives { velocity: command, position: &position };
        plant.advance(&mut q, drives, period, None).expect("it is stable");
    }
    (plant.velocities().to_vec(), q)
}

/// Potential energy of the masses of a robot (J).
fn energy(model: &Model, q: &[f64]) -> f64 {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let height = |(k, l): (usize, &robot::Link)| (data.pose(LinkId(k as u32)) * Point3::from(l.center_of_mass)).z;
    model.links.iter().enumerate().map(|(k, l)| 9.81 * l.mass * height((k, l))).sum()
}

/// Torques of gravity in a configuration, by central differences of the energy (N m).
fn gravity(model: &Model, q: &[f64]) -> Vec<f64> {
    let h = 1e-5;
    (0..q.len())
        .map(|i| {
            let mut at = [q.to_vec(), q.to_vec()];
            at[0][i] += h;
            at[1][i] -= h;
            -(energy(model, &at[0]) - energy(model, &at[1])) / (2.0 * h)
        })
        .collect()
}

#[test]
fn a_drive_follows_its_command_with_its_time_constant() {
    if !installed() {
        return;
    }
    // A command to one joint, too small to couple the joints or to move far: dv/dt = (command - v)/response.
    for (joint, response) in [(0, 0.02), (1, 0.02), (1, 0.1)] {
        let program = pendulum(&format!("response {response} s  gravity none  step 0.1 ms"), "");
        let mut command = [0.0, 0.0];
        command[joint] = 0.01;
        for seconds in [0.5 * response, response, 2.0 * response] {
            let (v, _) = after(&program, &command, seconds);
            let expected = 0.01 * (1.0 - (-seconds / response).exp());
            assert!(
                (v[joint] - expected).abs() < 3e-4,
                "joint {joint}, {response} s after {seconds} s: {} for {expected}",
                v[joint]
            );
        }
    }
}

#[test]
fn uncompensated_gravity_moves_a_drive_by_its_torque() {
    if !installed() {
        return;
    }
    let program = pendulum("response 5 ms  gravity uncompensated  step 0.1 ms", "");
    let model = &program.robot.model;
    let plant = program.run.simulator.plant.as_ref().expect("a plant");
    let inertias = mjcf::effective_inertias(model, &program.robot.home, plant);
    // After many time constants, the drive's torque kv v balances gravity where the robot is then.
    let (v, q) = after(&program, &[0.0, 0.0], 0.1);
    for (joint, torque) in gravity(model, &q).into_iter().enumerate() {
        let expected = torque * 0.005 / inertias[joint];
        assert!((v[joint] - expected).abs() < 0.02 * expected.abs() + 1e-4, "{joint}: {} for {expected}", v[joint]);
    }
    let (v, _) = after(&pendulum("response 5 ms", ""), &[0.0, 0.0], 0.1);
    assert!(v.iter().all(|v| v.abs() < 1e-6), "compensated, it stands: {v:?}");
}

#[test]
fn a_payload_pulls_although_gravity_is_compensated() {
    if !installed() {
        return;
    }
    let program = pendulum("response 5 ms  payload { link tip  mass 0.5 kg  at [0, 0.1, 0] m }  step 0.1 ms", "");
    let model = &program.robot.model;
    let plant = program.run.simulator.plant.as_ref().expect("a plant");
    let inertias = mjcf::effective_inertias(model, &program.robot.home, plant);
    let (v, q) = after(&program, &[0.0, 0.0], 0.1);
    let mut loaded = model.clone();
    for link in &mut loaded.links {
        link.mass = 0.0;
    }
    let tip = model.link("tip").expect("the tip");
    loaded.links[tip.index()].mass = 0.5;
    loaded.links[tip.index()].center_of_mass = [0.0, 0.1, 0.0].into();
    for (joint, torque) in gravity(&loaded, &q).into_iter().enumerate() {
        let expected = torque * 0.005 / inertias[joint];
        assert!((v[joint] - expected).abs() < 0.02 * expected.abs() + 1e-4, "{joint}: {} for {expected}", v[joint]);
    }
}

#[test]
fn drives_of_positions_reach_the_integral_of_the_command() {
    if !installed() {
        return;
    }
    let program = pendulum("actuators position  response 10 ms", "");
    let (v, q) = after(&program, &[0.5, -0.3], 0.4);
    // A critically damped drive lags by twice its time constant behind a ramp.
    for (joint, command) in [0.5, -0.3].into_iter().enumerate() {
        let expected = program.robot.home[joint] + command * (0.4 - 0.02);
        assert!((q[joint] - expected).abs() < 2e-3, "{joint}: {} for {expected}", q[joint]);
        assert!((v[joint] - command).abs() < 0.01, "{joint}: {}", v[joint]);
    }
}

#[test]
fn a_wall_holds_the_robot_unless_there_are_no_contacts() {
    if !installed() {
        return;
    }
    let wall = "obstacle wall { box [2, 0.1, 3] m  position [0, 0.3, 1] m }";
    let reach = |settings: &str, wall: &str| {
        let program = pendulum(&format!("response 20 ms  {settings}"), wall);
        let (_, q) = after(&program, &[0.0, 1.0], 2.5);
        q[1]
    };
    let free = reach("", "");
    assert!((free - 1.8).abs() < 0.05, "{free}");
    assert!((reach("contacts false", wall) - free).abs() < 1e-9);
    let held = reach("", wall);
    assert!(held < free - 0.2, "{held} at the wall, {free} without it");
}

#[test]
fn an_arm_of_the_examples_stays_near_what_the_kinematic_robot_does() {
    if !installed() {
        return;
    }
    let text = "hierarq 1
robot arm { urdf \"../../examples/robots/arm7.urdf\"  rate 500 Hz  home { joint_2 0.5 rad  joint_4 1.2 rad } }
task still = joint_velocity { velocity 0 rad/s }
stack s { level l hard { joint_velocity_limits }  level motion { still } }
run { duration 1 s  plant mujoco { response 5 ms } }
";
    let program = compiled(text);
    let command: Vec<f64> = (0..7).map(|i| 0.2 * f64::from(i % 3 - 1)).collect();
    let (v, q) = after(&program, &command, 1.0);
    for (joint, command) in command.iter().enumerate() {
        let kinematic = program.robot.home[joint] + command;
        assert!((q[joint] - kinematic).abs() < 0.01, "{joint}: {} for {kinematic}", q[joint]);
        assert!((v[joint] - command).abs() < 0.03, "{joint}: {} for {command}", v[joint]);
    }
}

#[test]
fn a_base_with_wheels_moves_as_it_is_commanded() {
    if !installed() {
        return;
    }
    let text = "hierarq 1
robot carrier { urdf \"../../examples/robots/mobile_arm.urdf\"  base planar  rate 100 Hz }
task still = joint_velocity { velocity 0 rad/s }
stack s { level l hard { joint_velocity_limits }  level motion { still } }
run { duration 1 s  plant mujoco { } }
";
    let program = compiled(text);
    let mut robot = {
        physics::provide();
        runtime::SimulatedRobot::of_run(&program, None).expect("physics")
    };
    assert!(robot.plant().is_some_and(|plant| plant.engine.starts_with("MuJoCo ")), "{:?}", robot.plant());
    let mut ideal = runtime::SimulatedRobot::new(&program);
    let mut command = vec![0.0; program.robot.model.nv()];
    command[..3].copy_from_slice(&[0.2, -0.1, 0.3]);
    for _ in 0..100 {
        robot.apply(&command);
        ideal.apply(&command);
    }
    let base = program.robot.model.root_base().nq();
    for i in 0..base {
        assert!((robot.q()[i] - ideal.q()[i]).abs() < 1e-12, "base");
    }
    for i in base..robot.q().len() {
        assert!((robot.q()[i] - ideal.q()[i]).abs() < 2e-3, "joint {i}: {} and {}", robot.q()[i], ideal.q()[i]);
    }
}

#[test]
fn bases_of_several_robots_move_as_they_are_commanded() {
    if !installed() {
        return;
    }
    let text = "hierarq 1
robot arm { urdf \"../../examples/robots/arm7.urdf\"  rate 100 Hz  at [0, 3, 0] m  home { joint_4 1 rad } }
robot cart { urdf \"../../examples/robots/mobile_arm.urdf\"  base unicycle  rate 100 Hz  at pose([1, 0, 0] m, rpy(0, 0, 90 deg)) }
robot slider { urdf \"../../examples/robots/mobile_arm.urdf\"  base planar  rate 100 Hz  at [-3, 0, 0] m }
task still = joint_velocity { velocity 0 rad/s }
stack s { level l hard { joint_velocity_limits }  level motion { still } }
run { duration 1 s  plant mujoco { } }
";
    let program = compiled(text);
    physics::provide();
    let mut robot = runtime::SimulatedRobot::of_run(&program, None).expect("physics");
    let mut ideal = runtime::SimulatedRobot::new(&program);
    let model = &program.robot.model;
    let mut command = vec![0.0; model.nv()];
    for base in &model.bases {
        let speeds = if base.kind.nv() == 2 { vec![0.2, 0.3] } else { vec![0.2, -0.1, -0.3] };
        command[base.dofs()].copy_from_slice(&speeds);
    }
    for _ in 0..100 {
        robot.apply(&command);
        ideal.apply(&command);
    }
    let of_base = |i: usize| model.bases.iter().any(|base| base.coordinates().contains(&i));
    for (i, (q, wanted)) in robot.q().iter().zip(ideal.q()).enumerate() {
        let most = if of_base(i) { 1e-12 } else { 2e-3 };
        assert!((q - wanted).abs() < most, "number {i}: {q} and {wanted}");
    }
}

#[test]
fn what_is_no_library_is_refused() {
    let no = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    assert!(matches!(MuJoCo::load(&no), Err(LibraryError::Unusable { .. })));
}

#[test]
fn the_same_run_gives_the_same_bits() {
    if !installed() {
        return;
    }
    let program = pendulum("response 5 ms  friction 0.2 Nm  gravity uncompensated", "");
    let once = after(&program, &[0.3, -0.2], 0.5);
    let again = after(&program, &[0.3, -0.2], 0.5);
    assert_eq!(once, again);
}

/// Final angle of the elbow after a run of the pendulum in a scenario, with the reason why it diverged, if it did.
fn elbow_after(settings: &str, declared: &str, scenario: &str) -> (f64, Option<String>) {
    let program = compiled(&format!(
        "hierarq 1
robot r {{ urdf \"robots/pendulum.urdf\"  rate 500 Hz  tracking_gain 0 /s  home {{ shoulder 0 rad  elbow 0 rad }} }}
{declared}
task still = joint_velocity {{ velocity 0 rad/s }}
stack s {{ level l hard {{ joint_velocity_limits }}  level motion {{ still }} }}
run {{ duration 1 s  stack s }}
scenario one {{ duration 2 s  plant mujoco {{ response 20 ms  {settings} }}
{scenario} }}
"
    ));
    physics::provide();
    struct Last(f64, usize, Option<String>);
    impl runtime::Recorder for Last {
        fn tick(&mut self, tick: &runtime::Tick) -> std::io::Result<()> {
            (self.0, self.1) = (tick.q[1], tick.index + 1);
            Ok(())
        }
        fn diverged(&mut self, why: &str) {
            self.2 = Some(why.to_string());
        }
    }
    let scenario = &program.scenarios[0];
    let program = scenario.program(&program);
    let mut simulation = runtime::Simulation::in_world(&program, scenario).expect("physics");
    let mut last = Last(f64::NAN, 0, None);
    simulation.run(&mut last, &mut || 0.0, &mut |_| true).expect("nothing is written");
    assert!(last.2.is_some() || last.1 == simulation.ticks());
    (last.0, last.2)
}

#[test]
fn a_simulation_that_diverges_says_when_and_ends() {
    if !installed() {
        return;
    }
    // A drive that is a hundred times faster than the time step oscillates until its torque is at its limit; without gravity and with
    // light links that is enough.
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/robots/pendulum.urdf"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("diverging");
    std::fs::create_dir_all(&folder).expect("a folder");
    let urdf = folder.join("strong.urdf");
    std::fs::write(&urdf, text.expect("a robot").replace("effort=\"200\"", "effort=\"0\"")).expect("written");
    let program = compiled(&format!(
        "hierarq 1
robot r {{ urdf \"{}\"  rate 500 Hz  home {{ shoulder 0.4 rad  elbow -0.7 rad }} }}
task still = joint_velocity {{ velocity 0 rad/s }}
stack s {{ level l hard {{ joint_velocity_limits }}  level motion {{ still }} }}
run {{ duration 1 s  plant mujoco {{ actuators position  response 0.1 ms  step 2 ms }} }}
",
        urdf.display()
    ));
    let mut plant = Plant::new(&program, None).expect("a plant");
    let mut q = program.robot.home.clone();
    let mut position = q.clone();
    let mut advance = || {
        program.robot.model.integrate(&mut position, &[0.5, -0.5], 0.002);
        let drives = Drives { velocity: &[0.5, -0.5], position: &position };
        plant.advance(&mut q, drives, 0.002, None).err()
    };
    let why = (0..500).find_map(|_| advance()).expect("it diverges");
    assert!(why.contains("has diverged") && why.contains("a shorter `step` than 2 ms"), "{why}");
}

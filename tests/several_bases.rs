//! Robots with bases of all kinds in one spec move as each of them does alone, and tasks may relate them.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use robot::Data;

use crate::common::{Everything, holds, program_of, recorded};

/// A robot of a spec, with a target for one of its frames in the axes of its place.
struct Member {
    name: &'static str,
    urdf: &'static str,
    base: &'static str,
    home: &'static str,
    limits: &'static str,
    frame: &'static str,
    /// Speeds of its base, or of a joint.
    drive: &'static [&'static str],
    target: [f64; 3],
    /// Place on the ground, and direction in degrees.
    at: [f64; 3],
}

const CART: Member = Member {
    name: "cart",
    urdf: "mobile_arm",
    base: "unicycle",
    home: "base_x -0.4 m  base_yaw 20 deg  torso_lift 0.15 m  \"arm_*\" [1.2, 0.35, -0.6, 2.05, 0.9, 0.6, 0] rad",
    limits: "base_forward { velocity 0.4 m/s }  base_yaw { velocity 0.5 rad/s }",
    frame: "tool",
    drive: &["base_forward 0.05 m/s", "base_yaw 0.1 rad/s"],
    target: [1.3, 0.5, 0.9],
    at: [0.0, 0.0, 0.0],
};

const ARM: Member = Member {
    name: "arm",
    urdf: "arm7",
    base: "fixed",
    home: "joint_2 0.4 rad  joint_4 1.4 rad  joint_6 0.6 rad",
    limits: "",
    frame: "tool",
    drive: &["joint_7 0.1 rad/s"],
    target: [0.4, 0.3, 0.6],
    at: [3.0, -1.0, 90.0],
};

const FLYER: Member = Member {
    name: "flyer",
    urdf: "arm7",
    base: "floating",
    home: "base_z 1 m  base_orientation rpy(20 deg, 0, 90 deg)  joint_2 0.4 rad  joint_4 1.2 rad",
    limits: "base_x { velocity 0.5 m/s }  base_wz { velocity 0.4 rad/s }",
    frame: "tool",
    drive: &["base_x 0.05 m/s", "base_wz 0.1 rad/s"],
    target: [0.5, 0.2, 2.0],
    at: [-2.0, 1.0, 30.0],
};

const SLIDER: Member = Member {
    name: "slider",
    base: "planar",
    limits: "base_y { velocity 0.3 m/s }",
    drive: &["base_y 0.05 m/s", "base_yaw 0.1 rad/s"],
    at: [0.0, 3.0, -45.0],
    ..CART
};

impl Member {
    fn place(&self) -> Isometry3<f64> {
        let [x, y, turn] = self.at;
        Isometry3::from_parts([x, y, 0.0].into(), UnitQuaternion::from_euler_angles(0.0, 0.0, turn.to_radians()))
    }

    /// Its declaration, alone or at its place.
    fn robot(&self, alone: bool) -> String {
        let Member { name, urdf, base, home, limits, at: [x, y, turn], .. } = self;
        let at = if alone { String::new() } else { format!("at pose([{x}, {y}, 0] m, rpy(0, 0, {turn} deg))") };
        let limits = if limits.is_empty() { String::new() } else { format!("limits {{ {limits} }}") };
        format!(
            "robot {name} {{ urdf \"robots/{urdf}.urdf\"  base {base}  rate 100 Hz  {at}  {limits}  home {{ {home} }} }}\n"
        )
    }

    fn task(&self, alone: bool) -> String {
        let target = Point3::from(self.target);
        let p = if alone { target } else { self.place() * target };
        let Member { name, frame, .. } = self;
        let frame = if alone { frame.to_string() } else { format!("{name}_{frame}") };
        format!(
            "task reach_{name} = frame_position({frame}) {{ position trapezoid([{}, {}, {}] m, speed: 0.2 m/s, \
             acceleration: 1 m/s^2)  gain 3 /s }}\n",
            p.x, p.y, p.z
        )
    }
}

/// A spec of some robots whose tasks know nothing of each other. The damping of a level would: it depends on all of its rows.
fn spec(members: &[&Member]) -> String {
    let alone = members.len() == 1;
    let robots: String = members.iter().map(|m| m.robot(alone)).collect();
    let tasks: String = members.iter().map(|m| m.task(alone)).collect();
    let names: Vec<String> = members.iter().map(|m| format!("reach_{}", m.name)).collect();
    let drive = |m: &&Member| -> String {
        let prefix = if alone { String::new() } else { format!("{}_", m.name) };
        m.drive.iter().map(|entry| format!("{prefix}{entry}  ")).collect()
    };
    let drives: String = members.iter().map(drive).collect();
    format!(
        "hierarq 1\n{robots}{tasks}stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}\n  \
         level drive damping none {{ joint_velocity {{ velocity {{ {drives} }} }} }}\n  level motion damping none {{ {} }}\n  \
         level rest damping none {{ joint_velocity {{ velocity {{ all 0 }} }} }} }}\n\
         scenario one {{ stack s  duration 3 s }}\n",
        names.join("  ")
    )
}

#[test]
fn robots_that_no_row_relates_move_as_alone() {
    let second = Member {
        name: "other",
        home: "base_y 0.7 m  base_yaw -100 deg  torso_lift 0.1 m  \"arm_*\" [1.2, 0.35, -0.6, 2.05, 0.9, 0.6, 0] rad",
        at: [1.0, -2.0, 120.0],
        ..CART
    };
    let teams: [&[&Member]; 4] = [&[&CART, &second], &[&CART, &ARM], &[&FLYER, &ARM], &[&SLIDER, &FLYER, &CART]];
    for team in teams {
        let together: Everything = recorded(&program_of(&spec(team)));
        let alone: Vec<Everything> = team.iter().map(|m| recorded(&program_of(&spec(&[m])))).collect();
        assert!(together.0.len() > 290);
        for (k, tick) in together.0.iter().enumerate() {
            assert_eq!(tick.fault, None);
            let q: Vec<f64> = alone.iter().flat_map(|of| of.0[k].q.clone()).collect();
            let v: Vec<f64> = alone.iter().flat_map(|of| of.0[k].command.clone()).collect();
            assert_eq!((q.len(), v.len()), (tick.q.len(), tick.command.len()));
            let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let (of_q, of_v) = (apart(&q, &tick.q), apart(&v, &tick.command));
            assert!(of_q < 1e-10 && of_v < 1e-10, "{} tick {k}: {of_q:e} {of_v:e}", team[0].name);
        }
        // They did move, the wheels too.
        let (first, last) = (&together.0[0].q, &together.0[together.0.len() - 1].q);
        assert!(first.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) > 0.2);
    }
}

#[test]
fn one_row_relates_a_unicycle_and_a_floating_base() {
    // The drone stays above the cart, wherever the cart drives.
    let text = "hierarq 1
robot cart { urdf \"robots/mobile_arm.urdf\"  base unicycle  rate 100 Hz  at [1, 0, 0] m  limits { base_forward { velocity 0.4 m/s } } }
robot drone { urdf \"robots/drone.urdf\"  base floating  rate 100 Hz  at pose([0, 2, 0] m, rpy(0, 0, 70 deg))  home { base_z 1.5 m } }
task drive = joint_velocity { velocity { cart_base_forward 0.3 m/s  cart_base_yaw 0.4 rad/s } }
task above = track(frame(drone_hull).position - frame(cart_base_link).position) { target [0, 0, 2] m  gain 2 /s }
task faces = track(dot(frame(drone_hull).orientation*[1, 0, 0], frame(cart_base_link).orientation*[0, 1, 0])) { target 0  gain 2 /s }
stack s { level limits hard { joint_position_limits  joint_velocity_limits }  level drive { drive }  level above { above  faces } }
scenario one {
  stack s
  duration 6 s
  start { cart_base_yaw 30 deg }
  expect always time > 4 s implies norm(frame(drone_hull).position - frame(cart_base_link).position - [0, 0, 2] m) < 1 cm
}
";
    let program = program_of(text);
    holds(&program);
    let all: Everything = recorded(&program);
    let model = &program.robot.model;
    let mut data = Data::new(model);
    let (hull, cart) = (model.link("drone_hull").expect("a link"), model.link("cart_base_link").expect("a link"));
    model.forward(&all.0[0].q, &mut data);
    assert!((data.position(cart) - Vector3::x()).norm() < 1e-12);
    assert!((data.position(hull) - Vector3::new(0.0, 2.0, 1.5)).norm() < 1e-12);
    // The cart drives on a circle of the radius v/ω.
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let centre = Vector3::new(1.0 - 0.75 * sin, 0.75 * cos, 0.0);
    for tick in &all.0 {
        model.forward(&tick.q, &mut data);
        let radius = (data.position(cart) - centre).norm();
        assert!((radius - 0.75).abs() < 1e-9, "{radius}");
    }
}

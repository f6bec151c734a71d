//! Random robots and hierarchies: serial arms of two to seven joints as URDF text, hard limits, and soft targets that lead into them.

use proptest::prelude::*;
use robot::{Data, Model, Options};

use crate::common;

/// A joint of an arm, and the link behind it.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Axis: 0, 1, 2 for x, y, z.
    axis: usize,
    /// Length of the link along z (m).
    length: f64,
    slides: bool,
    /// Half the range around its middle, in rad; a tenth of it in m.
    half: f64,
    /// Place at home as a part of the half range, and that of a target which can be reached.
    home: f64,
    goal: f64,
    /// Largest speed (rad/s); a fifth of it in m/s.
    speed: f64,
}

/// A robot.
#[derive(Clone, Debug)]
pub enum Arm {
    /// Joints of an arm that is written as a URDF.
    Random(Vec<Joint>),
    /// One of the examples.
    Example(&'static str, &'static str, &'static [f64]),
}

/// Declared delays of the drives (s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Delays {
    pub lag: f64,
    pub dead_time: f64,
}

/// What the soft levels ask for.
#[derive(Clone, Debug)]
pub enum Target {
    /// Places of all joints, which can be reached.
    Posture,
    /// A place of the tip, relative to that at home (m), which may be behind every limit.
    Place([f64; 3]),
    /// All joints towards an end of their ranges at their full speed.
    Push(bool),
    /// A way of the tip to and fro (m), once in so many seconds.
    Sway([f64; 3], f64),
}

/// A spec.
#[derive(Clone, Debug)]
pub struct Case {
    pub arm: Arm,
    pub rate: f64,
    /// Limit of accelerations, as a multiple of the largest speed per second.
    pub braking: Option<f64>,
    /// Room above the floor at home, and from a wall (m).
    pub floor: Option<f64>,
    pub wall: Option<f64>,
    pub target: Target,
    pub gain: f64,
    pub declared: Delays,
    pub tracking_gain: Option<f64>,
}

fn joint() -> impl Strategy<Value = Joint> {
    (0..3_usize, 0.08..0.4_f64, prop::bool::weighted(0.12), 0.6..2.9_f64, -0.7..0.7_f64, -0.7..0.7_f64, 0.5..3.0_f64)
        .prop_map(|(axis, length, slides, half, home, goal, speed)| Joint {
            axis,
            length,
            slides,
            half,
            home,
            goal,
            speed,
        })
}

fn arm() -> impl Strategy<Value = Arm> {
    let arm7 = Arm::Example("arm7", "tool", &[0.0, 0.40, 0.0, 1.60, 0.0, 1.14, 0.0]);
    let ur5 = Arm::Example("ur5", "tool0", &[0.3, -1.2, 1.6, -1.97, -1.57, 0.2]);
    prop_oneof![4 => prop::collection::vec(joint(), 2..=7).prop_map(Arm::Random), 1 => Just(arm7), 1 => Just(ur5)]
}

fn away(most: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-most..most)
}

/// Any spec, with the delays that it declares.
pub fn case(declared: impl Strategy<Value = Delays>) -> impl Strategy<Value = Case> {
    let target = prop_oneof![
        2 => Just(Target::Posture),
        4 => away(0.6).prop_map(Target::Place),
        1 => any::<bool>().prop_map(Target::Push),
        2 => (away(0.25), 1.5..4.0_f64).prop_map(|(way, period)| Target::Sway(way, period)),
    ];
    let rooms = (prop::option::of(0.02..0.3_f64), prop::option::weighted(0.3, 0.02..0.3_f64));
    (
        (arm(), prop::sample::select(vec![50.0, 100.0, 125.0, 250.0]), prop::option::weighted(0.8, 10.0..30.0_f64)),
        (rooms, target, 1.0..5.0_f64, declared, prop::option::weighted(0.3, 0.2..1.0_f64)),
    )
        .prop_map(|((arm, rate, braking), ((floor, wall), target, gain, declared, share))| Case {
            tracking_gain: share.map(|s| s * 0.25 / (declared.lag + declared.dead_time + 1.0 / rate)),
            arm,
            rate,
            braking,
            floor,
            wall,
            target,
            gain,
            declared,
        })
}

/// A compiled case, and what the tests have to know of it.
pub struct Built {
    pub program: runtime::Program,
    pub tip: robot::LinkId,
    /// Largest accelerations, where these are limited.
    pub accelerations: Option<Vec<f64>>,
    /// Lowest place of the tip, and its largest x (m).
    pub floor: Option<f64>,
    pub wall: Option<f64>,
    /// Place of the tip, and of joints, that are asked for at the end.
    pub goal: Option<Vec<f64>>,
}

impl Arm {
    /// Path of the URDF, name of the tip, home, and a goal within the limits.
    fn parts(&self, name: &str) -> (String, &'static str, Vec<f64>, Vec<f64>) {
        let joints = match self {
            Arm::Example(name, tip, home) => {
                let goal = home.iter().enumerate().map(|(i, q)| q + if i % 2 == 0 { 0.3 } else { -0.25 }).collect();
                return (format!("robots/{name}.urdf"), tip, home.to_vec(), goal);
            }
            Arm::Random(joints) => joints,
        };
        let mut text = String::from("<robot name=\"random\"><link name=\"base\"/>");
        for (k, j) in joints.iter().enumerate() {
            let scale = j.scale();
            let xyz = ["1 0 0", "0 1 0", "0 0 1"][j.axis];
            let (kind, from) = (if j.slides { "prismatic" } else { "revolute" }, k.to_string());
            let (parent, up) = if k == 0 { ("base", 0.3) } else { (from.as_str(), joints[k - 1].length) };
            text += &format!(
                "<link name=\"{}\"/><joint name=\"j{k}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{}\"/><origin xyz=\"0.02 0 {up}\"/>
                 <axis xyz=\"{xyz}\"/><limit lower=\"{}\" upper=\"{}\" velocity=\"{}\" effort=\"100\"/></joint>\n",
                k + 1,
                k + 1,
                -j.half * scale,
                j.half * scale,
                j.speed * if j.slides { 0.2 } else { 1.0 }
            );
        }
        let (last, length) = (joints.len(), joints[joints.len() - 1].length);
        text += &format!(
            "<link name=\"tip\"/><joint name=\"end\" type=\"fixed\"><parent link=\"{last}\"/><child link=\"tip\"/><origin xyz=\"0 0.03 {length}\"/></joint></robot>"
        );
        let path = common::urdf_file(&text, name).display().to_string();
        let places = |part: fn(&Joint) -> f64| joints.iter().map(|j| part(j) * j.half * j.scale()).collect();
        (path, "tip", places(|j| j.home), places(|j| j.goal))
    }
}

impl Joint {
    fn scale(&self) -> f64 {
        if self.slides { 0.1 } else { 1.0 }
    }
}

/// Numbers by the names of joints, each with the unit of its joint.
fn by_joint(model: &Model, numbers: &[f64], per: &str) -> String {
    let unit = |i: usize| if model.dofs[i].unit == robot::DofUnit::Radian { "rad" } else { "m" };
    model.dofs.iter().zip(numbers).enumerate().map(|(i, (d, x))| format!("{} {x} {}{per}  ", d.name, unit(i))).collect()
}

impl Case {
    /// The text of the spec, and what is known of it. `name` is that of a file for the robot.
    pub fn build(&self, name: &str) -> Built {
        let (urdf, tip, home, goal) = self.arm.parts(name);
        let path = common::example(&urdf);
        let text = std::fs::read_to_string(path).expect("a robot");
        let model = Model::from_urdf(&text, &Options::default()).expect("a robot").0;
        let mut data = Data::new(&model);
        let link = model.link(tip).expect("a tip");
        model.forward(&goal, &mut data);
        let reached = *data.position(link);
        model.forward(&home, &mut data);
        let at = *data.position(link);
        // A goal that can be reached is within all limits.
        let reachable = matches!(self.target, Target::Posture);
        let lowest = self.floor.map(|room| if reachable { at.z.min(reached.z) - room } else { at.z - room });
        let furthest = self.wall.map(|room| if reachable { at.x.max(reached.x) + room } else { at.x + room });
        let speeds: Vec<f64> = model.dofs.iter().map(|d| d.velocity).collect();
        let accelerations = self.braking.map(|factor| speeds.iter().map(|v| v * factor).collect::<Vec<f64>>());
        let list = |[x, y, z]: [f64; 3]| format!("[{x}, {y}, {z}] m");
        let gain = format!("gain {} /s", self.gain);
        let target = match &self.target {
            Target::Posture => format!("joint_position {{ target {{ {} }}  {gain} }}", by_joint(&model, &goal, "")),
            Target::Place(by) => {
                format!(
                    "frame_position({tip}) {{ position {}  {gain} }}",
                    list([at.x + by[0], at.y + by[1], at.z + by[2]])
                )
            }
            Target::Push(up) => {
                let signed: Vec<f64> = speeds.iter().map(|v| if *up { *v } else { -v }).collect();
                format!("joint_velocity {{ velocity {{ {} }} }}", by_joint(&model, &signed, "/s"))
            }
            Target::Sway(by, period) => format!(
                "frame_position({tip}) {{ position {} + {} * sin(2*pi*t/({period} s))  {gain} }}",
                list([at.x, at.y, at.z]),
                list(*by)
            ),
        };
        let declared = [("lag", self.declared.lag), ("dead_time", self.declared.dead_time)];
        let mut settings: String =
            declared.iter().filter(|d| d.1 > 0.0).map(|(key, value)| format!("{key} {value} s  ")).collect();
        if let Some(gain) = self.tracking_gain {
            settings += &format!("tracking_gain {gain} /s");
        }
        let limits = accelerations.as_ref().map_or_else(String::new, |a| {
            format!("joint_acceleration_limits {{ max {{ {} }} }}", by_joint(&model, a, "/s^2"))
        });
        // Planes, seen from the free side anticlockwise.
        let plane = |name: &str, points: Option<[[f64; 3]; 3]>| {
            let points = points?.map(list).join(", ");
            Some((format!("task {name} = virtual_wall(tip) {{ through [{points}]  gain 5 /s }}\n"), name.to_owned()))
        };
        let rooms: Vec<(String, String)> = [
            plane("floor", lowest.map(|z| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]])),
            plane("wall", furthest.map(|x| [[x, 0.0, 0.0], [x, 0.0, 1.0], [x, 1.0, 0.0]])),
        ]
        .into_iter()
        .flatten()
        .collect();
        let names: String = rooms.iter().map(|r| format!("{}  ", r.1)).collect();
        let room = if rooms.is_empty() { String::new() } else { format!("level room hard {{ {names} }}") };
        let spec = format!(
            "hierarq 1
robot arm {{ urdf \"{urdf}\"  rate {} Hz  {settings}  points {{ tip {tip} }}  home {{ {} }} }}
{}task aim = {target}
stack s {{
  level limits hard {{ joint_position_limits  joint_velocity_limits  {limits} }}
  {room}
  level m {{ aim }}
}}
run {{ stack s  duration 60 s }}",
            self.rate,
            by_joint(&model, &home, ""),
            rooms.iter().map(|r| r.0.as_str()).collect::<String>()
        );
        Built {
            program: common::program_of(&spec),
            tip: link,
            accelerations,
            floor: lowest,
            wall: furthest,
            goal: reachable.then_some(goal),
        }
    }
}

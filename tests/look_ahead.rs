//! Limits on hard levels without a written reserve look ahead: walls and distances hold at every tick, whatever the rate, the
//! gain and the speeds, and robots that are far away move as if they did not.

use crate::common;

use nalgebra::{UnitVector3, Vector3};
use robot::random::SplitMix64;
use robot::{Data, Model, Options};
use runtime::record::summary::MARGIN_TOLERANCE;
use runtime::{FaultKind, Program, Recorder, Simulation, Tick};

struct Dice(SplitMix64);

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.0.unit() * (high - low)
    }

    fn among<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.0.unit() * choices.len() as f64) as usize % choices.len()]
    }

    fn direction(&mut self) -> UnitVector3<f64> {
        UnitVector3::new_normalize(Vector3::from_fn(|_, _| self.between(-1.0, 1.0)) + Vector3::new(1e-3, 0.0, 0.0))
    }

    /// An expression that jumps between two values, several times a second.
    fn jumping(&mut self, low: f64, high: f64) -> String {
        let (a, b) = (self.between(low, high), self.between(low, high));
        format!("if(sin({}*t/(1 s) + {}) > 0, {a}, {b})", self.between(1.0, 30.0), self.between(0.0, 6.0))
    }
}

/// Levels of a random case.
#[derive(Clone, Copy, PartialEq)]
enum Levels {
    /// Limits of positions and of speeds.
    Speeds,
    /// Also of accelerations.
    Accelerations,
    /// Speeds, and a machine that changes the stack, with blends.
    Machine,
}

/// Random arm with a wall or a ball close to its tip, and a target that jumps far behind it. `reserve` is the parameter of the
/// limit.
fn case(seed: u64, levels: Levels, reserve: &str) -> Program {
    let mut dice = Dice(SplitMix64(seed));
    let urdf = std::fs::read_to_string(common::example("robots/arm7.urdf")).expect("readable");
    let model = Model::from_urdf(&urdf, &Options::default()).expect("a robot").0;
    let home: Vec<f64> = model.dofs.iter().map(|d| d.lower + dice.between(0.1, 0.9) * (d.upper - d.lower)).collect();
    let mut data = Data::new(&model);
    model.forward(&home, &mut data);
    let p = *data.position(model.link("tool").expect("a link"));
    let (n, away, rate) =
        (dice.direction().into_inner(), dice.between(0.001, 0.03), dice.among(&[20.0, 50.0, 100.0, 250.0]));
    let gain = dice.between(3.0, 12.0);
    let list = |v: Vector3<f64>| format!("[{}, {}, {}] m", v.x, v.y, v.z);
    let ball = dice.between(0.0, 1.0) < 0.5;
    let (radius, centre) = (0.4 * p.norm(), p * (0.6 - away / p.norm()));
    let limit = if ball {
        format!("self_collision {{ between tip  and post  d_min {radius} m  gain {gain} /s  {reserve} }}")
    } else {
        let u = n.cross(&dice.direction().into_inner()).normalize();
        let a = p - n * away;
        let through = [a, a + u, a + n.cross(&u)].map(list).join(", ");
        format!("virtual_wall(tip) {{ through [{through}]  gain {gain} /s  {reserve} }}")
    };
    let behind = p + 0.4 * if ball { -p.normalize() } else { -n };
    let target: Vec<String> = behind.iter().map(|x| dice.jumping(x - 0.7, x + 0.7)).collect();
    let other: Vec<String> = behind.iter().map(|x| dice.jumping(x - 0.7, x + 0.7)).collect();
    let accelerations = if levels == Levels::Accelerations { "joint_acceleration_limits" } else { "" };
    let (after, blend) = (dice.between(0.1, 0.4), dice.between(0.05, 0.3));
    let run = match levels {
        Levels::Machine => format!(
            "machine m {{ initial one  blend {blend} s
               state one {{ stack s  after {after} s -> two }}
               state two {{ stack s2  after {after} s -> one }} }}
             run {{ machine m  duration 1.5 s }}"
        ),
        _ => "run { stack s  duration 1.5 s }".to_string(),
    };
    let hard = format!("joint_position_limits  joint_velocity_limits  {accelerations}  apart");
    let home: Vec<String> = home.iter().map(f64::to_string).collect();
    common::program_of(&format!(
        "hierarq 1
         robot arm {{
           urdf \"robots/arm7.urdf\"
           rate {rate} Hz
           points {{ tip tool  post {{ link base_link  offset {} }} }}
           home {{ all [{}] rad }}
         }}
         task apart = {limit}
         task one = frame_position(tool) {{ position [{}] m  gain 8 /s }}
         task two = frame_position(tool) {{ position [{}] m  gain 8 /s }}
         stack s {{ level limits hard {{ {hard} }}  level motion {{ one }} }}
         stack s2 {{ level limits hard {{ {hard} }}  level motion {{ two }} }}
         {run}\n",
        list(centre),
        home.join(", "),
        target.join(", "),
        other.join(", "),
    ))
}

/// Results of a run.
#[derive(Default)]
struct Found {
    /// Smallest margin of `apart`, in m.
    margin: Option<f64>,
    fault: Option<FaultKind>,
    /// Ticks at which the robot was slower than the hierarchy asked for.
    slowed: usize,
    velocities: Vec<Vec<f64>>,
}

impl Recorder for Found {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let evaluator = tick.controller.evaluator();
        let limits = evaluator.members().iter().filter(|m| ["self_collision", "virtual_wall"].contains(&m.kind));
        for h in limits.flat_map(|m| &evaluator.margins()[m.margins.clone()]) {
            self.margin = Some(self.margin.map_or(*h, |least| least.min(*h)));
        }
        self.slowed += usize::from(tick.controller.stacks()[tick.stack].is_slowed());
        self.fault = self.fault.or(tick.fault.map(|f| f.kind()));
        self.velocities.push(tick.v.to_vec());
        Ok(())
    }
}

fn run(program: &Program) -> Found {
    let mut found = Found::default();
    let mut simulation = Simulation::new(program).expect("it can be executed");
    simulation.run(&mut found, &mut || 0.0, &mut |_| true).expect("no recorder fails");
    found
}

fn holds(found: &Found) -> bool {
    found.margin.is_some_and(|h| h >= -MARGIN_TOLERANCE)
}

#[test]
fn walls_and_distances_hold_at_every_tick() {
    let (mut near, mut lost, mut slowed, mut deepest) = (0, 0, 0, 0.0_f64);
    for seed in 0..80 {
        let found = run(&case(seed, Levels::Speeds, ""));
        assert!(found.fault.is_none() && holds(&found), "{seed}: {:?} {:?}", found.margin, found.fault);
        near += usize::from(found.margin.is_some_and(|h| h < 1e-4));
        slowed += usize::from(found.slowed > 0);
        let without = run(&case(seed, Levels::Speeds, "sampled_margin 0 m"));
        lost += usize::from(!holds(&without));
        deepest = deepest.min(without.margin.unwrap_or(0.0));
    }
    println!("{near} runs come near, {slowed} are slowed; without looking ahead {lost} lose, {deepest} m at most");
    assert!(near > 15 && lost > 15, "the motions show little: {near} come near, {lost} lose without looking ahead");
}

#[test]
fn with_limits_of_accelerations_they_hold_or_the_robot_stops() {
    let mut stopped = 0;
    for seed in 0..80 {
        let found = run(&case(seed, Levels::Accelerations, ""));
        let stops = found.fault.is_none_or(|f| f == FaultKind::Infeasible);
        assert!(stops && holds(&found), "{seed}: {:?} {:?}", found.margin, found.fault);
        stopped += usize::from(found.fault.is_some());
    }
    println!("{stopped} runs end in a fault");
}

#[test]
fn they_hold_from_one_stack_to_another() {
    for seed in 100..150 {
        let found = run(&case(seed, Levels::Machine, ""));
        assert!(found.fault.is_none() && holds(&found), "{seed}: {:?} {:?}", found.margin, found.fault);
    }
}

/// At the maximum of a height no velocity changes it to first order: the row alone allows full speed, beyond the wall.
#[test]
fn where_no_row_helps_the_robot_is_slower() {
    let urdf = r#"<robot name="bar"><link name="l0"/><link name="l1"/><link name="tip"/>
        <joint name="j" type="revolute"><parent link="l0"/><child link="l1"/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
        <joint name="f" type="fixed"><parent link="l1"/><child link="tip"/><origin xyz="1 0 0"/></joint></robot>"#;
    let path = common::urdf_file(urdf, "bar_ahead");
    let bar = |reserve: &str| {
        run(&common::program_of(&format!(
            "hierarq 1
             robot bar {{ urdf \"{}\"  rate 200 Hz  points {{ end tip }}  home {{ j -0.004 rad }} }}
             task wall = virtual_wall(end) {{ through [[0.99999, 0, 0], [0.99999, 1, 0], [0.99999, 0, 1]] m  gain 10 /s  {reserve} }}
             task push = joint_velocity {{ velocity {{ j if(t < 1 s, 2 rad/s, -2 rad/s) }} }}
             stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits  wall }}  level motion {{ push }} }}
             run {{ duration 2 s }}\n",
            path.display()
        )))
    };
    let ahead = bar("");
    assert!(ahead.fault.is_none() && holds(&ahead) && ahead.slowed > 0, "{:?} {:?}", ahead.margin, ahead.fault);
    let without = bar("sampled_margin 0 m");
    assert!(!holds(&without) && without.slowed == 0, "{:?}", without.margin);
}

#[test]
fn far_from_a_limit_the_velocities_are_the_same() {
    let far = |reserve: &str| {
        run(&common::program_of(&format!(
            "hierarq 1
             robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  points {{ tip tool }}  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
             task floor = virtual_wall(tip) {{ through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m  {reserve} }}
             task turn = frame_position(tool) {{ position initial(position) + [0, 0.1, 0] m * sin(2*pi*t/(4 s)) }}
             stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits  floor }}  level motion {{ turn }} }}
             run {{ duration 2 s }}\n"
        )))
    };
    let (ahead, without) = (far(""), far("sampled_margin 0 m"));
    assert!(ahead.velocities == without.velocities);
    assert!(ahead.margin.is_some_and(|h| h > 0.1));
}

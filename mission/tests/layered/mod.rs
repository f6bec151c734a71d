//! Layered problems for tests, benches and measurements: letters and sorting of thesis 6.4, and random ones from a
//! seed.
//!
//! The thesis prints masses (Table 6.2), speeds, weights and the number of blocks; positions of blocks and bases,
//! constant times, power and the slowing of people are our own values.
#![allow(dead_code, reason = "each binary uses a part")]

use std::collections::{BTreeMap, BTreeSet};

use hierarq_mission::kinds::layers::problem::{Agent, Body, Object, Problem, Skill, Task, Weights};
use hierarq_mission::numbers::{Energy, Range};

/// A small random number generator, so that the problems are the same on all platforms.
pub struct Random(pub u64);

impl Random {
    /// Returns a number between 0 and 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as f64) / ((1_u64 << 31) as f64)
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns an integer less than `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }
}

pub fn words(words: &[&str]) -> BTreeSet<String> {
    words.iter().map(|word| (*word).to_string()).collect()
}

pub fn skill(action: &str, duration: f64, pace: f64) -> Skill {
    Skill { action: action.into(), duration, pace }
}

pub fn robot(name: &str, place: [f64; 3]) -> Agent {
    Agent {
        name: name.into(),
        place,
        body: Body::Robot {
            speed: Range::new(0.1, 0.25),
            energy: Energy { standby: 4.0, friction: 10.0, drag: 100.0 },
        },
        skills: vec![skill("pick_and_place", 2.0, 1.0)],
        reach: None,
        payload: None,
        cannot: BTreeSet::new(),
        spread: 0.0,
        lost: false,
    }
}

pub fn human(name: &str, place: [f64; 3]) -> Agent {
    Agent {
        body: Body::Human { speed: 0.3, slowing: 3.0 },
        skills: vec![skill("pick_and_place", 2.0, 0.8), skill("open", 3.0, 0.5), skill("close", 3.0, 0.5)],
        ..robot(name, place)
    }
}

/// Two arms and a person at a workbench with 64 blocks in two picking areas, thesis 6.4.1.
pub fn bench(set: u64) -> Problem {
    let mut random = Random(set.wrapping_mul(7919).wrapping_add(17));
    random.unit();
    let mut objects = Vec::new();
    for (side, at) in [("left", -0.55), ("right", 0.55)] {
        for (color, cube) in [("red", 0.12), ("yellow", 0.09), ("blue", 0.06), ("green", 0.03)] {
            for (shape, count, mass) in [("cube", 5, cube), ("parallelepiped", 3, 3.0 * cube)] {
                for number in 1..=count {
                    objects.push(Object {
                        name: format!("{side}_{color}_{shape}_{number}"),
                        place: [at + random.within(-0.2, 0.2), random.within(-0.3, 0.3), 0.0],
                        mass,
                        features: words(&[color, shape]),
                    });
                }
            }
        }
    }
    Problem {
        agents: vec![
            robot("left_arm", [-0.35, -0.5, 0.0]),
            robot("right_arm", [0.35, -0.5, 0.0]),
            human("anna", [0.0, 0.5, 0.0]),
        ],
        objects,
        layers: vec![],
        tasks: vec![],
        weights: Weights { workload: 4.0, energy: 1.0, makespan: 10.0 },
        returns: true,
        start: 0.0,
        begun: vec![],
        places: BTreeMap::new(),
        labels: Default::default(),
    }
}

/// Centre of a cell of the 5-by-5 grid; row 5 is next to the person.
pub fn cell(row: usize, column: usize) -> [f64; 3] {
    [0.1 * (column as f64 - 3.0), 0.1 * (row as f64 - 3.0), 0.0]
}

pub fn add(problem: &mut Problem, layer: &str, name: &str, action: &str, features: &[&str], path: &[[f64; 3]]) {
    if problem.layers.last().is_none_or(|last| last != layer) {
        problem.layers.push(layer.into());
    }
    problem.tasks.push(Task {
        name: name.into(),
        layer: problem.layers.len() - 1,
        action: action.into(),
        features: words(features),
        path: path.to_vec(),
        object: None,
        agent: None,
    });
}

/// A letter, row 5 first: in each row the columns of cubes, and the middle columns of parallelepipeds.
fn letter(set: u64, rows: [(&[usize], &[usize]); 5]) -> Problem {
    let mut problem = bench(set);
    for (number, (cubes, longs)) in rows.into_iter().enumerate() {
        let row = 5 - number;
        let layer = format!("row_{row}");
        for (shape, columns) in [("cube", cubes), ("parallelepiped", longs)] {
            for &column in columns {
                let name = format!("{shape}_{row}_{column}");
                add(&mut problem, &layer, &name, "pick_and_place", &[shape], &[cell(row, column)]);
            }
        }
    }
    problem
}

/// Eleven tasks in five layers, as in thesis Fig. 6.7.
pub fn letter_h(set: u64) -> Problem {
    let sides: (&[usize], &[usize]) = (&[1, 5], &[]);
    letter(set, [sides, sides, (&[1, 5], &[3]), sides, sides])
}

pub fn letter_d(set: u64) -> Problem {
    let sides: (&[usize], &[usize]) = (&[1, 5], &[]);
    letter(set, [(&[1], &[3]), sides, sides, sides, (&[1], &[3])])
}

/// Four boxes: opened, filled with one block of each colour of which one is a parallelepiped, closed.
pub fn sorting(set: u64) -> Problem {
    let mut problem = bench(set);
    let boxes = [("red", -0.15, 0.15), ("yellow", 0.15, 0.15), ("blue", -0.15, -0.15), ("green", 0.15, -0.15)];
    for (own, x, y) in boxes {
        add(&mut problem, "open", &format!("open_{own}"), "open", &[], &[[x, y, 0.0]]);
    }
    for (own, x, y) in boxes {
        for (color, ..) in boxes {
            let features: &[&str] = if color == own { &[color, "parallelepiped"] } else { &[color] };
            add(&mut problem, "fill", &format!("{color}_to_{own}"), "pick_and_place", features, &[[x, y, 0.0]]);
        }
    }
    for (own, x, y) in boxes {
        add(&mut problem, "close", &format!("close_{own}"), "close", &[], &[[x, y, 0.0]]);
    }
    problem
}

/// A random problem: some agents with limits, objects of two colours, tasks in layers, some without an object. Not all
/// of these problems can be planned.
pub fn random(seed: u64, tasks: usize, objects: usize, robots: usize, humans: usize) -> Problem {
    let mut random = Random(seed.wrapping_mul(6151).wrapping_add(29));
    random.unit();
    let mut problem = Problem { objects: vec![], agents: vec![], ..bench(0) };
    let place = |random: &mut Random| [random.within(-1.0, 1.0), random.within(-1.0, 1.0), random.within(0.0, 0.3)];
    for number in 0..robots + humans {
        let at = place(&mut random);
        let mut agent =
            if number < robots { robot(&format!("r{number}"), at) } else { human(&format!("h{number}"), at) };
        if let Body::Robot { speed, energy } = &mut agent.body {
            speed.high = random.within(0.1, 0.4);
            energy.drag = random.within(0.0, 400.0);
            energy.standby = random.within(0.0, 8.0);
        }
        for skill in &mut agent.skills {
            skill.duration = random.within(0.0, 5.0);
        }
        agent.reach = (random.unit() < 0.2).then(|| random.within(1.0, 2.5));
        agent.payload = (random.unit() < 0.2).then(|| random.within(0.1, 0.4));
        if random.unit() < 0.2 {
            agent.cannot = words(&["red"]);
        }
        problem.agents.push(agent);
    }
    for number in 0..objects {
        let color = if random.unit() < 0.5 { "red" } else { "green" };
        let at = place(&mut random);
        let mass = random.within(0.01, 0.4);
        problem.objects.push(Object {
            name: format!("o{number}"),
            place: at,
            mass,
            features: words(&["block", color]),
        });
    }
    let mut layer = 0;
    for number in 0..tasks {
        if number > 0 && random.unit() < 0.4 {
            layer += 1;
        }
        let features: &[&str] = match random.below(4) {
            0 => &["red"],
            1 => &["green", "block"],
            2 => &["block"],
            _ if humans > 0 && random.unit() < 0.5 => &[],
            _ => &["block"],
        };
        let action = if features.is_empty() { "open" } else { "pick_and_place" };
        let path: Vec<[f64; 3]> = (0..random.below(3)).map(|_| place(&mut random)).collect();
        add(&mut problem, &format!("l{layer}"), &format!("t{number}"), action, features, &path);
    }
    let weights = &mut problem.weights;
    (weights.workload, weights.energy, weights.makespan) =
        (random.within(0.0, 5.0), random.within(0.0, 5.0), random.within(0.0, 20.0));
    problem.returns = random.unit() < 0.7;
    problem
}

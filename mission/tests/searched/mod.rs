//! Searches for tests and benches: the light and the panel, random worlds, a floor of 750 m^2 with rooms.
#![allow(dead_code, reason = "each binary uses a part")]

use hierarq_mission::kinds::search::geometry::{Point, distance};
use hierarq_mission::kinds::search::ground::{Body, Ground};
use hierarq_mission::kinds::search::problem::{
    Agent, Boundary, Codependence, Detection, Fall, Hidden, Planner, Problem, Rate, Source, SourceKind, Wall,
};

use hierarq_mission::occupancy::{Cell, OccupancyGrid};

use crate::common::Random;

pub fn agent(name: &str, human: bool, start: Point, speed: f64) -> Agent {
    Agent {
        name: name.into(),
        human,
        start,
        heading: 0.0,
        speed,
        radius: 0.2,
        passes: Vec::new(),
        unaware: Vec::new(),
        sees: None,
        spread: 0.0,
        lost: false,
        told: None,
        habits: None,
    }
}

/// A circular source of a task for all agents of a team of this size.
pub fn source(name: &str, centre: Point, radius: f64, rate: f64, pool: f64, team: usize) -> Source {
    Source {
        name: name.into(),
        kind: SourceKind::Task,
        boundary: Boundary::Circle { centre, radius },
        inside: Rate::constant(rate),
        outside: Rate::ZERO,
        pool: Some(pool),
        targets: (0..team).collect(),
        after: Vec::new(),
        until: Vec::new(),
        of: None,
    }
}

/// A source of the environment that repels.
pub fn hazard(name: &str, centre: Point, radius: f64, rate: f64, targets: Vec<usize>) -> Source {
    Source {
        kind: SourceKind::Environment,
        inside: Rate::constant(-rate),
        outside: Rate { peak: -rate, fall: Fall::Exponential, scale: 0.3, ..Rate::ZERO },
        pool: None,
        targets,
        ..source(name, centre, radius, 0.0, 0.0, 0)
    }
}

pub fn square(side: f64) -> Vec<Point> {
    vec![[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]]
}

pub fn problem(area: Vec<Point>, agents: Vec<Agent>, sources: Vec<Source>, horizon: f64) -> Problem {
    Problem {
        area,
        occupancy: None,
        walls: Vec::new(),
        agents,
        sources,
        codependent: Vec::new(),
        objects: Vec::new(),
        cell: 1.0,
        exposure: Vec::new(),
        horizon,
        start: 0.0,
        reminder: None,
        planner: Planner { states: 4_000, tree_nodes: 200, ..Planner::default() },
        labels: Default::default(),
        sight: Default::default(),
    }
}

/// Hidden objects, anywhere on the ground.
pub fn hidden(name: &str, count: usize, worth: f64) -> Hidden {
    Hidden { name: name.into(), count, found: 0, worth, region: Vec::new(), places: Vec::new() }
}

pub fn wall(name: &str, points: &[Point]) -> Wall {
    Wall { name: name.into(), points: points.to_vec(), solid: false, transparent: false }
}

/// The mission of `examples/tokens.hq`: two agents look for three tokens on 750 m^2 with walls.
pub fn yard() -> Problem {
    let team = vec![agent("tiago", false, [15.0, 1.0], 0.6), agent("anna", true, [14.0, 1.0], 0.9)];
    let area = vec![[0.0, 0.0], [30.0, 0.0], [30.0, 25.0], [0.0, 25.0]];
    let solid = |name: &str, [x, y]: Point, [width, height]: Point| Wall {
        solid: true,
        ..wall(name, &[[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
    };
    let mut p = problem(area, team, Vec::new(), 900.0);
    p.agents.iter_mut().for_each(|who| {
        (who.radius, who.sees) = (0.3, Some(Detection { within: 3.0, rate: 0.14 }));
    });
    p.agents[1].spread = 0.1;
    p.walls = vec![
        solid("hall", [4.0, 5.0], [7.0, 5.0]),
        solid("shed", [21.0, 15.0], [5.0, 5.0]),
        wall("hedge", &[[15.0, 6.0], [15.0, 13.0], [21.0, 13.0]]),
        wall("fence", &[[0.0, 16.0], [8.0, 16.0]]),
        wall("row_1", &[[11.0, 19.0], [11.0, 25.0]]),
        wall("row_2", &[[16.0, 17.0], [16.0, 23.0]]),
        solid("bench", [24.0, 5.0], [3.0, 2.0]),
    ];
    p.objects.push(hidden("token", 3, 10.0));
    p.planner = Planner { window: Some(60.0), states: 4_000, ..Planner::default() };
    p
}

/// The light and the panel of srs Fig. 9: the panel can be read by the robot alone, and only in the light.
pub fn light_and_panel(informed: bool) -> Problem {
    let mut robot = agent("robot", false, [1.0, 1.0], 1.0);
    let mut anna = agent("anna", true, [7.0, 1.0], 1.0);
    (robot.radius, anna.radius) = (0.3, 0.3);
    if !informed {
        anna.unaware.push(0);
    }
    let light = source("light", [7.0, 5.0], 0.5, 5.0, 5.0, 2);
    let panel = Source { targets: vec![0], after: vec![0], ..source("panel", [1.0, 5.0], 0.5, 5.0, 10.0, 2) };
    problem(square(8.0), vec![robot, anna], vec![light, panel], 30.0)
}

/// A random world with walls, sources of all kinds, precedence and codependence.
pub fn random(seed: u64, agents: usize, sources: usize) -> Problem {
    let mut random = Random(seed.wrapping_mul(104_729).wrapping_add(71));
    random.unit();
    let side = random.within(6.0, 12.0);
    let mut p = problem(square(side), Vec::new(), Vec::new(), random.within(10.0, 30.0));
    for i in 0..random.below(4) {
        let a = [random.within(0.0, side), random.within(0.0, side)];
        let b = [random.within(0.0, side), random.within(0.0, side)];
        if distance(a, b) > 0.5 {
            p.walls.push(wall(&format!("w{i}"), &[a, b]));
        }
    }
    let free = Ground::new(&p, &Body { radius: 0.4, passes: Vec::new() });
    let place = |random: &mut Random| loop {
        let at = [random.within(0.0, side), random.within(0.0, side)];
        if free.fits(at) {
            return at;
        }
    };
    for i in 0..agents {
        let start = place(&mut random);
        let mut who = agent(&format!("a{i}"), i % 2 == 1, start, random.within(0.5, 1.5));
        if !p.walls.is_empty() && random.unit() < 0.3 {
            who.passes.push(random.below(p.walls.len()));
        }
        p.agents.push(who);
    }
    for i in 0..sources {
        let at = place(&mut random);
        let mut one = source(
            &format!("s{i}"),
            at,
            random.within(0.3, 0.8),
            random.within(1.0, 6.0),
            random.within(2.0, 9.0),
            agents,
        );
        match random.below(6) {
            0 => one.outside = Rate { peak: random.within(0.1, 1.0), fall: Fall::Gaussian, scale: 0.5, ..Rate::ZERO },
            1 => one.targets = vec![random.below(agents)],
            2 => one.pool = None,
            3 => one.kind = SourceKind::Environment,
            _ => {}
        }
        p.sources.push(one);
    }
    for i in 1..sources {
        let other = random.below(i);
        if p.sources[other].pool.is_some() {
            match random.below(6) {
                0 => p.sources[i].after.push(other),
                1 => p.sources[i].until.push(other),
                2 if p.sources[i].pool.is_some() => {
                    p.codependent.push(Codependence { of: [other, i], share: random.within(0.1, 0.6) });
                }
                _ => {}
            }
        }
    }
    if random.unit() < 0.5 {
        let at = place(&mut random);
        p.sources.push(hazard("smoke", at, 0.5, random.within(0.5, 3.0), (0..agents).collect()));
    }
    if random.unit() < 0.5 {
        let speeds = Boundary::Speed([0.1, 5.0]);
        let effort = hazard("effort", [0.0; 2], 1.0, 0.05, (0..agents).collect());
        p.sources.push(Source { kind: SourceKind::Action, boundary: speeds, outside: Rate::ZERO, ..effort });
    }
    if agents > 1 && random.unit() < 0.4 {
        let beside = Source {
            kind: SourceKind::Interaction,
            pool: None,
            of: Some(0),
            ..source("beside", [0.0, 0.8], 0.6, 0.4, 0.0, agents)
        };
        p.sources.push(beside);
    }
    if random.unit() < 0.4 {
        let low = random.within(-4.0, 4.0);
        let against = hazard("against", [0.0; 2], 1.0, random.within(0.1, 0.6), (0..agents).collect());
        let boundary = Boundary::Heading([low, low + random.within(0.5, 3.0)]);
        p.sources.push(Source { kind: SourceKind::Action, boundary, outside: Rate::ZERO, ..against });
    }
    p
}

/// A floor of 30 m by 25 m with rooms, and sources in them.
pub fn floor(agents: usize, sources: usize) -> Problem {
    let area = vec![[0.0, 0.0], [30.0, 0.0], [30.0, 25.0], [0.0, 25.0]];
    let starts = [[15.0, 1.5], [14.0, 1.5], [16.0, 1.5]];
    let team = (0..agents).map(|i| agent(&format!("a{i}"), i % 2 == 1, starts[i % 3], 1.0)).collect();
    let mut p = problem(area, team, Vec::new(), 120.0);
    // Two rows of rooms with doors of 1.2 m along a corridor.
    for (row, y) in [10.0, 15.0].into_iter().enumerate() {
        for room in 0..5 {
            let x = 6.0 * room as f64;
            p.walls.push(wall(&format!("front_{row}_{room}_left"), &[[x, y], [x + 2.4, y]]));
            p.walls.push(wall(&format!("front_{row}_{room}_right"), &[[x + 3.6, y], [x + 6.0, y]]));
            if room > 0 {
                let ends = if row == 0 { [[x, 3.0], [x, 10.0]] } else { [[x, 15.0], [x, 25.0]] };
                p.walls.push(wall(&format!("side_{row}_{room}"), &ends));
            }
        }
    }
    let mut random = Random(17);
    random.unit();
    for i in 0..sources {
        let (room, upper) = (i % 5, i / 5 % 2 == 1);
        let y = if upper { random.within(17.0, 24.0) } else { random.within(4.0, 9.0) };
        let at = [6.0 * room as f64 + random.within(1.0, 5.0), y];
        p.sources.push(source(&format!("s{i}"), at, 0.6, 4.0, random.within(4.0, 10.0), agents));
    }
    p
}

/// A random map of this many columns and rows with walls, blocks and single cells, somewhere, in some direction.
pub fn grid(seed: u64, columns: usize, rows: usize) -> OccupancyGrid {
    let mut random = Random(seed.wrapping_mul(15_485_863).wrapping_add(29));
    random.unit();
    let mut cells = vec![Cell::Free; columns * rows];
    for _ in 0..random.below(12) {
        let (x, y) = (random.below(columns), random.below(rows));
        let (w, h) = match random.below(3) {
            0 => (1, 1 + random.below(rows)),
            1 => (1 + random.below(columns), 1),
            _ => (1 + random.below(3), 1 + random.below(3)),
        };
        let cell = if random.below(3) == 0 { Cell::Unknown } else { Cell::Occupied };
        for row in y..(y + h).min(rows) {
            // Walls have doors.
            let door = random.below(4);
            (x..(x + w).min(columns)).filter(|column| column % 4 != door).for_each(|x| cells[row * columns + x] = cell);
        }
    }
    let origin = [random.within(-20.0, 20.0), random.within(-20.0, 20.0)];
    let yaw = if random.unit() < 0.5 { 0.0 } else { random.within(-3.0, 3.0) };
    OccupancyGrid::new("random.pgm".into(), [columns, rows], random.within(0.1, 0.6), origin, yaw, cells)
        .expect("a map")
}

/// Two agents and four sources on free cells of a map.
pub fn on_grid(map: OccupancyGrid, seed: u64) -> Problem {
    let mut random = Random(seed + 1);
    random.unit();
    let mut place = || {
        for _ in 0..1_000 {
            let at = [random.within(0.0, map.columns as f64), random.within(0.0, map.rows as f64)];
            if map.clear(map.to_ground(at), map.to_ground(at), 0.45 * map.resolution) {
                return map.to_ground(at);
            }
        }
        map.to_ground([0.5, 0.5])
    };
    let mut team = vec![agent("a0", false, place(), 1.0), agent("a1", true, place(), 0.8)];
    team.iter_mut().for_each(|agent| agent.radius = 0.4 * map.resolution);
    let sources = (0..4).map(|i| source(&format!("s{i}"), place(), map.resolution, 4.0, 5.0, 2)).collect();
    let mut p = problem(map.corners().to_vec(), team, sources, 60.0);
    p.planner.states = 1_000;
    p.occupancy = Some(map);
    p
}

/// The floor with its walls as cells of 0.1 m: 300 by 250 of them.
pub fn mapped_floor(agents: usize, sources: usize) -> Problem {
    let mut p = floor(agents, sources);
    let (columns, rows) = (300, 250);
    let free = |index: usize| {
        let at = [(index % columns) as f64 * 0.1 + 0.05, (index / columns) as f64 * 0.1 + 0.05];
        let near = |wall: &Wall| {
            hierarq_mission::kinds::search::geometry::to_segment(at, wall.points[0], wall.points[1]) < 0.06
        };
        let edge = index.is_multiple_of(columns)
            || index % columns == columns - 1
            || index < columns
            || index / columns == rows - 1;
        if edge || p.walls.iter().any(near) { Cell::Occupied } else { Cell::Free }
    };
    let cells = (0..columns * rows).map(free).collect();
    p.occupancy = OccupancyGrid::new("floor.pgm".into(), [columns, rows], 0.1, [0.0; 2], 0.0, cells);
    p.walls.clear();
    p
}

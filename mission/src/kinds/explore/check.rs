//! Mistakes of a problem that no plan can mend, each with its code and place.

use blocks::{Help, Snippet};

use super::grid::Grid;
use super::polygon::{Convex, Point, minus};
use super::problem::{MAX_OBSTACLES, MAX_ROBOTS, MAX_SIDE, MAX_TARGETS, Problem};
use super::program::free;
use crate::declare::{Origins, Remark};
use crate::numbers::MAX_NUMBER;

/// Code of members that the mission lacks.
const LACKING: &str = "HQ0901";
/// Code of more members or larger numbers than a mission may have.
const LARGE: &str = "HQ0904";
/// Code of polygons that are not convex, or too small.
pub(super) const SHAPE: &str = "HQ0970";
/// Code of places in obstacles or outside of the region.
const BLOCKED: &str = "HQ0971";
/// Code of places that nobody reaches.
const UNREACHED: &str = "HQ0972";
/// Code of a team that is not connected.
const UNCONNECTED: &str = "HQ0973";
/// Code of a horizon that is too short.
const SHORT: &str = "HQ0974";
/// Code of a start at which members touch.
const TOUCH: &str = "HQ0976";

/// A part of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Item {
    /// The whole mission.
    Mission,
    /// A robot, by index.
    Robot(usize),
    /// The person.
    Person,
    /// A target, by index.
    Target(usize),
    /// An obstacle, by index.
    Obstacle(usize),
}

/// A mistake.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// Code of its diagnostic.
    pub code: &'static str,
    /// False for a warning.
    pub is_error: bool,
    /// The part.
    pub item: Item,
    /// Keys of the part that it may be written in, the most specific first.
    pub keys: &'static [&'static str],
    /// Another part that it is in conflict with, and words for that.
    pub against: Option<(Item, &'static str)>,
    /// The mistake, in a sentence.
    pub text: String,
    /// Reason.
    pub note: Option<String>,
    /// A way out.
    pub help: Help,
}

impl Mistake {
    fn new(
        code: &'static str,
        item: Item,
        keys: &'static [&'static str],
        text: String,
        help: impl Into<Help>,
    ) -> Mistake {
        Mistake { code, is_error: true, item, keys, against: None, text, note: None, help: help.into() }
    }

    fn note(self, note: impl Into<String>) -> Mistake {
        Mistake { note: Some(note.into()), ..self }
    }

    /// True if members are missing.
    pub(super) fn is_lacking(&self) -> bool {
        self.code == LACKING
    }

    fn against(self, item: Item, words: &'static str) -> Mistake {
        Mistake { against: Some((item, words)), ..self }
    }

    /// The mistake as a remark at its place.
    pub(super) fn remark(self, places: &Origins<Item>) -> Remark {
        let at = places.of(self.item, self.keys);
        let remark = match (self.code, self.is_error) {
            (LACKING, _) => Remark::lacking(self.code, at, self.text),
            (_, true) => Remark::error(self.code, at, self.text),
            (_, false) => Remark::warning(self.code, at, self.text),
        };
        let remark = self.note.into_iter().fold(remark.help(self.help), Remark::note);
        match self.against {
            Some((item, words)) => remark.label(places.of(item, &[]), words),
            None => remark,
        }
    }
}

/// Returns the mistakes of a problem; those of places are looked for if its numbers are sound.
pub fn check(problem: &Problem) -> Vec<Mistake> {
    let mut found = Vec::new();
    sizes(problem, &mut found);
    if found.is_empty() {
        places(problem, &mut found);
    }
    if found.is_empty() {
        starts(problem, &mut found);
    }
    if found.iter().all(|mistake| !mistake.is_error) {
        reach(problem, &mut found);
    }
    found
}

/// A missing robot, person or target.
pub(super) fn missing(what: &str, help: Help) -> Mistake {
    Mistake::new(LACKING, Item::Mission, &[], what.into(), help)
}

fn sizes(p: &Problem, found: &mut Vec<Mistake>) {
    if p.robots.is_empty() {
        let robot = Snippet::declared("robot", "NAME", [Snippet::entry("start", "[0.5, 0.5] m")]);
        found.push(missing("this exploration has no robot", Help::with("declare one: {}", [robot])));
    }
    if p.targets.is_empty() {
        let target = Snippet::declared("target", "NAME", [Snippet::entry("at", "[2.5, 4.5] m")]);
        found.push(missing("this exploration has no target", Help::with("declare one: {}", [target])));
    }
    let counts = [
        (p.robots.len(), MAX_ROBOTS, "robots"),
        (p.targets.len(), MAX_TARGETS, "targets"),
        (p.obstacles.len(), MAX_OBSTACLES, "obstacles"),
    ];
    for (count, most, what) in counts.into_iter().filter(|(count, most, _)| count > most) {
        let text = format!("{count} {what} are more than the {most} that an exploration may have");
        found.push(Mistake::new(LARGE, Item::Mission, &[], text, "split the mission into several"));
    }
    let mut large = |item: Item, keys: &'static [&'static str], numbers: &[f64]| {
        if numbers.iter().any(|x| !(x.is_finite() && x.abs() <= MAX_NUMBER)) {
            let text = "this number is larger than 1e6".to_string();
            found.push(Mistake::new(LARGE, item, keys, text, "check the unit after the number"));
        }
    };
    let of = |shape: &Convex| -> Vec<f64> { shape.corners().iter().flatten().copied().collect() };
    large(Item::Mission, &["area"], &of(&p.area));
    large(Item::Mission, &["exit"], &of(&p.exit));
    large(Item::Mission, &["range"], &of(&p.connection));
    large(Item::Mission, &["effort"], &[p.effort]);
    for (i, robot) in p.robots.iter().enumerate() {
        large(Item::Robot(i), &["start"], &robot.start);
        large(Item::Robot(i), &["size"], &of(&robot.body));
        large(Item::Robot(i), &["speed"], &[robot.speed]);
        large(Item::Robot(i), &["acceleration"], &[robot.acceleration]);
    }
    large(Item::Person, &["start"], &p.person.start);
    large(Item::Person, &["size"], &of(&p.person.body));
    large(Item::Person, &["speed"], &[p.person.speed]);
    for (i, target) in p.targets.iter().enumerate() {
        large(Item::Target(i), &["at"], &of(&target.shape));
        large(Item::Target(i), &["worth"], &[target.worth]);
    }
    for (i, obstacle) in p.obstacles.iter().enumerate() {
        large(Item::Obstacle(i), &["polygon"], &of(&obstacle.shape));
    }
}

/// The obstacle that a shape overlaps, or that it leaves the region.
fn conflict(p: &Problem, shape: &Convex) -> Option<(String, Option<usize>)> {
    if shape.corners().iter().any(|corner| !p.area.contains(*corner, 1e-9)) {
        return Some(("outside the area".into(), None));
    }
    let hit = p.obstacles.iter().position(|of| of.shape.gap(shape) < -1e-9)?;
    Some((format!("in the obstacle `{}`", p.obstacles[hit].name), Some(hit)))
}

fn places(p: &Problem, found: &mut Vec<Mistake>) {
    let mut blocked = |item: Item, keys: &'static [&'static str], who: &str, place: (String, Option<usize>), help| {
        let mistake = Mistake::new(BLOCKED, item, keys, format!("{who} is {}", place.0), help);
        found.push(match place.1 {
            Some(obstacle) => mistake.against(Item::Obstacle(obstacle), "the obstacle"),
            None => mistake,
        });
    };
    for (i, target) in p.targets.iter().enumerate() {
        // A robot that is in the target has its middle there; the rest of it may be outside.
        let taken = conflict(p, &target.shape);
        if let Some(place) = taken {
            let who = format!("a part of the target `{}`", target.name);
            blocked(Item::Target(i), &["at", "size"], &who, place, "move the target, or write a smaller `size`");
        }
    }
    if let Some(place) = conflict(p, &p.exit) {
        blocked(Item::Mission, &["exit"], "a part of the exit", place, "write a polygon on free ground");
    }
    for (i, robot) in p.robots.iter().enumerate() {
        if let Some(place) = conflict(p, &robot.body.moved(robot.start)) {
            let who = format!("a part of the body of `{}`", robot.name);
            blocked(Item::Robot(i), &["start"], &who, place, "write a free position, or a smaller `size`");
        }
    }
    let Some(grid) = Grid::new(p) else {
        let text = format!("the grid has more than {MAX_SIDE} cells along a side, or none");
        let help = Help::write_for_instance(Snippet::entry("cell", "1 m"));
        found.push(Mistake::new(LARGE, Item::Person, &["cell"], text, help));
        return;
    };
    let who = &p.person.name;
    match grid.at(p.person.start) {
        None => {
            let text = format!("`{who}` starts outside the grid");
            let note = "the grid has the whole cells that fit into the area, from its lower left corner on";
            let help = "write a position in the area, or a smaller `cell`";
            found.push(Mistake::new(BLOCKED, Item::Person, &["start"], text, help).note(note));
        }
        Some(cell) if grid.blocked[cell] => {
            let text = format!("`{who}` starts in a cell of the grid that is blocked");
            let note = "a cell is blocked if a part of it is in an obstacle or outside the area";
            let help = "write a free position, or a smaller `cell`";
            found.push(Mistake::new(BLOCKED, Item::Person, &["start"], text, help).note(note));
        }
        Some(cell) => people(p, &grid, cell, found),
    }
}

/// Ways of the person.
fn people(p: &Problem, grid: &Grid, start: usize, found: &mut Vec<Mistake>) {
    let who = &p.person.name;
    if grid.exits().next().is_none() {
        let text = "no free cell of the grid has its middle in the exit".to_string();
        let help = "write a larger exit, or a smaller `cell`";
        found.push(Mistake::new(UNREACHED, Item::Mission, &["exit"], text, help));
        return;
    }
    let to_exit = grid.steps_to(grid.exits());
    let Some(steps) = to_exit[start] else {
        let text = format!("`{who}` cannot reach the exit");
        let note = "people walk between cells that share a side and are not blocked";
        let help = "open a way between the obstacles, or write a smaller `cell`";
        found.push(Mistake::new(UNREACHED, Item::Mission, &["exit"], text, help).note(note));
        return;
    };
    let periods = (steps as f64 * p.person.cell / p.person.speed / p.period).ceil() as usize;
    if steps == 0 {
        let text = format!("`{who}` starts in the exit: the mission is over before it begins");
        let help = "write another `start`, or another `exit`";
        found.push(Mistake::new(BLOCKED, Item::Person, &["start"], text, help));
    } else if periods > p.periods {
        let text = format!("a plan looks ahead for {} periods, and the exit is at least {periods} away", p.periods);
        let help = Help::with("write at least {}", [Snippet::entry("horizon", (2 * periods).to_string())]);
        let note = format!("`{who}` walks {steps} cells of {} m at {} m/s", p.person.cell, p.person.speed);
        found.push(Mistake::new(SHORT, Item::Mission, &["horizon"], text, help).note(note));
    }
}

/// Members that touch, and a team that is not connected.
fn starts(p: &Problem, found: &mut Vec<Mistake>) {
    let grid = Grid::new(p);
    let person = grid.as_ref().and_then(|grid| Some(grid.middle(grid.at(p.person.start)?))).unwrap_or(p.person.start);
    for (i, robot) in p.robots.iter().enumerate() {
        let body = robot.body.moved(robot.start);
        if body.gap(&p.person.body.moved(person)) <= 0.0 {
            let text = format!("`{}` and `{}` touch at the start", robot.name, p.person.name);
            let mistake = Mistake::new(TOUCH, Item::Robot(i), &["start"], text, "move one of the two");
            found.push(mistake.against(Item::Person, "the person, in the middle of a cell"));
        }
        for (j, other) in p.robots.iter().enumerate().take(i) {
            if body.gap(&other.body.moved(other.start)) <= 0.0 {
                let text = format!("`{}` and `{}` touch at the start", other.name, robot.name);
                let mistake = Mistake::new(TOUCH, Item::Robot(i), &["start"], text, "move one of the two");
                found.push(mistake.against(Item::Robot(j), "the other robot"));
            }
        }
    }
    if !found.is_empty() {
        return;
    }
    // (13): the range that is left where the person may walk anywhere in a period.
    let strides = p.strides(p.period);
    let stride = Convex::hull(&strides).and_then(|stride| p.connection.difference(&stride));
    let Some(shrunk) = stride else {
        let text = format!(
            "`{}` can walk out of every range in one period, {:.2} m",
            p.person.name,
            p.person.speed * p.period
        );
        let help = "write a larger `range`, or a shorter `period`";
        found.push(Mistake::new(UNCONNECTED, Item::Mission, &["range"], text, help));
        return;
    };
    let near = |robot: &super::problem::Robot| shrunk.contains(minus(robot.start, person), 0.0);
    if !p.robots.iter().any(near) {
        let text = format!("no robot is connected to `{}` at the start", p.person.name);
        let note = format!(
            "the range is shortened by the {:.2} m that the person can walk in one period (armchair (13))",
            p.person.speed * p.period
        );
        let help = "start a robot nearer to the person, or write a larger `range`";
        found.push(Mistake::new(UNCONNECTED, Item::Person, &["start"], text, help).note(note));
    }
    let links = |i: usize| {
        let own = p.robots[i].start;
        p.robots
            .iter()
            .enumerate()
            .filter(|(j, other)| *j != i && p.connection.contains(minus(other.start, own), 0.0))
            .count()
    };
    let degrees: Vec<usize> = (0..p.robots.len()).map(links).collect();
    for i in 0..p.robots.len() {
        for j in 0..i {
            if degrees[i] + degrees[j] < p.robots.len() {
                let text =
                    format!("`{}` and `{}` have too few connections at the start", p.robots[j].name, p.robots[i].name);
                let note = format!(
                    "both have {} together, and the condition for a connected team is {} (armchair (10m))",
                    degrees[i] + degrees[j],
                    p.robots.len()
                );
                let help = "start the robots nearer to each other, or write a larger `range`";
                found.push(
                    Mistake::new(UNCONNECTED, Item::Robot(i), &["start"], text, help)
                        .against(Item::Robot(j), "the other robot")
                        .note(note),
                );
                return;
            }
        }
    }
}

/// Targets that no robot can take: warnings, since the person may.
fn reach(p: &Problem, found: &mut Vec<Mistake>) {
    let Some(grid) = Grid::new(p) else { return };
    let from = grid.at(p.person.start).map(|start| grid.steps_to([start].into_iter())).unwrap_or_default();
    for (i, target) in p.targets.iter().enumerate() {
        let robots = (0..p.robots.len()).any(|robot| {
            let parts = free(p, robot);
            connected(&parts, p.robots[robot].start, &target.shape)
        });
        let cell = grid.at(target.shape.middle());
        let person = cell.is_some_and(|cell| from.get(cell).copied().flatten().is_some());
        if robots && person {
            continue;
        }
        let who = match (robots, person) {
            (false, false) => "nobody".to_string(),
            (false, true) => "no robot".to_string(),
            _ => format!("`{}`", p.person.name),
        };
        let verb = if robots { "cannot reach" } else { "can reach" };
        let text = format!("{who} {verb} the target `{}`", target.name);
        let help = "move it, or open a way between the obstacles";
        let mistake = Mistake::new(UNREACHED, Item::Target(i), &["at"], text, help);
        let note = "people walk over whole free cells, and robots need room for their bodies";
        found.push(Mistake { is_error: !robots && !person, ..mistake.note(note) });
    }
}

/// True if a chain of overlapping parts leads from a point to a shape.
fn connected(parts: &[Convex], from: Point, to: &Convex) -> bool {
    let mut reached: Vec<bool> = parts.iter().map(|part| part.contains(from, 1e-9)).collect();
    loop {
        let next = (0..parts.len())
            .find(|i| !reached[*i] && (0..parts.len()).any(|j| reached[j] && parts[*i].gap(&parts[j]) < -1e-9));
        match next {
            Some(i) => reached[i] = true,
            None => break,
        }
    }
    parts.iter().zip(&reached).any(|(part, reached)| *reached && part.gap(to) < -1e-9)
}

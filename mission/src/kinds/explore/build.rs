//! An exploration from its declaration.

use blocks::{BinaryFile, Block, Help, Located, Snippet};
use learning::policy::Policy;

use super::blocks::{
    ENGINES, ExploreBlock, HumanBlock, MODELS, ModelBlock, ObstacleBlock, POLICY_CODE, RobotBlock, TYPES, TargetBlock,
};
use super::check::{Item, SHAPE, check, missing};
use super::grid::Grid;
use super::mind::Mind;
use super::mission::{Explore, members};
use super::motion::Dynamics;
use super::polygon::{Convex, Point, is_convex};
use super::problem::{
    EngineChoice, Escape, Fallback, MAX_CORNERS, Model, Obstacle, Person, Planner, PolicyFile, Problem, Robot, Target,
};
use crate::declare::{DeclaredMember, DeclaredMission, Origins, Remark, Remarks, labels, mistaken};

/// Code of a time constant that is missing, or of no use.
const CONSTANT: &str = "HQ0977";

/// Builds the mission.
pub(super) fn build(declared: &DeclaredMission, remarks: &mut Remarks) -> Explore {
    let mut places = Origins::new(declared, Item::Mission);
    let settings = ExploreBlock::read(&declared.settings);
    let mut shapes = Shapes { places: &mut places, remarks };
    let area = shapes.polygon(Item::Mission, "area", &settings.area, "the area");
    let exit = shapes.polygon(Item::Mission, "exit", &settings.exit, "the exit");
    let mut problem = Problem {
        area,
        obstacles: Vec::new(),
        types: TYPES.map(String::from).to_vec(),
        targets: Vec::new(),
        exit,
        connection: Convex::regular(8, settings.range).unwrap_or_else(unit),
        robots: Vec::new(),
        person: nobody(),
        period: settings.period,
        periods: settings.horizon,
        effort: settings.effort,
        planner: Planner {
            gap: settings.gap,
            time: settings.plan_time.unwrap_or(0.9 * settings.period),
            nodes: settings.nodes as u64,
            engine: [EngineChoice::BuiltIn, EngineChoice::Highs, EngineChoice::Auto]
                [ENGINES.iter().position(|word| *word == settings.engine).unwrap_or(0)],
            escape: Escape::ALL[Escape::NAMES.iter().position(|word| *word == settings.escape).unwrap_or(0)],
            fallback: if settings.fallback == Fallback::NAMES[0] { Fallback::Stop } else { Fallback::Barrier },
        },
        labels: Default::default(),
    };
    for member in declared.of("obstacle") {
        let item = Item::Obstacle(problem.obstacles.len());
        shapes.places.add(item, &member.settings);
        let corners = ObstacleBlock::read(&member.settings).polygon;
        let shape = shapes.polygon(item, "polygon", &corners, &format!("the obstacle `{}`", member.name));
        problem.obstacles.push(Obstacle { name: member.name.clone(), shape });
    }
    for member in declared.of("target") {
        let item = Item::Target(problem.targets.len());
        shapes.places.add(item, &member.settings);
        let block = TargetBlock::read(&member.settings);
        let shape = shapes.rectangle(item, block.size, &member.name).moved(block.at);
        let of = TYPES.iter().position(|word| *word == block.kind).unwrap_or(0);
        problem.targets.push(Target { name: member.name.clone(), shape, of, worth: block.worth });
    }
    for member in declared.of("robot") {
        let item = Item::Robot(problem.robots.len());
        shapes.places.add(item, &member.settings);
        let robot = robot(member, item, &mut shapes);
        problem.robots.push(robot);
    }
    let mut people = declared.of("human");
    let mut missed = None;
    match people.next() {
        Some(member) => {
            shapes.places.add(Item::Person, &member.settings);
            problem.person = person(member, &mut shapes);
        }
        None => {
            let human = Snippet::declared("human", "NAME", [Snippet::entry("start", "[3.5, 0.5] m")]);
            let help = Help::with("declare the person: {}", [human]);
            missed = Some(missing("this exploration has no human", help));
        }
    }
    if let Some(second) = people.next() {
        let remark = Remark::error("HQ0904", second.at, "an exploration has one human");
        let first = shapes.places.of(Item::Person, &[]);
        shapes.remarks.push(remark.label(first, "the first one").help("remove one of the two"));
    }
    problem.labels = labels(declared, [], remarks);
    mistaken(declared, members(&problem).iter().map(|member| member.name), &problem.labels, remarks);
    let lacks = missed.is_some();
    if let Some(mistake) = missed {
        remarks.push(mistake.remark(&places));
    }
    if !places.any_wrong() {
        // Without a person there is nothing that could be reached or met.
        for mistake in check(&problem).into_iter().filter(|mistake| !lacks || mistake.is_lacking()) {
            remarks.push(mistake.remark(&places));
        }
    }
    if !lacks && !remarks.has_error() && !places.any_wrong() {
        models(&problem, declared, &places, remarks);
    }
    Explore { problem }
}

fn unit() -> Convex {
    Convex::rectangle([1.0, 1.0]).unwrap_or_else(unit)
}

/// The person of a mission that declares none.
fn nobody() -> Person {
    let model = Model::GoalDirected { values: Vec::new() };
    let HumanBlock { start, speed, cell, .. } = HumanBlock::empty();
    Person { name: String::new(), start, body: unit(), speed, cell, walks: model.clone(), predicted: model }
}

/// Reads shapes, and reports those that cannot be used.
struct Shapes<'a, 'm> {
    places: &'a mut Origins<'m, Item>,
    remarks: &'a mut Remarks,
}

impl Shapes<'_, '_> {
    fn polygon(&mut self, item: Item, key: &'static str, corners: &[Point], who: &str) -> Convex {
        if self.places.is_wrong(item, &[key]) || self.places.written(item, &[key]).is_none() {
            return unit();
        }
        let hull = Convex::hull(corners);
        let why = match &hull {
            _ if corners.len() > MAX_CORNERS => Some("has more than 16 corners"),
            _ if corners.len() < 3 => Some("has fewer than three corners"),
            None => Some("encloses nothing"),
            Some(_) if !is_convex(corners) => Some("is not convex"),
            Some(_) => None,
        };
        if let Some(why) = why {
            let remark = Remark::error(SHAPE, self.places.of(item, &[key]), format!("{who} {why}"));
            let help = "write the corners of a convex polygon in order, from neighbour to neighbour; cut another shape into convex parts";
            let remark = if why == "is not convex" {
                remark.note("half-planes describe a convex polygon: a corner points inwards, or two sides cross")
            } else {
                remark
            };
            self.remarks.push(remark.help(help));
            self.places.mark_wrong(item, key);
        }
        hull.unwrap_or_else(unit)
    }

    fn rectangle(&mut self, item: Item, size: Point, name: &str) -> Convex {
        let shape = Convex::rectangle(size).filter(|_| size.iter().all(|x| *x > 0.0));
        if shape.is_none() && !self.places.is_wrong(item, &["size"]) {
            let at = self.places.of(item, &["size"]);
            let remark = Remark::error(SHAPE, at, format!("the rectangle of `{name}` encloses nothing"));
            let help =
                Help::with("write a width and a height above zero, {}", [Snippet::entry("size", "[0.5, 0.5] m")]);
            self.remarks.push(remark.help(help));
            self.places.mark_wrong(item, "size");
        }
        shape.unwrap_or_else(unit)
    }
}

fn robot(member: &DeclaredMember, item: Item, shapes: &mut Shapes) -> Robot {
    let block = RobotBlock::read(&member.settings);
    let body = shapes.rectangle(item, block.size, &member.name);
    let lag = member.settings.key_origin("lag");
    let dynamics = match (block.dynamics, block.lag) {
        (word, Some(constant)) if word == Dynamics::NAMES[2] => Dynamics::Lag(constant),
        (word, None) if word == Dynamics::NAMES[2] => {
            let at = shapes.places.of(item, &["dynamics"]);
            if lag.is_none() {
                let remark =
                    Remark::error(CONSTANT, at, format!("`{}` has a lag without a time constant", member.name));
                shapes.remarks.push(remark.help(Help::write_for_instance(Snippet::entry("lag", "0.3 s"))));
                shapes.places.mark_wrong(item, "lag");
            }
            Dynamics::Lag(0.3)
        }
        (word, _) => {
            if let Some(at) = lag {
                let remark = Remark::error(CONSTANT, at, format!("`{}` has a time constant, and no lag", member.name));
                let help = Help::with("write {}, or remove `lag`", [Snippet::entry("dynamics", "lag")]);
                shapes.remarks.push(remark.help(help));
                shapes.places.mark_wrong(item, "lag");
            }
            if word == Dynamics::NAMES[0] { Dynamics::Velocity } else { Dynamics::Acceleration }
        }
    };
    Robot {
        name: member.name.clone(),
        start: block.start,
        body,
        dynamics,
        speed: block.speed,
        acceleration: block.acceleration,
    }
}

fn person(member: &DeclaredMember, shapes: &mut Shapes) -> Person {
    let block = HumanBlock::read(&member.settings);
    let body = shapes.rectangle(Item::Person, block.size, &member.name);
    let mut read = |key: &'static str, of: Option<ModelBlock>| model(member, key, of, shapes);
    Person {
        name: member.name.clone(),
        start: block.start,
        body,
        speed: block.speed,
        cell: block.cell,
        walks: read("walks", block.walks),
        predicted: read("predicted", block.predicted),
    }
}

/// A model of the person, and what is written of it beside what it needs.
fn model(member: &DeclaredMember, key: &'static str, of: Option<ModelBlock>, shapes: &mut Shapes) -> Model {
    let Some(block) = of else { return Model::GoalDirected { values: Vec::new() } };
    let at = member.settings.key_origin(key).unwrap_or(member.at);
    let is_policy = block.model == MODELS[0];
    let mut wrong = |remark: Remark| {
        shapes.remarks.push(remark);
        shapes.places.mark_wrong(Item::Person, key);
    };
    match (is_policy, &block.file) {
        (true, None) if !member.settings.is_wrong(key) => {
            let remark = Remark::error(POLICY_CODE, at, "this model is a policy, and names no file");
            let other = [Snippet::entry("file", "\"person.safetensors\""), Snippet::entry("model", "goal_directed")];
            wrong(remark.help(Help::with("name the file that `hierarq learn` has written, {}, or write {}", other)));
        }
        (false, Some(file)) => {
            let remark = Remark::error(POLICY_CODE, file.at, "a file of a policy, and the model is none");
            wrong(remark.help(Help::with("write {}, or remove `file`", [Snippet::entry("model", "policy")])));
        }
        _ => {}
    }
    if !block.values.is_empty() && block.model != MODELS[1] {
        let remark = Remark::error(POLICY_CODE, at, "values of targets, and the model is not `goal_directed`");
        wrong(remark.help(Help::with("write {}, or remove `values`", [Snippet::entry("model", "goal_directed")])));
    }
    match (block.model, block.file) {
        (word, _) if word == MODELS[1] => Model::GoalDirected { values: block.values },
        (word, _) if word == MODELS[2] => Model::ConstantVelocity,
        (_, Some(Located { value: BinaryFile { path, bytes: Some(bytes), .. }, .. })) => {
            Model::Policy(PolicyFile { path, bytes: bytes.to_vec() })
        }
        // A simple model stands for a policy that is about to be trained.
        _ => Model::GoalDirected { values: Vec::new() },
    }
}

/// Policies that cannot be used.
fn models(problem: &Problem, declared: &DeclaredMission, places: &Origins<Item>, remarks: &mut Remarks) {
    let Some(grid) = Grid::new(problem) else { return };
    let person = &problem.person;
    let block = declared.of("human").next().map(|member| HumanBlock::read(&member.settings));
    let files = block.map_or([None, None], |block| [block.walks, block.predicted].map(|of| of.and_then(|of| of.file)));
    for ((key, model), file) in [("walks", &person.walks), ("predicted", &person.predicted)].into_iter().zip(files) {
        let Err(why) = Mind::new(problem, &grid, model) else { continue };
        let note = format!("the grid has {} x {} cells of {} m", grid.columns, grid.rows, grid.cell);
        remarks.push(match file {
            Some(Located { at, value: file }) => {
                let remark = Remark::error(POLICY_CODE, at, format!("`{}` cannot be used: {why}", file.path));
                // `hierarq learn` replaces policies alone.
                let is_policy = file.bytes.as_ref().is_some_and(|bytes| Policy::from_bytes(bytes).is_ok());
                let moved = if is_policy { "" } else { "move this one away and " };
                let help = format!("name another file, or {moved}train a policy for this grid: `{}`", file.command);
                remark.note(note).help(help)
            }
            None => {
                let at = places.of(Item::Person, &[key]);
                let remark = Remark::error(POLICY_CODE, at, format!("this model cannot be used: {why}"));
                remark.note(note).help("change the grid, or write another `model`")
            }
        });
    }
}

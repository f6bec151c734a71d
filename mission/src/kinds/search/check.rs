//! Mistakes of a problem that no plan can mend, each with its code and place.

use blocks::{Help, Snippet};

use super::geometry::{Point, area, crosses_itself, length};
use super::ground::{Body, Ground};
use super::map_file;
use super::problem::{
    Boundary, Fall, MAX_AGENTS, MAX_CORNERS, MAX_SOURCES, MAX_WALLS, Problem, Rate, RateFunction, Source, SourceKind,
};
use super::ways::goals;
use crate::declare::{Origins, Remark};
use crate::numbers::{MAX_NUMBER, MIN_SPEED};

/// Code of members that the mission lacks.
const LACKING: &str = "HQ0901";

/// A part of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Item {
    /// The whole mission.
    Mission,
    /// A wall, by index.
    Wall(usize),
    /// An agent, by index.
    Agent(usize),
    /// A source, by index.
    Source(usize),
    /// A group of hidden objects, by index.
    Object(usize),
}

/// A mistake.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// Code of its diagnostic.
    pub code: &'static str,
    /// The part.
    pub item: Item,
    /// Keys of the part that it may be written in, the most specific first.
    pub keys: &'static [&'static str],
    /// Another part that it is in conflict with, and words for that.
    pub against: Option<(Item, &'static [&'static str], &'static str)>,
    /// The mistake, in a sentence.
    pub text: String,
    /// Reason.
    pub note: Option<&'static str>,
    /// Place in the image of the map, with its state.
    pub pixel: Option<String>,
    /// A way out.
    pub help: Help,
}

impl Mistake {
    pub(super) fn new(
        code: &'static str,
        item: Item,
        keys: &'static [&'static str],
        text: String,
        help: impl Into<Help>,
    ) -> Mistake {
        Mistake { code, item, keys, against: None, text, note: None, pixel: None, help: help.into() }
    }

    /// The mistake as an error at its place.
    pub(super) fn remark(self, places: &Origins<Item>) -> Remark {
        let at = places.of(self.item, self.keys);
        let remark = match self.code {
            LACKING => Remark::lacking(self.code, at, self.text),
            _ => Remark::error(self.code, at, self.text),
        };
        let remark = remark.help(self.help);
        let remark = self.note.into_iter().fold(remark, Remark::note);
        let remark = self.pixel.into_iter().fold(remark, Remark::note);
        match self.against {
            Some((item, keys, words)) => remark.label(places.of(item, keys), words),
            None => remark,
        }
    }
}

/// Returns the mistakes of a problem. Those that depend on a sound map and sound sources are looked for if there are no
/// others.
pub fn check(problem: &Problem) -> Vec<Mistake> {
    let mut found = Vec::new();
    sizes(problem, &mut found);
    if found.is_empty() {
        shapes(problem, &mut found);
        rates(problem, &mut found);
        precedence(problem, &mut found);
    }
    if found.is_empty() {
        super::check_objects::objects(problem, &mut found);
        super::check_people::people(problem, &mut found);
        reach(problem, &mut found);
    }
    found
}

fn sizes(p: &Problem, found: &mut Vec<Mistake>) {
    let missing = |what: &str, help: Help| Mistake::new(LACKING, Item::Mission, &[], what.into(), help);
    if p.agents.is_empty() {
        let agent = [Snippet::entry("start", "[0, 0] m"), Snippet::entry("speed", "1 m/s")];
        let help = Help::with("declare one: {}", [Snippet::declared("robot", "NAME", agent)]);
        found.push(missing("this search has no agent", help));
    }
    if p.sources.is_empty() && p.objects.is_empty() {
        let source = [
            Snippet::entry("at", "[4, 2] m"),
            Snippet::entry("radius", "0.5 m"),
            Snippet::block("inside", [Snippet::entry("rate", "5 /s")]),
            Snippet::entry("pool", "10"),
        ];
        let object = Snippet::declared("object", "NAME", [Snippet::entry("count", "3")]);
        let help = Help::with("declare one: {}, or {}", [Snippet::declared("source", "NAME", source), object]);
        found.push(missing("this search has no source of reward, and no hidden object", help));
    }
    let corners = p.area.len() + p.walls.iter().map(|wall| wall.points.len()).sum::<usize>();
    let counts = [
        (p.agents.len(), MAX_AGENTS, "agents"),
        (p.sources.len(), MAX_SOURCES, "sources"),
        (p.walls.len(), MAX_WALLS, "walls"),
        (corners, MAX_CORNERS, "corners of area and walls"),
    ];
    for (count, most, what) in counts.into_iter().filter(|(count, most, _)| count > most) {
        let text = format!("{count} {what} are more than the {most} that a search may have");
        found.push(Mistake::new("HQ0904", Item::Mission, &[], text, "split the mission into several"));
    }
    let mut large = |item: Item, keys: &'static [&'static str], good: bool| {
        if !good {
            let text = "this number is larger than 1e6".to_string();
            found.push(Mistake::new("HQ0904", item, keys, text, "check the unit after the number"));
        }
    };
    let small = |x: f64| x.is_finite() && x.abs() <= MAX_NUMBER;
    let of_rate = |rate: &Rate| rate.range().into_iter().all(small) && small(rate.scale);
    let points = |points: &[Point]| points.iter().flatten().all(|x| small(*x));
    large(Item::Mission, &["area"], points(&p.area));
    large(Item::Mission, &["horizon"], small(p.horizon));
    for (i, wall) in p.walls.iter().enumerate() {
        large(Item::Wall(i), &["line", "polygon"], points(&wall.points));
    }
    for (i, agent) in p.agents.iter().enumerate() {
        large(Item::Agent(i), &["start"], points(&[agent.start]));
        large(Item::Agent(i), &["speed"], small(agent.speed));
        large(Item::Agent(i), &["radius"], small(agent.radius));
        large(Item::Agent(i), &["heading"], small(agent.heading));
    }
    for (i, source) in p.sources.iter().enumerate() {
        large(Item::Source(i), BOUNDARY, points(&source.boundary.points()));
        let radius = if let Boundary::Circle { radius, .. } = source.boundary { radius } else { 0.0 };
        large(Item::Source(i), &["radius"], small(radius));
        large(Item::Source(i), &["pool"], source.pool.is_none_or(small));
        large(Item::Source(i), &["inside"], of_rate(&source.inside));
        large(Item::Source(i), &["outside"], of_rate(&source.outside));
    }
    if found.is_empty() {
        super::check_objects::sizes(p, found);
    }
}

/// Keys of a boundary.
const BOUNDARY: &[&str] = &["polygon", "line", "points", "at", "speeds", "headings"];

fn polygon(points: &[Point]) -> Option<&'static str> {
    match () {
        () if points.len() < 3 => Some("has fewer than three corners"),
        () if crosses_itself(points) => Some("crosses itself"),
        () if area(points) <= 0.0 => Some("encloses nothing"),
        () => None,
    }
}

fn line(points: &[Point]) -> Option<&'static str> {
    match () {
        () if points.len() < 2 => Some("has fewer than two points"),
        () if length(points) <= 0.0 => Some("has no length"),
        () => None,
    }
}

fn shapes(p: &Problem, found: &mut Vec<Mistake>) {
    let mut wrong = |item: Item, keys: &'static [&'static str], what: &str, why: Option<&'static str>, help: &str| {
        if let Some(why) = why {
            found.push(Mistake::new("HQ0941", item, keys, format!("{what} {why}"), help));
        }
    };
    const IN_ORDER: &str = "write its points in order, from neighbour to neighbour";
    const SMALLER_FIRST: &str =
        "write the smaller value first; directions may go on after half a turn, `[170, 190] deg`";
    wrong(Item::Mission, &["area"], "this area", polygon(&p.area), IN_ORDER);
    for (i, wall) in p.walls.iter().enumerate() {
        let why = if wall.solid { polygon(&wall.points) } else { line(&wall.points) };
        wrong(Item::Wall(i), &["polygon", "line"], "this wall", why, IN_ORDER);
    }
    for (i, source) in p.sources.iter().enumerate() {
        let why = match &source.boundary {
            Boundary::Polygon(points) => polygon(points),
            Boundary::Line(points) => line(points),
            Boundary::Points(points) => points.is_empty().then_some("has no point"),
            Boundary::Circle { .. } => None,
            Boundary::Speed([low, high]) | Boundary::Heading([low, high]) if low > high => {
                Some("ends before it begins")
            }
            Boundary::Heading([low, high]) if high - low > std::f64::consts::TAU => Some("is more than a whole turn"),
            Boundary::Speed(_) | Boundary::Heading(_) => None,
        };
        let of_motion = matches!(source.boundary, Boundary::Speed(_) | Boundary::Heading(_));
        wrong(Item::Source(i), BOUNDARY, "this boundary", why, if of_motion { SMALLER_FIRST } else { IN_ORDER });
    }
    for (i, agent) in p.agents.iter().enumerate().filter(|(_, agent)| agent.speed < MIN_SPEED) {
        let text = format!("`{}` is slower than 0.001 m/s", agent.name);
        found.push(Mistake::new(
            "HQ0903",
            Item::Agent(i),
            &["speed"],
            text,
            Help::write_for_instance(Snippet::entry("speed", "1 m/s")),
        ));
    }
}

/// A rate that is positive near a boundary without an inside.
fn outside() -> Snippet {
    let rate = [Snippet::entry("rate", "5 /s"), Snippet::entry("fall", "gaussian"), Snippet::entry("scale", "0.5 m")];
    Snippet::block("outside", rate)
}

fn rates(p: &Problem, found: &mut Vec<Mistake>) {
    for (i, source) in p.sources.iter().enumerate() {
        let (item, name) = (Item::Source(i), &source.name);
        if let Some((text, help)) = misfit(source) {
            found.push(Mistake::new("HQ0945", item, &["inside", "outside"], text, help));
            continue;
        }
        let zero = source.inside.is_zero() && source.outside.is_zero();
        if zero {
            let text = format!("`{name}` gives no reward, neither inside its boundary nor outside");
            found.push(Mistake::new(
                "HQ0945",
                item,
                &[],
                text,
                Help::write_for_instance(Snippet::block("inside", [Snippet::entry("rate", "5 /s")])),
            ));
        } else if let Some(pool) = source.pool {
            if pool <= 0.0 && p.start <= 0.0 {
                let text = format!("the pool of `{name}` is empty from the start");
                let help = Help::with(
                    "write its content, for instance {}, or remove `pool` for a source without an end",
                    [Snippet::entry("pool", "10")],
                );
                found.push(Mistake::new("HQ0945", item, &["pool"], text, help));
            } else if source.repels() {
                let text = format!("`{name}` has a negative rate, and a pool");
                let help = "remove `pool`, or declare what repels as a source of its own";
                let mistake = Mistake::new("HQ0945", item, &["inside", "outside"], text, help);
                let note = Some("a pool holds the reward that can be collected, and a negative reward never ends");
                found.push(Mistake { note, against: Some((item, &["pool"], "the pool")), ..mistake });
            } else if !source.attracts() {
                let text =
                    format!("nobody can consume `{name}`: its boundary has no inside, and outside it gives nothing");
                found.push(Mistake::new("HQ0945", item, BOUNDARY, text, Help::write_for_instance(outside())));
            }
        }
    }
}

/// Arguments of a rate that its source does not have: what is wrong, and a way out.
pub(super) fn misfit(source: &Source) -> Option<(String, &'static str)> {
    [&source.inside, &source.outside].into_iter().find_map(|rate| misfit_of(source, rate))
}

fn misfit_of(source: &Source, rate: &Rate) -> Option<(String, &'static str)> {
    let name = &source.name;
    let uses = |argument: usize| rate.function.as_ref().is_some_and(|function| function.of.uses(argument));
    let of_place = RateFunction::OF_PLACE.into_iter().any(uses);
    let of_motion = [RateFunction::SPEED, RateFunction::HEADING].into_iter().find(|argument| uses(*argument));
    let word = |argument: usize| if argument == RateFunction::SPEED { "speed" } else { "heading" };
    match (source.kind == SourceKind::Action, of_motion) {
        (true, _) if of_place || rate.fall != Fall::Constant => Some((
            format!("the rate of `{name}` varies with a length, and its axis is a motion"),
            "write it as an expression of `speed` or `heading`, without `fall`, `scale`, `d` and `away`",
        )),
        (true, Some(RateFunction::HEADING)) if !matches!(source.boundary, Boundary::Heading(_)) => Some((
            format!("the rate of `{name}` varies with the heading, and its boundary is an interval of speeds"),
            "write `headings` in place of `speeds`: who stands has no direction of travel, and gets no reward of it",
        )),
        (false, Some(argument)) => Some((
            format!("the rate of `{name}` varies with the {}, and it is no action source", word(argument)),
            "declare a source of the kind `action` beside it, with an interval of `speeds` or of `headings`",
        )),
        _ => None,
    }
}

fn precedence(p: &Problem, found: &mut Vec<Mistake>) {
    let mut wrong = |i: usize, keys: &'static [&'static str], text: String, against: Option<usize>, help: &str| {
        let against = against.map(|other| (Item::Source(other), &[][..], "the other source"));
        found.push(Mistake { against, ..Mistake::new("HQ0944", Item::Source(i), keys, text, help) });
    };
    let name = |i: usize| &p.sources[i].name;
    for (i, source) in p.sources.iter().enumerate() {
        for (list, key) in [(&source.after, "after"), (&source.until, "until")] {
            for other in list.iter().copied() {
                let keys: &'static [&'static str] = if key == "after" { &["after"] } else { &["until"] };
                if other == i {
                    let text = format!("`{}` is rewarding only {key} it is consumed itself", name(i));
                    wrong(i, keys, text, None, "name another source, or remove it");
                } else if p.sources[other].pool.is_none() {
                    let text = format!(
                        "`{}` is rewarding only {key} `{}` is consumed, and that never ends",
                        name(i),
                        name(other)
                    );
                    wrong(i, keys, text, Some(other), "give the other source a `pool`");
                }
            }
        }
        if let Some(other) = source.after.iter().find(|other| source.until.contains(other)) {
            let text =
                format!("`{}` is rewarding only after `{1}` is consumed and only until then", name(i), name(*other));
            wrong(i, &["until"], text, Some(*other), "keep one of the two");
        }
    }
    for pair in &p.codependent {
        let [i, other] = pair.of;
        if i == other {
            wrong(
                i,
                &["codependent"],
                format!("`{}` shares its pool with itself", name(i)),
                None,
                "name another source",
            );
        } else if let Some(endless) = [i, other].into_iter().find(|k| p.sources[*k].pool.is_none()) {
            let text = format!(
                "`{}` and `{}` share their pools, and that of `{}` never ends",
                name(i),
                name(other),
                name(endless)
            );
            wrong(i, &["codependent"], text, Some(other), "give both a `pool`");
        } else {
            for (first, then) in [(i, other), (other, i)] {
                let content = |k: usize| p.sources[k].pool.unwrap_or_default();
                if p.sources[then].after.contains(&first) && pair.share * content(first) >= content(then) {
                    let text = format!(
                        "`{}` comes after `{}`, whose consumption leaves nothing of it",
                        name(then),
                        name(first)
                    );
                    wrong(then, &["after"], text, Some(first), "write a smaller share, or a larger pool");
                }
            }
        }
    }
    if let Some(circle) = circle(p) {
        let names: Vec<&str> = circle.iter().map(|i| p.sources[*i].name.as_str()).collect();
        let text =
            format!("each of these comes after the one before it, and the first after the last: {}", names.join(", "));
        wrong(circle[0], &["after"], text, circle.get(1).copied(), "take one of the sources out of an `after`");
    }
}

/// Sources that come after one another in a circle, of at least two.
fn circle(p: &Problem) -> Option<Vec<usize>> {
    fn visit(p: &Problem, at: usize, state: &mut [u8], path: &mut Vec<usize>) -> Option<Vec<usize>> {
        state[at] = 1;
        path.push(at);
        for before in p.sources[at].after.iter().copied().filter(|before| *before != at) {
            if state[before] == 1 {
                let from = path.iter().position(|of| *of == before).unwrap_or_default();
                return Some(path[from..].iter().rev().copied().collect());
            }
            if state[before] == 0
                && let Some(found) = visit(p, before, state, path)
            {
                return Some(found);
            }
        }
        path.pop();
        state[at] = 2;
        None
    }
    let mut state = vec![0; p.sources.len()];
    (0..p.sources.len()).find_map(|i| if state[i] == 0 { visit(p, i, &mut state, &mut Vec::new()) } else { None })
}

/// Agents that stand in a wall, and sources that nobody can reach or consume.
fn reach(p: &Problem, found: &mut Vec<Mistake>) {
    let mut reached = vec![false; p.sources.len()];
    let mut walled = false;
    for (i, agent) in p.agents.iter().enumerate() {
        let ground = Ground::new(p, &Body::of(agent));
        if let Some(mistake) = map_file::start(p, i) {
            found.push(mistake);
            walled = true;
            continue;
        }
        if !ground.fits(agent.start) {
            let text = format!("`{}` starts in a wall, nearer to one than its radius, or outside the area", agent.name);
            let help = "write a free position, or a smaller `radius`";
            found.push(Mistake::new("HQ0942", Item::Agent(i), &["start"], text, help));
            walled = true;
            continue;
        }
        if ground.clear_everywhere() {
            goals(p, i, &ground, None).into_iter().for_each(|(_, source)| reached[source] = true);
            continue;
        }
        let raster = ground.raster();
        let from = raster.reached(agent.start);
        goals(p, i, &ground, Some(&from)).into_iter().for_each(|(_, source)| reached[source] = true);
    }
    for (i, source) in p.sources.iter().enumerate() {
        let consumers = (0..p.agents.len()).filter(|agent| p.consumes(*agent, i)).count();
        let item = Item::Source(i);
        if consumers == 0 {
            let text =
                format!("nobody can consume `{}`: it has no target, or its targets do not know of it", source.name);
            let help = "name an agent in `targets`, or take the source out of its `unaware`";
            found.push(Mistake::new("HQ0943", item, &["targets"], text, help));
        } else if source.kind == SourceKind::Interaction {
            let others = (0..p.agents.len()).any(|agent| Some(agent) != source.of && p.consumes(agent, i));
            if !others {
                let text = format!("nobody but the agent that `{}` is relative to may consume it", source.name);
                found.push(Mistake::new("HQ0943", item, &["targets"], text, "name another agent in `targets`"));
            }
        } else if source.kind != SourceKind::Action && source.attracts() && !reached[i] && !walled {
            if let Some(mistake) = map_file::source(p, i) {
                found.push(mistake);
                continue;
            }
            let text = format!("nobody who may consume `{}` can reach it", source.name);
            let help = "open a wall, let an agent pass it (`passes`), or move the source to a free position";
            let note = Some(
                "ways are searched on a grid of 0.1 m or over the cells of the map, coarser on large ones, with the radius of each agent",
            );
            found.push(Mistake { note, ..Mistake::new("HQ0943", item, BOUNDARY, text, help) });
        }
    }
}

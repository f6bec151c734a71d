//! A search from its declaration.

use blocks::{Block, Help, MemberIndex, Snippet, Word};

use super::blocks::{AgentBlock, HiddenBlock, RateBlock, SearchBlock, SourceBlock, WallBlock};
use super::check::{Item, check, misfit};
use super::check_objects::unseen;
use super::check_people;
use super::horizon;
use super::map_file;
use super::mission::{Search, members};
use super::problem::{
    Agent, Boundary, Codependence, Detection, Extent, Fall, Hidden, NoValue, Planner, Problem, Rate, RateFunction,
    Source, SourceKind, Travel, Wall,
};
use crate::declare::{DeclaredMember, DeclaredMission, Origins, Remark, Remarks, labels, mistaken};

/// Builds the mission.
pub(super) fn build(declared: &DeclaredMission, remarks: &mut Remarks) -> Search {
    let mut places = Origins::new(declared, Item::Mission);
    let settings = SearchBlock::read(&declared.settings);
    let agents: Vec<&DeclaredMember> = declared.of("robot").chain(declared.of("human")).collect();
    let mut problem = Problem {
        area: settings.area,
        occupancy: None,
        walls: Vec::new(),
        agents: Vec::new(),
        sources: Vec::new(),
        codependent: Vec::new(),
        objects: Vec::new(),
        cell: settings.cell,
        exposure: Vec::new(),
        horizon: settings.horizon,
        start: 0.0,
        reminder: settings.reminder.map(check_people::reminder),
        planner: Planner {
            goals: settings.goals,
            reduction: settings.reduction,
            discount: settings.discount,
            tree_nodes: settings.tree_nodes,
            stay: settings.stay,
            states: settings.states as u64,
            window: settings.window,
            lookouts: settings.lookouts,
            seed: settings.seed as u64,
        },
        labels: Default::default(),
        sight: Default::default(),
    };
    check_people::add_places(Item::Mission, &declared.settings, &mut places);
    map_file::add(declared, settings.map, &mut problem, &mut places, remarks);
    for member in declared.of("wall") {
        let item = Item::Wall(problem.walls.len());
        places.add(item, &member.settings);
        problem.walls.push(wall(member, item, &mut places, remarks));
    }
    for member in &agents {
        let item = Item::Agent(problem.agents.len());
        places.add(item, &member.settings);
        check_people::add_places(item, &member.settings, &mut places);
        problem.agents.push(agent(member));
    }
    for member in declared.of("source") {
        let item = Item::Source(problem.sources.len());
        places.add(item, &member.settings);
        let mut source = source(member, item, agents.len(), &mut places, remarks);
        let fastest = problem.agents.iter().map(|agent| agent.speed).fold(0.0, f64::max);
        if misfit(&source).is_none()
            && let Err(at) = source.survey(problem.bounds(), fastest)
        {
            remarks.push(no_value(&source, at, places.of(item, &["inside", "outside"])));
            places.mark_wrong(item, "inside");
        }
        problem.sources.push(source);
    }
    for member in declared.of("object") {
        places.add(Item::Object(problem.objects.len()), &member.settings);
        problem.objects.push(hidden(member));
    }
    codependences(declared, &mut problem, &mut places, remarks);
    problem.labels = labels(declared, [], remarks);
    mistaken(declared, members(&problem).iter().map(|member| member.name), &problem.labels, remarks);
    if !places.any_wrong() {
        for mistake in check(&problem) {
            remarks.push(mistake.remark(&places));
        }
    }
    if !remarks.has_error() && !places.any_wrong() {
        idle(&problem, &places, remarks);
        horizon::add(&problem, &places, remarks);
        check_people::without_effect(&problem, &places, remarks);
        hidden_for_good(&problem, &places, remarks);
    }
    Search { problem }
}

fn indices(of: &[MemberIndex]) -> Vec<usize> {
    of.iter().map(|index| index.0).collect()
}

fn agent(member: &DeclaredMember) -> Agent {
    let block = AgentBlock::read(&member.settings);
    Agent {
        name: member.name.clone(),
        human: member.role == "human",
        start: block.start,
        heading: block.heading,
        speed: block.speed,
        radius: block.radius,
        passes: indices(&block.passes),
        unaware: indices(&block.unaware),
        sees: block.sees.map(|sees| Detection { within: sees.within, rate: sees.rate }),
        spread: block.spread,
        lost: false,
        told: None,
        habits: block.habits.map(check_people::habits),
    }
}

fn hidden(member: &DeclaredMember) -> Hidden {
    let block = HiddenBlock::read(&member.settings);
    Hidden {
        name: member.name.clone(),
        count: block.count,
        found: 0,
        worth: block.worth,
        region: block.region,
        places: block.positions,
    }
}

/// Codes of what is wrong with a boundary.
const BOUNDARY: &str = "HQ0941";

fn wall(member: &DeclaredMember, item: Item, places: &mut Origins<Item>, remarks: &mut Remarks) -> Wall {
    let block = WallBlock::read(&member.settings);
    let written = |key: &str| member.settings.key_origin(key);
    let help = || {
        let pieces = [Snippet::entry("line", "[[0, 2], [3, 2]] m"), Snippet::entry("polygon", "[..] m")];
        Help::with("write the points of a thin wall, {}, or the corners of a solid one, {}", pieces)
    };
    let name = &member.name;
    match (written("line"), written("polygon")) {
        (None, None) => {
            remarks.push(Remark::error(BOUNDARY, member.at, format!("`{name}` has no points")).help(help()));
            places.mark_wrong(item, "line");
        }
        (Some(one), Some(other)) => {
            let text = format!("`{name}` is thin and solid at once");
            remarks.push(Remark::error(BOUNDARY, other, text).label(one, "the other one").help("keep one of the two"));
            places.mark_wrong(item, "polygon");
        }
        _ => {}
    }
    let solid = written("polygon").is_some();
    let points = if solid { block.polygon } else { block.line };
    Wall { name: name.clone(), points, solid, transparent: block.transparent }
}

fn rate(block: Option<RateBlock>) -> Rate {
    let Some(RateBlock { rate, fall, scale }) = block else { return Rate::ZERO };
    let fall = Fall::ALL.into_iter().find(|form| form.name() == fall).unwrap_or(Fall::Constant);
    match rate.as_constant() {
        Some(peak) => Rate { peak, fall, scale, function: None },
        None => Rate { peak: 0.0, fall, scale, function: Some(RateFunction { of: rate, extent: Extent::default() }) },
    }
}

/// A function that has no finite value somewhere.
fn no_value(source: &Source, value: NoValue, at: blocks::Origin) -> Remark {
    let place = match (value, source.kind) {
        (NoValue::At([x, y]), SourceKind::Interaction) => format!("at ({x:.2}, {y:.2}) m in the frame of its agent"),
        (NoValue::At([x, y]), _) => format!("at ({x:.2}, {y:.2}) m of the map"),
        (NoValue::Of(Travel { speed, heading }), _) if matches!(source.boundary, Boundary::Heading(_)) => {
            format!("for a speed of {speed:.2} m/s and a heading of {:.0} deg", heading.to_degrees())
        }
        (NoValue::Of(Travel { speed, .. }), _) => format!("for a speed of {speed:.2} m/s"),
    };
    let text = format!("the rate of `{}` has no finite value {place}", source.name);
    Remark::error("HQ0945", at, text).help(
        "check for a root of a negative number, a division by zero, or a logarithm of a number that is not positive",
    )
}

/// A circle, as an example.
fn circle() -> Snippet {
    Snippet::parts([Snippet::entry("at", "[4, 2] m"), Snippet::entry("radius", "0.5 m")])
}

/// Intervals of motions, as examples.
fn motions() -> [Snippet; 2] {
    [Snippet::entry("speeds", "[0.1, 2] m/s"), Snippet::entry("headings", "[80, 100] deg")]
}

/// Keys that give a boundary.
const BOUNDARIES: [&str; 6] = ["at", "polygon", "line", "points", "speeds", "headings"];
/// Those that are intervals of motions, with what they are.
const INTERVALS: [(&str, &str); 2] = [("speeds", "speeds"), ("headings", "directions")];

fn source(
    member: &DeclaredMember,
    item: Item,
    agents: usize,
    places: &mut Origins<Item>,
    remarks: &mut Remarks,
) -> Source {
    let block = SourceBlock::read(&member.settings);
    let kind = kind(block.kind);
    let written: Vec<(&'static str, blocks::Origin)> =
        BOUNDARIES.iter().filter_map(|key| Some((*key, member.settings.key_origin(key)?))).collect();
    let name = &member.name;
    let mut wrong = |key: &'static str, remark: Remark| {
        remarks.push(remark);
        places.mark_wrong(item, key);
    };
    match written[..] {
        [] => {
            let remark = Remark::error(BOUNDARY, member.at, format!("`{name}` has no boundary"));
            wrong(
                "at",
                match kind {
                    SourceKind::Action => {
                        remark.help(Help::with("write an interval of speeds, {}, or of directions, {}", motions()))
                    }
                    _ => remark.help(Help::with("write a circle, {}, or a polygon, a line or points", [circle()])),
                },
            );
        }
        [_] => {}
        [(one, first), (other, second), ..] => {
            let text = format!("`{name}` has two boundaries, `{one}` and `{other}`");
            let remark = Remark::error(BOUNDARY, second, text).label(first, "the other one");
            wrong("at", remark.help("keep one of the two, or declare two sources"));
        }
    }
    if let Some(at) = member.settings.key_origin("radius").filter(|_| member.settings.key_origin("at").is_none()) {
        let remark = Remark::error(BOUNDARY, at, "there is no circle that this radius is of");
        wrong(
            "radius",
            remark.help(Help::with("write the centre of the circle too, {}", [Snippet::entry("at", "[4, 2] m")])),
        );
    }
    let interval = INTERVALS.iter().find_map(|(key, what)| Some((*key, *what, member.settings.key_origin(key)?)));
    if let (Some((key, what, at)), false) = (interval, kind == SourceKind::Action) {
        let text = format!("the boundary of `{name}` is an interval of {what}, and not on the ground");
        let remark = Remark::error(BOUNDARY, at, text).note(format!(
            "the boundary of an action source is an interval of motions, and this source has the kind `{}`",
            kind.name()
        ));
        let help = Help::with("write {}, or a boundary on the ground", [Snippet::entry("kind", "action")]);
        wrong(key, remark.help(help));
    } else if let (Some((key, at)), true, None) = (written.first(), kind == SourceKind::Action, interval) {
        let text = format!("`{name}` is an action source, and `{key}` is on the ground");
        let help = Help::with("write an interval of speeds, {}, or of directions, {}, or another `kind`", motions());
        wrong("at", Remark::error(BOUNDARY, *at, text).help(help));
    }
    match (kind == SourceKind::Interaction, member.settings.key_origin("of")) {
        (true, None) => {
            let remark = Remark::error(BOUNDARY, member.at, format!("`{name}` is an interaction source of no agent"));
            let remark = remark.note("the boundary of an interaction source is in the frame of an agent");
            wrong("of", remark.help(Help::with("name the agent, for instance {}", [Snippet::entry("of", "anna")])));
        }
        (false, Some(at)) => {
            let remark =
                Remark::error(BOUNDARY, at, format!("`{name}` is in the frame of an agent, and no interaction source"));
            let remark = remark.note(format!("its kind is `{}`", kind.name()));
            wrong("of", remark.help(Help::with("write {}, or remove `of`", [Snippet::entry("kind", "interaction")])));
        }
        _ => {}
    }
    let boundary = match (block.at, block.radius, block.speeds.or(block.headings)) {
        (_, _, Some(speeds)) if block.speeds.is_some() => Boundary::Speed([speeds.low, speeds.high]),
        (_, _, Some(headings)) => Boundary::Heading([headings.low, headings.high]),
        (Some(centre), Some(radius), _) => Boundary::Circle { centre, radius },
        (Some(at), None, _) => Boundary::Points(vec![at]),
        _ if !block.line.is_empty() => Boundary::Line(block.line),
        _ if !block.points.is_empty() => Boundary::Points(block.points),
        _ => Boundary::Polygon(block.polygon),
    };
    Source {
        name: name.clone(),
        kind,
        boundary,
        inside: rate(block.inside),
        outside: rate(block.outside),
        pool: block.pool,
        targets: block.targets.map_or_else(|| (0..agents).collect(), |targets| indices(&targets)),
        after: indices(&block.after),
        until: indices(&block.until),
        of: block.of.map(|of| of.0),
    }
}

fn kind(word: Word) -> SourceKind {
    SourceKind::ALL.into_iter().find(|kind| kind.name() == word).unwrap_or(SourceKind::Task)
}

/// Reads which sources share their pools. Each pair counts once, on whichever side it is written.
fn codependences(declared: &DeclaredMission, problem: &mut Problem, places: &mut Origins<Item>, remarks: &mut Remarks) {
    for (index, member) in declared.of("source").enumerate() {
        for entry in SourceBlock::read(&member.settings).codependent {
            let (pair, share) = ([index, entry.member], entry.value.value);
            let same = |of: &&Codependence| of.of == pair || of.of == [pair[1], pair[0]];
            match problem.codependent.iter().find(same) {
                Some(known) if known.share != share => {
                    let name = &problem.sources.get(entry.member).map_or("", |source| source.name.as_str());
                    let text =
                        format!("`{}` and `{name}` share their pools by {share} and by {}", member.name, known.share);
                    let other = places.of(Item::Source(entry.member), &["codependent"]);
                    let remark = Remark::error("HQ0944", entry.value.at, text).label(other, "here by another share");
                    remarks.push(remark.help("write the same share on both sides, or on one side alone"));
                    places.mark_wrong(Item::Source(index), "codependent");
                }
                Some(_) => {}
                None => problem.codependent.push(Codependence { of: pair, share }),
            }
        }
    }
}

/// Warns of agents that have nothing to collect.
fn idle(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    for (index, agent) in problem.agents.iter().enumerate() {
        // An agent that is unaware of sources takes part knowingly.
        let looks = agent.sees.is_some() && !problem.objects.is_empty();
        if !looks && !problem.sources.iter().any(|source| source.attracts() && source.targets.contains(&index)) {
            let text = format!("`{}` has nothing to collect", agent.name);
            let remark = Remark::warning("HQ0907", places.of(Item::Agent(index), &[]), text);
            remarks.push(remark.help("make it a target of a source with a positive rate, or remove it"));
        }
        if agent.sees.is_some() && problem.objects.is_empty() {
            let text = format!("`{}` looks for hidden objects, and this search has none", agent.name);
            let remark = Remark::warning("HQ0946", places.of(Item::Agent(index), &["sees"]), text);
            remarks.push(remark.help(Help::with(
                "declare them, {}, or remove `sees`",
                [Snippet::declared("object", "NAME", [Snippet::entry("count", "3")])],
            )));
        }
    }
}

/// Warns of objects that may be where nobody can see them.
fn hidden_for_good(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    for (index, object) in problem.objects.iter().enumerate() {
        let Some((share, [x, y])) = unseen(problem, index) else { continue };
        let text =
            format!("`{}` can be where nobody sees it, with a probability of {:.0} %", object.name, 100.0 * share);
        let remark = Remark::warning("HQ0949", places.of(Item::Object(index), &["region"]), text);
        let remark = remark.note(format!("for instance at ({x}, {y}) m"));
        let help = "let an agent see farther or pass a wall, or leave that part out of the region";
        remarks.push(remark.help(help));
    }
}

//! Drawings of plans: snapshots of one plan, and properties of the drawing of any plan.

use mission::chart::Chart;
use mission::kinds::layers;
use mission::kinds::schedule::chart::chart;
use mission::kinds::schedule::map::map as of;
use mission::kinds::schedule::plan::{Activity, Actor, Phase, Plan, Target};
use mission::kinds::schedule::problem::{AgentKind, Duration, Problem, Robot, WorkingAgent};
use mission::numbers::{Energy, Range};
use mission::plan::{Statistics, Status};
use proptest::prelude::*;

use hierarq::gantt::{Look, Standing, map, picture, svg, text};

/// One service: the robot, the agent, the operation, and the starts of the phases, from the operation's begin to the
/// end.
type Service = (usize, usize, usize, [f64; 8]);

fn plan(robots: &[&str], agents: &[&str], services: &[Service]) -> Plan {
    let mut activities = Vec::new();
    for (robot, agent, operation, t) in services {
        let target = Target { agent: *agent, operation: *operation };
        let one = |actor, phase, start, end| Activity {
            actor,
            phase,
            target,
            start,
            end,
            speed: (phase == Phase::Going).then_some(0.1),
            place: None,
            begun: start < 50.0,
        };
        activities.push(one(Actor::Agent(*agent), Phase::Operation, t[0], t[1]));
        for (phase, k) in Phase::SERVICE.into_iter().zip(2..) {
            activities.push(one(Actor::Robot(*robot), phase, t[k], t[k + 1]));
        }
    }
    let mut plan = Plan {
        members: robots.iter().chain(agents).map(|name| name.to_string()).collect(),
        activities,
        cost: 1.0,
        status: Status::Proven { bound: 1.0 },
        engine: "by hand".into(),
        statistics: Statistics::default(),
    };
    plan.sort();
    plan
}

fn drawn(plan: &Plan) -> Chart {
    chart(&problem(), plan)
}

/// Two robots and three agents, similar to thesis Fig. 5.7.
fn small() -> Plan {
    plan(
        &["m1", "m2"],
        &["h1", "h2", "carrier"],
        &[
            (0, 1, 0, [0.0, 275.0, 20.0, 150.0, 264.0, 275.0, 295.0, 425.0]),
            (1, 0, 0, [0.0, 204.0, 0.0, 160.0, 190.0, 204.0, 224.0, 354.0]),
            (1, 2, 0, [0.0, 250.0, 354.0, 600.0, 600.0, 621.0, 641.0, 790.0]),
            (0, 0, 1, [224.0, 428.0, 425.0, 560.0, 560.0, 570.0, 590.0, 710.0]),
        ],
    )
}

fn problem() -> Problem {
    team(&["m1", "m2"], &["h1", "h2", "carrier"])
}

/// A team with these names, at the places of the first ones.
fn team(robots: &[&str], agents: &[&str]) -> Problem {
    let robot = |name: &str, depot| Robot {
        name: name.into(),
        depot,
        speed: Range::new(0.05, 0.2),
        proximity: None,
        serve: 20.0,
        deposit: 10.0,
        factor: 1.0,
        energy: Energy::of_factor(1.0),
    };
    let agent = |name: &str, kind, place| WorkingAgent {
        severity: 0.5,
        ..WorkingAgent::new(name, kind, place, 2, Duration { mean: 204.0, sigma: 20.0 })
    };
    let depots = [[-10.4, 7.0], [-14.4, 7.0]];
    let places =
        [(AgentKind::Human, [1.0, -1.375]), (AgentKind::Human, [2.3, -4.125]), (AgentKind::Worker, [2.3, -15.125])];
    Problem::new(
        robots.iter().enumerate().map(|(i, name)| robot(name, depots[i % 2])).collect(),
        (agents.iter().enumerate()).map(|(i, name)| agent(name, places[i % 3].0, places[i % 3].1)).collect(),
    )
}

#[test]
fn a_plan_in_the_terminal() {
    insta::assert_snapshot!("terminal", text(&drawn(&small()), 80, false));
}

#[test]
fn a_plan_in_colours() {
    let coloured = text(&drawn(&small()), 80, true);
    let mut plain = String::new();
    let mut rest = coloured.as_str();
    while let Some((before, after)) = rest.split_once('\x1b') {
        plain.push_str(before);
        rest = after.split_once('m').expect("each sequence ends").1;
    }
    plain.push_str(rest);
    assert_eq!(plain, text(&drawn(&small()), 80, false), "colours change no character");
    assert!(coloured.lines().all(|line| line.matches("\x1b[0m").count() * 2 == line.matches('\x1b').count()));
}

#[test]
fn a_plan_as_a_picture() {
    let look = Look { now: Some(310.0), until: None, styled: false };
    insta::assert_snapshot!("picture", picture(&drawn(&small()), &look));
}

#[test]
fn a_plan_on_the_map() {
    let standing = Standing { moving: vec![[-4.0, 3.0], [-14.4, 7.0]], styled: false };
    insta::assert_snapshot!("map", map(&of(&problem(), &small()), &standing));
}

/// The chart of a layered plan: two arms and a person build a letter.
fn layered() -> Chart {
    let tasks = [("left_foot", 0), ("right_foot", 0), ("bar", 1), ("left_top", 2), ("right_top", 2)];
    let done = [(0, 0, 0.0, 12.0), (1, 1, 0.0, 15.0), (2, 2, 15.0, 21.0), (0, 3, 21.0, 30.0), (0, 4, 30.0, 41.0)];
    let agent = |name: &str, body| layers::problem::Agent {
        name: name.into(),
        place: [0.0; 3],
        body,
        skills: Vec::new(),
        reach: None,
        payload: None,
        cannot: Default::default(),
        spread: 0.0,
        lost: false,
    };
    let arm = layers::problem::Body::Robot { speed: Range::new(0.1, 0.3), energy: Energy::of_factor(1.0) };
    let person = layers::problem::Body::Human { speed: 0.3, slowing: 0.0 };
    let task = |(name, layer): (&str, usize)| layers::problem::Task {
        name: name.into(),
        action: "place".into(),
        layer,
        features: Default::default(),
        object: None,
        path: Vec::new(),
        agent: None,
    };
    let problem = layers::problem::Problem {
        agents: vec![agent("left_arm", arm), agent("right_arm", arm), agent("anna", person)],
        objects: Vec::new(),
        layers: ["base", "bridge", "top"].map(String::from).to_vec(),
        tasks: tasks.map(task).to_vec(),
        weights: layers::problem::Weights { workload: 1.0, energy: 1.0, makespan: 1.0 },
        returns: true,
        start: 0.0,
        begun: Vec::new(),
        labels: Default::default(),
        places: Default::default(),
    };
    let activity = |(agent, task, start, end): (usize, usize, f64, f64)| layers::plan::Activity {
        agent,
        task,
        object: None,
        start,
        end,
        speed: Some(0.2),
        place: [0.0; 3],
        begun: false,
    };
    let plan = layers::plan::Plan {
        members: problem.agents.iter().map(|agent| agent.name.clone()).collect(),
        activities: done.into_iter().map(activity).collect(),
        cost: 1.0,
        status: Status::Proven { bound: 1.0 },
        engine: "by hand".into(),
        statistics: Statistics::default(),
    };
    layers::chart::chart(&problem, &plan)
}

#[test]
fn a_layered_plan_in_the_terminal() {
    insta::assert_snapshot!("layers_terminal", text(&layered(), 80, false));
}

#[test]
fn a_layered_plan_as_a_picture() {
    insta::assert_snapshot!("layers_picture", picture(&layered(), &Look { styled: false, ..Look::default() }));
    well_formed(&svg(&layered()));
}

#[test]
fn a_plan_of_nothing() {
    let none = plan(&["m1"], &[], &[]);
    let chart = chart(&team(&["m1"], &[]), &none);
    assert_eq!(text(&chart, 80, false), "Nothing is planned.\n");
    well_formed(&svg(&chart));
    let mut nobody = problem();
    nobody.robots.clear();
    nobody.agents.clear();
    well_formed(&map(&of(&nobody, &none), &Standing::default()));
}

#[test]
fn names_are_text_and_nothing_else() {
    let bad = "<script>alert('1')</script>&\"\u{1b}]0;x\u{7}";
    let hostile = plan(&[bad], &[bad], &[(0, 0, 0, [0.0, 100.0, 0.0, 80.0, 90.0, 100.0, 120.0, 160.0])]);
    let team = team(&[bad], &[bad]);
    let chart = chart(&team, &hostile);
    let pictures = [svg(&chart), map(&of(&team, &hostile), &Standing { moving: vec![[0.0, 0.0]], styled: true })];
    for drawn in pictures {
        assert!(!drawn.contains("<script") && !drawn.contains('\u{1b}'), "{drawn}");
        well_formed(&drawn);
    }
    let terminal = text(&chart, 100, false);
    assert!(!terminal.contains(['\u{1b}', '\u{7}']), "{terminal:?}");
}

#[test]
fn numbers_that_are_none_are_not_drawn() {
    let mut odd = small();
    odd.activities[0].start = f64::NAN;
    odd.activities[1].end = f64::INFINITY;
    odd.activities[2].start = 1e300;
    odd.activities.last_mut().expect("some").target.agent = 99;
    well_formed(&svg(&drawn(&odd)));
    assert!(!text(&drawn(&odd), 80, true).is_empty());
    let mut lost = problem();
    lost.agents[0].place = [f64::NAN, 0.0];
    lost.robots[0].depot = [0.0, f64::INFINITY];
    well_formed(&map(&of(&lost, &odd), &Standing { moving: vec![[f64::NAN, 0.0]], styled: false }));
}

/// Checks that a drawing is valid XML without NaN or infinite numbers.
fn well_formed(drawn: &str) {
    let parsed = roxmltree::Document::parse(drawn).expect("XML");
    assert!(parsed.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")));
    for node in parsed.descendants() {
        let odd = node.attributes().find(|a| a.value().contains("NaN") || a.value().contains("inf"));
        assert_eq!(odd, None, "{drawn}");
    }
}

const ROBOTS: [&str; 3] = ["m1", "m2", "m3"];
const AGENTS: [&str; 4] = ["h1", "h2", "w1", "somebody_with_a_long_name"];

fn any_plan() -> impl Strategy<Value = Plan> {
    let service = (0..3usize, 0..4usize, 0..5usize, prop::array::uniform8(0.0..400.0f64), 0.0..5000.0f64);
    prop::collection::vec(service, 1..12).prop_map(|services| {
        let services: Vec<Service> = services
            .into_iter()
            .map(|(robot, agent, operation, gaps, from)| {
                let mut t = from;
                (
                    robot,
                    agent,
                    operation,
                    gaps.map(|gap| {
                        t += gap;
                        t
                    }),
                )
            })
            .collect();
        plan(&ROBOTS, &AGENTS, &services)
    })
}

proptest! {
    #[test]
    fn each_activity_is_drawn_once_and_as_long_as_it_takes(plan in any_plan()) {
        let drawn = svg(&chart(&team(&ROBOTS, &AGENTS), &plan));
        let parsed = roxmltree::Document::parse(&drawn).expect("XML");
        let bars: Vec<_> = parsed.descendants().filter(|node| node.attribute("data-phase").is_some()).collect();
        prop_assert_eq!(bars.len(), plan.activities.len());
        let total = |phase: Phase| -> f64 {
            plan.activities.iter().filter(|a| a.phase == phase).map(|a| a.end - a.start).sum()
        };
        let width = |phase: Phase| -> f64 {
            let of = bars.iter().filter(|bar| bar.attribute("data-phase") == Some(phase.name()));
            of.map(|bar| bar.attribute("width").and_then(|w| w.parse::<f64>().ok()).expect("a number")).sum()
        };
        // Widths are written to a hundredth of a pixel.
        let sum = |of: &dyn Fn(Phase) -> f64| Phase::ALL.into_iter().map(of).sum::<f64>();
        let scale = sum(&width) / sum(&total);
        for phase in Phase::ALL {
            prop_assert!((width(phase) - scale * total(phase)).abs() < 0.02 * bars.len() as f64, "{phase:?}");
        }
    }

    #[test]
    fn the_terminal_keeps_its_width_and_shows_every_service(plan in any_plan(), columns in 0..200usize) {
        let drawn = text(&chart(&team(&ROBOTS, &AGENTS), &plan), columns, false);
        let lines: Vec<&str> = drawn.lines().collect();
        prop_assert_eq!(lines.len(), 2 + ROBOTS.len() + AGENTS.len() + 1);
        let most = columns.clamp(40, 400);
        prop_assert!(lines[..lines.len() - 1].iter().all(|line| line.chars().count() <= most), "{}", drawn);
        for (index, line) in lines[2..lines.len() - 1].iter().enumerate() {
            let serves = |a: &&Activity| a.phase == Phase::Serving && match a.actor {
                Actor::Robot(robot) => robot == index || a.target.agent + ROBOTS.len() == index,
                Actor::Agent(_) => false,
            };
            prop_assert_eq!(plan.activities.iter().any(|a| serves(&a)), line.contains('#'), "{}", drawn);
        }
    }
}

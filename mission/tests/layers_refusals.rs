//! Layered problems that cannot be planned, and invalid JSON: each mistake has a position, a reason and a fix.
use crate::layered;

use std::collections::BTreeMap;

use hierarq_mission::kinds::layers::check::{Declaration, Item, Key, Mistake};
use hierarq_mission::kinds::layers::choose::{Formulation, Options, Refusal, plan};
use hierarq_mission::kinds::layers::json::{Fault, FaultKind, Imported, Mode, export, export_plan, import};
use hierarq_mission::kinds::layers::problem::{Begun, Body, Problem};
use hierarq_mission::kinds::layers::reason::{ObstacleKind, Reason};
use hierarq_mission::kinds::layers::validate::validate;
use hierarq_mission::numbers::Range;
use proptest::prelude::*;

/// The mistakes of letter H after a change.
fn mistakes(change: impl Fn(&mut Problem)) -> Vec<Mistake> {
    let mut problem = layered::letter_h(1);
    assert_eq!(problem.check(), []);
    change(&mut problem);
    let mistakes = problem.check();
    assert_eq!(plan(&problem, &Options::default()).unwrap_err(), Refusal::Problem(mistakes.clone()));
    mistakes
}

fn first(change: impl Fn(&mut Problem)) -> Mistake {
    mistakes(change).into_iter().next().unwrap()
}

fn at(item: Item, key: Key) -> Declaration {
    Declaration { item, key: Some(key) }
}

#[test]
fn numbers_out_of_range_name_the_key() {
    let robot = Item::Agent(0);
    let speed = |p: &mut Problem, range: Range| {
        if let Body::Robot { speed, .. } = &mut p.agents[0].body {
            *speed = range;
        }
    };
    let found = first(|p| speed(p, Range::new(0.3, 0.2)));
    assert_eq!((found.at, found.reason), (at(robot, Key::Speed), Reason::Reversed { low: 0.3, high: 0.2 }));
    assert_eq!(first(|p| speed(p, Range::new(0.0, 0.2))).at, at(robot, Key::Speed));
    assert_eq!(first(|p| p.agents[0].place[2] = f64::INFINITY).at, at(robot, Key::Place));
    assert_eq!(first(|p| p.agents[0].reach = Some(-1.0)).at, at(robot, Key::Reach));
    assert_eq!(first(|p| p.agents[0].skills[0].duration = -1.0).at, at(robot, Key::Skills));
    let twice = |p: &mut Problem| p.agents[0].skills.push(layered::skill("pick_and_place", 1.0, 1.0));
    assert_eq!(first(twice).reason, Reason::TwiceSkill { action: "pick_and_place".into() });
    assert_eq!(first(|p| p.agents[2].skills[0].pace = 1.5).at, at(Item::Agent(2), Key::Skills));
    assert_eq!(first(|p| p.objects[3].mass = -0.1).at, at(Item::Object(3), Key::Mass));
    assert_eq!(first(|p| p.weights.energy = -1.0).at, at(Item::Mission, Key::Weights));
    assert_eq!(first(|p| p.tasks[4].layer = 9).at, at(Item::Task(4), Key::Layer));
    assert_eq!(first(|p| p.tasks[4].object = Some(64)).reason, Reason::Unknown { index: 64 });
    assert_eq!(first(|p| p.layers.push("empty".into())).at, Declaration { item: Item::Layer(5), key: None });
    assert_eq!(first(|p| p.agents.clear()).reason, Reason::NoAgent);
    assert_eq!(first(|p| p.tasks.clear()).reason, Reason::NoTask);
    let many = |p: &mut Problem| p.objects = vec![p.objects[0].clone(); 600];
    assert_eq!(first(many).reason, Reason::TooMany { count: 600, most: 512 });
    let still = |p: &mut Problem| {
        p.returns = false;
        for who in &mut p.agents {
            who.place = [0.0; 3];
            who.skills.iter_mut().for_each(|skill| skill.duration = 0.0);
        }
        p.objects.iter_mut().for_each(|thing| thing.place = [0.0; 3]);
        p.tasks.iter_mut().for_each(|task| task.path.clear());
    };
    assert_eq!(first(still).reason, Reason::NoTime);
}

#[test]
fn tasks_that_nobody_can_do_say_why() {
    let found = first(|p| p.tasks[2].action = "weld".into());
    assert_eq!(
        (found.at, found.reason),
        (at(Item::Task(2), Key::Action), Reason::NobodyHasSkill { action: "weld".into() })
    );
    let found = first(|p| p.tasks[2].features = layered::words(&["red", "sphere"]));
    assert_eq!(found.at, at(Item::Task(2), Key::Features));
    assert!(matches!(found.reason, Reason::NoObject { nearest: Some(0), .. }), "{found:?}");
    let found = first(|p| p.tasks[2].object = Some(5));
    assert_eq!(found.reason, Reason::LacksFeature { object: 5, feature: "cube".into() });
    assert_eq!((found.at, found.against), (at(Item::Task(2), Key::Object), Some(at(Item::Object(5), Key::Features))));
    let found = first(|p| {
        p.agents.iter_mut().for_each(|who| who.reach = Some(2.0));
        p.tasks[2].path = vec![[0.0, 9.0, 0.0]];
    });
    assert_eq!(found.against, Some(at(Item::Agent(2), Key::Reach)), "the person is nearest");
    let Reason::Nobody { obstacles } = found.reason else { panic!() };
    assert!(matches!(obstacles[2].kind, ObstacleKind::Path { distance, reach: 2.0 } if (distance - 8.5).abs() < 1e-9));
    let found = first(|p| {
        p.agents.iter_mut().for_each(|who| who.payload = Some(0.05));
        p.tasks[2].features = layered::words(&["red", "cube"]);
    });
    assert_eq!(found.against, Some(at(Item::Agent(0), Key::Payload)));
    let found = first(|p| {
        p.tasks[2].agent = Some(1);
        p.agents[1].lost = true;
    });
    assert_eq!(found.at, at(Item::Task(2), Key::Agent));
    let Reason::Nobody { obstacles } = found.reason else { panic!() };
    assert_eq!((obstacles.len(), &obstacles[0].kind), (1, &ObstacleKind::Lost));
}

#[test]
fn too_few_objects_name_the_tasks_that_compete() {
    let found = mistakes(|p| {
        p.objects.retain(|thing| !thing.features.contains("cube") || thing.name.ends_with("cube_1"));
        for task in p.tasks.iter_mut().take(3) {
            task.features.insert("red".into());
        }
    });
    // Three tasks need a red cube, and there are two; the ten tasks that need any cube have eight.
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(found[0].reason, Reason::TooFewObjects { tasks: vec![0, 1, 2], objects: vec![0, 16] });
    for mistake in &found {
        let Reason::TooFewObjects { tasks, objects } = &mistake.reason else { panic!("{mistake:?}") };
        assert!(tasks.len() > objects.len());
    }
    let (what, fix) = found[0].describe(&layered::letter_h(1));
    assert!(what.contains("need") && !fix.is_empty(), "{what}");
    let red = mistakes(|p| {
        p.objects.retain(|thing| !thing.features.contains("red") || thing.name == "left_red_cube_1");
        for task in [0, 4] {
            p.tasks[task].features.insert("red".into());
        }
    });
    assert_eq!(red[0].reason, Reason::TooFewObjects { tasks: vec![0, 4], objects: vec![0] });
    assert_eq!((red[0].at, red[0].against), (at(Item::Task(4), Key::Features), Some(at(Item::Task(0), Key::Features))));
}

#[test]
fn what_has_begun_must_be_possible() {
    let begun = Begun { task: 0, agent: 0, object: Some(0), speed: 0.1, start: 0.0, end: 5.0 };
    let reason = |begun: Vec<Begun>| {
        first(|p| {
            p.start = 10.0;
            p.begun = begun.clone();
        })
        .reason
    };
    assert_eq!(reason(vec![Begun { start: 11.0, end: 12.0, ..begun }]), Reason::Later { begins: 11.0 });
    assert_eq!(reason(vec![Begun { end: -1.0, ..begun }]), Reason::NotAscending);
    assert_eq!(reason(vec![Begun { object: None, ..begun }]), Reason::ObjectOfBegun);
    assert_eq!(reason(vec![Begun { speed: 0.0, ..begun }]), Reason::TooSmall { value: 0.0, least: 1e-3 });
    assert_eq!(reason(vec![begun, begun]), Reason::Twice);
    assert_eq!(reason(vec![begun, Begun { task: 1, object: Some(1), ..begun }]), Reason::Overlap);
    assert_eq!(reason(vec![begun, Begun { task: 1, agent: 1, ..begun }]), Reason::SameObject);
    assert_eq!(reason(vec![Begun { task: 4, ..begun }]), Reason::LayerBefore { task: 0 });
}

fn read(text: &str, mode: Mode) -> Result<Imported, Vec<Fault>> {
    let places = BTreeMap::from([("box".to_string(), [0.1, 0.2, 0.0])]);
    import(text, &Problem { places, ..layered::bench(1) }, mode)
}

/// Line, column, path and kind of each mistake.
fn faults(text: &str) -> Vec<(usize, usize, String, FaultKind)> {
    let found = read(text, Mode::Context).unwrap_err();
    for fault in &found {
        assert!(!fault.what.is_empty() && !fault.fix.is_empty(), "{fault}");
    }
    found.into_iter().map(|fault| (fault.at.line, fault.at.column, fault.path, fault.kind)).collect()
}

#[test]
fn every_mistake_of_a_text_is_told_with_its_place() {
    let text = r#"{ "layers": [
  { "name": "a", "tasks": [
    { "name": "x", "action": "pick", "features": ["cube", "purple"], "to": [0, 0] },
    { "name": "x", "features": ["cube", "parallelepiped"], "to": "bin", "colour": 3 }
  ] },
  { "name": "a", "tasks": "none" }
] }"#;
    use FaultKind::*;
    let expected = [
        (3, 30, "layers[0].tasks[0].action", UnknownAction),
        (3, 59, "layers[0].tasks[0].features[1]", UnknownFeature),
        (3, 76, "layers[0].tasks[0].to", Type),
        (4, 5, "layers[0].tasks[1]", Missing),
        (4, 15, "layers[0].tasks[1].name", Twice),
        (4, 32, "layers[0].tasks[1].features", NoObject),
        (4, 66, "layers[0].tasks[1].to", UnknownName),
        (4, 73, "layers[0].tasks[1].colour", UnknownKey),
        (6, 3, "layers[1]", Twice),
        (6, 27, "layers[1].tasks", Type),
    ];
    let expected: Vec<_> = expected.map(|(line, column, path, kind)| (line, column, path.to_string(), kind)).into();
    assert_eq!(faults(text), expected);
    let told: Vec<String> = read(text, Mode::Context).unwrap_err().iter().map(Fault::to_string).collect();
    assert_eq!(
        told[0],
        "line 3, column 30, layers[0].tasks[0].action: nobody performs `pick`; there is `close`, `open`, `pick_and_place`"
    );
    assert!(told[6].ends_with("there is no place `bin`; there is `box`"), "{}", told[6]);
}

#[test]
fn a_text_that_breaks_off_says_where_and_what_was_wrong_before() {
    let text =
        "{\"layers\": [\n {\"tasks\": [\n  {\"name\": \"x\", \"action\": \"pick_and_plac\"},\n  {\"name\": \"y\", ";
    let found = read(text, Mode::Context).unwrap_err();
    let kinds: Vec<FaultKind> = found.iter().map(|fault| fault.kind).collect();
    assert_eq!(kinds, [FaultKind::UnknownAction, FaultKind::Truncated], "{found:?}");
    assert!(found[0].fix.contains("did you mean `pick_and_place`"), "{}", found[0]);
    assert_eq!(found[1].what, "the text ends within the `{` of line 4, column 3");
    assert!(found[1].fix.ends_with("`}]}]}`"), "{}", found[1].fix);
    for (text, kind) in [
        ("", FaultKind::Truncated),
        ("no", FaultKind::Syntax),
        ("```json\n{}\n```", FaultKind::Syntax),
        ("{} {}", FaultKind::Syntax),
        ("{\"layers\": [1,]}", FaultKind::Syntax),
        ("{\"layers\": [01]}", FaultKind::Syntax),
        ("{\"layers\": 1e999}", FaultKind::Syntax),
        ("{\"layers\": \"\\x\"}", FaultKind::Syntax),
        ("{'layers': []}", FaultKind::Syntax),
        ("{}", FaultKind::Missing),
        ("[]", FaultKind::Type),
        ("{\"layers\": []}", FaultKind::Impossible),
        ("{\"layers\": [], \"tasks\": []}", FaultKind::UnknownKey),
        (&"[".repeat(100_000), FaultKind::TooMuch),
    ] {
        assert!(read(text, Mode::Context).unwrap_err().iter().any(|fault| fault.kind == kind), "{text}");
    }
}

/// A hostile text takes no time, and gives at most about a hundred messages.
#[test]
fn too_much_is_cut_off() {
    let features = vec!["\"x\""; 5000].join(",");
    let task = format!("{{\"name\": \"t\", \"action\": \"open\", \"features\": [{features}]}}");
    let found =
        read(&format!("{{\"layers\": [{{\"tasks\": [{}]}}]}}", vec![task; 9].join(",")), Mode::Context).unwrap_err();
    assert!((100..110).contains(&found.len()), "{}", found.len());
    assert_eq!(found[0].kind, FaultKind::TooMuch);
    let task = "{\"name\": \"t\", \"action\": \"weld\"}";
    let found = read(&format!("{{\"tasks\": [{}]}}", vec![task; 300].join(",")), Mode::Context).unwrap_err();
    assert!(found.iter().any(|fault| fault.kind == FaultKind::TooMuch) && found.len() < 400);
    assert!(read(&" ".repeat(2 << 20), Mode::Context).unwrap_err()[0].kind == FaultKind::TooMuch);
}

#[test]
fn precedences_become_layers_and_circles_are_named() {
    let task = |name: &str, after: &str| {
        format!("{{\"name\": \"{name}\", \"action\": \"open\", \"to\": \"box\", \"after\": [{after}]}}")
    };
    let text = |tasks: &[String]| format!("{{\"tasks\": [{}]}}", tasks.join(",\n"));
    let good = read(&text(&[task("c", "\"a\", \"b\""), task("a", ""), task("b", "\"a\"")]), Mode::Context).unwrap();
    let layers: Vec<usize> = good.problem.tasks.iter().map(|task| task.layer).collect();
    assert_eq!((layers, good.problem.layers.len()), (vec![2, 0, 1], 3));
    let found = read(&text(&[task("a", "\"b\""), task("b", "\"c\""), task("c", "\"b\"")]), Mode::Context).unwrap_err();
    assert_eq!((found[0].kind, found[0].at.line), (FaultKind::Cycle, 2));
    assert!(found[0].what.contains("`b`, `c`"), "{}", found[0]);
    let found = read(&text(&[task("a", "\"z\"")]), Mode::Context).unwrap_err();
    assert_eq!(found[0].path, "tasks[0].after[0]");
}

#[test]
fn what_can_be_read_and_not_planned_is_told_at_its_task() {
    let mut problem = layered::bench(1);
    problem.objects.retain(|thing| thing.features.contains("green"));
    problem.agents.retain(|who| !who.is_human());
    problem.agents.iter_mut().for_each(|who| who.payload = Some(0.05));
    let text = "{\"layers\": [{\"tasks\": [\n{\"name\": \"t\", \"action\": \"pick_and_place\",\n \"features\": [\"parallelepiped\"], \"to\": [0,0,0]}]}]}";
    let found = import(text, &problem, Mode::Context).unwrap_err();
    assert_eq!(
        (found[0].kind, found[0].at.line, found[0].path.as_str()),
        (FaultKind::Impossible, 2, "layers[0].tasks[0]")
    );
    assert!(found[0].what.contains("more than its payload"), "{}", found[0]);
}

#[test]
fn the_three_modes_share_the_work_differently() {
    let problem = layered::letter_d(1);
    let best = plan(&problem, &Options { formulation: Some(Formulation::Batches), ..Options::default() }).unwrap();
    let context = import(&export(&problem), &problem, Mode::Context).unwrap();
    assert_eq!(context, Imported { problem: problem.clone(), plan: None });
    // All tasks allocated as in the plan: only the speeds remain, which batches have optimized already.
    let text = export_plan(&problem, &best);
    let allocated =
        import(&text.replace(", \"start\"", ", \"description\": \"\", \"start\""), &problem, Mode::Allocated);
    let faults = allocated.unwrap_err();
    assert_eq!(faults.len(), 2 * problem.tasks.len(), "start and end have no meaning");
    assert!(faults.iter().all(|fault| fault.fix == "remove it: times are planned"), "{faults:?}");
    let scheduled = import(&text, &problem, Mode::Scheduled).unwrap();
    let again = plan(&scheduled.problem, &Options::default()).unwrap();
    assert!((again.cost - best.cost).abs() < 1e-9 * best.cost, "the scales are those of the free problem");
    let given = scheduled.plan.unwrap();
    assert_eq!(validate(&scheduled.problem, &given), vec![]);
    assert!((given.cost - best.cost).abs() < 1e-6 * best.cost);
    // A plan in which everything begins at once is rejected.
    let mut hasty = export_plan(&problem, &best);
    for activity in &best.activities {
        let (start, end) = (activity.start, activity.end);
        hasty = hasty.replace(
            &format!("\"start\": {start}, \"end\": {end}"),
            &format!("\"start\": 0, \"end\": {}", end - start),
        );
    }
    let hasty = import(&hasty, &problem, Mode::Scheduled).unwrap_err();
    for words in ["of a layer before ends", "two at once"] {
        assert!(hasty.iter().any(|fault| fault.what.contains(words)), "{words}: {hasty:?}");
    }
    let missing = import(&export(&problem), &problem, Mode::Scheduled).unwrap_err();
    assert_eq!(missing.len(), 4 * problem.tasks.len(), "agent, object, start and end of each");
}

/// Control characters for terminals are neither accepted in names nor printed in refusals.
#[test]
fn names_command_nothing() {
    let with = |name: &str, action: &str, key: &str| {
        let text = serde_json::json!({ "tasks": [{ "name": name, "action": action, key: 1 }] }).to_string();
        let faults = import(&text, &layered::letter_d(1), Mode::Context).unwrap_err();
        faults.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    for bad in ["a\u{1b}[2J", "a\nb", "a\u{202e}b", "a\u{9b}2J", "\u{7f}"] {
        let told = with(bad, bad, bad);
        assert_eq!(told.iter().filter(|fault| fault.contains("this is not a name")).count(), 2, "{told:?}");
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(!told.concat().chars().any(hierarq_mission::characters::commands), "{told:?}");
    }
    assert!(!with("würfel 🧊", "x", "y").concat().contains("no name"));
}

/// Each mistake in the times of a plan is reported at its task, by name, with a valid time.
#[test]
fn times_that_cannot_be_are_refused() {
    let problem = layered::letter_d(1);
    let best = plan(&problem, &Options::default()).unwrap();
    let good: serde_json::Value = serde_json::from_str(&export_plan(&problem, &best)).unwrap();
    let with = |key: &str, change: &dyn Fn(f64, f64) -> f64| {
        let mut text = good.clone();
        let task = &mut text["layers"][0]["tasks"][0];
        let (start, end) = (task["start"].as_f64().unwrap(), task["end"].as_f64().unwrap());
        task[key] = change(start, end).into();
        text
    };
    let name = &problem.tasks.iter().find(|task| task.layer == 0).unwrap().name;
    let told = |text: &serde_json::Value| {
        let faults = import(&text.to_string(), &problem, Mode::Scheduled).unwrap_err();
        faults.into_iter().find(|fault| fault.what.contains(&format!("`{name}`"))).unwrap()
    };
    let early = told(&with("start", &|_, _| -5.0));
    assert_eq!(early.path, "layers[0].tasks[0].start");
    assert!(early.to_string().contains("begins at -5 s, before the mission does; give a `start` of 0 s"), "{early}");
    let backwards = told(&with("end", &|start, _| start - 1.0));
    assert!(backwards.what.contains("before it begins"), "{backwards}");
    // The suggested time is sufficient, and not much too large.
    let hasty = told(&with("end", &|start, _| start + 0.1));
    assert!(hasty.what.contains("in 0.1 s"), "{hasty}");
    let enough: f64 = hasty.fix.split(' ').find_map(|word| word.parse().ok()).unwrap();
    for (end, takes) in [(enough, true), (enough - 0.002, false)] {
        let faults = import(&with("end", &|_, _| end).to_string(), &problem, Mode::Scheduled).err().unwrap_or_default();
        assert_eq!(!faults.iter().any(|fault| fault.what.contains("at least")), takes, "{faults:?}");
    }
}

proptest! {
    #[test]
    fn no_text_is_too_strange(text in "[\\[\\]{}\",:a-z0-9.\\\\\n -]{0,200}", cut in 0_usize..3000, put in ".{0,5}") {
        let _ = read(&text, Mode::Scheduled);
        let good = export(&layered::letter_d(1));
        let at = (0..=cut.min(good.len())).rev().find(|at| good.is_char_boundary(*at)).unwrap();
        for damaged in [good[..at].to_string(), format!("{}{put}{}", &good[..at], &good[at..])] {
            if let Err(faults) = read(&damaged, Mode::Context) {
                prop_assert!(!faults.is_empty());
            }
        }
    }

    #[test]
    fn what_is_given_out_is_read_again(seed in 0_u64..100_000, name in "\\PC{1,20}") {
        prop_assume!(!name.chars().any(hierarq_mission::characters::commands));
        let mut problem = layered::random(seed, 5, 8, 2, 1);
        problem.tasks[0].name = name;
        if problem.check().is_empty() {
            let again = import(&export(&problem), &problem, Mode::Context).unwrap();
            prop_assert_eq!(again.problem.tasks.len(), problem.tasks.len());
            for task in &problem.tasks {
                prop_assert!(again.problem.tasks.contains(task), "{:?}", task);
            }
        }
    }
}

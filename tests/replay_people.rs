//! People in the replay of a report: where the scenario lets them walk, as far as the controller knew.

use runtime::program::ScenarioProgram;
use runtime::record::All;
use runtime::record::series::SeriesRecorder;
use runtime::record::summary::{Summary, SummaryRecorder};
use runtime::{Program, Simulation};
use serde_json::Value;
use views::report;

use crate::common::program;

/// The data of the page for a scenario of the example.
fn page(scenario: &str) -> Value {
    let all = program("bystander.hq");
    let scenario = all.scenarios.iter().find(|s| s.name == scenario).expect("a scenario");
    let program = scenario.program(&all);
    let mut simulation = Simulation::in_world(&program, scenario).expect("it can be executed");
    let ticks = simulation.ticks();
    let mut summary = SummaryRecorder::new(simulation.controller(), ticks);
    let mut series = SeriesRecorder::new(simulation.controller(), ticks, report::drawn_links(&program));
    let mut all = All(vec![&mut summary, &mut series]);
    simulation.run(&mut all, &mut || 0.0, &mut |_| true).expect("no recorder fails");
    let summary = summary.summary(&program, simulation.controller(), Vec::new());
    data(&program, Some(scenario), &summary, &series)
}

fn data(program: &Program, scenario: Option<&ScenarioProgram>, summary: &Summary, series: &SeriesRecorder) -> Value {
    report::data(&report::Run { program, scenario, spec: "bystander.hq", summary, good: true, series })
}

/// Position and uncertainty of each of the three points, by time.
fn samples(page: &Value) -> Vec<(f64, [[Option<f64>; 4]; 3])> {
    let [person] = page["scene"]["people"].as_array().expect("people").as_slice() else { panic!("one person") };
    assert_eq!(person["name"], "walker");
    assert_eq!(person["points"], serde_json::json!(["chest", "left_wrist", "right_wrist"]));
    assert_eq!(person["links"], serde_json::json!([[0, 1], [0, 2]]));
    let times = page["time"].as_array().expect("times");
    let data = person["data"].as_array().expect("numbers");
    assert_eq!(data.len(), times.len() * 12);
    let one = |(time, row): (&Value, &[Value])| {
        let point = |k: usize| std::array::from_fn(|n| row[4 * k + n].as_f64());
        (time.as_f64().expect("a time"), [point(0), point(1), point(2)])
    };
    times.iter().zip(data.chunks(12)).map(one).collect()
}

#[test]
fn a_person_is_drawn_where_the_scenario_lets_them_walk() {
    let samples = samples(&page("walks past"));
    // The path of the spec, at constant speed between its points; the chest is 0.9 m above it.
    let way = |t: f64| match t {
        t if t < 1.0 => [0.9, -1.6],
        t if t < 4.0 => [0.9 - 0.22 * (t - 1.0) / 3.0, -1.6 + 1.6 * (t - 1.0) / 3.0],
        t if t < 5.0 => [0.68, 0.0],
        t => [0.68 + 0.22 * (t - 5.0) / 3.0, 1.6 * (t - 5.0) / 3.0],
    };
    let known: Vec<_> = samples.iter().filter(|(t, _)| *t > 0.1).collect();
    assert!(known.len() > 500);
    for (t, [chest, left, _]) in known {
        let [x, y] = way(*t);
        // Readings every 20 ms with a noise of 1 mm, of a person at 0.54 m/s.
        let near = |found: Option<f64>, wanted: f64| found.is_some_and(|found| (found - wanted).abs() < 0.02);
        assert!(near(chest[0], x) && near(chest[1], y) && near(chest[2], 0.9), "{t}: {chest:?}");
        assert!(near(left[0], x - 0.1) && near(left[1], y + 0.3) && near(left[2], 0.6), "{t}: {left:?}");
        assert_eq!(chest[3], Some(0.0));
    }
}

#[test]
fn a_person_who_is_lost_is_drawn_with_what_is_not_known() {
    let samples = samples(&page("out of sight"));
    let uncertainty = |from: f64, to: f64| {
        let within = samples.iter().filter(move |(t, _)| (from..to).contains(t));
        within.filter_map(|(_, points)| points[0][3]).fold(0.0, f64::max)
    };
    assert_eq!(uncertainty(0.5, 2.0), 0.0);
    // It grows by 0.5 m/s from the timeout of 0.1 s on, at the latest.
    let lost = uncertainty(2.3, 2.4);
    assert!((0.1..=0.2).contains(&lost), "{lost}");
    assert!(uncertainty(4.0, 8.0) < 1e-3);
}

#[test]
fn nobody_is_drawn_whom_nobody_saw() {
    let program = program("bystander.hq");
    let mut simulation = Simulation::new(&program).expect("it can be executed");
    let mut series = SeriesRecorder::new(simulation.controller(), simulation.ticks(), report::drawn_links(&program));
    let mut summary = SummaryRecorder::new(simulation.controller(), simulation.ticks());
    simulation.run(&mut All(vec![&mut series, &mut summary]), &mut || 0.0, &mut |_| true).expect("no recorder fails");
    let summary = summary.summary(&program, simulation.controller(), Vec::new());
    let page = data(&program, None, &summary, &series);
    assert_eq!(page["scene"]["people"], serde_json::json!([]));
}

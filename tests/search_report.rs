//! Report of a search: roles of people and robots in the chart, the map at several instants, the reward field.

use crate::common::played;

use mission::kinds::search::Search;
use mission::kinds::search::map::map;
use mission::map::{Map, Region, Shade, Shape};
use runtime::missions::MissionRun;
use views::report;

const ROOM: &str = "hierarq 1
mission room : search {
  area [[0, 0], [10, 0], [10, 8], [0, 8]] m
  horizon 200 s
  window 30 s
  states 500
  robot r { start [1, 1] m  speed 1 m/s  sees { within 3 m  rate 0.3 /s } }
  human anna { start [9, 7] m  speed 1 m/s  sees { within 3 m  rate 0.3 /s } }
  object token { count 1  positions [[5, 4]] m }
  wall middle { line [[5, 0], [5, 3]] m }
  source smoke { kind environment  at [8, 2] m  radius 0.5 m  inside { rate -2 /s }  outside { rate -2 /s  fall exponential  scale 0.5 m } }
  source light { at [2, 6] m  radius 0.4 m  inside { rate 1 /s }  outside { rate 1 /s  fall linear  scale 1 m }  pool 3 }
}
scenario s {
  mission room
  duration 100 s
  seed 3
  operations planned
  happens [{ at 2 s  my_goal anna  to [9, 3] m }, { at 4 s  robot_goal r  to [1, 7] m }]
}
";

fn run() -> MissionRun {
    let (mission, scenario) = played::scenario(ROOM);
    played::logged(&mission, &scenario).0
}

/// The sum of the areas of belief, each weighted by the least share of its shade.
fn belief(map: &Map) -> f64 {
    let weight = |shape: &Shape| match shape {
        Shape::Regions { region: Region::Belief(shade), rectangles, .. } => {
            (shade.percent() as f64 - 25.0).max(2.0) * rectangles.len() as f64
        }
        _ => 0.0,
    };
    map.shapes.iter().map(weight).sum()
}

#[test]
fn a_report_shows_roles_and_maps_over_time() {
    let run = run();
    let chart = run.executed.as_ref().expect("a chart");
    let roles = chart.rows.last().expect("a row");
    let names: Vec<&str> = roles.bars.iter().map(|bar| bar.title.as_str()).collect();
    assert_eq!((roles.name.as_str(), &names[..3]), ("roles", &["leader-follower", "peer-to-peer", "master-slave"][..]));
    assert_eq!([roles.bars[1].start, roles.bars[2].start], [2.0, 4.0]);
    assert!(roles.bars.windows(2).all(|two| two[0].end == two[1].start), "roles follow one another");
    assert!(run.planned.as_ref().is_some_and(|chart| chart.rows.iter().all(|row| row.name != "roles")));

    let maps = &run.maps;
    assert!((2..=6).contains(&maps.len()), "{}", maps.len());
    assert_eq!((maps[0].time, &maps[0].positions), (0.0, &vec![[1.0, 1.0], [9.0, 7.0]]));
    let steps: Vec<f64> = maps.windows(2).map(|two| two[1].time - two[0].time).collect();
    assert!(steps.iter().all(|step| *step > 0.0 && (step - steps[0]).abs() < 1e-9), "{steps:?}");
    // Relative to the most likely cell, where nobody has looked, there is less and less.
    assert!(belief(&maps[1].map) < belief(&maps[0].map));

    let page = report::mission("room.hq", &run);
    assert_eq!(page.matches("<figcaption>at").count(), maps.len());
    assert!(page.contains("master-slave") && page.contains("repels-near"));
    if let Ok(path) = std::env::var("HIERARQ_SHOW") {
        std::fs::write(path, page).expect("written");
    }
}

/// The drawn field is that of the rates: what attracts and what repels are each where they are the strongest.
#[test]
fn the_field_is_that_of_the_rates() {
    let (mission, _) = played::scenario(ROOM);
    let problem = &mission.kind.downcast::<Search>().expect("a search").problem;
    let drawn = map(problem, &[]);
    let rate_at = |p: [f64; 2]| {
        let [smoke, light] = [[8.0, 2.0, 0.5], [2.0, 6.0, 0.4]].map(|[x, y, r]| (p[0] - x).hypot(p[1] - y) - r);
        assert!(smoke > 0.0 && light > 0.0, "inside the boundary it is drawn: {p:?}");
        -2.0 * (-smoke / 0.5_f64).exp() + (1.0 - light).max(0.0)
    };
    let mut cells: Vec<(f64, f64, Shade)> = Vec::new();
    for shape in &drawn.shapes {
        let Shape::Regions { region, rectangles, .. } = shape else { continue };
        let (sign, shade) = match region {
            Region::AttractsNear(shade) => (1.0, *shade),
            Region::RepelsNear(shade) => (-1.0, *shade),
            _ => continue,
        };
        for [a, _, c, _] in rectangles {
            cells.push((sign, rate_at([0.5 * (a[0] + c[0]), 0.5 * (a[1] + c[1])]), shade));
        }
    }
    let most = cells.iter().map(|(_, rate, _)| rate.abs()).fold(0.0, f64::max);
    for (sign, rate, shade) in &cells {
        let (share, high) = (sign * rate / most, shade.percent() as f64 / 100.0);
        assert!(share <= high + 1e-9 && share > high - 0.25 - 1e-9, "{share} in {shade:?}");
    }
    assert!(cells.len() > 100 && cells.iter().any(|(sign, ..)| *sign > 0.0), "{}", cells.len());
}

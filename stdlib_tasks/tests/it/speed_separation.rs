//! Speed and separation: the row against differences, its bound against the formula of the standard, people inside.

use hierarq_stdlib_tasks::bound::{Bound, Geometry};
use hierarq_stdlib_tasks::task::TaskFault;
use nalgebra::Vector3;
use proptest::prelude::*;
use robot::{LinkId, Shape};

use crate::common::*;
use crate::limits::shaped;

const PERIOD: f64 = 0.01;

/// T_r with the period, a, C, Z_d, Z_r.
const RULE: [f64; 5] = [0.1 + PERIOD, 3.0, 0.1, 0.05, 0.02];

fn case(
    parts: Vec<Geometry>,
    from: &Vector3<f64>,
    speed: &Vector3<f64>,
    human: &str,
    stop: (&'static str, f64),
) -> Case {
    Case::new("speed_separation")
        .with("parts", Bound::Geometries(parts))
        .moving("from", from.as_slice(), speed.as_slice())
        .with("method", Bound::Choice("slow".to_string()))
        .with("human", Bound::Choice(human.to_string()))
        .number("human_speed", &[1.6])
        .number("reaction", &[RULE[0] - PERIOD])
        .number(stop.0, &[stop.1])
        .number("intrusion", &[RULE[2]])
        .number("human_uncertainty", &[RULE[3]])
        .number("robot_uncertainty", &[RULE[4]])
}

/// S_p as the standard writes it, for a deceleration.
fn separation(robot: f64, human: f64) -> f64 {
    let [reaction, a, c, z_d, z_r] = RULE;
    let (v, h) = (robot.max(0.0), human.max(0.0));
    let stopping = v / a;
    h * (reaction + stopping) + v * reaction + v * v / (2.0 * a) + c + z_d + z_r
}

/// The greatest speed with which a distance is enough, by halving.
fn fastest(distance: f64, human: f64) -> f64 {
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if separation(middle, human) <= distance { low = middle } else { high = middle }
    }
    low
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn the_row_is_the_rate_of_the_distance_and_its_bound_is_the_standards(seed in any::<u64>()) {
        let mut rng = rng(seed);
        for model in robots() {
            let [left, right] = arms(&model);
            let ball = shaped("ball", right.tip, Shape::Sphere { radius: 0.06 }, &mut rng);
            let parts = vec![point(left.tip, &mut rng), ball.clone()];
            let place = Place::new(&model, &model.random_configuration(&mut rng));
            let (from, speed) = (vector(&mut rng, 2.0), vector(&mut rng, 1.0));
            let v = velocity(&model, &mut rng, 1.0);
            for human in ["assumed", "measured"] {
                let case = case(parts.clone(), &from, &speed, human, ("deceleration", RULE[1]));
                let mut task = case.build(&model);
                let Ok(w) = place.write(&mut *task, &case, 0.0) else { continue };
                for (i, part) in parts.iter().enumerate() {
                    let radius = if i == 1 { 0.06 } else { 0.0 };
                    let at = |p: &Place| (p.data.pose(part.link) * part.center()).coords;
                    let distance = |p: &Place| (at(p) - from).norm() - radius;
                    let d = distance(&place);
                    prop_assume!(d > 1e-3);
                    let h = 1e-6;
                    let rate = (distance(&place.moved(&v, h)) - distance(&place.moved(&v, -h))) / (2.0 * h);
                    prop_assert!((w.rate(i, &v) - rate).abs() < 1e-5, "{} {rate}", w.rate(i, &v));
                    let towards = (at(&place) - from).normalize().dot(&speed);
                    let comes = if human == "assumed" { 1.6 } else { towards };
                    prop_assert!((w.lower[i] + fastest(d, comes)).abs() < 1e-9, "{} {}", w.lower[i], fastest(d, comes));
                    prop_assert!((w.margins[i] - (d - separation(0.0, comes))).abs() < 1e-9);
                    // The margin for a velocity is what is left of the distance: none where the row is just met.
                    let values = case.values_at(0.0);
                    let (mut margins, scale) = (vec![0.0; 2], w.lower[i] / w.rate(i, &v));
                    let met: Vec<f64> = v.iter().map(|x| x * scale).collect();
                    task.observe(&place.state(&values, &case.rates), &met, &mut margins, &mut []);
                    if w.lower[i] < -1e-6 && scale.is_finite() {
                        prop_assert!(margins[i].abs() < 1e-8, "{}", margins[i]);
                    }
                }
            }
        }
    }
}

#[test]
fn zero_velocity_is_always_allowed() {
    let mut rng = rng(5);
    for model in robots() {
        let [left, _] = arms(&model);
        for reach in [0.01, 0.3, 3.0] {
            let from = vector(&mut rng, reach);
            let case = case(vec![point(left.tip, &mut rng)], &from, &Vector3::zeros(), "assumed", ("stopping", 0.4));
            let place = Place::new(&model, &model.random_configuration(&mut rng));
            let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
            assert!(w.lower[0] <= 0.0 && w.upper[0] == f64::INFINITY);
        }
    }
}

#[test]
fn a_person_inside_a_part() {
    let model = arm7();
    let link: LinkId = model.link("tool").unwrap();
    let box_ = Geometry {
        name: "box".into(),
        link,
        origin: nalgebra::Isometry3::identity(),
        shape: Shape::Capsule { radius: 0.0, half_length: 0.1 },
    };
    let place = Place::new(&model, &model.neutral());
    let inside = place.point(link);
    let mut case =
        case(vec![box_], &(inside + Vector3::new(1.0, 0.0, 0.0)), &Vector3::zeros(), "assumed", ("stopping", 0.4));
    let mut task = case.build(&model);
    let free = place.write(&mut *task, &case, 0.0).unwrap();
    case.set("from", inside.as_slice());
    let met = place.write(&mut *task, &case, 0.0).unwrap();
    assert!(
        (met.j.norm() - free.j.norm()).abs() < 1.0 && met.lower[0] == 0.0 && met.margins[0] < 0.0,
        "the last way out"
    );
    let mut fresh = case.build(&model);
    assert!(matches!(place.write(&mut *fresh, &case, 0.0), Err(TaskFault::Overlap { row: 0 })));
    case.set("from", &[f64::NAN, 0.0, 0.0]);
    assert!(matches!(place.write(&mut *task, &case, 0.0), Err(TaskFault::NotFinite { row: 0 })));
}

#[test]
fn stopping_is_said_once() {
    let model = arm7();
    let [left, _] = arms(&model);
    let parts = vec![Geometry::point("a", left.tip, Vector3::zeros())];
    let good = case(parts, &Vector3::new(2.0, 0.0, 0.0), &Vector3::zeros(), "assumed", ("stopping", 0.4));
    let build = |case: &Case| case.build_for(&model, PERIOD, &[]).map(drop);
    assert!(build(&good).is_ok());
    assert_eq!(build(&good.clone().number("deceleration", &[2.0])).unwrap_err().param, "stopping");
    let mut none = good;
    none.params.remove("stopping");
    assert!(build(&none).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Outputs against the formula of the standard, part by part.
    #[test]
    fn what_is_told_is_of_the_part_that_has_the_least(seed in any::<u64>()) {
        let mut rng = rng(seed);
        for model in robots() {
            let [left, right] = arms(&model);
            let parts = vec![point(left.tip, &mut rng), point(right.tip, &mut rng), point(left.tip, &mut rng)];
            let place = Place::new(&model, &model.random_configuration(&mut rng));
            let (from, speed) = (vector(&mut rng, 2.0), vector(&mut rng, 1.0));
            let v = velocity(&model, &mut rng, 1.0);
            for (human, method) in [("assumed", "slow"), ("measured", "slow"), ("measured", "watch")] {
                let mut case = case(parts.clone(), &from, &speed, human, ("deceleration", RULE[1]));
                case.params.insert("method".to_string(), Bound::Choice(method.to_string()));
                let mut task = case.build(&model);
                let Ok(w) = place.write(&mut *task, &case, 0.0) else { continue };
                // A machine acts one period later than a row.
                let later = if method == "watch" { PERIOD } else { 0.0 };
                let (mut tightest, mut room, mut limit) = ((f64::INFINITY, 0.0, 0.0), f64::INFINITY, f64::INFINITY);
                for (i, part) in parts.iter().enumerate() {
                    let to = (place.data.pose(part.link) * part.center()).coords - from;
                    let comes = if human == "assumed" { 1.6 } else { to.normalize().dot(&speed) };
                    let approach = -w.rate(i, &v);
                    let needs = |robot: f64| separation(robot, comes) + later * (comes.max(0.0) + robot.max(0.0));
                    if to.norm() - needs(approach) < tightest.0 {
                        tightest = (to.norm() - needs(approach), to.norm(), needs(approach));
                    }
                    room = room.min(to.norm() - needs(0.0));
                    if later == 0.0 {
                        limit = limit.min(fastest(to.norm(), comes));
                    }
                    prop_assert_eq!(w.lower[i] == f64::NEG_INFINITY, method == "watch");
                }
                let mut told = [f64::NAN; 4];
                task.write_outputs(&place.state(&case.values_at(0.0), &case.rates), &v, &mut told);
                prop_assert!((told[0] - tightest.1).abs() < 1e-9 && (told[1] - tightest.2).abs() < 1e-9, "{told:?} {tightest:?}");
                prop_assert!((told[2] - room).abs() < 1e-9, "{told:?} {room}");
                prop_assert!(later > 0.0 || (told[3] - limit).abs() < 1e-9, "{told:?} {limit}");
            }
        }
    }
}

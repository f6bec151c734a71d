//! `admittance` and `hand_guiding`: rows against central differences, motions against the closed solution of a mass on a
//! spring with a damper, what switching does, and where the motion comes to rest.

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::compliance::{Axis, Drive};
use hierarq_stdlib_tasks::task::{State, Task, TaskFault};
use nalgebra::{Matrix2, Vector3};
use proptest::prelude::*;
use robot::{Base, LinkId, Model};

use crate::common::*;

const THESIS: [&[f64]; 3] = [&[20.0, 3.0], &[253.0, 27.0], &[800.0, 60.0]];

/// Three slides, then three hinges through one point: near zero each row of a pose is one joint.
fn gantry() -> Model {
    let axes = ["1 0 0", "0 1 0", "0 0 1"];
    let mut urdf = String::from(r#"<robot name="gantry"><link name="l0"/>"#);
    for i in 0..6 {
        let (kind, axis) = (if i < 3 { "prismatic" } else { "revolute" }, axes[i % 3]);
        urdf.push_str(&format!(
            r#"<link name="l{}"/><joint name="j{i}" type="{kind}"><parent link="l{i}"/><child link="l{}"/><axis xyz="{axis}"/>
            <limit lower="-9" upper="9" velocity="9" effort="9"/></joint>"#,
            i + 1,
            i + 1
        ));
    }
    read(&(urdf + "</robot>"), Base::Fixed)
}

fn frame(link: LinkId) -> Bound {
    Bound::Frame("frame".to_string(), link)
}

/// A target that is where the frame is.
fn aimed(case: Case, place: &Place, link: LinkId) -> Case {
    let pose = place.data.pose(link);
    let (p, r) = (pose.translation.vector, pose.rotation);
    case.group("target", &[("position", p.as_slice()), ("orientation", &[r.w, r.i, r.j, r.k])])
}

fn admittance(place: &Place, link: LinkId, body: [&[f64]; 3], wrench: [&[f64]; 2]) -> Case {
    aimed(Case::new("admittance").with("frame", frame(link)), place, link).body(body, wrench)
}

fn built(case: &Case, model: &Model, period: f64) -> Box<dyn Task> {
    case.build_for(model, period, &vec![f64::INFINITY; model.nv()]).unwrap()
}

/// One tick: the place after it, which remembers the velocity.
fn tick<'m>(place: &Place<'m>, task: &mut dyn Task, case: &Case, period: f64) -> Place<'m> {
    let v = follow(&place.write(task, case, 0.0).unwrap());
    let mut next = place.moved(&v, period);
    next.velocity = v;
    next
}

/// Displacement of a mass on a spring with a damper under a force f that begins at time zero: the textbook's
/// underdamped solution.
fn swing(axis: &Axis, f: f64, t: f64) -> f64 {
    let (natural, decay) = (axis.stiffness / axis.mass, axis.damping / (2.0 * axis.mass));
    let w = (natural - decay * decay).sqrt();
    f / axis.stiffness * (1.0 - (-decay * t).exp() * ((w * t).cos() + decay / w * (w * t).sin()))
}

/// The largest difference to the closed solution within two seconds, for six axes, each with its own numbers.
fn worst(period: f64) -> [f64; 6] {
    let model = gantry();
    let link = model.link("l6").unwrap();
    let axes: Vec<Axis> = (0..6)
        .map(|i| {
            let x = f64::from(i);
            Axis { mass: 2.0 + x, damping: 8.0 + 2.0 * x, stiffness: 200.0 + 50.0 * x }
        })
        .collect();
    // One hinge alone turns: closed solutions of turns exist about one axis.
    let force = [10.0, -7.0, 4.0, 0.0, 0.0, 9.0];
    let of = |f: fn(&Axis) -> f64| axes.iter().map(f).collect::<Vec<f64>>();
    let (m, d, k) = (of(|a| a.mass), of(|a| a.damping), of(|a| a.stiffness));
    let mut place = Place::new(&model, &model.neutral());
    let mut case = admittance(&place, link, [&[1.0, 1.0], &[1.0, 1.0], &[1.0, 1.0]], [&force[..3], &force[3..]]);
    for (name, all) in [("mass", &m), ("damping", &d), ("stiffness", &k)] {
        case.set(&format!("{name}.linear"), &all[..3]);
        case.set(&format!("{name}.angular"), &all[3..]);
    }
    let mut task = built(&case, &model, period);
    let mut worst = [0.0_f64; 6];
    for n in 1..=(2.0 / period).round() as usize {
        place = tick(&place, &mut *task, &case, period);
        for (i, worst) in worst.iter_mut().enumerate() {
            *worst = worst.max((place.q[i] - swing(&axes[i], force[i], n as f64 * period)).abs());
        }
    }
    worst
}

#[test]
fn a_step_of_force_is_answered_as_by_a_mass_on_a_spring() {
    let (coarse, fine) = (worst(2e-3), worst(1e-3));
    for (i, (a, b)) in coarse.iter().zip(&fine).enumerate() {
        if i == 3 || i == 4 {
            assert!(*a < 1e-12, "{a}");
            continue;
        }
        // Millimetres and milliradians of centimetres, and half as much with half the period.
        assert!(*b < 1e-3 && *b > 1e-6, "{b}");
        assert!((a / b - 2.0).abs() < 0.06, "axis {i}: {a} and {b}");
    }
}

#[test]
fn a_steady_wrench_displaces_by_the_compliance() {
    for model in [gantry(), arm7(), canopies(Base::Fixed)] {
        let link = model.link("l6").or(model.link("tool")).or(model.link("left_tool")).unwrap();
        let mut q = model.neutral();
        for (i, x) in q.iter_mut().enumerate().skip(if model.nv() == 6 { 6 } else { 0 }) {
            *x = [0.4, 0.7, -0.5, -1.1, 0.6, 0.8, 0.3][i % 7];
        }
        let home = Place::new(&model, &q);
        let (f, mu) = ([20.0, -10.0, 5.0], [0.0, 0.0, 6.0]);
        let case = admittance(&home, link, THESIS, [&f, &mu]);
        let mut task = built(&case, &model, 0.01);
        let mut place = home.moved(&vec![0.0; model.nv()], 0.0);
        for _ in 0..1200 {
            place = tick(&place, &mut *task, &case, 0.01);
        }
        let (a, b) = (home.data.pose(link), place.data.pose(link));
        let moved = b.translation.vector - a.translation.vector;
        assert!((moved - Vector3::from(f) / 800.0).norm() < 1e-9, "{moved}");
        let turned = (b.rotation * a.rotation.inverse()).scaled_axis();
        assert!((turned - Vector3::from(mu) / 60.0).norm() < 1e-9, "{turned}");
        let w = place.write(&mut *task, &case, 0.0).unwrap();
        assert!((w.measures[0] - moved.norm()).abs() < 1e-12 && (w.measures[1] - turned.norm()).abs() < 1e-9);
    }
}

#[test]
fn a_hand_leads_at_force_over_damping_and_the_frame_stays_where_it_was_led() {
    let model = gantry();
    let link = model.link("l6").unwrap();
    let (f, mu) = ([25.3, 0.0, -12.65], [0.0, 0.0, 2.7]);
    let mut case = Case::new("hand_guiding").with("frame", frame(link)).body([THESIS[0], THESIS[1], &[]], [&f, &mu]);
    let mut task = built(&case, &model, 0.01);
    let mut place = Place::new(&model, &model.neutral());
    for _ in 0..300 {
        place = tick(&place, &mut *task, &case, 0.01);
    }
    for (v, expected) in place.velocity.iter().zip([0.1, 0.0, -0.05, 0.0, 0.0, 0.1]) {
        assert!((v - expected).abs() < 1e-9, "{:?}", place.velocity);
    }
    case.set("wrench.force", &[0.0; 3]);
    case.set("wrench.moment", &[0.0; 3]);
    // Momentum over damping is how far it runs on.
    let (q, v) = (place.q.clone(), place.velocity.clone());
    for _ in 0..300 {
        place = tick(&place, &mut *task, &case, 0.01);
    }
    for i in 0..6 {
        let run_out = if i < 3 { 20.0 / 253.0 } else { 3.0 / 27.0 } * v[i];
        assert!((place.q[i] - q[i] - run_out).abs() < 1e-9 && place.velocity[i].abs() < 1e-9);
    }
    // Held back by half, it reports the other half.
    place.velocity = v.clone();
    case.set("wrench.force", &f);
    case.set("wrench.moment", &mu);
    place.write(&mut *task, &case, 0.0).unwrap();
    let half: Vec<f64> = v.iter().map(|x| 0.5 * x).collect();
    let mut measures = [0.0; 2];
    task.observe(&place.state(&case.values, &case.rates), &half, &mut [], &mut measures);
    assert!((measures[0] - 0.5 * 0.1_f64.hypot(0.05)).abs() < 1e-9 && (measures[1] - 0.05).abs() < 1e-9);
}

/// Linear and angular velocity of a frame along `v`, by central differences.
fn slope(place: &Place, link: LinkId, v: &[f64]) -> [Vector3<f64>; 2] {
    let h = 1e-6;
    let (before, after) = (place.moved(v, -h), place.moved(v, h));
    let turn = after.data.pose(link).rotation * before.data.pose(link).rotation.inverse();
    [(after.point(link) - before.point(link)) / (2.0 * h), turn.scaled_axis() / (2.0 * h)]
}

#[test]
fn rows_are_those_of_the_frame_and_the_right_side_is_the_law() {
    let mut rng = rng(92);
    let period = 0.004;
    for model in robots() {
        let [arm, _] = arms(&model);
        for q in configurations(&model, 4, &mut rng) {
            let mut place = Place::new(&model, &q);
            place.velocity = velocity(&model, &mut rng, 1.0);
            let v_last = place.velocity.clone();
            let [m, d, k, h] =
                [5.0, 40.0, 300.0, 9.0].map(|top: f64| (0..6).map(|_| top * (0.2 + rng())).collect::<Vec<_>>());
            let with = |name: &'static str| {
                let case = Case::new(name).with("frame", frame(arm.tip));
                let all = [("mass", &m), ("damping", &d), ("stiffness", &k)];
                let all = &all[..if name == "admittance" { 3 } else { 2 }];
                let case = all.iter().fold(case, |c, (n, x)| c.group(n, &[("linear", &x[..3]), ("angular", &x[3..])]));
                case.group("wrench", &[("force", &h[..3]), ("moment", &h[3..])])
            };
            let mut case = with("admittance").pose("target", &mut rng);
            let mut task = built(&case, &model, period);
            task.enter(&place.state(&case.values, &case.rates));
            // Velocities of the target at two ticks, by differences of what the case says of it.
            let moving = |case: &Case| {
                let at = |path: &str, t: f64| {
                    let s = case.place(path);
                    case.values_at(t)[s.at..s.at + s.len].to_vec()
                };
                let e = 1e-6;
                let p = |t: f64| Vector3::from_row_slice(&at("target.position", t));
                let r = |t: f64| quaternion(&at("target.orientation", t));
                let turn = (r(e) * r(-e).inverse()).scaled_axis();
                ([p(0.0), (p(e) - p(-e)) / (2.0 * e)], (r(0.0), turn / (2.0 * e)))
            };
            let first = moving(&case);
            let entered = place.write(&mut *task, &case, 0.0).unwrap();
            for path in ["target.position", "target.orientation"] {
                let s = case.place(path);
                case.rates[s.at..s.at + s.len].iter_mut().for_each(|x| *x += 0.2 * (rng() - 0.5));
            }
            let second = moving(&case);
            let later = place.write(&mut *task, &case, 0.0).unwrap();
            let led = with("hand_guiding");
            let guided = place.write(&mut *built(&led, &model, period), &led, 0.0).unwrap();

            let v = velocity(&model, &mut rng, 1.0);
            let (along, last) = (slope(&place, arm.tip, &v), slope(&place, arm.tip, &v_last));
            let pose = place.data.pose(arm.tip);
            for (w, now, before) in [(&entered, &first, &first), (&later, &second, &first)] {
                let turn = now.1.0 * pose.rotation.inverse();
                let error = [now.0[0] - pose.translation.vector, turn.scaled_axis()];
                if error[1].norm() > 3.1 {
                    continue;
                }
                let (v_d, was) = ([now.0[1], now.1.1], [before.0[1], before.1.1]);
                for i in 0..6 {
                    let (part, a) = (i / 3, i % 3);
                    assert!((w.rate(i, &v) - along[part][a]).abs() < 1e-7, "row {i}");
                    assert_eq!(w.lower[i], w.upper[i]);
                    // mathematics, correction 7: the law with the velocity that was asked for leaves nothing over.
                    let asked = w.lower[i];
                    let a_d = (v_d[part][a] - was[part][a]) / period;
                    let acceleration = (asked - last[part][a]) / period;
                    let law = m[i] * (a_d - acceleration) + d[i] * (v_d[part][a] - asked) + k[i] * error[part][a];
                    assert!((law + h[i]).abs() < 1e-5 * m[i] / period, "row {i}: {law} and {}", h[i]);
                }
            }
            for i in 0..6 {
                let (part, a) = (i / 3, i % 3);
                assert!((guided.rate(i, &v) - along[part][a]).abs() < 1e-7);
                let law = m[i] * (last[part][a] - guided.lower[i]) / period - d[i] * guided.lower[i];
                assert!((law + h[i]).abs() < 1e-5 * m[i] / period);
            }
        }
    }
}

#[test]
fn a_target_that_moves_evenly_is_followed_without_a_lag() {
    let model = gantry();
    let link = model.link("l6").unwrap();
    let period = 0.01;
    let mut place = Place::new(&model, &model.neutral());
    let mut case = admittance(&place, link, THESIS, [&[0.0; 3], &[0.0; 3]]);
    let slot = case.place("target.position");
    case.rates[slot.at] = 0.2;
    let mut task = built(&case, &model, period);
    for n in 0..800 {
        let v = follow(&place.write(&mut *task, &case, f64::from(n) * period).unwrap());
        place = place.moved(&v, period);
        place.velocity = v;
    }
    assert!((place.q[0] - 8.0 * 0.2).abs() < 1e-9, "{}", place.q[0]);
}

#[test]
fn switching_parameters_and_tasks_leaves_the_velocity_continuous() {
    let model = arm7();
    let link = model.link("tool").unwrap();
    let period = 0.01;
    let mut rng = rng(93);
    let home = Place::new(&model, &[0.2, 0.5, -0.3, -1.2, 0.4, 0.9, 0.1]);
    let sizes: [[f64; 6]; 4] = [
        [20.0, 3.0, 253.0, 27.0, 800.0, 60.0],
        [2.0, 0.3, 50.0, 5.0, 20.0, 1.0],
        [60.0, 9.0, 900.0, 90.0, 3000.0, 200.0],
        [5.0, 1.0, 20.0, 3.0, 500.0, 40.0],
    ];
    let (mut place, mut fastest) = (home.moved(&[0.0; 7], 0.0), 0.0_f64);
    let guiding = Case::new("hand_guiding").with("frame", frame(link));
    let mut cases = [
        admittance(&home, link, THESIS, [&[0.0; 3], &[0.0; 3]]),
        guiding.body([THESIS[0], THESIS[1], &[]], [&[0.0; 3], &[0.0; 3]]),
    ];
    let mut tasks = cases.clone().map(|c| built(&c, &model, period));
    for n in 0..600 {
        let s = sizes[(rng() * 4.0) as usize % 4];
        let which = usize::from(n % 50 >= 35);
        let (f, mu) = ([15.0 * (0.02 * f64::from(n)).sin(), 8.0, -5.0], [0.5, 0.0, (0.03 * f64::from(n)).cos()]);
        for case in &mut cases {
            for (i, name) in ["mass", "damping", "stiffness"].iter().enumerate() {
                if case.params.contains_key(*name) {
                    case.set(&format!("{name}.linear"), &[s[2 * i]; 3]);
                    case.set(&format!("{name}.angular"), &[s[2 * i + 1]; 3]);
                }
            }
            case.set("wrench.force", &f);
            case.set("wrench.moment", &mu);
        }
        // Another stack becomes active: its task begins anew.
        if n % 50 == 35 || n % 50 == 0 {
            tasks[which].enter(&place.state(&cases[which].values, &cases[which].rates));
        }
        let w = place.write(&mut *tasks[which], &cases[which], 0.0).unwrap();
        let before = slope(&place, link, &place.velocity);
        let pose = (home.data.pose(link), place.data.pose(link));
        let error = [
            pose.0.translation.vector - pose.1.translation.vector,
            (pose.0.rotation * pose.1.rotation.inverse()).scaled_axis(),
        ];
        for i in 0..6 {
            let (part, a) = (i / 3, i % 3);
            let spring = if which == 0 { s[4 + part] * error[part][a].abs() } else { 0.0 };
            let h = if part == 0 { f[a] } else { mu[a] };
            // No more than force over mass can change a velocity within a tick.
            let most = period * (spring + s[2 + part] * before[part][a].abs() + h.abs()) / s[part];
            let change = (w.lower[i] - before[part][a]).abs();
            assert!(change <= most + 1e-7, "row {i} at tick {n}: {change} of {most}");
        }
        fastest = fastest.max(before[0].norm());
        let v = follow(&w);
        place = place.moved(&v, period);
        place.velocity = v;
    }
    assert!(fastest > 0.05, "the test could fail: {fastest}");
}

proptest! {
    /// Stable is what the eigenvalues of one tick say.
    #[test]
    fn it_comes_to_rest_where_both_eigenvalues_are_inside_the_circle(
        m in 0.01..100.0f64, d in 0.01..1000.0f64, share in 0.0..2.0f64, period in 1e-4..0.1f64,
    ) {
        let bound = Axis { mass: m, damping: d, stiffness: 0.0 }.stiffness_bound(period);
        let axis = Axis { mass: m, damping: d, stiffness: share * bound };
        prop_assume!((share - 1.0).abs() > 1e-3 && share > 1e-3);
        let next = |x: f64, v: f64| {
            let v = axis.velocity(period, &Drive { before: v, velocity: 0.0, change: 0.0, error: -x, force: 0.0 });
            [x + period * v, v]
        };
        let tick = Matrix2::from_columns(&[next(1.0, 0.0).into(), next(0.0, 1.0).into()]);
        let largest = tick.complex_eigenvalues().iter().map(|z| z.norm()).fold(0.0, f64::max);
        prop_assert_eq!(axis.comes_to_rest(period), largest < 1.0, "{}", largest);
    }
}

#[test]
fn what_is_no_number_or_no_body_is_a_fault() {
    let model = arm7();
    let link = model.link("tool").unwrap();
    let home = Place::new(&model, &[0.2, 0.5, -0.3, -1.2, 0.4, 0.9, 0.1]);
    let good = admittance(&home, link, THESIS, [&[1.0, 0.0, 0.0], &[0.0; 3]]);
    let fault = |path: &str, values: &[f64]| {
        let mut task = built(&good, &model, 0.01);
        let mut case = good.clone();
        case.set(path, values);
        home.write(&mut *task, &case, 0.0).err()
    };
    assert_eq!(fault("wrench.force", &[0.0; 3]), None);
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(fault("wrench.force", &[0.0, x, 0.0]), Some(TaskFault::NotFinite { row: 1 }));
        assert_eq!(fault("wrench.moment", &[0.0, 0.0, x]), Some(TaskFault::NotFinite { row: 5 }));
    }
    assert_eq!(fault("stiffness.linear", &[800.0, 800.0, 9e5]), Some(TaskFault::Gain { row: 2 }));
    assert_eq!(fault("stiffness.angular", &[-1.0, 60.0, 60.0]), Some(TaskFault::Gain { row: 3 }));
    assert_eq!(fault("mass.linear", &[-20.0, 20.0, 20.0]), Some(TaskFault::Gain { row: 0 }));
    assert_eq!(fault("damping.linear", &[0.0, 253.0, 253.0]), Some(TaskFault::Gain { row: 0 }));
    assert_eq!(fault("stiffness.linear", &[0.0; 3]), None);
}

#[test]
fn entering_forgets_how_the_target_moved() {
    let model = arm7();
    let link = model.link("tool").unwrap();
    let home = Place::new(&model, &[0.2, 0.5, -0.3, -1.2, 0.4, 0.9, 0.1]);
    let mut case = admittance(&home, link, THESIS, [&[0.0; 3], &[0.0; 3]]);
    let mut task = built(&case, &model, 0.01);
    let enter = |task: &mut dyn Task, case: &Case| {
        let state: State = home.state(&case.values, &case.rates);
        task.enter(&state);
    };
    enter(&mut *task, &case);
    home.write(&mut *task, &case, 0.0).unwrap();
    let slot = case.place("target.position");
    case.rates[slot.at] = 0.1;
    // A target that starts at once takes the mass with it; one that moved already at the first tick drags it by the damper.
    let jumped = home.write(&mut *task, &case, 0.0).unwrap().lower[0];
    assert!((jumped - 0.1).abs() < 1e-12, "{jumped}");
    enter(&mut *task, &case);
    let dragged = home.write(&mut *task, &case, 0.0).unwrap().lower[0];
    assert!((dragged - 0.1 * 2.53 / (20.0 + 2.53)).abs() < 1e-12, "{dragged}");
}

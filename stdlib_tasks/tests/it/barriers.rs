//! Barriers under attack: at every tick the fastest motion that a row still allows, mixed with any other, never takes
//! the margin below zero, or below the loss that was announced where nothing is held in reserve.

use hierarq_stdlib_tasks::bound::{Bound, Geometry};
use hierarq_stdlib_tasks::clearance;
use hierarq_stdlib_tasks::task::Task;
use nalgebra::{Isometry3, Translation3};
use robot::{Base, DofUnit, Model, Shape};

use crate::common::*;
use crate::limits::{collision, middle, shaped, wall};

const PERIOD: f64 = 0.02;

/// A speed for every degree of freedom.
fn speeds(model: &Model) -> Vec<f64> {
    let base = |unit| if unit == DofUnit::Radian { 0.8 } else { 0.6 };
    model.dofs.iter().map(|d| if d.velocity.is_finite() { d.velocity } else { base(d.unit) }).collect()
}

/// A point and a ball at the tips.
fn attackers(model: &Model, rng: &mut impl FnMut() -> f64) -> Vec<Geometry> {
    let [left, right] = arms(model);
    vec![point(left.tip, rng), shaped("ball", right.tip, Shape::Sphere { radius: 0.05 }, rng)]
}

fn cases(model: &Model, rng: &mut impl FnMut() -> f64) -> Vec<Case> {
    let head = middle(model);
    let slab = Geometry {
        name: "slab".to_string(),
        link: head,
        origin: Isometry3::from_parts(Translation3::new(0.1, 0.0, 0.0), rotation(rng)),
        shape: Shape::Box { half: [0.2, 0.1, 0.05] },
    };
    let rod = shaped("rod", head, Shape::Capsule { radius: 0.04, half_length: 0.15 }, rng);
    let all = attackers(model, rng);
    vec![
        wall(all[..1].to_vec(), None, (0.0, 0.0), rng),
        wall(all[1..].to_vec(), None, (0.0, 0.0), rng),
        wall(all[..1].to_vec(), Some(head), (0.0, 0.0), rng),
        collision(all[..1].to_vec(), vec![slab], (0.05, 0.0)),
        collision(vec![rod], all[1..].to_vec(), (0.05, 0.0)),
        collision(all[..1].to_vec(), all[1..].to_vec(), (0.1, 0.0)),
        wall(all[1..].to_vec(), Some(head), (0.0, 0.05), rng),
        collision(all[..1].to_vec(), all[1..].to_vec(), (0.1, -0.05)),
    ]
}

/// Speeds as they are now: a sliding joint does not leave its range.
fn allowed(place: &Place, speed: &[f64]) -> Vec<(f64, f64)> {
    let ends = place.model.dofs.iter().zip(speed).map(|(d, &s)| match (d.unit, d.q_index) {
        (DofUnit::Metre, Some(q)) => {
            let (low, high) = ((d.lower - place.q[q]) / PERIOD, (d.upper - place.q[q]) / PERIOD);
            ((-s).max(low.min(0.0)), s.min(high.max(0.0)))
        }
        _ => (-s, s),
    });
    ends.collect()
}

/// A corner of the box of speeds, moved towards the one that lowers (or raises) the margin fastest until the row is
/// met exactly; none where the row cannot be met at these speeds.
fn attack(row: &[f64], lower: f64, bounds: &[(f64, f64)], rng: &mut impl FnMut() -> f64) -> Option<Vec<f64>> {
    let rate = |v: &[f64]| row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
    let corner: Vec<f64> = bounds.iter().map(|b| if rng() < 0.5 { b.0 } else { b.1 }).collect();
    let now = rate(&corner);
    let sinks = now > lower;
    let end_of = |(b, r): (&(f64, f64), &f64)| if (*r > 0.0) == sinks { b.0 } else { b.1 };
    let goal: Vec<f64> = bounds.iter().zip(row).map(end_of).collect();
    let end = rate(&goal);
    if sinks && end > lower {
        return Some(goal);
    }
    if !sinks && end < lower {
        return None;
    }
    let share = if end == now { 0.0 } else { ((lower - now) / (end - now)).clamp(0.0, 1.0) };
    Some(corner.iter().zip(&goal).map(|(a, b)| a + share * (b - a)).collect())
}

/// The lowest margin of a run from a safe start, where each step is the worst of a few that the row allows.
fn lowest(task: &mut dyn Task, case: &Case, start: Place, speed: &[f64], rng: &mut impl FnMut() -> f64) -> f64 {
    let mut place = start;
    let mut lowest = f64::INFINITY;
    for tick in 0..70 {
        let t = f64::from(tick) * PERIOD;
        let Ok(w) = place.write(task, case, t) else { break };
        lowest = lowest.min(w.margins[0]);
        let row: Vec<f64> = w.j.row(0).iter().copied().collect();
        let bounds = allowed(&place, speed);
        let mut worst: Option<(f64, Place)> = None;
        for _ in 0..4 {
            let Some(v) = attack(&row, w.lower[0], &bounds, rng) else { continue };
            let next = place.moved(&v, PERIOD);
            let Ok(then) = next.write(task, case, t + PERIOD) else { continue };
            if worst.as_ref().is_none_or(|(h, _)| then.margins[0] < *h) {
                worst = Some((then.margins[0], next));
            }
        }
        let Some((_, next)) = worst else { break };
        place = next;
    }
    lowest
}

/// Runs every case and checks its lowest margin and announced loss; gives the lowest margin in units of the loss.
fn runs(auto: bool, seed: u64, check: impl Fn(f64, f64, &str)) -> f64 {
    let mut rng = rng(seed);
    let mut worst = 0.0_f64;
    for model in [arm7(), canopies(Base::Unicycle), canopies(Base::Planar), canopies(Base::Floating)] {
        let speed = speeds(&model);
        for _ in 0..2 {
            for mut case in cases(&model, &mut rng) {
                case.set("sampled_margin", &[0.0]);
                if auto {
                    case = case.with("sampled_margin", Bound::Choice("auto".to_string()));
                }
                let mut task = case.build_for(&model, PERIOD, &speed).unwrap();
                let loss = task.sampled_loss()[0];
                assert!(loss.is_finite() && loss > 0.0);
                assert_eq!(task.sampled_margin()[0], if auto { loss } else { 0.0 });
                let start = (0..200).find_map(|_| {
                    let place = Place::new(&model, &model.random_configuration(&mut rng));
                    let h = place.write(&mut *task, &case, 0.0).ok()?.margins[0];
                    (0.0..0.3).contains(&h).then_some(place)
                });
                let Some(start) = start else { continue };
                let h = lowest(&mut *task, &case, start, &speed, &mut rng);
                check(h, loss, case.name);
                worst = worst.min(h / loss);
            }
        }
    }
    worst
}

#[test]
fn an_automatic_reserve_keeps_the_margin_at_or_above_zero() {
    runs(true, 41, |h, _, name| assert!(h >= -1e-12, "{name}: {h}"));
}

#[test]
fn without_a_reserve_no_more_is_lost_than_announced() {
    let worst = runs(false, 42, |h, loss, name| assert!(h >= -loss - 1e-12, "{name}: {h} beyond {loss}"));
    assert!(worst < -1e-3, "the attack is no attack: {worst}");
}

#[test]
fn a_reserve_follows_a_gain_that_moves() {
    // The same reserve in m/s at every gain: `φ δ = A T / 2`.
    let mut rng = rng(43);
    let model = canopies(Base::Planar);
    let mut case = cases(&model, &mut rng).remove(0).with("sampled_margin", Bound::Choice("auto".to_string()));
    let slot = case.place("gain");
    case.rates[slot.at] = 1.0;
    let mut task = case.build_for(&model, PERIOD, &speeds(&model)).unwrap();
    let place = Place::new(&model, &model.random_configuration(&mut rng));
    let kept = |w: &Written, gain: f64| w.lower[0] + gain * w.margins[0];
    let now = place.write(&mut *task, &case, 0.0).unwrap();
    let later = place.write(&mut *task, &case, 3.0).unwrap();
    assert!(kept(&now, 5.0) > 0.0);
    assert!((kept(&now, 5.0) - kept(&later, 8.0)).abs() < 1e-9);
    assert!((kept(&now, 5.0) - 5.0 * task.sampled_margin()[0]).abs() < 1e-9);
}

#[test]
fn joints_never_pass_their_limits() {
    let mut rng = rng(44);
    for model in [arm7(), canopies(Base::Unicycle)] {
        // φ T = 1, the largest gain that keeps a linear margin.
        let case = Case::new("joint_position_limits").number("gain", &[1.0 / PERIOD]);
        let mut task = case.build_for(&model, PERIOD, &speeds(&model)).unwrap();
        let dofs: Vec<usize> = task.rows().iter().map(|r| model.dof(&r.name).unwrap()).collect();
        let mut place = Place::new(&model, &model.random_configuration(&mut rng));
        let mut touched = false;
        for _ in 0..300 {
            let w = place.write(&mut *task, &case, 0.0).unwrap();
            let mut v = vec![0.0; model.nv()];
            for (i, &dof) in dofs.iter().enumerate() {
                let s = model.dofs[dof].velocity;
                let wish = if (dof + model.nv()) % 2 == 0 { s } else { -s };
                v[dof] = wish.clamp(w.lower[i], w.upper[i]);
                assert!(w.margins[i] >= -1e-12);
                touched |= w.margins[i] < 1e-9;
            }
            place = place.moved(&v, PERIOD);
        }
        assert!(touched, "no limit was reached");
    }
}

#[test]
fn a_joint_outside_its_limits_is_driven_back() {
    let model = arm7();
    let case = Case::new("joint_position_limits").number("gain", &[10.0]);
    let mut task = case.build(&model);
    let mut q = model.neutral();
    (q[0], q[1]) = (3.0, -2.2);
    let w = Place::new(&model, &q).write(&mut *task, &case, 0.0).unwrap();
    assert!(w.upper[0] < 0.0 && w.lower[0] < w.upper[0] && w.margins[0] < 0.0);
    assert!(w.lower[1] > 0.0 && w.upper[1] > w.lower[1] && w.margins[1] < 0.0);
}

#[test]
fn auto_needs_speed_limits() {
    let mut rng = rng(45);
    let model = canopies(Base::Planar);
    let speed: Vec<f64> = model.dofs.iter().map(|d| d.velocity).collect();
    let auto = |case: Case| case.with("sampled_margin", Bound::Choice("auto".to_string()));
    // The base has none, and moves the point against the world, but not against the robot's own parts.
    let cases: Vec<Case> = cases(&model, &mut rng).into_iter().map(auto).collect();
    let error = cases[0].build_for(&model, PERIOD, &speed).err().unwrap();
    assert_eq!(error.param, "sampled_margin");
    assert!(error.message.contains("`point`"), "{}", error.message);
    assert!(cases[2].build_for(&model, PERIOD, &speed).is_ok());
    assert!(cases[3].build_for(&model, PERIOD, &speed).is_ok());
}

#[test]
fn a_ball_is_what_moves_whichever_side_names_it() {
    // The convex part counts as still, the ball as moving: the other way round the bound means nothing.
    let mut rng = rng(46);
    let model = canopies(Base::Planar);
    let speed = speeds(&model);
    let slab = shaped("slab", middle(&model), Shape::Box { half: [0.2, 0.1, 0.05] }, &mut rng);
    let ball = attackers(&model, &mut rng).remove(1);
    let offset = ball.origin.translation.vector.norm();
    let expected = clearance::acceleration_bound(&model, Some(slab.link), ball.link, offset, &speed) * PERIOD / 20.0;
    let sides = [(vec![ball.clone()], vec![slab.clone()]), (vec![slab], vec![ball])];
    for (between, and) in sides {
        let task = collision(between, and, (0.05, 0.0)).build_for(&model, PERIOD, &speed).unwrap();
        assert!((task.sampled_loss()[0] - expected).abs() < 1e-12);
    }
}

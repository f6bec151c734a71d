//! Chosen axes of frame tasks: each row is the exact derivative of its component of the error, against central
//! differences of poses; all rows together are those of the whole task.

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::task::Task;
use nalgebra::Vector3;
use robot::{LinkId, Model};

use crate::common::*;

const H: f64 = 1e-6;
const GAIN: f64 = 1.7;

/// Every choice of axes.
fn choices() -> Vec<[bool; 3]> {
    (1..8).map(|bits| [0, 1, 2].map(|i| bits & (1 << i) != 0)).collect()
}

/// A frame with its moving target and its chosen axes.
struct Chosen {
    link: LinkId,
    axes: [bool; 3],
    of: Option<LinkId>,
}

impl Chosen {
    fn case(&self, name: &'static str, rng: &mut impl FnMut() -> f64) -> Case {
        let (p, q) = (vector(rng, 1.0), rotation(rng));
        let frame = |link: LinkId| Bound::Frame("f".to_string(), link);
        let case = Case::new(name).with("frame", frame(self.link)).number("gain", &[GAIN]);
        let case = match name {
            "frame_position" => case.moving("position", p.as_slice(), &[0.1, -0.2, 0.3]),
            _ => case.moving("orientation", &[q.w, q.i, q.j, q.k], &[0.2, 0.1, -0.3, 0.4]),
        };
        let case = case.with("axes", Bound::Axes(self.axes));
        match self.of {
            Some(of) => case.with("axes_of", frame(of)),
            None => case,
        }
    }

    /// The chosen components of the error after `s` seconds of `v`.
    fn errors(&self, place: &Place, case: &Case, v: &[f64], s: f64) -> Vec<f64> {
        let (there, values) = (place.moved(v, s), case.values_at(s));
        let pose = there.data.pose(self.link);
        let error = if case.name == "frame_position" {
            let slot = case.place("position");
            Vector3::from_row_slice(&values[slot.at..slot.at + 3]) - pose.translation.vector
        } else {
            let slot = case.place("orientation");
            (quaternion(&values[slot.at..slot.at + 4]) * pose.rotation.inverse()).scaled_axis()
        };
        let inward = self.of.map_or(error, |of| there.data.pose(of).rotation.inverse() * error);
        (0..3).filter(|&i| self.axes[i]).map(|i| inward[i]).collect()
    }
}

fn links(model: &Model) -> [LinkId; 2] {
    arms(model).map(|arm| arm.tip)
}

#[test]
fn rows_are_the_derivatives_of_the_chosen_components() {
    let mut rng = rng(11);
    for model in robots() {
        let [left, right] = links(&model);
        for q in configurations(&model, 2, &mut rng) {
            let place = Place::new(&model, &q);
            for name in ["frame_position", "frame_orientation"] {
                for (axes, of) in choices().into_iter().flat_map(|a| [None, Some(left), Some(right)].map(|of| (a, of)))
                {
                    let chosen = Chosen { link: left, axes, of };
                    let case = chosen.case(name, &mut rng);
                    let now = chosen.errors(&place, &case, &vec![0.0; model.nv()], 0.0);
                    // Beside half a turn the rotation vector jumps.
                    let whole = Chosen { link: left, axes: [true; 3], of: None };
                    let size: f64 =
                        whole.errors(&place, &case, &vec![0.0; model.nv()], 0.0).iter().map(|x| x * x).sum();
                    if name == "frame_orientation" && size.sqrt() > 3.1 {
                        continue;
                    }
                    let mut task = case.build(&model);
                    let w = place.write(&mut *task, &case, 0.0).unwrap();
                    assert_eq!(w.j.nrows(), now.len());
                    let v = velocity(&model, &mut rng, 0.5);
                    let (before, after) = (chosen.errors(&place, &case, &v, -H), chosen.errors(&place, &case, &v, H));
                    // The whole error in the world's axes keeps the rows of thesis (2.5), which do not follow the
                    // components of a rotation vector.
                    let classic = name == "frame_orientation" && axes == [true; 3] && of.is_none();
                    for i in 0..now.len() {
                        assert_eq!(w.lower[i], w.upper[i]);
                        if !classic {
                            let rate = (after[i] - before[i]) / (2.0 * H);
                            let from_row = w.lower[i] - GAIN * now[i] - w.rate(i, &v);
                            assert!((rate - from_row).abs() < 1e-6, "{name} {axes:?} {of:?}: {rate} and {from_row}");
                        }
                    }
                    let norm = now.iter().map(|x| x * x).sum::<f64>().sqrt();
                    assert!((w.measures[0] - norm).abs() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn rows_of_all_axes_ask_for_what_the_whole_task_asks() {
    let mut rng = rng(12);
    let model = arm7();
    let [link, _] = links(&model);
    for _ in 0..20 {
        let place = Place::new(&model, &model.random_configuration(&mut rng));
        let chosen = Chosen { link, axes: [true; 3], of: None };
        let plain = chosen.case("frame_position", &mut rng);
        let weighted = plain.clone().number("axis_weights", &[1.0, 2.0, 3.0]);
        let (mut a, mut b) = (plain.build(&model), weighted.build(&model));
        let (a, b) = (place.write(&mut *a, &plain, 0.0).unwrap(), place.write(&mut *b, &weighted, 0.0).unwrap());
        assert!((a.j - b.j).norm() < 1e-12 && (a.lower - b.lower).norm() < 1e-12);
    }
}

#[test]
fn a_pose_has_the_rows_of_its_parts_in_order() {
    let mut rng = rng(13);
    let model = canopies(robot::Base::Floating);
    let [left, _] = links(&model);
    let place = Place::new(&model, &model.random_configuration(&mut rng));
    let frame = Bound::Frame("f".to_string(), left);
    let (p, q) = (vector(&mut rng, 1.0), rotation(&mut rng));
    let (p, q): ([f64; 3], [f64; 4]) = (p.into(), [q.w, q.i, q.j, q.k]);
    let axes = |a: [bool; 3]| Bound::Axes(a);
    let (xy, z) = ([true, true, false], [false, false, true]);
    let group = |list: [(&str, Bound); 2]| Bound::Group(list.into_iter().map(|(n, b)| (n.to_string(), b)).collect());
    let pose = Case::new("frame_pose")
        .with("frame", frame.clone())
        .with("axes_of", frame.clone())
        .number("position", &p)
        .number("orientation", &q)
        .number("gain", &[GAIN, GAIN])
        .with("axes", group([("linear", axes(xy)), ("angular", axes(z))]))
        .group("axis_weights", &[("linear", &[1.0, 2.0, 3.0]), ("angular", &[4.0, 5.0, 6.0])]);
    let mut task = pose.build(&model);
    let names: Vec<String> = task.rows().into_iter().map(|r| r.name).collect();
    assert_eq!(names, ["x", "y", "rz"]);
    assert_eq!(task.row_weights(), [1.0, 2.0, 6.0]);
    let whole = place.write(&mut *task, &pose, 0.0).unwrap();
    let parts = [("frame_position", "position", &p[..], xy), ("frame_orientation", "orientation", &q[..], z)];
    let mut row = 0;
    for (name, key, value, chosen) in parts {
        let case = Case::new(name)
            .with("frame", frame.clone())
            .with("axes_of", frame.clone())
            .number(key, value)
            .number("gain", &[GAIN])
            .with("axes", axes(chosen));
        let part = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
        for i in 0..part.j.nrows() {
            assert!((part.j.row(i) - whole.j.row(row)).norm() < 1e-12);
            assert!((part.lower[i] - whole.lower[row]).abs() < 1e-12);
            row += 1;
        }
    }
    assert_eq!(row, whole.j.nrows());
}

/// A free component of the error is large, the frame turns, and the chosen ones still decay as `exp(-K t)`.
#[test]
fn free_axes_do_not_disturb_the_others() {
    let mut rng = rng(14);
    let model = arm7();
    let [link, _] = links(&model);
    let chosen = Chosen { link, axes: [true, true, false], of: Some(link) };
    let mut case = chosen.case("frame_position", &mut rng);
    case.rates.fill(0.0);
    let mut task: Box<dyn Task> = case.build(&model);
    let mut place = Place::new(&model, &model.random_configuration(&mut rng));
    let still = vec![0.0; model.nv()];
    let start = chosen.errors(&place, &case, &still, 0.0);
    let dt = 1e-3;
    let steps = 1000;
    for _ in 0..steps {
        let w = place.write(&mut *task, &case, 0.0).unwrap();
        place = place.moved(&follow(&w), dt);
    }
    let end = chosen.errors(&place, &case, &still, 0.0);
    let decay = (-GAIN * dt * f64::from(steps)).exp();
    for (a, b) in start.iter().zip(end) {
        assert!((a * decay - b).abs() < 2e-3 * (1.0 + a.abs()), "{a} became {b}");
    }
}

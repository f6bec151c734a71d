//! Obstacles in the 3D replay: their forms, where the controller took them to be, and where they truly were.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot::Soup;
use runtime::Program;
use runtime::program::Times;
use runtime::record::series::SeriesRecorder;
use serde_json::{Value as Json, json};
use stdlib_tasks::bound::{Obstacle, Slot};
use stdlib_tasks::obstacle::Form;

use super::scene::{placed, round, wxyz, xyz};

/// Edge length of the part of a plane that is drawn, in m.
const PLANE: f64 = 4.0;

/// Least radius with which a point of a cloud is drawn, in m.
const SMALLEST_POINT: f64 = 0.004;

/// Data of all obstacles: form, link, and one pose, or one for each sample; an absent obstacle has none. One that is elsewhere
/// in the program `truth` has its true pose beside, or the word `absent`.
pub(super) fn obstacles(program: &Program, truth: Option<&Program>, series: &SeriesRecorder) -> Vec<Json> {
    let (believed, real) = (poses(program, series), truth.map(|truth| poses(truth, series)));
    let drawn = |(i, o): (usize, &Obstacle)| {
        let data: Vec<f64> = believed[i].iter().flatten().copied().map(round).collect();
        let mut out = json!({ "name": o.name, "link": o.link.map(|l| l.0), "visual": form(&o.form), "data": data });
        // True places are constant.
        let real = real.as_ref().and_then(|real| real.get(i)?.first());
        let is_there = |pose: &[f64; 7]| pose[0].is_finite();
        if let Some(real) =
            real.filter(|real| believed[i].iter().any(|b| is_there(b) != is_there(real) || is_there(b) && b != *real))
        {
            out["truth"] = if is_there(real) { json!(real.map(round)) } else { json!("absent") };
        }
        out
    };
    program.obstacles.iter().enumerate().map(drawn).collect()
}

/// Poses of each obstacle, one for each sample, or one that holds for all.
fn poses(program: &Program, series: &SeriesRecorder) -> Vec<Vec<[f64; 7]>> {
    if program.obstacles.is_empty() {
        return Vec::new();
    }
    let samples = values(program, series);
    let of = |o: &Obstacle| {
        let mut poses: Vec<[f64; 7]> = samples.iter().map(|values| pose(o, values)).collect();
        if poses.iter().all(|pose| *pose == poses[0]) {
            poses.truncate(1);
        }
        poses
    };
    program.obstacles.iter().map(of).collect()
}

fn form(form: &Form) -> Json {
    match form {
        Form::Shape(origin, shape) => placed(shape, origin),
        Form::Soup(soup) => drawn_soup(soup),
        Form::HalfSpace(turn) => {
            let origin = Isometry3::from_parts(Default::default(), *turn);
            json!({ "type": "plane", "size": [PLANE, PLANE, 0.0], "xyz": [0.0, 0.0, 0.0], "wxyz": wxyz(&origin) })
        }
    }
}

/// Largest number of elements that are drawn: of more, some are left out evenly.
const MOST_DRAWN: usize = 4000;

/// A mesh of the triangles and pieces, or of small octahedra in place of the points.
fn drawn_soup(soup: &Soup) -> Json {
    let (mut vertices, mut faces): (Vec<f64>, Vec<u32>) = (Vec::new(), Vec::new());
    let mut corner = |p: Vector3<f64>| {
        vertices.extend(xyz(&p));
        (vertices.len() / 3 - 1) as u32
    };
    let step = soup.len().div_ceil(MOST_DRAWN);
    let size = soup.radius().max(SMALLEST_POINT);
    for element in (0..soup.len()).step_by(step) {
        match soup.corners(element) {
            [p] => {
                let tips: Vec<u32> =
                    (0..6).map(|i| corner(p + Vector3::ith(i % 3, if i < 3 { size } else { -size }))).collect();
                for [a, b, c] in
                    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
                {
                    faces.extend([tips[a], tips[b], tips[c]]);
                }
            }
            _ => {
                for [a, b, c] in soup.faces(element) {
                    faces.extend([corner(a), corner(b), corner(c)]);
                }
            }
        }
    }
    let origin = Isometry3::identity();
    let mut out = json!({ "type": "mesh", "vertices": vertices, "faces": faces });
    out["xyz"] = json!([0.0, 0.0, 0.0]);
    out["wxyz"] = json!(wxyz(&origin));
    out["color"] = json!(null);
    out
}

/// Values of the obstacles' poses at each sample.
fn values(program: &Program, series: &SeriesRecorder) -> Vec<Vec<f64>> {
    let slots = program.obstacles.iter().flat_map(Obstacle::slots);
    let places: BTreeSet<usize> = slots.flat_map(|s: Slot| s.at..s.at + s.len).collect();
    let tape = program.values.tape.only(&places);
    let mut registers = vec![0.0; tape.ops.len()];
    let inputs = vec![f64::NAN; tape.inputs];
    let mut rates = vec![0.0; program.values.initial.len()];
    let at = |(time, signals): (&f64, &Vec<f64>)| {
        let mut values = program.values.initial.clone();
        let times = Times { t: f64::NAN, time: *time };
        tape.evaluate(times, &inputs, signals, &mut registers, &mut values, &mut rates);
        values
    };
    series.times.iter().zip(&series.signals).map(at).collect()
}

/// Position and `w x y z`; NaN while the obstacle is absent.
fn pose(o: &Obstacle, values: &[f64]) -> [f64; 7] {
    if !o.is_present(values) {
        return [f64::NAN; 7];
    }
    let q = |i: usize| values[o.orientation.at + i];
    let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q(0), q(1), q(2), q(3)));
    let p = |i: usize| values[o.position.at + i];
    [p(0), p(1), p(2), turn.w, turn.i, turn.j, turn.k]
}

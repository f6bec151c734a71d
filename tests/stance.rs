//! The example with double and single support: the centre of mass against the hull of the soles that touch the ground, by brute
//! force, at the true configurations of a run.

use nalgebra::{Point3, Vector2};
use robot::Data;
use runtime::Program;
use stdlib_tasks::expression::center_of_mass;

use crate::common;

/// Points of both soles that are on the ground, from above, and the centre of mass.
fn ground(program: &Program, data: &mut Data, q: &[f64]) -> (Vec<Vector2<f64>>, Vector2<f64>) {
    let model = &program.robot.model;
    model.forward(q, data);
    let mut points = Vec::new();
    for sole in ["left_sole", "right_sole"] {
        let pose = data.pose(model.link(sole).expect("a sole"));
        for (x, y) in [(0.085, 0.03), (-0.085, 0.03), (-0.085, -0.03), (0.085, -0.03)] {
            let p = pose * Point3::new(x, y, 0.0);
            if p.z < 5e-3 {
                points.push(p.coords.xy());
            }
        }
    }
    (points, center_of_mass(model, data).xy())
}

/// Largest share by which a point is on the wrong side of a line with all points on the other, in m.
fn outside(points: &[Vector2<f64>], p: &Vector2<f64>) -> f64 {
    let mut most = f64::NEG_INFINITY;
    for a in points {
        for b in points {
            let along = b - a;
            if along.norm() < 1e-6 {
                continue;
            }
            let height = |c: &Vector2<f64>| along.perp(&(c - a)) / along.norm();
            if points.iter().all(|c| height(c) > -1e-9) {
                most = most.max(-height(p));
            }
        }
    }
    most
}

#[test]
fn the_weight_is_above_what_touches_the_ground() {
    let program = common::program("stance.hq");
    let mut data = Data::new(&program.robot.model);
    let run = common::run(&program);
    let (mut single, mut edge) = (0, f64::NEG_INFINITY);
    for s in &run {
        assert!(s.fault.is_none(), "a fault at {} s: {:?}", s.time, s.fault);
        let (points, com) = ground(&program, &mut data, &s.q);
        let out = outside(&points, &com);
        // The margin of the example is 1 cm.
        assert!(out < -0.01 + 1e-6, "at {} s the weight is {out} m outside", s.time);
        if points.len() == 4 {
            single += 1;
            edge = edge.max(out);
        }
    }
    assert!(single > 500, "the foot is in the air on {single} ticks");
    assert!(edge > -0.0105, "the limit was never felt: {edge}");
}

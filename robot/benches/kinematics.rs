//! Time of forward kinematics and of rows, on a robot with 20 degrees of freedom.

#![allow(non_snake_case, reason = "frames stand in the names: X_WL, p_W")]

use divan::{Bencher, black_box};
use hierarq_robot::{Base, Data, LinkId, Model, Options, Shape, closest};
use nalgebra::{Isometry3, Vector3};

fn main() {
    divan::main();
}

/// A planar base, a torso, two arms of seven joints and a head of two.
fn robot() -> Model {
    let mut text = String::from("<robot name='bench'><link name='base'/>");
    let mut joint = |name: &str, parent: &str, xyz: &str, axis: &str| {
        text.push_str(&format!(
            "<link name='{name}_link'/><joint name='{name}' type='revolute'><parent link='{parent}'/>\
             <child link='{name}_link'/><origin xyz='{xyz}' rpy='0.1 0.2 0.3'/><axis xyz='{axis}'/>\
             <limit lower='-2' upper='2' velocity='1' effort='1'/></joint>"
        ));
        format!("{name}_link")
    };
    let torso = joint("torso", "base", "0 0 0.5", "0 0 1");
    for side in ["left", "right"] {
        let mut parent = torso.clone();
        for i in 0..7 {
            let axis = ["0 0 1", "0 1 0", "1 0 0"][i % 3];
            parent = joint(&format!("{side}_{i}"), &parent, "0.1 0.05 0.1", axis);
        }
    }
    let neck = joint("neck", &torso, "0 0 0.4", "0 0 1");
    joint("nod", &neck, "0 0 0.1", "0 1 0");
    text.push_str("</robot>");
    let options = Options { base: Base::Planar, ..Options::default() };
    let Ok((model, _)) = Model::from_urdf(&text, &options) else { panic!("the robot is broken") };
    assert_eq!(model.nv(), 20);
    model
}

fn posed() -> (Model, Vec<f64>, Data) {
    let model = robot();
    let mut state = 0.5;
    let q = model.random_configuration(&mut || {
        state = (state * 997.0_f64 + 0.1234).fract();
        state
    });
    let mut data = Data::new(&model);
    model.forward(&q, &mut data);
    (model, q, data)
}

#[divan::bench]
fn forward(bencher: Bencher) {
    let (model, q, mut data) = posed();
    bencher.bench_local(|| model.forward(black_box(&q), black_box(&mut data)));
}

#[divan::bench]
fn point_rows_48(bencher: Bencher) {
    let (model, _, data) = posed();
    let links = [model.link("left_6_link"), model.link("right_6_link"), model.link("nod_link")];
    let links: Vec<LinkId> = links.into_iter().flatten().collect();
    let n = Vector3::new(0.6, 0.0, 0.8);
    let mut rows = vec![[0.0; 24]; 48];
    bencher.bench_local(|| {
        for (i, row) in rows.iter_mut().enumerate() {
            *row = [0.0; 24];
            let link = links[i % 3];
            data.add_point(&model, link, data.position(link), black_box(&n), row);
        }
    });
}

#[divan::bench]
fn capsule_capsule(bencher: Bencher) {
    let a = Shape::Capsule { radius: 0.1, half_length: 0.3 };
    let X = Isometry3::new(Vector3::new(0.4, 0.3, 0.2), Vector3::new(0.7, -0.4, 0.1));
    bencher.bench_local(|| closest(black_box(&a), &Isometry3::identity(), &a, black_box(&X)));
}

#[divan::bench]
fn capsule_box(bencher: Bencher) {
    let a = Shape::Capsule { radius: 0.1, half_length: 0.3 };
    let b = Shape::Box { half: [0.2, 0.3, 0.4] };
    let X = Isometry3::new(Vector3::new(0.6, 0.5, 0.4), Vector3::new(0.7, -0.4, 0.1));
    bencher.bench_local(|| closest(black_box(&a), &Isometry3::identity(), &b, black_box(&X)));
}

#[divan::bench]
fn box_box(bencher: Bencher) {
    let a = Shape::Box { half: [0.2, 0.3, 0.4] };
    let X = Isometry3::new(Vector3::new(0.8, 0.7, 0.6), Vector3::new(0.7, -0.4, 0.1));
    bencher.bench_local(|| closest(black_box(&a), &Isometry3::identity(), &a, black_box(&X)));
}

//! A tick of `self_collision` with 162 pairs of capsules on 21 degrees of freedom: its distances and rows.
//! `cargo bench -p hierarq-stdlib-tasks --bench self_collision`

use std::collections::BTreeMap;

use divan::{Bencher, black_box};
use hierarq_stdlib_tasks::bound::{Bound, Geometry, Slot};
use hierarq_stdlib_tasks::build::Context;
use hierarq_stdlib_tasks::kinds::find;
use hierarq_stdlib_tasks::task::{Rows, State};
use nalgebra::Isometry3;
use robot::{Base, Data, Model, Options, Shape};

fn main() {
    divan::main();
}

/// Capsules of the links of an arm: nine of the left one, 18 of the right one.
fn capsules(model: &Model, arm: &str, count: usize) -> Vec<Geometry> {
    let links: Vec<_> = model.links.iter().enumerate().filter(|(_, l)| l.name.contains(arm)).collect();
    let one = |i: usize| {
        let (index, link) = links[i % links.len()];
        Geometry {
            name: format!("{} {i}", link.name),
            link: robot::LinkId(index as u32),
            origin: Isometry3::translation(0.01 * i as f64, 0.02, 0.0),
            shape: Shape::Capsule { radius: 0.03, half_length: 0.05 + 0.005 * i as f64 },
        }
    };
    (0..count).map(one).collect()
}

/// All rows, or the margins alone of rows that are known to have no effect.
#[divan::bench(args = [false, true])]
fn tick_of_162_capsules(bencher: Bencher, idle: bool) {
    let options = Options { base: Base::Planar, ..Options::default() };
    let urdf = include_str!("../../examples/robots/canopies.urdf");
    let Ok((model, _)) = Model::from_urdf(urdf, &options) else { panic!("the robot is broken") };
    let mut state = 0.5;
    let q = model.random_configuration(&mut || {
        state = (state * 997.0_f64 + 0.1234).fract();
        state
    });
    let mut data = Data::new(&model);
    model.forward(&q, &mut data);
    let values = [0.01, 10.0, 0.0];
    let number = |at| Bound::Value(Slot { at, len: 1 });
    let bound: BTreeMap<String, Bound> = [
        ("between", Bound::Geometries(capsules(&model, "left", 9))),
        ("and", Bound::Geometries(capsules(&model, "right", 18))),
        ("d_min", number(0)),
        ("gain", number(1)),
        ("sampled_margin", number(2)),
    ]
    .map(|(name, bound)| (name.to_string(), bound))
    .into();
    let speed = vec![1.0; model.nv()];
    let ctx = Context { model: &model, values: &values, period: 1e-3, speed: &speed, entry_speed: &speed };
    let Some(kind) = find("self_collision") else { panic!("no such task") };
    let Ok(mut task) = (kind.build)(&bound, &ctx) else { panic!("the task is broken") };
    let (count, nv) = (task.rows().len(), model.nv());
    assert_eq!(count, 162);
    let idle = vec![idle; count];
    let still = vec![0.0; nv];
    let [mut jacobian, mut lower, mut upper, mut margins] = [count * nv, count, count, count].map(|n| vec![0.0; n]);
    let mut undefined = false;
    bencher.bench_local(|| {
        jacobian.fill(0.0);
        let state = State {
            model: &model,
            data: black_box(&data),
            q: &q,
            values: &values,
            rates: &[0.0; 3],
            velocity: &still,
            stack_velocity: &still,
        };
        let mut rows = Rows {
            jacobian: &mut jacobian,
            stride: nv,
            lower: &mut lower,
            upper: &mut upper,
            margins: &mut margins,
            measures: &mut [],
            undefined: &mut undefined,
            idle: &idle,
            trial: false,
        };
        task.update(&state, &mut rows).is_ok()
    });
}

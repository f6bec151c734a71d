//! Time of expressions of the robot's state, the value and the row of its derivative, on 21 degrees of freedom: one of 50
//! operations, and quantities of the state alone.

use divan::{Bencher, black_box};
use hierarq_stdlib_tasks::bound::Geometry;
use hierarq_stdlib_tasks::dimension::LENGTH;
use hierarq_stdlib_tasks::expression::{Evaluation, Expression, Leaf, Manipulability, MotionPart, Op};
use hierarq_stdlib_tasks::task::State;
use nalgebra::{Isometry3, Vector3};
use robot::{Base, Data, LinkId, Model, Options, Shape};

fn main() {
    divan::main();
}

/// The dual-arm robot on a planar base, at some configuration.
fn posed() -> (Model, Vec<f64>, Data) {
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
    (model, q, data)
}

/// `|R [a, b, c] + p_left - p_right|` of both tools, with a wave on top: 50 operations, 18 of them leaves.
fn expression(model: &Model) -> Expression {
    let link = |name: &str| model.link(name).unwrap_or(model.root());
    let (left, right) = (link("left_tool"), link("right_tool"));
    let leaves = vec![
        Leaf::Point { link: left, offset: Vector3::new(0.1, 0.0, 0.05) },
        Leaf::Point { link: right, offset: Vector3::zeros() },
        Leaf::Orientation(left),
        Leaf::Joint(model.nv() - 3),
    ];
    let mut ops: Vec<Op> = (0..11).map(Op::State).collect();
    ops.extend((0..7).map(Op::Input));
    // 18..21: p_left - p_right
    ops.extend((0..3).map(|i| Op::Sub(i, 3 + i)));
    // 21..39: a row of products of the quaternion with the inputs, added up
    for k in 0..3 {
        ops.extend([Op::Mul(6 + k, 11 + k), Op::Mul(7 + k, 14 + k), Op::Mul(9, 12 + k)]);
        let first = ops.len() - 3;
        ops.extend([Op::Add(first, first + 1), Op::Sub(first + 3, first + 2), Op::Add(first + 4, 18 + k)]);
    }
    let end = ops.len();
    let parts = [26, 32, 38];
    ops.extend(parts.map(|p| Op::Powi(p, 2)));
    ops.extend([Op::Add(end, end + 1), Op::Add(end + 3, end + 2), Op::Sqrt(end + 4)]);
    ops.extend([Op::Sin(10), Op::Cos(10), Op::Mul(end + 6, end + 7), Op::Mul(end + 8, 17), Op::Add(end + 9, end + 5)]);
    assert_eq!(ops.len(), 50);
    let outputs = vec![ops.len() - 1];
    Expression { ops, inputs: (0..7).collect(), leaves, outputs, dimension: LENGTH }
}

/// Measures value and row of an expression over seven numbers of the table.
fn measure(bencher: Bencher, of: impl Fn(&Model) -> Expression) {
    let (model, q, data) = posed();
    let e = of(&model);
    let values: Vec<f64> = (0..7).map(|i| 0.1 + 0.05 * f64::from(i)).collect();
    let rates = vec![0.01; 7];
    let Ok(()) = e.check(&model, values.len()) else { panic!("the expression is broken") };
    let mut evaluation = Evaluation::new(&e, &model);
    let mut row = vec![0.0; model.nv()];
    bencher.bench_local(|| {
        let state = State {
            model: &model,
            data: &data,
            q: &q,
            values: black_box(&values),
            rates: &rates,
            velocity: &[0.0; 7],
            stack_velocity: &[0.0; 7],
        };
        row.fill(0.0);
        let found = evaluation.forward(&state).is_ok();
        let still = evaluation.add_row(&state, &[1.0], black_box(&mut row));
        (found, still, evaluation.value(0))
    });
}

/// First number of a quantity of the state alone, as the value of a `keep` or `track`.
fn alone(leaf: Leaf) -> Expression {
    Expression { ops: vec![Op::State(0)], inputs: vec![], leaves: vec![leaf], outputs: vec![0], dimension: LENGTH }
}

fn left(model: &Model) -> LinkId {
    model.link("left_tool").unwrap_or(model.root())
}

#[divan::bench]
fn value_and_row_50_operations(bencher: Bencher) {
    measure(bencher, expression);
}

#[divan::bench]
fn position(bencher: Bencher) {
    measure(bencher, |model| alone(Leaf::Point { link: left(model), offset: Vector3::zeros() }));
}

#[divan::bench]
fn center_of_mass(bencher: Bencher) {
    measure(bencher, |_| alone(Leaf::Com));
}

#[divan::bench]
fn distance_of_two_capsules(bencher: Bencher) {
    measure(bencher, |model| {
        let part = |link: LinkId| Geometry {
            name: String::new(),
            link,
            origin: Isometry3::identity(),
            shape: Shape::Capsule { radius: 0.05, half_length: 0.1 },
        };
        let right = model.link("right_tool").unwrap_or(model.root());
        alone(Leaf::Distance(Box::new((part(left(model)), part(right)))))
    });
}

/// Number of velocities that count: three of the origin, or six with those of the axes.
#[divan::bench(args = [3, 6])]
fn manipulability(bencher: Bencher, velocities: usize) {
    let part = if velocities == 3 { MotionPart::Linear } else { MotionPart::Whole };
    measure(bencher, |model| {
        let dofs = (0..model.nv()).collect();
        alone(Leaf::Manipulability(Box::new(Manipulability { link: left(model), part, dofs })))
    });
}

//! Time of a trajectory per tick, and at a change of its goal. `cargo bench -p hierarq-runtime --bench trajectories`.

use divan::{Bencher, black_box};
use hierarq_runtime::trajectory::{Limits, Path, State, Turn, Turning};
use nalgebra::{UnitQuaternion, Vector3};

fn main() {
    divan::main();
}

const JERKS: [Option<f64>; 2] = [None, Some(5.0)];

fn limits(jerk: Option<f64>) -> Limits {
    Limits { speed: 0.2, acceleration: 0.5, jerk }
}

fn goal() -> Vector3<f64> {
    Vector3::new(0.3, 0.2, 0.1)
}

/// A lookup half way.
#[divan::bench(args = JERKS)]
fn at(bencher: Bencher, jerk: Option<f64>) {
    let path = Path::plan(&State::rest(Vector3::zeros()), goal(), &limits(jerk)).expect("a plan");
    let t = 0.5 * path.duration();
    bencher.bench_local(|| path.at(black_box(t)));
}

/// A lookup of an orientation.
#[divan::bench(args = JERKS)]
fn orientation_at(bencher: Bencher, jerk: Option<f64>) {
    let (rest, orientation) = (Vector3::zeros(), UnitQuaternion::identity());
    let from = Turning { orientation, velocity: rest, acceleration: rest };
    let turn = Turn::plan(&from, UnitQuaternion::from_euler_angles(0.3, 0.8, -0.2), &limits(jerk)).expect("a plan");
    let t = 0.5 * turn.duration();
    bencher.bench_local(|| turn.at(black_box(t)));
}

/// A plan from rest.
#[divan::bench(args = JERKS)]
fn plan(bencher: Bencher, jerk: Option<f64>) {
    let (from, l) = (State::rest(Vector3::zeros()), limits(jerk));
    bencher.bench_local(|| Path::plan(black_box(&from), goal(), &l));
}

/// A plan in motion to a goal aside.
#[divan::bench(args = JERKS)]
fn plan_anew(bencher: Bencher, jerk: Option<f64>) {
    let l = limits(jerk);
    let path = Path::plan(&State::rest(Vector3::zeros()), goal(), &l).expect("a plan");
    let now = path.at(0.3);
    let aside = Vector3::new(0.1, 0.3, 0.2);
    bencher.bench_local(|| Path::plan(black_box(&now), aside, &l));
}

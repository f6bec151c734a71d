//! `joint_acceleration_limits`: rows and margins, and how they get along with limits of positions.

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::task::{State, Task};
use proptest::prelude::*;
use robot::{Base, Model};

use crate::common::*;

const PERIOD: f64 = 0.01;

fn limits(model: &Model, max: &[(usize, f64)]) -> (Case, Box<dyn Task>) {
    let mut case = Case::new("joint_acceleration_limits");
    let list = max.iter().map(|&(dof, x)| (dof, case.slot(&[x], &[0.0]))).collect();
    let case = case.with("max", Bound::PerJoint(list));
    let task = case.build_for(model, PERIOD, &vec![f64::INFINITY; model.nv()]).unwrap();
    (case, task)
}

#[test]
fn the_velocity_changes_by_so_much_at_most() {
    let model = canopies(Base::Planar);
    let mut rng = rng(91);
    let max = [(0, 0.4), (3, 2.0), (model.nv() - 1, 7.0)];
    let (case, mut task) = limits(&model, &max);
    assert_eq!(task.degrees_of_freedom().unwrap(), max.map(|m| m.0));
    let units: Vec<String> = task.rows().iter().map(|r| r.dimension.to_string()).collect();
    assert_eq!(units, ["m/s^2", "rad/s^2", "rad/s^2"]);
    for _ in 0..20 {
        let mut place = Place::new(&model, &model.random_configuration(&mut rng));
        place.velocity = velocity(&model, &mut rng, 1.0);
        let w = place.write(&mut *task, &case, 0.0).unwrap();
        let v = velocity(&model, &mut rng, 1.0);
        let mut margins = vec![f64::INFINITY; max.len()];
        // The controller shows the new velocity here: the margin is still that against the one before.
        let state = State { velocity: &v, stack_velocity: &v, ..place.state(&case.values, &case.rates) };
        task.observe(&state, &v, &mut margins, &mut []);
        for (i, &(dof, a)) in max.iter().enumerate() {
            assert_eq!(w.rate(i, &v), v[dof]);
            assert!((w.upper[i] - (place.velocity[dof] + a * PERIOD)).abs() < 1e-15);
            assert!((w.lower[i] - (place.velocity[dof] - a * PERIOD)).abs() < 1e-15);
            let acceleration = (v[dof] - place.velocity[dof]) / PERIOD;
            assert!((margins[i] - (a - acceleration.abs())).abs() < 1e-9);
            assert_eq!(margins[i] >= 0.0, w.lower[i] <= v[dof] && v[dof] <= w.upper[i]);
        }
    }
}

/// The limits of the joints of a robot, without `max`.
fn of_urdf(limit: &str) -> Vec<(usize, f64)> {
    let joint = format!(
        r#"<robot name="slide"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>
        <child link="b"/><axis xyz="1 0 0"/>{limit}</joint></robot>"#
    );
    Case::new("joint_acceleration_limits").build(&read(&joint, Base::Fixed)).acceleration_limits()
}

#[test]
fn without_max_the_urdf_decides() {
    assert_eq!(of_urdf(r#"<limit velocity="2" effort="1"/>"#), [(0, 20.0)]);
    assert_eq!(of_urdf(r#"<limit velocity="2" effort="1" acceleration="9" deceleration="8"/>"#), [(0, 8.0)]);
    assert_eq!(of_urdf(r#"<limit effort="1" acceleration="9"/>"#), [(0, 9.0)]);
}

/// The velocities that limits of position (between -1 and 1), velocity and acceleration leave to a joint at `q` that moved
/// at `last`, from the rows that the three tasks write.
struct Joint {
    model: Model,
    tasks: Vec<(Case, Box<dyn Task>)>,
}

impl Joint {
    fn new(gain: f64, speed: f64, acceleration: f64) -> Self {
        let model = read(
            r#"<robot name="slide"><link name="a"/><link name="b"/><joint name="j" type="prismatic"><parent link="a"/>
            <child link="b"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="9" effort="1"/></joint></robot>"#,
            Base::Fixed,
        );
        let position = Case::new("joint_position_limits").number("gain", &[gain]);
        let mut fast = Case::new("joint_velocity_limits");
        let max = fast.slot(&[speed], &[0.0]);
        let fast = fast.with("max", Bound::PerJoint(vec![(0, max)]));
        let mut tasks: Vec<_> = [position, fast].map(|c| (c.clone(), c.build(&model))).into();
        tasks.push(limits(&model, &[(0, acceleration)]));
        Joint { model, tasks }
    }

    fn left(&mut self, q: f64, last: f64) -> (f64, f64) {
        let mut place = Place::new(&self.model, &[q]);
        place.velocity = vec![last];
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (case, task) in &mut self.tasks {
            let w = place.write(&mut **task, case, 0.0).unwrap();
            low = low.max(w.lower[0]);
            high = high.min(w.upper[0]);
        }
        (low, high)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Whatever is asked for, three hard limits of a joint can be met where `a >= φ v_max`.
    #[test]
    fn limits_of_one_joint_never_contradict_each_other(
        gain in 0.5..100.0f64, speed in 0.1..3.0f64, more in 1.0..3.0f64,
        choices in prop::collection::vec((0.0..1.0f64, 0u8..4), 300),
    ) {
        let mut joint = Joint::new(gain, speed, gain * speed * more);
        let (mut q, mut v) = (0.0, 0.0);
        for (share, kind) in choices {
            let (low, high) = joint.left(q, v);
            prop_assert!(low <= high + 1e-12, "at {q} m, {v} m/s: from {low} to {high}");
            // Mostly as fast as it goes, to one side for a while.
            v = match kind { 0 => low + share * (high - low), _ if gain > 20.0 => low, _ => high };
            q += PERIOD * v;
            prop_assert!(q.abs() <= 1.0 + 1e-12);
        }
    }
}

#[test]
fn a_joint_that_brakes_too_weakly_runs_out_of_choice() {
    let run = |share: f64| {
        let (gain, speed) = (10.0, 1.0);
        let mut joint = Joint::new(gain, speed, gain * speed * share);
        let (mut q, mut v) = (-1.0, 0.0);
        (0..1000).all(|_| {
            let (low, high) = joint.left(q, v);
            (v, q) = (high, q + PERIOD * high);
            low <= high + 1e-12
        })
    };
    assert!(run(1.0));
    assert!(!run(0.85), "the bound is tight");
}

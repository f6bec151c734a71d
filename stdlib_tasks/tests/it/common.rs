//! Robots, hand-bound parameters, and what a task writes from them.

use hierarq_stdlib_tasks::bound::{Arm, Bound, BoundParams, Geometry, Slot};
use hierarq_stdlib_tasks::task::{BuildError, Context, Rows, State, Task, TaskFault};
use nalgebra::Isometry3;
use nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion, Vector3};
use robot::{Base, Data, LinkId, Model, Options, Placed};

pub use robot::random::units as rng;

/// A vector with entries in ±reach.
pub fn vector(rng: &mut impl FnMut() -> f64, reach: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| reach * (2.0 * rng() - 1.0))
}

/// Any rotation.
pub fn rotation(rng: &mut impl FnMut() -> f64) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(rng() - 0.5, rng() - 0.5, rng() - 0.5, rng() - 0.5))
}

/// A velocity with entries in ±reach.
pub fn velocity(model: &Model, rng: &mut impl FnMut() -> f64, reach: f64) -> Vec<f64> {
    (0..model.nv()).map(|_| reach * (2.0 * rng() - 1.0)).collect()
}

/// The dual-arm robot on a base.
pub fn canopies(base: Base) -> Model {
    read(include_str!("../../../examples/robots/canopies.urdf"), base)
}

/// The seven-joint arm, fixed.
pub fn arm7() -> Model {
    read(include_str!("../../../examples/robots/arm7.urdf"), Base::Fixed)
}

/// A URDF that must be good.
pub fn read(urdf: &str, base: Base) -> Model {
    Model::from_urdf(urdf, &Options { base, ..Options::default() }).unwrap().0
}

/// Two robots in one model, the names of the first as they are; both stand tilted somewhere.
pub fn two(first: &Model, second: &Model, rng: &mut impl FnMut() -> f64) -> Model {
    let [a, b] = [0, 1].map(|_| Isometry3::from_parts(vector(rng, 2.0).into(), rotation(rng)));
    let placed = [Placed { model: first, prefix: "", at: a }, Placed { model: second, prefix: "second_", at: b }];
    Model::merged("two", &placed).unwrap().0
}

/// All robots of these tests.
pub fn robots() -> Vec<Model> {
    let arm = read(include_str!("../../../examples/robots/arm7.urdf"), Base::Floating);
    let two = two(&canopies(Base::Unicycle), &arm, &mut rng(1));
    vec![arm7(), canopies(Base::Unicycle), canopies(Base::Planar), canopies(Base::Floating), canopies(Base::Fixed), two]
}

/// Configurations of a robot: neutral, all zeros (stretched arms), a hair beside it, and random ones.
pub fn configurations(model: &Model, random: usize, rng: &mut impl FnMut() -> f64) -> Vec<Vec<f64>> {
    let neutral = model.neutral();
    let mut zero = vec![0.0; model.nq()];
    model.copy_bases(&neutral, &mut zero);
    let mut beside = zero.clone();
    let v = velocity(model, rng, 1e-5);
    model.integrate(&mut beside, &v, 1.0);
    let mut all = vec![neutral, zero, beside];
    all.extend((0..random).map(|_| model.random_configuration(rng)));
    all
}

/// Two arms: those of the dual-arm robot; of the single arm, the whole and its lower half.
pub fn arms(model: &Model) -> [Arm; 2] {
    let link = |name: &str| model.link(name);
    let arm = |name: &str, links: [&str; 4]| Arm {
        name: name.to_string(),
        shoulder: link(links[0]),
        elbow: link(links[1]),
        wrist: link(links[2]),
        tip: link(links[3]).unwrap(),
    };
    if model.link("tool").is_some() {
        [arm("left", ["link_2", "link_4", "link_6", "tool"]), arm("right", ["link_2", "link_4", "tool", "link_4"])]
    } else {
        [
            arm("left", ["arm_left_2_link", "arm_left_4_link", "arm_left_6_link", "left_tool"]),
            arm("right", ["arm_right_2_link", "arm_right_4_link", "arm_right_6_link", "right_tool"]),
        ]
    }
}

/// A task with parameters bound by hand. Numbers run linearly in time: `values + t rates`.
#[derive(Clone)]
pub struct Case {
    pub name: &'static str,
    pub params: BoundParams,
    pub values: Vec<f64>,
    pub rates: Vec<f64>,
}

impl Case {
    pub fn new(name: &'static str) -> Self {
        Case { name, params: BoundParams::new(), values: Vec::new(), rates: Vec::new() }
    }

    pub fn slot(&mut self, values: &[f64], rates: &[f64]) -> Slot {
        let at = self.values.len();
        self.values.extend_from_slice(values);
        self.rates.extend_from_slice(rates);
        Slot { at, len: values.len() }
    }

    pub fn with(mut self, name: &str, bound: Bound) -> Self {
        self.params.insert(name.to_string(), bound);
        self
    }

    pub fn number(self, name: &str, values: &[f64]) -> Self {
        self.moving(name, values, &vec![0.0; values.len()])
    }

    pub fn moving(mut self, name: &str, values: &[f64], rates: &[f64]) -> Self {
        let slot = self.slot(values, rates);
        self.with(name, Bound::Value(slot))
    }

    /// A group `position`, `orientation` with random rates.
    pub fn pose(mut self, name: &str, rng: &mut impl FnMut() -> f64) -> Self {
        let (p, q) = (vector(rng, 1.0), rotation(rng));
        let position = self.slot(p.as_slice(), vector(rng, 0.5).as_slice());
        let orientation = self.slot(&[q.w, q.i, q.j, q.k], &[rng() - 0.5, rng() - 0.5, rng() - 0.5, rng() - 0.5]);
        let group = [("position", position), ("orientation", orientation)];
        self.with(name, Bound::Group(group.into_iter().map(|(n, s)| (n.to_string(), Bound::Value(s))).collect()))
    }

    /// A group of numbers that stand still.
    pub fn group(mut self, name: &str, numbers: &[(&str, &[f64])]) -> Self {
        let inner = numbers.iter().map(|(n, x)| (n.to_string(), Bound::Value(self.slot(x, &vec![0.0; x.len()]))));
        let group = Bound::Group(inner.collect());
        self.with(name, group)
    }

    /// Virtual mass, damping and, unless it is empty, stiffness, linear and angular, the same for all axes, and a wrench.
    pub fn body(self, numbers: [&[f64]; 3], wrench: [&[f64]; 2]) -> Self {
        let mut case = self;
        for (name, both) in ["mass", "damping", "stiffness"].iter().zip(numbers) {
            if let [linear, angular] = both {
                case = case.group(name, &[("linear", &[*linear; 3]), ("angular", &[*angular; 3])]);
            }
        }
        case.group("wrench", &[("force", wrench[0]), ("moment", wrench[1])])
    }

    /// The place of a number, `absolute.position` for one in a group, `angle.left` for one of an arm.
    pub fn place(&self, path: &str) -> Slot {
        let (first, rest) = path.split_once('.').unwrap_or((path, ""));
        match &self.params[first] {
            Bound::Value(slot) => *slot,
            Bound::Group(group) => match &group[rest] {
                Bound::Value(slot) => *slot,
                other => panic!("{path} is {other:?}"),
            },
            Bound::PerArm(list) => list.iter().find(|(arm, _)| arm.name == rest).unwrap().1,
            other => panic!("{path} is {other:?}"),
        }
    }

    pub fn set(&mut self, path: &str, values: &[f64]) {
        let slot = self.place(path);
        self.values[slot.at..slot.at + slot.len].copy_from_slice(values);
    }

    pub fn values_at(&self, t: f64) -> Vec<f64> {
        self.values.iter().zip(&self.rates).map(|(x, r)| x + t * r).collect()
    }

    pub fn build_for(&self, model: &Model, period: f64, speed: &[f64]) -> Result<Box<dyn Task>, BuildError> {
        let kind = hierarq_stdlib_tasks::find(self.name).unwrap();
        (kind.build)(&self.params, &Context { model, values: &self.values, period, speed, entry_speed: speed })
    }

    pub fn build(&self, model: &Model) -> Box<dyn Task> {
        let speed: Vec<f64> = model.dofs.iter().map(|d| d.velocity).collect();
        self.build_for(model, 0.01, &speed).unwrap_or_else(|e| panic!("{}: {e:?}", self.name))
    }
}

/// Rows that a task wrote.
pub struct Written {
    pub j: DMatrix<f64>,
    pub lower: DVector<f64>,
    pub upper: DVector<f64>,
    pub margins: Vec<f64>,
    pub measures: Vec<f64>,
    pub undefined: bool,
}

impl Written {
    /// J v of a row.
    pub fn rate(&self, row: usize, v: &[f64]) -> f64 {
        self.j.row(row).iter().zip(v).map(|(a, b)| a * b).sum()
    }
}

/// A robot at a configuration.
pub struct Place<'a> {
    pub model: &'a Model,
    pub data: Data,
    pub q: Vec<f64>,
    pub velocity: Vec<f64>,
}

impl<'a> Place<'a> {
    pub fn new(model: &'a Model, q: &[f64]) -> Self {
        let mut data = Data::new(model);
        model.forward(q, &mut data);
        Place { model, data, q: q.to_vec(), velocity: vec![0.0; model.nv()] }
    }

    /// This place after `dt` seconds of `v`.
    pub fn moved(&self, v: &[f64], dt: f64) -> Self {
        let mut q = self.q.clone();
        self.model.integrate(&mut q, v, dt);
        Place::new(self.model, &q)
    }

    pub fn state<'s>(&'s self, values: &'s [f64], rates: &'s [f64]) -> State<'s> {
        let velocity = &self.velocity;
        State { model: self.model, data: &self.data, q: &self.q, values, rates, velocity, stack_velocity: velocity }
    }

    /// Rows that the task writes at time `t`, into rows that are longer than the robot needs.
    pub fn write(&self, task: &mut dyn Task, case: &Case, t: f64) -> Result<Written, TaskFault> {
        let (n, nv) = (task.rows().len(), self.model.nv());
        let stride = nv + 3;
        let mut jacobian = vec![0.0; n * stride];
        let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
        let (mut margins, mut measures) = (vec![f64::INFINITY; n], vec![0.0; task.measures().len()]);
        let mut undefined = false;
        let values = case.values_at(t);
        for (i, dof) in task.degrees_of_freedom().into_iter().flatten().enumerate() {
            jacobian[i * stride + dof] = 1.0;
        }
        let mut rows = Rows {
            idle: &[],
            trial: false,
            jacobian: &mut jacobian,
            stride,
            lower: &mut lower,
            upper: &mut upper,
            margins: &mut margins,
            measures: &mut measures,
            undefined: &mut undefined,
        };
        task.update(&self.state(&values, &case.rates), &mut rows)?;
        assert!(jacobian.chunks(stride).all(|row| row[nv..].iter().all(|&x| x == 0.0)), "padding was written");
        let j = DMatrix::from_fn(n, nv, |i, k| jacobian[i * stride + k]);
        Ok(Written { j, lower: lower.into(), upper: upper.into(), margins, measures, undefined })
    }

    /// A value that `initial(name)` would capture.
    pub fn current_value(&self, task: &dyn Task, case: &Case, t: f64, name: &str, len: usize) -> Vec<f64> {
        let mut out = vec![0.0; len];
        let values = case.values_at(t);
        assert!(task.current_value(name, &self.state(&values, &case.rates), &mut out), "no value {name}");
        out
    }

    pub fn point(&self, link: LinkId) -> Vector3<f64> {
        self.data.pose(link).translation.vector
    }
}

/// The default of `turns`.
pub fn nearest() -> Bound {
    Bound::Choice("nearest".to_string())
}

/// A point on a link.
pub fn point(link: LinkId, rng: &mut impl FnMut() -> f64) -> Geometry {
    Geometry::point("point", link, vector(rng, 0.1))
}

/// A rotation from `w x y z`.
pub fn quaternion(a: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(a[0], a[1], a[2], a[3]))
}

/// The velocity with the least norm that meets the rows' lower bounds.
pub fn follow(w: &Written) -> Vec<f64> {
    let gram = &w.j * w.j.transpose();
    let x = gram.full_piv_lu().solve(&w.lower).expect("independent rows");
    (w.j.transpose() * x).iter().copied().collect()
}

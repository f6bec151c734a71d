//! Safety field: a mean over the robot, combined over the points of people, of a function of their distance.
//!
//! ```text
//! F_j = sum_l w_l int_0^1 chi(|p_l(s) - p_j|) ds     sum w_l = 1            thesis (4.2), (4.3), correction 8
//! F   = 1/m sum_j F_j  |  min_j F_j  |  -1/k log(sum_j exp(-k F_j))         thesis (4.4) is the first
//! dF/dt = gradient . v + human_rate                                         thesis (4.12)-(4.14)
//! ```
//!
//! The thesis sums over links, but its thresholds (0.75, 0.9) are those of a mean in metres, so the mean is used.

use nalgebra::Vector3;
use robot::{Data, Model};
use serde::{Deserialize, Serialize};

use crate::field::body::Body;
use crate::field::chi::Chi;
use crate::field::error::{SafetyError, setting};
use crate::field::line::line_mean;
use crate::field::quadrature::GaussLegendre;
use crate::field::segment::Mean;

/// A point of a person, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HumanPoint {
    /// \[m\]
    pub position: Vector3<f64>,
    /// \[m/s\]; an estimate or zero if it is not measured.
    pub velocity: Vector3<f64>,
}

impl HumanPoint {
    /// A point at rest.
    pub fn at_rest(position: Vector3<f64>) -> HumanPoint {
        HumanPoint { position, velocity: Vector3::zeros() }
    }
}

/// Combination of the points of people into one number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Their mean, as in the thesis. A point far away raises the field and so compensates for a near one.
    #[default]
    Mean,
    /// Their minimum. Its gradient is that of the point that attains it (the first of several) and jumps if that point
    /// changes; the row of one point alone then does not keep another from falling below the threshold within a tick.
    Least,
    /// A smooth lower bound of the minimum, `-1/k log(sum exp(-k F_j))`, so that keeping it above a threshold keeps
    /// every point there; it is lower than the minimum by at most `log(m) / k`. Suitable for a barrier.
    SoftLeast {
        /// k, positive, in the inverse unit of `chi` (1/m).
        sharpness: f64,
    },
}

/// The field with all its storage, for one robot. Call [`Field::update`] once per tick, then read the results.
#[derive(Clone, Debug)]
pub struct Field {
    body: Body,
    chi: Chi,
    over: Over,
    rule: GaussLegendre,
    capacity: usize,
    /// One mean per point and segment, point by point.
    means: Vec<Mean>,
    values: Vec<f64>,
    weights: Vec<f64>,
    human_gradients: Vec<Vector3<f64>>,
    /// For each link of the body: force and moment about the world's origin.
    wrenches: Vec<[Vector3<f64>; 2]>,
    gradient: Vec<f64>,
    value: f64,
    human_rate: f64,
    points: usize,
}

impl Field {
    /// Creates a field of `model` for up to `capacity` points.
    ///
    /// # Errors
    /// [`SafetyError::Setting`] for a reach or sharpness that is not positive.
    pub fn new(model: &Model, body: Body, chi: Chi, over: Over, capacity: usize) -> Result<Field, SafetyError> {
        chi.check()?;
        if let Over::SoftLeast { sharpness } = over {
            setting("sharpness", sharpness, sharpness > 0.0 && sharpness.is_finite(), "positive and finite")?;
        }
        if body.links().iter().any(|l| l.index() >= model.links.len()) {
            return Err(SafetyError::Body);
        }
        Ok(Field {
            chi,
            over,
            rule: GaussLegendre::new(),
            capacity,
            means: vec![Mean::ZERO; capacity * body.segments().len()],
            values: vec![f64::INFINITY; capacity],
            weights: vec![0.0; capacity],
            human_gradients: vec![Vector3::zeros(); capacity],
            wrenches: vec![[Vector3::zeros(); 2]; body.links().len()],
            gradient: vec![0.0; model.nv()],
            value: f64::INFINITY,
            human_rate: 0.0,
            points: 0,
            body,
        })
    }

    /// Evaluates the field and its derivatives; `model` is the one it was made for, `data` its kinematics of this tick.
    /// Without a point the field is infinite and its derivatives are zero: nobody is there. Never allocates.
    ///
    /// # Errors
    /// [`SafetyError::TooManyPoints`], [`SafetyError::Human`] for a point that is not finite,
    /// [`SafetyError::NotFinite`] if the field is not. The results must then not be used.
    pub fn update(&mut self, model: &Model, data: &Data, points: &[HumanPoint]) -> Result<(), SafetyError> {
        self.points = 0;
        self.value = f64::NAN;
        if points.len() > self.capacity {
            return Err(SafetyError::TooManyPoints { given: points.len(), capacity: self.capacity });
        }
        if model.nv() != self.gradient.len() {
            return Err(SafetyError::Shape { name: "model" });
        }
        self.body.place(data);
        let count = self.body.segments().len();
        for (j, point) in points.iter().enumerate() {
            let h = &point.position;
            if !h.iter().chain(point.velocity.iter()).all(|x| x.is_finite()) {
                return Err(SafetyError::Human { point: j });
            }
            let mut value = 0.0;
            let means = &mut self.means[j * count..(j + 1) * count];
            for ((mean, s), [a, b]) in means.iter_mut().zip(self.body.segments()).zip(self.body.ends()) {
                *mean = line_mean(&self.chi, &self.rule, &(a - h), &(b - h));
                value += s.weight * mean.value;
            }
            if !value.is_finite() {
                return Err(SafetyError::Human { point: j });
            }
            self.values[j] = value;
        }
        self.points = points.len();
        self.combine();
        self.derive(model, data, points);
        let finite = self.gradient.iter().all(|g| g.is_finite()) && self.human_rate.is_finite();
        if self.value.is_nan() || !finite { Err(SafetyError::NotFinite { name: "safety field" }) } else { Ok(()) }
    }

    pub(super) fn body_mut(&mut self) -> &mut Body {
        &mut self.body
    }

    /// Computes the field from the values of the points, and the weight of each in its gradient.
    fn combine(&mut self) {
        let (values, weights) = (&self.values[..self.points], &mut self.weights[..self.points]);
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        if values.is_empty() {
            self.value = f64::INFINITY;
            return;
        }
        match self.over {
            Over::Mean => {
                let share = 1.0 / values.len() as f64;
                weights.fill(share);
                self.value = values.iter().map(|v| share * v).sum();
            }
            Over::Least => {
                let first = values.iter().position(|v| *v == least);
                weights.iter_mut().enumerate().for_each(|(j, w)| *w = f64::from(u8::from(Some(j) == first)));
                self.value = least;
            }
            Over::SoftLeast { sharpness } => {
                for (w, v) in weights.iter_mut().zip(values) {
                    *w = (-sharpness * (v - least)).exp();
                }
                let sum: f64 = weights.iter().sum();
                weights.iter_mut().for_each(|w| *w /= sum);
                self.value = least - sum.ln() / sharpness;
            }
        }
    }

    /// Computes the gradient in the velocity, those in the points, and the rate by the people.
    fn derive(&mut self, model: &Model, data: &Data, points: &[HumanPoint]) {
        self.wrenches.fill([Vector3::zeros(); 2]);
        self.gradient.fill(0.0);
        self.human_rate = 0.0;
        let count = self.body.segments().len();
        for (j, point) in points.iter().enumerate() {
            self.human_gradients[j] = Vector3::zeros();
            let weight = self.weights[j];
            if weight == 0.0 {
                continue;
            }
            let parts = self.body.segments().iter().zip(self.body.slots()).zip(self.body.ends());
            for (mean, ((s, slots), ends)) in self.means[j * count..(j + 1) * count].iter().zip(parts) {
                for ((g, slot), p) in [mean.start, mean.end].iter().zip(slots).zip(ends) {
                    let force = g * (weight * s.weight);
                    let [f, m] = &mut self.wrenches[*slot];
                    *f += force;
                    *m += p.cross(&force);
                    self.human_gradients[j] -= force;
                }
            }
            self.human_rate += self.human_gradients[j].dot(&point.velocity);
        }
        for (link, [force, moment]) in self.body.links().iter().zip(&self.wrenches) {
            data.add_wrench(model, *link, force, moment, &mut self.gradient);
        }
    }

    /// F, in the unit of `chi` (m for the distance); infinite without a point.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Gradient: dF/dt is this times the velocity `v`, plus [`Field::human_rate`]; nv numbers.
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    /// Contribution of the people's own motion to dF/dt, per s.
    pub fn human_rate(&self) -> f64 {
        self.human_rate
    }

    /// dF/dt for the velocity `v` (nv numbers), people included. With the velocity that the hierarchy returned it is
    /// the actual rate of the field, which may differ from the one that a safety planner expected.
    pub fn rate(&self, v: &[f64]) -> f64 {
        self.gradient.iter().zip(v).map(|(g, v)| g * v).sum::<f64>() + self.human_rate
    }

    /// F_j of each point of the last update.
    pub fn values(&self) -> &[f64] {
        &self.values[..self.points]
    }

    /// dF/dp_j of each point of the last update.
    pub fn human_gradients(&self) -> &[Vector3<f64>] {
        &self.human_gradients[..self.points]
    }

    /// Index of the point with the smallest F_j; `None` without points.
    pub fn nearest(&self) -> Option<usize> {
        let values = self.values();
        (0..values.len()).reduce(|best, j| if values[j] < values[best] { j } else { best })
    }

    /// Segments that represent the robot.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// The function of the distance.
    pub fn chi(&self) -> &Chi {
        &self.chi
    }

    /// Combination of the points of people into one number.
    pub fn over(&self) -> Over {
        self.over
    }

    /// Number of points that there is storage for.
    pub fn capacity(&self) -> usize {
        self.capacity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::testing::{rng, robots};
    use proptest::prelude::*;
    use robot::LinkId;

    fn kinds() -> Vec<(Chi, Over)> {
        vec![
            (Chi::Distance, Over::Mean),
            (Chi::Distance, Over::Least),
            (Chi::Clamped { reach: 1.1 }, Over::SoftLeast { sharpness: 7.0 }),
            (Chi::Saturating { reach: 0.8 }, Over::Mean),
        ]
    }

    fn field(model: &Model, chi: Chi, over: Over) -> Field {
        let links: Vec<LinkId> = (0..model.links.len() as u32).map(LinkId).collect();
        let Ok(body) = Body::of_links(model, &links) else { panic!("{model:?}") };
        let Ok(field) = Field::new(model, body, chi, over, 3) else { panic!("{over:?}") };
        field
    }

    fn people(rng: &mut impl FnMut() -> f64, reach: f64) -> [HumanPoint; 3] {
        std::array::from_fn(|_| HumanPoint {
            position: Vector3::from_fn(|_, _| reach * (2.0 * rng() - 1.0)),
            velocity: Vector3::from_fn(|_, _| 2.0 * rng() - 1.0),
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn the_rate_is_the_derivative(seed in any::<u64>(), reach in 0.1..3.0f64) {
            let mut rng = rng(seed);
            for model in robots() {
                for (chi, over) in kinds() {
                    let least = over == Over::Least;
                    let mut field = field(&model, chi, over);
                    let mut data = Data::new(&model);
                    let q = model.random_configuration(&mut rng);
                    let v: Vec<f64> = (0..model.nv()).map(|_| 2.0 * rng() - 1.0).collect();
                    let people = people(&mut rng, reach);
                    let e = 1e-6;
                    let mut at = |t: f64| {
                        let mut q = q.clone();
                        model.integrate(&mut q, &v, t);
                        model.forward(&q, &mut data);
                        let moved = people.map(|p| HumanPoint { position: p.position + p.velocity * t, ..p });
                        field.update(&model, &data, &moved).map(|()| {
                            (field.value(), field.rate(&v), field.nearest())
                        })
                    };
                    let (Ok(plus), Ok(minus), Ok(here)) = (at(e), at(-e), at(0.0)) else { panic!("not finite") };
                    // The minimum has a derivative where the nearest point does not change.
                    prop_assume!(!least || plus.2 == minus.2);
                    let expected = (plus.0 - minus.0) / (2.0 * e);
                    prop_assert!((here.1 - expected).abs() < 2e-5 * (1.0 + expected.abs()), "{} {expected} {over:?}", here.1);
                }
            }
        }

        #[test]
        fn the_soft_least_lies_below_the_least(seed in any::<u64>(), sharpness in 0.5..200.0f64) {
            let mut rng = rng(seed);
            let model = &robots()[0];
            let mut data = Data::new(model);
            model.forward(&model.random_configuration(&mut rng), &mut data);
            let people = people(&mut rng, 2.0);
            let mut soft = field(model, Chi::Distance, Over::SoftLeast { sharpness });
            let mut least = field(model, Chi::Distance, Over::Least);
            prop_assert!(soft.update(model, &data, &people).is_ok() && least.update(model, &data, &people).is_ok());
            let gap = least.value() - soft.value();
            prop_assert!((-1e-12..=3f64.ln() / sharpness + 1e-12).contains(&gap), "{gap}");
            prop_assert_eq!(Some(least.value()), least.values().iter().copied().reduce(f64::min));
        }
    }

    #[test]
    fn the_mean_is_a_mean_over_links_and_points() {
        // From far away every part of the robot has the same distance.
        for model in robots() {
            let mut field = field(&model, Chi::Distance, Over::Mean);
            let data = Data::new(&model);
            let far = HumanPoint { position: Vector3::new(1e7, 0.0, 0.0), velocity: Vector3::x() };
            assert_eq!(field.update(&model, &data, &[far, far]), Ok(()));
            assert!((field.value() - 1e7).abs() < 10.0 && (field.human_rate() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn people_inside_the_robot_give_numbers() {
        for model in robots() {
            for (chi, over) in kinds() {
                let mut field = field(&model, chi, over);
                let data = Data::new(&model);
                let mut places: Vec<Vector3<f64>> =
                    (0..model.links.len() as u32).map(|l| *data.position(LinkId(l))).collect();
                field.body.place(&data);
                places.extend(field.body().ends().iter().map(|[a, b]| (a + b) * 0.5));
                for p in places {
                    let human = HumanPoint { position: p, velocity: Vector3::repeat(1.0) };
                    assert_eq!(field.update(&model, &data, &[human, human]), Ok(()));
                    let bounded = field.gradient().iter().all(|g| g.abs() < 100.0);
                    assert!(bounded && field.human_rate().abs() <= 3f64.sqrt() + 1e-9);
                }
            }
        }
    }

    #[test]
    fn nobody_and_nonsense() {
        let model = &robots()[0];
        let data = Data::new(model);
        let mut field = field(model, Chi::Distance, Over::Mean);
        assert_eq!(field.update(model, &data, &[]), Ok(()));
        assert_eq!((field.value(), field.human_rate(), field.nearest()), (f64::INFINITY, 0.0, None));
        assert!(field.gradient().iter().all(|g| *g == 0.0));
        let good = HumanPoint::at_rest(Vector3::x());
        for bad in [f64::NAN, f64::INFINITY, 1e200] {
            let points = [good, HumanPoint::at_rest(Vector3::new(0.0, bad, 0.0))];
            assert_eq!(field.update(model, &data, &points), Err(SafetyError::Human { point: 1 }));
            assert!(field.value().is_nan() && field.values().is_empty(), "nothing that looks like a result");
        }
        let points = [good, HumanPoint { velocity: Vector3::repeat(f64::NAN), ..good }];
        assert_eq!(field.update(model, &data, &points), Err(SafetyError::Human { point: 1 }));
        assert_eq!(field.update(model, &data, &[good; 4]), Err(SafetyError::TooManyPoints { given: 4, capacity: 3 }));
        assert_eq!(field.update(model, &data, &[good]), Ok(()));
        let body = || Body::of_links(model, &[model.root()]);
        let Ok(one) = body() else { panic!("the root is a body") };
        assert!(Field::new(model, one.clone(), Chi::Clamped { reach: 0.0 }, Over::Mean, 1).is_err());
        assert!(Field::new(model, one, Chi::Distance, Over::SoftLeast { sharpness: f64::NAN }, 1).is_err());
    }
}

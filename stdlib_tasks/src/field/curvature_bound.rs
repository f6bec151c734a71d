//! Bound on the downward curvature of the field between two ticks: its margin in sampled time (correction 13).
//!
//! The distance between a point of a person and a point `a + s (b - a)` of a segment is a convex function of all of
//! `a`, `b` and the person's point, and so is any mean of such distances: along their velocities the field falls no
//! faster than its derivative predicts. It curves downwards only as far as the ends themselves leave their straight
//! lines, and an inner point accelerates as the mean of the ends. With `A_l`, `A'_l` the bounds of the ends'
//! accelerations,
//!
//! ```text
//! F(t + P) >= F + P F' - B P^2 / 2        B = sum_l w_l (A_l + A'_l) / 2
//! ```
//!
//! A concave `chi` adds `max |chi''| V^2`, a soft minimum `k V^2` (the variance of rates within ±V), where V is the
//! largest speed of any point of the robot and any of a person towards each other.

use crate::clearance::acceleration_bound;
use nalgebra::DMatrix;
use robot::{Data, Model};

use crate::field::chi::Chi;
use crate::field::value::{Field, Over};

impl Field {
    /// B: largest decrease of dF/dt over time \[unit of F per s²\] while each degree of freedom moves at a steady speed
    /// of at most `speed` (nv numbers), sliding joints are inside their limits, people do not accelerate, and no two
    /// points of robot and person move towards each other faster than `closing` \[m/s\] (used only for
    /// [`Chi::Saturating`] and [`Over::SoftLeast`]). `crate::clearance::loss(B, period, gain)` is the depth below its
    /// threshold at which the field may settle, and the amount that prevents this if it is added to the threshold.
    ///
    /// Infinite if it has no bound: for a joint without a speed, [`Chi::Clamped`] and [`Chi::Given`], and for
    /// [`Over::Least`] of several points, where another point may become the nearest within a tick.
    pub fn curvature_bound(&self, model: &Model, speed: &[f64], closing: f64) -> f64 {
        let far = |end: &crate::field::Attached| acceleration_bound(model, None, end.link, end.at.norm(), speed);
        let ends: f64 = self.body().segments().iter().map(|s| 0.5 * s.weight * (far(&s.start) + far(&s.end))).sum();
        let square = closing * closing;
        let concave = match self.chi() {
            Chi::Distance => 0.0,
            Chi::Saturating { reach } => square / reach,
            Chi::Clamped { .. } | Chi::Given(_) => f64::INFINITY,
        };
        let between = match self.over() {
            Over::Mean => 0.0,
            Over::SoftLeast { sharpness } => sharpness * square,
            Over::Least if self.capacity() <= 1 => 0.0,
            Over::Least => f64::INFINITY,
        };
        ends + concave + between
    }

    /// Largest effect of each degree of freedom on the field at a configuration, for any positions of people: the mean
    /// over the segments of the lengths of their ends' columns of the Jacobian, nv numbers.
    pub fn levers(&mut self, model: &Model, data: &Data) -> Vec<f64> {
        let n = model.nv();
        let (mut levers, mut jacobian) = (vec![0.0; n], DMatrix::zeros(6, n));
        let body = self.body_mut();
        body.place(data);
        for (segment, ends) in body.segments().iter().zip(body.ends()) {
            for (end, point) in [&segment.start, &segment.end].into_iter().zip(ends) {
                jacobian.fill(0.0);
                data.jacobian(model, end.link, point, &mut jacobian);
                for (lever, column) in levers.iter_mut().zip(jacobian.column_iter()) {
                    *lever += 0.5 * segment.weight * column.fixed_rows::<3>(0).norm();
                }
            }
        }
        levers
    }
}

#[cfg(test)]
mod tests {
    use crate::field::testing::{rng, robots, vector};
    use crate::field::{Body, Chi, Field, HumanPoint, Over, mean_distance};
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use robot::{Data, LinkId};

    proptest! {
        #[test]
        fn the_mean_distance_is_convex(a in vector(1.0), b in vector(1.0), da in vector(2.0), db in vector(2.0)) {
            let here = mean_distance(&a, &b);
            let there = mean_distance(&(a + da), &(b + db)).value;
            prop_assert!(there >= here.value + here.start.dot(&da) + here.end.dot(&db) - 1e-12);
        }

        /// Long periods, so that the curvature matters.
        #[test]
        fn a_step_loses_no_more_than_it_says(seed in any::<u64>(), period in 0.01..0.5f64) {
            let mut rng = rng(seed);
            for model in robots() {
                for (chi, over) in [
                    (Chi::Distance, Over::Mean),
                    (Chi::Saturating { reach: 0.7 }, Over::Mean),
                    (Chi::Distance, Over::SoftLeast { sharpness: 5.0 }),
                ] {
                    let links: Vec<LinkId> = (0..model.links.len() as u32).map(LinkId).collect();
                    let Ok(body) = Body::of_links(&model, &links) else { panic!() };
                    let Ok(mut field) = Field::new(&model, body, chi, over, 3) else { panic!() };
                    let mut data = Data::new(&model);
                    let q = model.random_configuration(&mut rng);
                    let v: Vec<f64> = (0..model.nv()).map(|_| 2.0 * rng() - 1.0).collect();
                    let mut people: Vec<HumanPoint> = (0..3).map(|_| HumanPoint {
                        position: Vector3::from_fn(|_, _| 3.0 * rng() - 1.5),
                        velocity: Vector3::from_fn(|_, _| 2.0 * rng() - 1.0),
                    }).collect();
                    model.forward(&q, &mut data);
                    prop_assert!(field.update(&model, &data, &people).is_ok());
                    let rate = field.rate(&v);
                    let before = field.value();
                    // The fastest end along the motion, by differences, and the fastest person.
                    let (steps, mut next, mut fastest) = (20, q.clone(), 0.0f64);
                    let mut ends = field.body().ends().to_vec();
                    for _ in 0..steps {
                        model.integrate(&mut next, &v, period / f64::from(steps));
                        model.forward(&next, &mut data);
                        prop_assert!(field.update(&model, &data, &people).is_ok());
                        for (a, b) in ends.iter().flatten().zip(field.body().ends().iter().flatten()) {
                            fastest = fastest.max((a - b).norm() * f64::from(steps) / period);
                        }
                        ends = field.body().ends().to_vec();
                    }
                    let slides = |k: usize| model.dofs[k].q_index.is_some_and(|i| !(model.dofs[k].lower..=model.dofs[k].upper).contains(&next[i]));
                    if (0..model.nv()).any(slides) {
                        continue;
                    }
                    people.iter_mut().for_each(|p| p.position += p.velocity * period);
                    let walking = people.iter().map(|p| p.velocity.norm()).fold(0.0, f64::max);
                    prop_assert!(field.update(&model, &data, &people).is_ok());
                    let speed: Vec<f64> = v.iter().map(|v| v.abs()).collect();
                    let bend = field.curvature_bound(&model, &speed, 1.02 * fastest + walking);
                    let least = before + period * rate - 0.5 * bend * period * period;
                    prop_assert!(field.value() >= least - 1e-7, "{} {least} {over:?}", field.value());
                    prop_assert!(bend.is_finite());
                }
            }
        }
    }

    #[test]
    fn what_nothing_bounds_is_infinite() {
        let model = &robots()[0];
        let new = |chi, over, capacity| {
            let Ok(body) = Body::of_links(model, &[LinkId(3), LinkId(5)]) else { panic!() };
            let Ok(field) = Field::new(model, body, chi, over, capacity) else { panic!() };
            field.curvature_bound(model, &[1.0; 7], 1.0)
        };
        let plain = new(Chi::Distance, Over::Mean, 3);
        assert!(plain > 0.0 && plain.is_finite());
        assert_eq!(new(Chi::Distance, Over::Least, 1), plain);
        assert_eq!(new(Chi::Distance, Over::Least, 2), f64::INFINITY);
        assert_eq!(new(Chi::Clamped { reach: 1.0 }, Over::Mean, 1), f64::INFINITY);
        assert!((new(Chi::Saturating { reach: 0.5 }, Over::Mean, 1) - plain - 2.0).abs() < 1e-12);
        assert!((new(Chi::Distance, Over::SoftLeast { sharpness: 9.0 }, 2) - plain - 9.0).abs() < 1e-12);
    }
}

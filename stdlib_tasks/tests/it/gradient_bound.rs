//! Bounds of slopes against the rows that limits write on random trees, and where they are reached.

use hierarq_stdlib_tasks::bound::{Bound, Geometry};
use nalgebra::Isometry3;
use proptest::prelude::*;
use robot::{Base, LinkId, Model, Shape};

use crate::clearance::{any_bases, trees};
use crate::common::*;

/// A shape of any kind on a link.
fn part(name: &str, link: LinkId, rng: &mut impl FnMut() -> f64) -> Geometry {
    let shape = match (4.0 * rng()) as usize {
        0 => Shape::Sphere { radius: 0.0 },
        1 => Shape::Sphere { radius: 0.05 },
        2 => Shape::Capsule { radius: 0.02, half_length: 0.3 * rng() },
        _ => Shape::Box { half: [0.2 * rng(), 0.2 * rng(), 0.2 * rng()] },
    };
    let origin = Isometry3::from_parts(vector(rng, 0.4).into(), rotation(rng));
    Geometry { name: name.to_string(), link, origin, shape }
}

fn check(model: &Model, seed: u64) -> Result<(), TestCaseError> {
    let mut rng = rng(seed);
    let any = |rng: &mut dyn FnMut() -> f64| LinkId((rng() * model.links.len() as f64) as u32);
    let (a, b) = (any(&mut rng), any(&mut rng));
    let (a, b) = (part("a", a, &mut rng), part("b", b, &mut rng));
    let mut wall = Case::new("virtual_wall")
        .with("points", Bound::Geometries(vec![a.clone()]))
        .number("through", &std::array::from_fn::<f64, 9, _>(|_| 2.0 * rng() - 1.0))
        .number("d_min", &[0.1])
        .number("gain", &[1.0])
        .number("sampled_margin", &[0.0]);
    if rng() < 0.5 {
        wall = wall.with("on", Bound::Frame("on".to_string(), b.link));
    }
    let apart = Case::new("self_collision")
        .with("between", Bound::Geometries(vec![a]))
        .with("and", Bound::Geometries(vec![b]))
        .number("d_min", &[0.0])
        .number("gain", &[1.0])
        .number("sampled_margin", &[0.0]);
    for case in [wall, apart] {
        let speed = vec![1.0; model.nv()];
        // Parts of one rigid body are refused.
        let Ok(mut task) = case.build_for(model, 0.01, &speed) else { continue };
        let slopes = task.gradient_bounds(model);
        prop_assert_eq!(slopes.len(), 1);
        for _ in 0..20 {
            let place = Place::new(model, &model.random_configuration(&mut rng));
            let Ok(written) = place.write(task.as_mut(), &case, 0.0) else { continue };
            // Parts that overlap are pushed apart along the last way that was good: that row is no slope of a distance.
            if case.name == "self_collision" && written.margins[0] <= 0.0 {
                continue;
            }
            for (slope, steep) in slopes[0].iter().zip(written.j.row(0).iter()) {
                prop_assert!(steep.abs() <= slope * (1.0 + 1e-9) + 1e-12, "{}: {} and {}", case.name, steep, slope);
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_row_is_steeper_than_its_bound(seed: u64, links in 1_usize..8, bases in any_bases()) {
        let model = trees(seed, links, &bases);
        check(&model, seed)?;
    }
}

/// The tool of the stretched arm turns about its base as fast as it is far away: there the bound is reached.
#[test]
fn the_bound_is_reached_by_a_stretched_arm() {
    let model = read(
        "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>\
         <joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 1 0\"/>\
         <limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>\
         <joint name=\"k\" type=\"revolute\"><parent link=\"b\"/><child link=\"c\"/><origin xyz=\"0.5 0 0\"/><axis xyz=\"0 1 0\"/>\
         <limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint></robot>",
        Base::Fixed,
    );
    let tip = Geometry::point("tip", model.link("c").unwrap(), nalgebra::Vector3::new(0.25, 0.0, 0.0));
    let case = Case::new("virtual_wall")
        .with("points", Bound::Geometries(vec![tip]))
        .number("through", &[0.0, 0.0, -1.0, 1.0, 0.0, -1.0, 0.0, 1.0, -1.0])
        .number("d_min", &[0.0])
        .number("gain", &[1.0])
        .number("sampled_margin", &[0.0]);
    let mut task = case.build(&model);
    assert_eq!(task.gradient_bounds(&model), [[0.75, 0.25]]);
    let written = Place::new(&model, &[0.0, 0.0]).write(task.as_mut(), &case, 0.0).unwrap();
    assert!((written.j[(0, 0)].abs() - 0.75).abs() < 1e-12 && (written.j[(0, 1)].abs() - 0.25).abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Wherever the joints stand, a point is in its ball, as seen from another link and from the world.
    #[test]
    fn no_point_leaves_its_reach(seed: u64, links in 1_usize..8, bases in any_bases()) {
        let model = trees(seed, links, &bases);
        let mut rng = rng(seed);
        let any = |rng: &mut dyn FnMut() -> f64| LinkId((rng() * model.links.len() as f64) as u32);
        let (to, from, point) = (any(&mut rng), any(&mut rng), vector(&mut rng, 0.5));
        for from in [None, Some(from)] {
            let (centre, radius) = hierarq_stdlib_tasks::gradient_bound::reach(&model, from, to, &point);
            for _ in 0..20 {
                let place = Place::new(&model, &model.random_configuration(&mut rng));
                let from = from.map_or(nalgebra::Isometry3::identity(), |from| *place.data.pose(from));
                let seen = from.inverse() * place.data.pose(to);
                let away = (seen * nalgebra::Point3::from(point)).coords - centre;
                prop_assert!(away.norm() <= radius * (1.0 + 1e-9) + 1e-9, "{} of {}", away.norm(), radius);
            }
        }
    }
}

//! Spots of a soup, against all of its elements one by one.

use hierarq_robot::geometry::{closest_point_triangle, closest_segment_triangle};
use hierarq_robot::{Closest, Degenerate, Frontier, Hull, Search, Shape, Soup, SoupError, Spot, closest};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use crate::common::{pose, rng, vector};

type Elements = Vec<Vec<Vector3<f64>>>;

/// Elements of some number of corners each, strewn or on a lattice.
fn elements(count: usize, corners: usize, rng: &mut impl FnMut() -> f64) -> Elements {
    let mut one = |_| {
        let middle = vector(rng, 1.5);
        (0..corners).map(|_| middle + vector(rng, 0.2)).collect()
    };
    (0..count).map(&mut one).collect()
}

fn part(kind: u32, rng: &mut impl FnMut() -> f64) -> Shape {
    match kind {
        0 => Shape::Sphere { radius: 0.1 * rng() },
        1 => Shape::Capsule { radius: 0.1 * rng(), half_length: 0.3 * rng() },
        2 => Shape::Box { half: [0.2 * rng(), 0.2 * rng(), 0.2 * rng()] },
        3 => Shape::Cylinder { radius: 0.2 * rng(), half_length: 0.2 * rng() },
        _ => Shape::Hull(Hull::around(&elements(1, 8, rng)[0]).unwrap().1),
    }
}

/// The closest points of a shape and an element by the functions for convex shapes.
fn one_by_one(
    corners: &[Vector3<f64>],
    radius: f64,
    a: (&Shape, &Isometry3<f64>),
    X_WS: &Isometry3<f64>,
) -> Result<Closest, Degenerate> {
    let (shape, X_Wa) = a;
    let (middle, hull) = Hull::around(corners).unwrap();
    let X_We = X_WS * Isometry3::translation(middle.x, middle.y, middle.z);
    if corners.len() == 1 {
        return closest(shape, X_Wa, &Shape::Sphere { radius }, &X_We);
    }
    let c = closest(shape, X_Wa, &Shape::Hull(hull), &X_We)?;
    Ok(Closest { distance: c.distance - radius, on_b: c.on_b + c.normal * radius, ..c })
}

/// Height of the nearest point on the axis of a capsule.
fn along(shape: &Shape, X_Wa: &Isometry3<f64>, c: &Closest) -> f64 {
    match *shape {
        Shape::Capsule { radius, .. } => X_Wa.inverse_transform_point(&(c.on_a + c.normal * radius).into()).z,
        _ => 0.0,
    }
}

/// True if the spot stands for an element with these closest points, up to a slack.
fn stands_for(spot: &Spot, (shape, X_Wa): (&Shape, &Isometry3<f64>), c: &Closest, slack: f64) -> bool {
    let s = &spot.closest;
    let away = c.on_b - s.on_b;
    let near = match *shape {
        Shape::Sphere { .. } => true,
        Shape::Capsule { half_length, .. } => {
            (along(shape, X_Wa, c) - along(shape, X_Wa, s)).abs() <= half_length + slack
        }
        _ => (c.on_a - s.on_a).norm() <= shape.bounding_radius() + slack,
    };
    near && s.normal.dot(&away) - 0.25 * away.norm() - 0.1 * s.distance.max(0.0) <= 1e-6 + slack
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn spots_are_the_nearest_elements_that_none_before_stands_for(
        seed in any::<u64>(), kind in 0u32..5, count in 1usize..400, corners in 0usize..4, most in 1usize..7,
    ) {
        let mut rng = rng(seed);
        let corners = [1, 1, 3, 6][corners];
        let soup = Soup::new(&elements(count, corners, &mut rng), if corners == 1 { 0.05 * rng() } else { 0.0 }).unwrap();
        let (shape, X_Wa, X_WS) = (part(kind, &mut rng), pose(&mut rng, 1.5), pose(&mut rng, 1.0));
        let range = if rng() < 0.5 { f64::INFINITY } else { 2.0 * rng() };
        let mut spots = vec![None; most];
        let search = soup.spots(&shape, &X_Wa, &X_WS, range, &mut spots, &mut Frontier::default());
        let found: Vec<Spot> = spots.iter().copied().flatten().collect();
        // The distance of bodies that are approached is exact to 1e-10; with a body that touches, a gap counts or not.
        let slack = 1e-5;
        let mut touching = false;
        for i in 0..soup.len() {
            match one_by_one(soup.corners(i), soup.radius(), (&shape, &X_Wa), &X_WS) {
                Err(_) => touching = true,
                Ok(c) => {
                    let last = found.last().filter(|_| found.len() == most);
                    let far = last.is_some_and(|s| c.distance >= s.closest.distance - 1e-9) || c.distance >= range;
                    let taken = found.iter().any(|s| s.element == i || stands_for(s, (&shape, &X_Wa), &c, slack));
                    prop_assert!(far || taken, "{i} at {} of {:?}", c.distance, found);
                }
            }
        }
        prop_assert_eq!(search == Search::Touching, touching);
        match soup.nearest(&shape, &X_Wa, &X_WS) {
            Ok(near) => prop_assert_eq!((near.element, near.closest), (found[0].element, found[0].closest)),
            Err(why) => prop_assert!(why == Search::Touching && touching),
        }
        for (k, spot) in found.iter().enumerate() {
            let alone = soup.closest_to(spot.element, &shape, &X_Wa, &X_WS).unwrap();
            prop_assert!((alone.distance - spot.closest.distance).abs() < 1e-12);
            let expected = one_by_one(soup.corners(spot.element), soup.radius(), (&shape, &X_Wa), &X_WS).unwrap();
            prop_assert!((expected.distance - spot.closest.distance).abs() < 1e-9, "{expected:?} {spot:?}");
            let c = &spot.closest;
            prop_assert!((c.normal.dot(&(c.on_a - c.on_b)) - c.distance).abs() < 1e-9);
            for before in &found[..k] {
                prop_assert!(before.closest.distance <= spot.closest.distance && spot.closest.distance < range);
                prop_assert!(!stands_for(before, (&shape, &X_Wa), &spot.closest, -slack));
            }
        }
    }

    /// The nearest point of a triangle is where no step along its plane comes nearer.
    #[test]
    fn the_nearest_points_of_triangles(seed in any::<u64>(), thin in 0u32..4) {
        let mut rng = rng(seed);
        let mut t = [vector(&mut rng, 1.0), vector(&mut rng, 1.0), vector(&mut rng, 1.0)];
        if thin == 0 {
            // Without area, or nearly so.
            t[2] = t[0] + (t[1] - t[0]) * (2.0 * rng() - 0.5) + vector(&mut rng, 1e-9);
        }
        let (s0, s1) = (vector(&mut rng, 1.0), vector(&mut rng, 1.0));
        let (p, q) = closest_segment_triangle(&s0, &s1, &t);
        let least = (p - q).norm();
        for i in 0..=24 {
            let s = s0 + (s1 - s0) * (f64::from(i) / 24.0);
            let on = closest_point_triangle(&s, &t);
            prop_assert!((s - on).norm() >= least - 1e-9);
            for j in 0..=12 {
                for k in 0..=12 - j {
                    let [u, v] = [j, k].map(|x| f64::from(x) / 12.0);
                    let other = t[0] * (1.0 - u - v) + t[1] * u + t[2] * v;
                    prop_assert!((s - other).norm() >= (s - on).norm() - 1e-9);
                }
            }
        }
        // The points are on the segment and in the triangle.
        let along = (p - s0).dot(&(s1 - s0)) / (s1 - s0).norm_squared();
        prop_assert!((s0 + (s1 - s0) * along.clamp(0.0, 1.0) - p).norm() < 1e-9);
        prop_assert!((closest_point_triangle(&q, &t) - q).norm() < 1e-9);
    }

    #[test]
    fn a_soup_is_read_back_as_written(seed in any::<u64>(), count in 1usize..200, same in any::<bool>()) {
        let mut rng = rng(seed);
        let mut all = elements(count, 2, &mut rng);
        if same {
            // Coordinates that are equal.
            all.iter_mut().flatten().for_each(|p| p.apply(|x| *x = (2.0 * *x).round()));
        }
        let soup = Soup::new(&all, 0.01).unwrap();
        let read: Soup = serde_json::from_str(&serde_json::to_string(&soup).unwrap()).unwrap();
        prop_assert_eq!(read, soup);
    }
}

#[test]
fn two_walls_of_points_are_a_spot_each() {
    // Walls at y = -1 and y = 0.9 with a point every 5 cm.
    let wall = |y: f64| (0..1600).map(move |i| [Vector3::new(f64::from(i % 40) * 0.05, y, f64::from(i / 40) * 0.05)]);
    let soup = Soup::new(&wall(-1.0).chain(wall(0.9)).collect::<Vec<_>>(), 0.02).unwrap();
    let ball = Shape::Sphere { radius: 0.1 };
    let mut spots = [None; 4];
    let at = Isometry3::translation(1.0, 0.0, 1.0);
    assert_eq!(
        soup.spots(&ball, &at, &Isometry3::identity(), f64::INFINITY, &mut spots, &mut Frontier::default()),
        Search::Apart
    );
    let found: Vec<_> = spots.iter().flatten().map(|s| (s.closest.distance, s.closest.normal.y)).collect();
    assert_eq!(found.len(), 2);
    assert!((found[0].0 - 0.78).abs() < 1e-12 && (found[1].0 - 0.88).abs() < 1e-12, "{found:?}");
    assert!(found[0].1 < -0.999 && found[1].1 > 0.999, "{found:?}");
    // A rod along the walls may turn towards each with either end.
    let rod = Shape::Capsule { radius: 0.1, half_length: 0.4 };
    let lying = Isometry3::from_parts(at.translation, nalgebra::UnitQuaternion::from_euler_angles(0.0, 1.5, 0.05));
    soup.spots(&rod, &lying, &Isometry3::identity(), f64::INFINITY, &mut spots, &mut Frontier::default());
    let sides: Vec<f64> = spots.iter().flatten().map(|s| s.closest.normal.y.signum()).collect();
    assert!(sides.contains(&1.0) && sides.contains(&-1.0), "{sides:?}");
}

#[test]
fn what_is_no_soup() {
    let no: [[Vector3<f64>; 1]; 0] = [];
    assert_eq!(Soup::new(&no, 0.1).unwrap_err(), SoupError::Empty);
    assert_eq!(Soup::new(&[vec![]; 1] as &[Vec<_>; 1], 0.1).unwrap_err(), SoupError::Corners(0));
    assert_eq!(Soup::new(&[[Vector3::new(0.0, f64::NAN, 0.0)]], 0.1).unwrap_err(), SoupError::NotFinite);
    assert_eq!(Soup::new(&[[Vector3::zeros()]], -0.1).unwrap_err(), SoupError::NotFinite);
    assert_eq!(Soup::new(&vec![[Vector3::zeros()]; 200_001], 0.1).unwrap_err(), SoupError::TooMany(200_001));
    // Poses that are measured may be anything.
    let soup = Soup::new(&[[Vector3::zeros()]], 0.1).unwrap();
    let nan = Isometry3::translation(f64::NAN, 0.0, 0.0);
    let ball = Shape::Sphere { radius: 0.1 };
    let mut spots = [None];
    assert_eq!(
        soup.spots(&ball, &nan, &Isometry3::identity(), f64::INFINITY, &mut spots, &mut Frontier::default()),
        Search::NotFinite
    );
    assert_eq!(
        soup.spots(&ball, &Isometry3::identity(), &nan, 1.0, &mut spots, &mut Frontier::default()),
        Search::NotFinite
    );
    assert_eq!(
        soup.spots(
            &ball,
            &Isometry3::identity(),
            &Isometry3::identity(),
            f64::INFINITY,
            &mut spots,
            &mut Frontier::default()
        ),
        Search::Touching
    );
    assert!(spots[0].is_none());
}

//! Convex pieces of meshes, against brute force over triangles and sampled points.

use hierarq_robot::geometry::closest_point_triangle;
use hierarq_robot::{Excess, MOST_PIECES, Pieces, PlacedShape, Shape, Surface, SurfaceError, closest};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use crate::common::{pose, rng, vector};

type Triangle = [Vector3<f64>; 3];

/// The surface of the filled cells of a grid, anticlockwise from outside.
fn blocks(x: &[f64], y: &[f64], z: &[f64], filled: impl Fn(usize, usize, usize) -> bool) -> Vec<Triangle> {
    let lines = [x, y, z];
    let counts = [x.len() - 1, y.len() - 1, z.len() - 1];
    let is_filled = |cell: [i64; 3]| {
        let inside = (0..3).all(|i| (0..counts[i] as i64).contains(&cell[i]));
        inside && filled(cell[0] as usize, cell[1] as usize, cell[2] as usize)
    };
    let mut all = Vec::new();
    for i in 0..counts[0] * counts[1] * counts[2] {
        let cell = [i % counts[0], i / counts[0] % counts[1], i / counts[0] / counts[1]].map(|k| k as i64);
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0i64), (axis, 1)]) {
            let mut beside = cell;
            beside[axis] += 2 * side - 1;
            if !is_filled(cell) || is_filled(beside) {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |du: i64, dv: i64| {
                let mut at = cell;
                (at[axis], at[u], at[v]) = (cell[axis] + side, cell[u] + du, cell[v] + dv);
                Vector3::from_fn(|k, _| lines[k][at[k] as usize])
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            all.extend(if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    all
}

fn table() -> Vec<Triangle> {
    let edge = |i: usize| i == 0 || i == 2;
    blocks(&[-0.5, -0.45, 0.45, 0.5], &[-0.3, -0.25, 0.25, 0.3], &[0.0, 0.7, 0.74], |x, y, z| {
        z == 1 || (edge(x) && edge(y))
    })
}

fn channel() -> Vec<Triangle> {
    blocks(&[0.0, 0.02, 0.1, 0.12], &[-0.1, 0.1], &[0.0, 0.02, 0.1], |x, _, z| z == 0 || x != 1)
}

/// A ring of radius `large` with a round section of radius `small`.
fn torus(large: f64, small: f64, count: usize) -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let [u, v] = [i, j].map(|k| std::f64::consts::TAU * (k % count) as f64 / count as f64);
        let r = large + small * v.cos();
        Vector3::new(r * u.cos(), r * u.sin(), small * v.sin())
    };
    let cell = |k: usize| {
        let (i, j) = (k / count, k % count);
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    };
    (0..count * count).flat_map(cell).collect()
}

/// A random heap of blocks of a grid.
fn heap(rng: &mut impl FnMut() -> f64) -> Vec<Triangle> {
    let line = |rng: &mut dyn FnMut() -> f64| {
        let mut line = vec![rng() - 0.5];
        (0..4).for_each(|i| line.push(line[i] + 0.05 + 0.2 * rng()));
        line
    };
    let (x, y, z) = (line(rng), line(rng), line(rng));
    let cells: Vec<bool> = (0..64).map(|_| rng() < 0.4).collect();
    blocks(&x, &y, &z, |i, j, k| cells[i + 4 * j + 16 * k] || (i, j, k) == (0, 0, 0))
}

/// The open crate of the examples, of five sheets.
fn crate_without_lid() -> Vec<Triangle> {
    let closed = blocks(&[-0.18, 0.18], &[-0.18, 0.18], &[0.0, 0.22], |_, _, _| true);
    closed.into_iter().filter(|t| !t.iter().all(|p| p.z == 0.22)).collect()
}

fn pieces(mesh: &[Triangle], within: f64) -> (Surface, Pieces) {
    let surface = Surface::new(mesh).unwrap();
    let pieces = surface.pieces(within).unwrap();
    (surface, pieces)
}

fn distance(shapes: &[PlacedShape], shape: &Shape, at: &Isometry3<f64>) -> f64 {
    let one = |s: &PlacedShape| closest(shape, at, &s.shape, &s.origin).map_or(f64::NEG_INFINITY, |c| c.distance);
    shapes.iter().map(one).fold(f64::INFINITY, f64::min)
}

fn point_distance(shapes: &[PlacedShape], p: &Vector3<f64>) -> f64 {
    distance(shapes, &Shape::Sphere { radius: 0.0 }, &Isometry3::translation(p.x, p.y, p.z))
}

fn by_brute_force(mesh: &[Triangle], p: &Vector3<f64>) -> f64 {
    mesh.iter().map(|t| (p - closest_point_triangle(p, t)).norm()).fold(f64::INFINITY, f64::min)
}

/// True if a ray crosses the mesh an odd number of times.
fn is_inside(mesh: &[Triangle], p: &Vector3<f64>) -> bool {
    let ray = Vector3::new(0.5411, 0.2309, 0.8087);
    let crosses = |[a, b, c]: &&Triangle| {
        let volume = |u: &Vector3<f64>, v: &Vector3<f64>| ray.dot(&(u - p).cross(&(v - p)));
        let (ab, bc, ca) = (volume(a, b), volume(b, c), volume(c, a));
        let same = (ab > 0.0) == (bc > 0.0) && (bc > 0.0) == (ca > 0.0);
        let normal = (b - a).cross(&(c - a));
        same && normal.dot(&(a - p)) / normal.dot(&ray) > 0.0
    };
    mesh.iter().filter(crosses).count() % 2 == 1
}

fn on_surface(mesh: &[Triangle], rng: &mut impl FnMut() -> f64) -> Vector3<f64> {
    let [a, b, c] = mesh[(rng() * mesh.len() as f64) as usize % mesh.len()];
    let (mut u, mut v) = (rng(), rng());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a + (b - a) * u + (c - a) * v
}

/// Checks the properties that every decomposition has.
fn check(mesh: &[Triangle], within: f64, rng: &mut impl FnMut() -> f64) -> Result<Pieces, TestCaseError> {
    let (surface, found) = pieces(mesh, within);
    let shapes = found.shapes();
    prop_assert_eq!(shapes.len(), found.corners.len());
    prop_assert!(found.excess <= within || shapes.len() == MOST_PIECES, "{} of {within}", found.excess);
    for p in mesh.iter().flatten() {
        prop_assert!(point_distance(&shapes, p) <= 1e-8, "vertex {p} at {}", point_distance(&shapes, p));
    }
    for _ in 0..200 {
        let p = on_surface(mesh, rng);
        prop_assert!(point_distance(&shapes, &p) <= 1e-8, "{p} at {}", point_distance(&shapes, &p));
    }
    let size = surface.extent();
    let parts = [Shape::Sphere { radius: 0.0 }, Shape::Capsule { radius: 0.02 * size, half_length: 0.2 * size }];
    for i in 0..200 {
        let part = &parts[i % 2];
        let at = pose(rng, 0.8 * size);
        let p = at.translation.vector;
        let inside = surface.is_closed() && is_inside(mesh, &p);
        prop_assert_eq!(surface.contains(&p), inside);
        let safe = distance(&shapes, part, &at);
        if i % 2 == 0 {
            let expected = by_brute_force(mesh, &p);
            let signed = if inside { -expected } else { expected };
            prop_assert!((surface.signed_distance(&p) - signed).abs() < 1e-9);
            if inside {
                prop_assert!(safe <= 1e-8, "{p} inside is {safe} away");
            } else {
                prop_assert!(safe <= expected + 1e-8, "{safe} above {expected}");
                prop_assert!(expected <= safe.max(0.0) + found.excess + 1e-8, "{expected} above {safe}");
            }
        } else {
            // Along its axis, a capsule is balls.
            let Shape::Capsule { radius, half_length } = *part else { continue };
            let ball = |k: i32| {
                by_brute_force(mesh, &(at * nalgebra::Point3::new(0.0, 0.0, half_length * f64::from(k) / 20.0)).coords)
            };
            let expected = (-20..=20).map(ball).fold(f64::INFINITY, f64::min) - radius;
            prop_assert!(safe <= expected + 1e-8, "{safe} above {expected}");
        }
    }
    Ok(found)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn pieces_of_heaps_contain_them_and_exceed_them_by_what_they_say(seed in any::<u64>()) {
        let mut rng = rng(seed);
        let mesh = heap(&mut rng);
        check(&mesh, 0.02, &mut rng)?;
    }
}

#[test]
fn pieces_of_named_bodies() {
    let mut rng = rng(5);
    for (mesh, within, count) in [
        (table(), 5e-3, 5..=6),
        (channel(), 5e-3, 3..=3),
        (blocks(&[0.0, 1.0], &[0.0, 2.0], &[0.0, 3.0], |_, _, _| true), 5e-3, 1..=1),
        (crate_without_lid(), 5e-3, 5..=64),
        (torus(0.2, 0.05, 24), 0.02, 4..=40),
    ] {
        let found = check(&mesh, within, &mut rng).unwrap();
        assert!(count.contains(&found.corners.len()), "{} of {count:?}", found.corners.len());
    }
}

#[test]
fn the_same_mesh_gives_the_same_pieces_in_every_thread() {
    let mesh = torus(0.2, 0.05, 16);
    let alone = pieces(&mesh, 0.01).1;
    let threads: Vec<_> = (0..4)
        .map(|_| {
            let mesh = mesh.clone();
            std::thread::spawn(move || pieces(&mesh, 0.01).1)
        })
        .collect();
    for thread in threads {
        assert_eq!(thread.join().unwrap(), alone);
    }
}

#[test]
fn a_mesh_may_be_turned_inside_out_open_degenerate_tiny_or_huge() {
    let mut rng = rng(6);
    let turned: Vec<Triangle> = table().into_iter().map(|[a, b, c]| [a, c, b]).collect();
    assert_eq!(pieces(&turned, 5e-3).1, pieces(&table(), 5e-3).1);
    // Without one of its triangles, a mesh has no inside; its surface is contained all the same.
    check(&table()[1..], 5e-3, &mut rng).unwrap();
    let mut with_lines = channel();
    let [a, b, _] = with_lines[0];
    with_lines.extend([[a, a, a], [a, b, b], [a, b, 0.5 * (a + b)]]);
    check(&with_lines, 5e-3, &mut rng).unwrap();
    for scale in [1e-3, 300.0] {
        let scaled: Vec<Triangle> = channel().into_iter().map(|t| t.map(|p| p * scale)).collect();
        assert_eq!(check(&scaled, 5e-3 * scale, &mut rng).unwrap().corners.len(), 3);
    }
    let point = [Vector3::new(1.0, 2.0, 3.0); 3];
    assert_eq!(pieces(&[point], 1e-3).1.corners, [vec![point[0]]]);
    assert!(matches!(Surface::new(&[]), Err(SurfaceError::Empty)));
    let nan = Vector3::new(0.0, f64::NAN, 0.0);
    assert!(matches!(Surface::new(&[[a, b, nan]]), Err(SurfaceError::NotFinite)));
    assert!(matches!(Surface::new(&vec![point; 200_001]), Err(SurfaceError::TooMany(200_001))));
}

/// Points of a shape's surface.
fn sampled(placed: &PlacedShape, rng: &mut impl FnMut() -> f64) -> Vector3<f64> {
    // From far away, the nearest point of the shape is on its surface.
    let p = placed.origin.translation.vector + vector(rng, 1.0).normalize() * 10.0 + vector(rng, 0.5);
    closest(&Shape::Sphere { radius: 0.0 }, &Isometry3::translation(p.x, p.y, p.z), &placed.shape, &placed.origin)
        .unwrap()
        .on_b
}

#[test]
fn the_excess_of_a_shape_is_that_of_its_farthest_point() {
    let mut rng = rng(7);
    let mesh = channel();
    let surface = Surface::new(&mesh).unwrap();
    let points: Vec<Vector3<f64>> = mesh.iter().flatten().copied().collect();
    let at = |shape| PlacedShape { origin: Isometry3::translation(0.06, 0.0, 0.05), shape };
    for placed in [
        PlacedShape::hull(&points).unwrap(),
        at(Shape::Box { half: [0.07, 0.11, 0.06] }),
        at(Shape::Capsule { radius: 0.1, half_length: 0.1 }),
        at(Shape::Cylinder { radius: 0.13, half_length: 0.06 }),
        at(Shape::Sphere { radius: 0.15 }),
    ] {
        let excess = Excess::of(std::slice::from_ref(&placed), &surface, 1e-5);
        let samples = (0..4000).map(|_| by_brute_force(&mesh, &sampled(&placed, &mut rng)));
        let most = samples.fold(0.0, f64::max);
        // Samples miss the farthest point by a little.
        assert!((most..=1.1 * most + 1e-3).contains(&excess.distance), "{placed:?}: {} of {most}", excess.distance);
    }
    // The hull over the channel is flat: its middle is 4 cm from the walls, and 8 cm from the floor.
    let hull = Excess::of(&[PlacedShape::hull(&points).unwrap()], &surface, 1e-5);
    assert!((0.04..0.041).contains(&hull.distance), "{hull:?}");
    assert!((hull.volume - 0.12 * 0.2 * 0.1).abs() < 1e-12);
    let volume = 0.12 * 0.2 * 0.1 - 0.08 * 0.2 * 0.08;
    assert!((surface.volume().unwrap() - volume).abs() < 1e-12);
    // Pieces that meet exceed nothing where they do.
    let pieces = Excess::of(&surface.pieces(1e-3).unwrap().shapes(), &surface, 1e-4);
    assert!(pieces.distance < 1.1e-4 && (pieces.volume - volume).abs() < 1e-12, "{pieces:?}");
}

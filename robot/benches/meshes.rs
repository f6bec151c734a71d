//! Shapes of a robot with thirty meshes of 5,000 triangles. `cargo bench -p hierarq-robot --bench meshes`

use divan::{Bencher, black_box};
use hierarq_robot::{PlacedShape, Surface};
use nalgebra::Vector3;

fn main() {
    divan::main();
}

type Triangle = [Vector3<f64>; 3];

/// A link like those of an arm: a body about its axis, thicker at both ends, with a dent all around in the middle.
fn link(number: usize) -> Vec<Triangle> {
    let (around, along) = (50, 50);
    let length = 0.2 + 0.01 * number as f64;
    let at = |i: usize, j: usize| {
        let z = j as f64 / along as f64;
        let closed = if j == 0 || j == along { 0.0 } else { 1.0 };
        let radius = closed * (0.05 + 0.04 * (6.0 * z).cos().powi(2) + 0.001 * number as f64);
        let angle = std::f64::consts::TAU * (i % around) as f64 / around as f64;
        Vector3::new(radius * angle.cos(), radius * angle.sin(), length * z)
    };
    let cell = |k: usize| {
        let (i, j) = (k % around, k / around);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..around * along).flat_map(cell).filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

fn meshes() -> Vec<Vec<Triangle>> {
    (0..30).map(link).collect()
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn hulls_of_30_meshes(bencher: Bencher) {
    let meshes: Vec<Vec<Vector3<f64>>> = meshes().iter().map(|m| m.iter().flatten().copied().collect()).collect();
    bencher.bench(|| meshes.iter().map(|points| PlacedShape::hull(black_box(points)).is_ok()).filter(|x| *x).count());
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn capsules_of_30_meshes(bencher: Bencher) {
    let surfaces: Vec<Surface> = meshes().iter().map(|m| Surface::new(m).expect("a mesh")).collect();
    bencher.bench(|| surfaces.iter().filter_map(|s| black_box(s).capsule()).count());
}

/// With 5 mm of excess.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn pieces_of_30_meshes(bencher: Bencher) {
    let meshes = meshes();
    bencher.bench(|| {
        let count = |m: &Vec<Triangle>| Surface::new(black_box(m)).ok()?.pieces(5e-3).ok().map(|p| p.corners.len());
        meshes.iter().filter_map(count).sum::<usize>()
    });
}

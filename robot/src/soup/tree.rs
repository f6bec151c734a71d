//! A binary tree around elements: each node is halved at the median of its longest extent. A node is a ball and a box in it
//! that may lie in any direction: a patch of a wall is thin.

use nalgebra::{Matrix3, Vector3};

/// Number of corners up to which elements share a leaf.
const LEAF: usize = 8;

/// Nodes, each before its children: the left one follows it.
#[derive(Debug)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
}

/// A ball, and a box of any direction about the same centre, that contain the corners of elements.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub centre: Vector3<f64>,
    pub radius: f64,
    /// From the centre to three faces of the box.
    halves: [Vector3<f64>; 3],
    pub inside: Inside,
}

impl Node {
    /// A bound of `n·(p - centre)` for all corners p in the node; n is a unit vector.
    pub fn height(&self, n: &Vector3<f64>) -> f64 {
        let [x, y, z] = &self.halves;
        x.dot(n).abs() + y.dot(n).abs() + z.dot(n).abs()
    }
}

/// Contents of a node.
#[derive(Clone, Copy, Debug)]
pub(super) enum Inside {
    /// Two nodes: the next one, and the one of this index.
    Halves(u32),
    /// Elements of these numbers, the last one excluded.
    Elements(u32, u32),
}

impl Tree {
    /// Returns the tree of elements, and their order in it.
    pub fn over<E: AsRef<[Vector3<f64>]>>(elements: &[E]) -> (Tree, Vec<u32>) {
        let mut order: Vec<u32> = (0..elements.len() as u32).collect();
        let middles: Vec<Vector3<f64>> = elements
            .iter()
            .map(|e| {
                let (low, high) = extents(e.as_ref());
                0.5 * (low + high)
            })
            .collect();
        let mut nodes: Vec<Node> = Vec::new();
        // Ranges of the order that wait for a node, and the parent whose right child they are.
        let mut waiting: Vec<(usize, usize, Option<usize>)> = vec![(0, elements.len(), None)];
        while let Some((from, to, right_of)) = waiting.pop() {
            let at = nodes.len();
            if let Some(parent) = right_of {
                nodes[parent].inside = Inside::Halves(at as u32);
            }
            let corners = |order: &[u32]| order.iter().map(|&i| elements[i as usize].as_ref().len()).sum::<usize>();
            let all = || order[from..to].iter().flat_map(|&i| elements[i as usize].as_ref());
            let (low, high) = extents(all());
            let middle = 0.5 * (low + high);
            let spread: Matrix3<f64> = all().map(|p| (p - middle) * (p - middle).transpose()).sum();
            let axes = spread.symmetric_eigen().eigenvectors;
            let (least, most) = extents(all().map(|p| axes.tr_mul(&(p - middle))).collect::<Vec<_>>().iter());
            let centre = middle + axes * (0.5 * (least + most));
            let reach = all().map(|p| (p - centre).norm()).fold(0.0, f64::max);
            // Rounding must leave no corner outside.
            let slack = 1e-12 * (1.0 + reach);
            let half = (0.5 * (most - least)).add_scalar(slack);
            let halves = [0, 1, 2].map(|k| axes.column(k) * half[k]);
            let inside = Inside::Elements(from as u32, to as u32);
            nodes.push(Node { centre, radius: reach + slack, halves, inside });
            if to - from == 1 || corners(&order[from..to]) <= LEAF {
                continue;
            }
            let axis = (high - low).imax();
            let key = |i: &u32| middles[*i as usize][axis];
            // Stable, so that a soup that was written and read has the same order.
            order[from..to].sort_by(|a, b| key(a).total_cmp(&key(b)));
            let half = from + (to - from) / 2;
            waiting.push((half, to, Some(at)));
            waiting.push((from, half, None));
        }
        (Tree { nodes }, order)
    }
}

/// Smallest and largest coordinates.
fn extents<'p>(points: impl IntoIterator<Item = &'p Vector3<f64>>) -> (Vector3<f64>, Vector3<f64>) {
    let wide = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    points.into_iter().fold(wide, |(low, high), p| (low.inf(p), high.sup(p)))
}

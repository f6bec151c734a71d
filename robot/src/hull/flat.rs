//! Outlines of points in a plane.

use nalgebra::Vector3;

/// Twice the area of a triangle, relative to the square of the extent, up to which its corners are on a line.
const ON_LINE: f64 = 1e-13;

/// Corners of the convex hull of points in a plane, anticlockwise about a normal; two of points on a line, one of equal points.
pub(crate) fn outline(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let Some(first) = points.first() else { return Vec::new() };
    let farthest = |of: &dyn Fn(&Vector3<f64>) -> f64| {
        points.iter().fold((*first, of(first)), |best, p| if of(p) > best.1 { (*p, of(p)) } else { best })
    };
    let (end, squared) = farthest(&|p| (p - first).norm_squared());
    let Some(u) = (end - first).try_normalize(0.0) else { return vec![*first] };
    let away = |p: &Vector3<f64>| (p - first) - u * u.dot(&(p - first));
    let (side, aside) = farthest(&|p| away(p).norm_squared());
    let v = away(&side).try_normalize(0.0).filter(|_| aside > 1e-20 * squared);
    let Some(v) = v else {
        let low = points.iter().fold(*first, |low, p| if u.dot(&(p - low)) < 0.0 { *p } else { low });
        return vec![low, end];
    };
    let mut flat: Vec<[f64; 2]> = Vec::new();
    let mut order: Vec<usize> = (0..points.len()).collect();
    flat.extend(points.iter().map(|p| [u.dot(&(p - first)), v.dot(&(p - first))]));
    order.sort_by(|i, j| flat[*i][0].total_cmp(&flat[*j][0]).then(flat[*i][1].total_cmp(&flat[*j][1])));
    // Andrew's monotone chain: the lower side from left to right, then the upper one back.
    let mut chain: Vec<usize> = Vec::new();
    for half in [order.clone(), order.into_iter().rev().collect()] {
        let start = chain.len();
        for i in half {
            while let [.., a, b] = chain[start..] {
                let ([ax, ay], [bx, by], [cx, cy]) = (flat[a], flat[b], flat[i]);
                if (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > ON_LINE * squared {
                    break;
                }
                chain.pop();
            }
            chain.push(i);
        }
        chain.pop();
    }
    chain.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_four_corners() {
        let grid: Vec<_> = (0..25).map(|i| Vector3::new(f64::from(i % 5), 2.0, f64::from(i / 5))).collect();
        let found = outline(&grid);
        assert_eq!(found.len(), 4);
        assert!(found.iter().all(|p| [0.0, 4.0].contains(&p.x) && [0.0, 4.0].contains(&p.z)), "{found:?}");
    }

    #[test]
    fn a_line_has_two_ends_and_a_point_is_one() {
        let line: Vec<_> = [1.0, 3.0, 2.0, -1.0].map(|x| Vector3::new(x, x, 0.0)).to_vec();
        assert_eq!(outline(&line), [Vector3::new(-1.0, -1.0, 0.0), Vector3::new(3.0, 3.0, 0.0)]);
        assert_eq!(outline(&[Vector3::zeros(); 3]), [Vector3::zeros()]);
        assert!(outline(&[]).is_empty());
    }
}

//! Home configuration of a robot, and the mobility of its tip there.

use nalgebra::{DMatrix, Matrix3, SymmetricEigen};
use robot::{Data, DofUnit, LinkId, Model};

/// Margin of home from each limit, as a share of the joint's range.
const INSET: f64 = 0.08;

/// Tested bends (rad); for prismatic joints a tenth of that in m.
static BENDS: [f64; 4] = [-1.0, -0.5, 0.5, 1.0];

/// Sufficient smallest singular value, as a share of the reach.
const ENOUGH: f64 = 0.25;

/// Cost of bending a joint by 1 rad, in the same measure: a spec with few and small bends is easier to read.
const PRICE: f64 = 0.03;

/// Maximum number of joints of a limb that are bent; longer limbs are bent near the root.
const BENT: usize = 9;

/// Clamps a position to the limits, with a margin if possible, and rounds it for readability.
fn inside(model: &Model, dof: usize, x: f64) -> f64 {
    let d = &model.dofs[dof];
    let room = INSET * (d.upper - d.lower);
    let room = if room.is_finite() { room } else { 0.0 };
    let (low, high) = (d.lower + room, d.upper - room);
    let x = x.min(high).max(low);
    let rounded = (x * 100.0).round() / 100.0;
    if rounded >= d.lower && rounded <= d.upper { rounded } else { x }
}

/// Moves joints away from a limit if zero is outside of their range: a knee that cannot be stretched is bent.
pub(super) fn enter(model: &Model, q: &mut [f64]) {
    for (k, d) in model.dofs.iter().enumerate() {
        if let Some(i) = d.q_index.filter(|&i| q[i] != 0.0) {
            q[i] = inside(model, k, q[i]);
        }
    }
}

/// Matrix J Jᵀ of the tip's position, over some degrees of freedom.
fn gram(model: &Model, data: &Data, tip: LinkId, dofs: &[usize], jacobian: &mut DMatrix<f64>) -> Matrix3<f64> {
    data.jacobian(model, tip, data.position(tip), jacobian);
    let mut sum = Matrix3::zeros();
    for &d in dofs {
        let column = jacobian.fixed_view::<3, 1>(0, d);
        sum += column * column.transpose();
    }
    sum
}

/// Length of the stretched limb from its first joint to its tip \[m\].
pub(super) fn reach(model: &Model, tip: LinkId, dofs: &[usize]) -> f64 {
    let data = Data::new(model);
    let mut points: Vec<_> =
        dofs.iter().filter_map(|&d| model.dofs[d].joint.map(|j| *data.position(model.joint_ref(j).child))).collect();
    points.push(*data.position(tip));
    points.windows(2).map(|p| (p[1] - p[0]).norm()).sum()
}

/// Bends a stretched or folded limb: changes `q` at its degrees of freedom, so that its tip can move in all directions
/// and all joints are within their limits.
pub(super) fn bend(model: &Model, tip: LinkId, dofs: &[usize], q: &mut [f64]) {
    let at = |dof: usize| model.dofs[dof].q_index.unwrap_or(0);
    for &d in dofs {
        q[at(d)] = inside(model, d, q[at(d)]);
    }
    let start = q.to_vec();
    let mut data = Data::new(model);
    let mut jacobian = DMatrix::zeros(6, model.nv());
    let reach = reach(model, tip, dofs).max(1e-6);
    let mut best: (f64, Vec<f64>) = (f64::NEG_INFINITY, start.clone());
    let mut look = |bends: &[(usize, f64)]| {
        let mut q = start.clone();
        let mut price = 0.0;
        for &(dof, bend) in bends {
            let size = if model.dofs[dof].unit == DofUnit::Metre { 0.1 } else { 1.0 };
            let x = q[at(dof)] + bend * size;
            if inside(model, dof, x) != (x * 100.0).round() / 100.0 {
                return;
            }
            q[at(dof)] = (x * 100.0).round() / 100.0;
            price += PRICE * bend.abs();
        }
        model.forward(&q, &mut data);
        let least = SymmetricEigen::new(gram(model, &data, tip, dofs, &mut jacobian)).eigenvalues.min().max(0.0).sqrt();
        let value = (least / reach).min(ENOUGH) - price;
        if value > best.0 {
            best = (value, q);
        }
    };
    let bent = &dofs[..dofs.len().min(BENT)];
    look(&[]);
    for (i, &a) in bent.iter().enumerate() {
        for x in BENDS {
            look(&[(a, x)]);
            for (k, &b) in bent.iter().enumerate().skip(i + 1) {
                for y in BENDS {
                    look(&[(a, x), (b, y)]);
                    for &c in &bent[k + 1..] {
                        for z in BENDS {
                            look(&[(a, x), (b, y), (c, z)]);
                        }
                    }
                }
            }
        }
    }
    q.copy_from_slice(&best.1);
}

/// Mobility of the tip along each axis of the world at `q` \[m per rad, or per m\].
pub(super) fn freedom(model: &Model, tip: LinkId, dofs: &[usize], q: &[f64]) -> [f64; 3] {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let mut jacobian = DMatrix::zeros(6, model.nv());
    let gram = gram(model, &data, tip, dofs, &mut jacobian) + Matrix3::identity() * 1e-12;
    let inverse = gram.try_inverse().unwrap_or_else(|| Matrix3::identity() * f64::MAX);
    std::array::from_fn(|k| inverse[(k, k)].max(f64::MIN_POSITIVE).sqrt().recip())
}

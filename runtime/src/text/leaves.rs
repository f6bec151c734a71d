//! Leaves of expressions of the robot's state, in words.

use stdlib_tasks::expression::{Expression, Leaf, MotionPart};

use super::number;
use crate::program::{Op, Program};

/// Words for an expression that consists of one leaf.
pub(super) fn whole_leaf(p: &Program, e: &Expression) -> Option<String> {
    let [leaf] = e.leaves.as_slice() else { return None };
    let same = |i: usize| e.outputs.get(i) == Some(&i) && e.ops.get(i) == Some(&Op::State(i));
    let whole = e.ops.len() == leaf.width() && e.outputs.len() == leaf.width() && (0..leaf.width()).all(same);
    whole.then(|| words(p, leaf))
}

/// Numbers of a leaf, each in words.
pub(super) fn leaf(p: &Program, leaf: &Leaf) -> Vec<String> {
    let names: &[&str] = match leaf.width() {
        1 => return vec![words(p, leaf)],
        3 => &["x", "y", "z"],
        _ => &["w", "x", "y", "z"],
    };
    names.iter().map(|n| format!("{n} of {}", words(p, leaf))).collect()
}

/// A leaf in words.
fn words(p: &Program, leaf: &Leaf) -> String {
    let name = |l: robot::LinkId| p.robot.model.link_ref(l).name.as_str();
    let vector = |v: &nalgebra::Vector3<f64>| v.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ");
    match leaf {
        Leaf::Point { link, offset } if offset.norm() == 0.0 => format!("the position of {}", name(*link)),
        Leaf::Point { link, offset } => format!("the point [{}] m of {}", vector(offset), name(*link)),
        Leaf::Orientation(link) => format!("the orientation of {}", name(*link)),
        Leaf::Joint(dof) => format!("the position of joint {}", p.robot.model.dofs[*dof].name),
        Leaf::Distance(pair) => format!("the distance from {} to {}", pair.0.name, pair.1.name),
        Leaf::PlaneDistance(above) => {
            let plane = &above.plane;
            let axes = plane.link.map_or("the world", name);
            let (normal, offset) = (vector(&plane.normal), number(plane.offset));
            format!("the height of {} above the plane [{normal}]·x = {offset} m in {axes}", above.part.name)
        }
        Leaf::PointDistance(away) => {
            let [a, b] = away.ends.map(|e| format!("[{}]", e.map(|i| format!("${i}")).join(", ")));
            let what = if a == b { a } else { format!("the segment from {a} to {b}") };
            format!("the distance from {} to {what}", away.part.name)
        }
        Leaf::Com => "the centre of mass".to_string(),
        Leaf::Manipulability(of) => {
            let part = match of.part {
                MotionPart::Whole => "",
                MotionPart::Linear => "linear ",
                MotionPart::Angular => "angular ",
            };
            let joints = of.dofs.iter().filter_map(|&d| p.robot.model.dofs.get(d)).map(|d| d.name.as_str());
            format!("the {part}manipulability of {} by {}", name(of.link), joints.collect::<Vec<_>>().join(", "))
        }
        Leaf::Field(field) => {
            let points: Vec<String> =
                field.points.iter().map(|p| format!("[{}]", p.map(|i| format!("${i}")).join(", "))).collect();
            format!("the safety field {} of {}", field.name, points.join(", "))
        }
    }
}

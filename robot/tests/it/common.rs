//! Robots and numbers to test with.

use hierarq_robot::{Base, Model, Options};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

pub use hierarq_robot::random::units as rng;

/// A vector with entries in ±reach.
pub fn vector(rng: &mut impl FnMut() -> f64, reach: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| reach * (2.0 * rng() - 1.0))
}

/// A pose within ±reach, turned any way.
pub fn pose(rng: &mut impl FnMut() -> f64, reach: f64) -> Isometry3<f64> {
    let q = Quaternion::new(rng() - 0.5, rng() - 0.5, rng() - 0.5, rng() - 0.5);
    Isometry3::from_parts(Translation3::from(vector(rng, reach)), UnitQuaternion::new_normalize(q))
}

/// Data of a random joint: parent among the links before, kind, origin, axis, leader.
type Spec = (prop::sample::Index, u8, [f64; 6], [f64; 3], prop::sample::Index);

/// URDF text of a random tree with fixed, turning, sliding and mimicking joints (mimics of
/// mimics included).
pub fn tree() -> impl Strategy<Value = String> {
    let spec = (
        any::<prop::sample::Index>(),
        0u8..6,
        prop::array::uniform6(-1.5f64..1.5),
        prop::array::uniform3(-1.0f64..1.0).prop_filter("axis", |a| a.iter().any(|x| x.abs() > 0.1)),
        any::<prop::sample::Index>(),
    );
    prop::collection::vec(spec, 1..10).prop_map(|specs: Vec<Spec>| write(&specs))
}

fn write(specs: &[Spec]) -> String {
    let mut text = String::from("<robot name=\"random\">\n<link name=\"l0\"/>\n");
    let mut movable: Vec<usize> = Vec::new();
    for (k, (parent, kind, o, a, leader)) in specs.iter().enumerate() {
        let (kind, limit) = match kind {
            0 => ("fixed", ""),
            1 => ("continuous", ""),
            2 => ("prismatic", "<limit lower=\"-0.7\" upper=\"0.9\" velocity=\"1\" effort=\"1\"/>"),
            _ => ("revolute", "<limit lower=\"-2\" upper=\"1.5\" velocity=\"1\" effort=\"1\"/>"),
        };
        // Followers have no limits, which could leave a leader no motion; `followers` has those that do.
        let (kind, limit, mimic) = if specs[k].1 == 5 && !movable.is_empty() {
            let leader = movable[leader.index(movable.len())];
            let (multiplier, offset) = (0.5 - 0.7 * a[0], o[0]);
            ("continuous", "", format!("<mimic joint=\"j{leader}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>"))
        } else {
            (kind, limit, String::new())
        };
        if kind != "fixed" {
            movable.push(k);
        }
        text += &format!(
            "<link name=\"l{child}\"/>\n<joint name=\"j{k}\" type=\"{kind}\">\n\
             <parent link=\"l{parent}\"/><child link=\"l{child}\"/>\n\
             <origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/>\n<axis xyz=\"{} {} {}\"/>{limit}{mimic}\n\
             </joint>\n",
            o[0],
            o[1],
            o[2],
            o[3],
            o[4],
            o[5],
            a[0],
            a[1],
            a[2],
            child = k + 1,
            parent = parent.index(k + 1),
        );
    }
    text + "</robot>\n"
}

/// Any base.
pub fn base() -> impl Strategy<Value = Base> {
    prop::sample::select(vec![Base::Fixed, Base::Planar, Base::Unicycle, Base::Floating])
}

/// The model of a text that must be sound.
pub fn load(text: &str, base: Base) -> Model {
    match Model::from_urdf(text, &Options { base, ..Options::default() }) {
        Ok((model, _)) => model,
        Err(messages) => panic!("{messages:#?}\n{text}"),
    }
}

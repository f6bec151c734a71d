//! Files that load: harmless oddities of real files, locks, mimics, and models from JSON.

use std::collections::BTreeSet;

use hierarq_robot::{Base, Data, DofUnit, Drive, JointKind, LinkId, Model, Options, Shape, UrdfCode};
use proptest::prelude::*;

use crate::common::{base, load, rng, tree};

fn arm(options: &Options) -> (Model, Vec<UrdfCode>) {
    let (model, warnings) = Model::from_urdf(include_str!("arm.urdf"), options).unwrap();
    (model, warnings.iter().map(|w| w.code).collect())
}

/// One joint of this kind and body, with the codes of the warnings.
fn joint(kind: &str, body: &str) -> (Model, Vec<UrdfCode>) {
    let text = format!(
        "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='{kind}'>\
         <parent link='a'/><child link='b'/>{body}</joint></robot>"
    );
    let (model, warnings) = Model::from_urdf(&text, &Options::default()).unwrap();
    (model, warnings.iter().map(|w| w.code).collect())
}

#[test]
fn the_arm() {
    let (model, warnings) = arm(&Options { base: Base::Unicycle, ..Options::default() });
    // The wheel has no limit of speed; nothing else is odd.
    assert_eq!(warnings, [UrdfCode::NoVelocityLimit]);
    let names: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["stand", "column", "upper", "forearm", "tool", "right_finger", "left_finger", "left_wheel"]);
    let dofs: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(dofs, ["base_forward", "base_yaw", "lift", "shoulder", "elbow", "finger_left", "wheel_left"]);
    assert_eq!((model.nq(), model.nv()), (8, 7));
    assert_eq!(model.dofs[2].unit, DofUnit::Metre);
    assert_eq!((model.dofs[2].q_index, model.dofs[2].upper), (Some(3), 0.4));
    assert_eq!(model.dofs[0].q_index, None);
    // The right finger comes first and follows all the same.
    let right = model.joint_ref(model.joint("finger_right").unwrap());
    assert_eq!(right.drive, Drive::Mimic { dof: 5, multiplier: 1.0, offset: 0.0 });
    assert_eq!(model.link_ref(LinkId(1)).mass, 4.5);
    assert_eq!(model.links[0].visual[0].color, Some([0.5, 0.5, 0.5, 1.0]));
    let shapes: Vec<Shape> = model.links.iter().flat_map(|l| &l.collision).map(|c| c.shape.clone()).collect();
    assert_eq!(
        shapes,
        [
            Shape::Capsule { radius: 0.05, half_length: 0.2 },
            Shape::Capsule { radius: 0.04, half_length: 0.15 },
            Shape::Sphere { radius: 0.06 },
            Shape::Box { half: [0.01, 0.05, 0.02] },
        ]
    );
    assert_eq!(format!("{model:?}").lines().count(), 1);
    assert_eq!(model.parent(model.link("tool").unwrap()), model.link("forearm"));
    assert!(!model.moves_between(model.link("forearm").unwrap(), model.link("tool").unwrap()));
    assert!(model.moves_between(model.link("upper").unwrap(), model.link("tool").unwrap()));
}

#[test]
fn keep_and_lock() {
    let keep: BTreeSet<String> = ["shoulder".to_owned(), "elbow".to_owned()].into();
    let options = Options {
        keep: Some(keep),
        lock: [("lift".to_owned(), 0.25), ("finger_left".to_owned(), 0.03)].into(),
        ..Options::default()
    };
    let (model, warnings) = arm(&options);
    assert_eq!(warnings, []);
    assert_eq!(model.nv(), 2);
    let drive = |name: &str| model.joint_ref(model.joint(name).unwrap()).drive;
    assert_eq!(drive("lift"), Drive::Locked(0.25));
    assert_eq!(drive("finger_right"), Drive::Locked(0.03));
    assert_eq!(drive("wheel_left"), Drive::Locked(0.0));
    // The same pose as the free robot held there.
    let (free, _) = arm(&Options::default());
    let mut q = free.neutral();
    let set = |q: &mut [f64], name: &str, x: f64| q[free.dofs[free.dof(name).unwrap()].q_index.unwrap()] = x;
    for (name, x) in [("lift", 0.25), ("shoulder", 0.7), ("elbow", -1.1), ("finger_left", 0.03)] {
        set(&mut q, name, x);
    }
    let (mut data, mut free_data) = (Data::new(&model), Data::new(&free));
    model.forward(&[0.7, -1.1], &mut data);
    free.forward(&q, &mut free_data);
    for l in 0..model.links.len() as u32 {
        let gap = data.pose(LinkId(l)).to_homogeneous() - free_data.pose(LinkId(l)).to_homogeneous();
        assert!(gap.norm() < 1e-14);
    }
}

#[test]
fn a_joint_that_is_not_kept_rests_at_the_nearest_limit() {
    let text = "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='revolute'>\
        <parent link='a'/><child link='b'/><limit lower='0.5' upper='1' velocity='1' effort='1'/></joint></robot>";
    let options = Options { keep: Some(BTreeSet::new()), ..Options::default() };
    let (model, _) = Model::from_urdf(text, &options).unwrap();
    assert_eq!(model.joints[0].drive, Drive::Locked(0.5));
    // Locked outside its limits it may be, with a warning.
    let options = Options { lock: [("j".to_owned(), 2.0)].into(), ..Options::default() };
    let (model, warnings) = Model::from_urdf(text, &options).unwrap();
    assert_eq!(model.joints[0].drive, Drive::Locked(2.0));
    assert_eq!(warnings[0].code, UrdfCode::BadLock);
}

#[test]
fn limits_that_are_missing_or_odd() {
    use UrdfCode::{Immovable, NoLimits, NoVelocityLimit};
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    for (kind, body, range, velocity, codes) in [
        ("revolute", "", free, f64::INFINITY, vec![NoLimits, NoVelocityLimit]),
        ("prismatic", "", free, f64::INFINITY, vec![NoLimits, NoVelocityLimit]),
        ("continuous", "", free, f64::INFINITY, vec![NoVelocityLimit]),
        ("revolute", "<limit velocity='2' effort='1'/>", free, 2.0, vec![NoLimits]),
        ("revolute", "<limit lower='-1' velocity='2'/>", (-1.0, 0.0), 2.0, vec![]),
        ("revolute", "<limit upper='1' velocity='0'/>", (0.0, 1.0), f64::INFINITY, vec![NoVelocityLimit]),
        ("revolute", "<limit lower='-1' upper='1' velocity='-3'/>", (-1.0, 1.0), f64::INFINITY, vec![NoVelocityLimit]),
        ("revolute", "<limit lower='-1' upper='1' velocity='1e9'/>", (-1.0, 1.0), f64::INFINITY, vec![NoVelocityLimit]),
        ("revolute", "<limit lower='-1' upper='1' velocity='inf'/>", (-1.0, 1.0), f64::INFINITY, vec![NoVelocityLimit]),
        ("revolute", "<limit lower='0' upper='0' velocity='1'/>", (0.0, 0.0), 1.0, vec![Immovable]),
        ("continuous", "<limit lower='-1' upper='1' velocity='1'/>", free, 1.0, vec![]),
    ] {
        let (model, warnings) = joint(kind, body);
        let joint = &model.joints[0];
        assert_eq!((joint.lower, joint.upper), range, "{kind} {body}");
        assert_eq!(joint.velocity, velocity, "{kind} {body}");
        assert_eq!(warnings, codes, "{kind} {body}");
        let expected = if range == (0.0, 0.0) { Drive::Locked(0.0) } else { Drive::Dof(0) };
        assert_eq!(joint.drive, expected);
    }
}

#[test]
fn chains_of_mimics() {
    let mut text = String::from("<robot name='r'><link name='l0'/>");
    // Each joint follows the next; the last one moves.
    for i in 0..4 {
        let mimic =
            if i < 3 { format!("<mimic joint='j{}' multiplier='2' offset='{i}'/>", i + 1) } else { String::new() };
        text += &format!(
            "<link name='l{0}'/><joint name='j{i}' type='continuous'><parent link='l{i}'/><child link='l{0}'/>{mimic}</joint>",
            i + 1
        );
    }
    text += "</robot>";
    let model = load(&text, Base::Fixed);
    assert_eq!(model.nv(), 1);
    // j2 = 2 x + 2, j1 = 2 j2 + 1 = 4 x + 5, j0 = 2 j1 = 8 x + 10.
    let drives: Vec<Drive> = model.joints.iter().map(|j| j.drive).collect();
    let mimic = |multiplier, offset| Drive::Mimic { dof: 0, multiplier, offset };
    assert_eq!(drives, [mimic(8.0, 10.0), mimic(4.0, 5.0), mimic(2.0, 2.0), Drive::Dof(0)]);
    assert_eq!(model.joint_position(model.joint("j0").unwrap(), &[0.5]), 14.0);
    // One degree of freedom, four columns.
    assert_eq!(model.support(LinkId(4)).len(), 4);
    // Held at the end, all are held.
    let options = Options { lock: [("j3".to_owned(), -1.0)].into(), ..Options::default() };
    let (model, _) = Model::from_urdf(&text, &options).unwrap();
    assert_eq!(model.joints[0].drive, Drive::Locked(2.0));
    // Links behind a fixed joint stand still.
    let fixed = text.replacen("name='j3' type='continuous'", "name='j3' type='fixed'", 1);
    assert_eq!(load(&fixed, Base::Fixed).joints[2].drive, Drive::Locked(2.0));
}

#[test]
fn harmless_oddities() {
    let text = "<?xml version='1.0'?><!-- é --><robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>\
        <link name='a'><visual><geometry><mesh filename='package://nowhere/a.dae'/></geometry>\
        <material name='m'><texture/></material></visual>\
        <visual><geometry><box size='0 0 0'/></geometry></visual>\
        <visual/><collision><geometry/></collision><collision><geometry><torus r='1'/></geometry></collision>\
        <unknown><link name='a'/></unknown></link><link name='b'/><plugin/>\
        <joint name='j' type='fixed'><parent link='a'/><child link='b'/><axis xyz='0 0 0'/><dynamics damping='x'/></joint>\
        <drake:thing xmlns:drake='d'/></robot>";
    let (model, warnings) = Model::from_urdf(text, &Options::default()).unwrap();
    let codes: Vec<UrdfCode> = warnings.iter().map(|w| w.code).collect();
    use UrdfCode::{BadSize, Ignored};
    assert_eq!(codes, [BadSize, Ignored, Ignored, Ignored]);
    assert_eq!(model.links[0].visual.len(), 1);
    assert_eq!(model.joints[0].kind, JointKind::Fixed);
    assert!(model.joints[0].axis.norm() == 1.0);
}

#[test]
fn one_link_is_a_robot() {
    for (base, nq, nv) in [(Base::Fixed, 0, 0), (Base::Planar, 3, 3), (Base::Unicycle, 3, 2), (Base::Floating, 7, 6)] {
        let model = load("<robot><link name='l'/></robot>", base);
        assert_eq!((model.nq(), model.nv(), model.neutral().len()), (nq, nv, nq));
        assert_eq!(base.dof_names().len(), nv);
        assert_eq!(Data::new(&model).pose(model.root()), &nalgebra::Isometry3::identity());
    }
}

#[test]
fn a_hundred_joints_of_which_two_matter() {
    let mut text = String::from("<robot name='hand'><link name='l0'/>");
    for i in 0..100 {
        text += &format!(
            "<link name='l{0}'/><joint name='j{i}' type='revolute'><parent link='l{i}'/><child link='l{0}'/>\
             <origin xyz='0.01 0 0'/><axis xyz='0 0 1'/></joint>",
            i + 1
        );
    }
    text += "</robot>";
    let keep = Some(["j3".to_owned(), "j97".to_owned()].into());
    let options = Options { keep, ..Options::default() };
    let (model, warnings) = Model::from_urdf(&text, &options).unwrap();
    assert_eq!(model.nv(), 2);
    // Nothing is said about the joints that do not matter.
    assert_eq!(warnings.len(), 4);
    assert_eq!(model.support(LinkId(100)).len(), 2);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn json_keeps_everything(text in tree(), base in base(), seed in any::<u64>()) {
        let model = load(&text, base);
        let json = serde_json::to_string(&model).unwrap();
        let back: Model = serde_json::from_str(&json).unwrap();
        prop_assert_eq!(&back, &model);
        prop_assert_eq!(serde_json::to_string(&back).unwrap(), json);
        let q = model.random_configuration(&mut rng(seed));
        let (mut a, mut b) = (Data::new(&model), Data::new(&back));
        model.forward(&q, &mut a);
        back.forward(&q, &mut b);
        prop_assert!(a == b);
    }

    #[test]
    fn random_and_neutral_are_inside_the_limits(text in tree(), base in base(), seed in any::<u64>()) {
        let model = load(&text, base);
        for q in [model.neutral(), model.random_configuration(&mut rng(seed))] {
            prop_assert_eq!(q.len(), model.nq());
            for dof in &model.dofs {
                if let Some(i) = dof.q_index {
                    prop_assert!(dof.lower <= q[i] && q[i] <= dof.upper);
                }
            }
            if base == Base::Floating {
                prop_assert!((q[3..7].iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn damaged_json_is_refused() {
    let json = serde_json::to_value(load(include_str!("arm.urdf"), Base::Planar)).unwrap();
    assert!(serde_json::from_value::<Model>(json.clone()).is_ok());
    let damage: [(&str, serde_json::Value); 6] = [
        ("/joints/2/parent", 7.into()),
        ("/joints/1/drive", serde_json::json!({ "dof": 900 })),
        ("/joints/1/axis/0", 3.into()),
        ("/dofs/3/q_index", 9.into()),
        ("/links/0/parent_joint", 1.into()),
        ("/links", serde_json::json!([])),
    ];
    for (at, value) in damage {
        let mut broken = json.clone();
        *broken.pointer_mut(at).unwrap() = value;
        assert!(serde_json::from_value::<Model>(broken).is_err(), "{at}");
    }
}

#[test]
fn limits_of_accelerations_are_those_of_urdf_1_2() {
    for (body, acceleration) in [
        ("<limit velocity='2' effort='1'/>", f64::INFINITY),
        ("<limit velocity='2' acceleration='7'/>", 7.0),
        ("<limit velocity='2' deceleration='5'/>", 5.0),
        ("<limit velocity='2' acceleration='7' deceleration='5' jerk='100'/>", 5.0),
        ("<limit velocity='2' acceleration='0' deceleration='inf'/>", f64::INFINITY),
        ("<limit velocity='2' acceleration='-3'/>", f64::INFINITY),
    ] {
        let (model, _) = joint("continuous", body);
        assert_eq!((model.joints[0].acceleration, model.dofs[0].acceleration), (acceleration, acceleration), "{body}");
        // Without a limit the number is infinite, and JSON has no word for that.
        let again: Model = serde_json::from_str(&serde_json::to_string(&model).unwrap()).unwrap();
        assert_eq!(again.dofs[0].acceleration, acceleration);
    }
}

//! Parameters of a wrong form, or that point nowhere, give an error: never a panic.

use std::collections::BTreeMap;

use hierarq_stdlib_tasks::KINDS;
use hierarq_stdlib_tasks::bound::{Arm, Bound, Geometry, Obstacle, Slot};
use hierarq_stdlib_tasks::dimension::LENGTH;
use hierarq_stdlib_tasks::expression::{
    Expression, Leaf, Manipulability, MotionPart, Op, Plane, PlaneDistance, PointDistance,
};
use hierarq_stdlib_tasks::obstacle::Form;
use hierarq_stdlib_tasks::params::{Input, ParamInfo, ParamType, Presence};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use proptest::prelude::*;
use robot::{Base, LinkId, Model, Shape};

use crate::common::*;

/// A ball that is there, a metre away.
fn obstacle(case: &mut Case) -> Obstacle {
    Obstacle {
        name: "o".to_string(),
        form: Form::Shape(Isometry3::identity(), Shape::Sphere { radius: 0.1 }),
        link: None,
        position: case.slot(&[1.0, 0.0, 0.0], &[0.0; 3]),
        orientation: case.slot(&[1.0, 0.0, 0.0, 0.0], &[0.0; 4]),
        present: Some(case.slot(&[1.0], &[0.0])),
    }
}

/// Good parameters of a task type, every optional one given.
pub fn valid(name: &'static str, model: &Model) -> Case {
    let [left, right] = arms(model);
    let mut rng = rng(77);
    let both = |case: Case| {
        let [left, right] = arms(model);
        case.with("left_arm", Bound::Arm(left)).with("right_arm", Bound::Arm(right)).number("gain", &[2.0, 2.0])
    };
    let dof = model.nv() - 1;
    let a = Geometry::point("a", left.tip, Vector3::new(0.0, 0.0, 0.1));
    let b = Geometry::point("b", right.tip, Vector3::zeros());
    let carrier = Bound::Frame("carrier".to_string(), model.root());
    let mut case = Case::new(name);
    match name {
        "joint_position_limits" => {
            let (low, high) = (case.slot(&[-1.0], &[0.0]), case.slot(&[1.0], &[0.0]));
            case.with("joints", Bound::Joints(vec![dof, dof - 1]))
                .with("lower", Bound::PerJoint(vec![(dof, low)]))
                .with("upper", Bound::PerJoint(vec![(dof, high)]))
                .number("gain", &[5.0])
        }
        "joint_velocity_limits" => {
            let max = case.slot(&[0.5], &[0.0]);
            case.with("joints", Bound::Joints(vec![dof])).with("max", Bound::PerJoint(vec![(dof, max)]))
        }
        "virtual_wall" => case
            .with("points", Bound::Geometries(vec![a, b]))
            .number("through", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0])
            .with("on", carrier)
            .number("d_min", &[0.1])
            .number("gain", &[5.0])
            .number("sampled_margin", &[0.0]),
        "self_collision" => case
            .with("between", Bound::Geometries(vec![a, b.clone()]))
            .with("and", Bound::Geometries(vec![b]))
            .with("except", Bound::Pairs(Vec::new()))
            .number("d_min", &[0.1])
            .number("gain", &[5.0])
            .number("sampled_margin", &[0.0]),
        "keep_clear" => {
            let of = obstacle(&mut case);
            case.with("links", Bound::Geometries(vec![a]))
                .with("of", Bound::Obstacles(vec![of]))
                .number("spots", &[4.0])
                .number("nearest", &[1.0])
                .number("d_min", &[0.1])
                .number("gain", &[5.0])
                .number("sampled_margin", &[0.0])
        }
        "stance" => {
            let points = Bound::Value(case.slot(&[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0], &[0.0; 9]));
            let carries = Bound::Value(case.slot(&[1.0], &[0.0]));
            let foot = [("points", points), ("carries", carries), ("frame", carrier)];
            let foot = Bound::Group(foot.map(|(n, b)| (n.to_string(), b)).into());
            case.with("feet", Bound::Group([("carrier".to_string(), foot)].into()))
                .number("margin", &[0.01])
                .number("gain", &[5.0])
        }
        "least_motion" => {
            case.with("of", Bound::Choice("acceleration".to_string())).with("joints", Bound::Joints(vec![dof]))
        }
        "frame_pose" => case
            .with("frame", carrier)
            .number("position", &[0.1, 0.2, 0.3])
            .number("orientation", &[1.0, 0.0, 0.0, 0.0])
            .number("gain", &[2.0, 2.0])
            .with("axes", Bound::Group([("linear".to_string(), Bound::Axes([true; 3]))].into()))
            .with("axes_of", Bound::Frame("f".to_string(), left.tip))
            .group("axis_weights", &[("angular", &[1.0, 2.0, 3.0])]),
        "frame_position" => case
            .with("frame", carrier)
            .number("position", &[0.1, 0.2, 0.3])
            .number("gain", &[2.0])
            .with("axes", Bound::Axes([true, false, true]))
            .with("axes_of", Bound::Frame("f".to_string(), left.tip))
            .number("axis_weights", &[1.0, 2.0, 3.0]),
        "joint_acceleration_limits" => {
            let max = case.slot(&[5.0], &[0.0]);
            case.with("joints", Bound::Joints(vec![dof])).with("max", Bound::PerJoint(vec![(dof, max)]))
        }
        "admittance" => {
            let body = [&[20.0, 3.0][..], &[253.0, 27.0], &[800.0, 60.0]];
            let case = case.with("frame", carrier).pose("target", &mut rng);
            case.body(body, [&[1.0, 2.0, 3.0], &[0.1, 0.2, 0.3]])
        }
        "hand_guiding" => {
            let body = [&[20.0, 3.0][..], &[253.0, 27.0], &[]];
            case.with("frame", carrier).body(body, [&[1.0, 2.0, 3.0], &[0.1, 0.2, 0.3]])
        }
        "frame_orientation" => case
            .with("frame", carrier)
            .number("orientation", &[1.0, 0.0, 0.0, 0.0])
            .number("gain", &[2.0])
            .with("axes", Bound::Axes([true; 3]))
            .with("axes_of", Bound::Frame("f".to_string(), left.tip))
            .number("axis_weights", &[1.0, 2.0, 3.0]),
        "look_at" => case
            .with("frame", Bound::Frame("f".to_string(), left.tip))
            .number("target", &[0.5, 0.6, 0.7])
            .number("axis", &[0.0, 0.0, 1.0])
            .number("gain", &[2.0]),
        "cooperative_motion" => both(case)
            .number("alpha", &[0.5])
            .number("beta", &[1.0])
            .with("relative_to", Bound::Choice("left".to_string()))
            .pose("absolute", &mut rng)
            .pose("relative", &mut rng),
        "uncooperative_motion" => both(case).pose("left", &mut rng).pose("right", &mut rng),
        "hold" => {
            let frames = vec![("left".to_string(), left.tip), ("right".to_string(), right.tip)];
            case.with("frames", Bound::Frames(frames)).number("gain", &[2.0, 2.0])
        }
        "joint_position" => {
            let target = case.slot(&[0.3], &[0.0]);
            case.with("target", Bound::PerJoint(vec![(dof, target)])).with("turns", nearest()).number("gain", &[2.0])
        }
        "safety_planner" => {
            let [speed, weight, back] = [[0.4], [1.0], [2.0]].map(|x| Bound::Value(case.slot(&x, &[0.0])));
            let one = [("speed", speed), ("weight", weight), ("return", back)].map(|(n, b)| (n.to_string(), b));
            let deviate = [("position".to_string(), Bound::Group(one.into()))].into();
            case.with("task", Bound::Task(0))
                .with("field", Bound::Field(0))
                .number("min", &[0.75])
                .number("gain", &[10.0])
                .with("method", Bound::Choice("planner".to_string()))
                .number("epsilon", &[0.1])
                .group("scaling", &[("weight", &[10.0])])
                .with("deviate", Bound::Group(deviate))
                .group("internal", &[("gain", &[1.0]), ("weight", &[1.0])])
                .number("relax", &[1e6])
        }
        "joint_velocity" => {
            let wanted = case.slot(&[0.3], &[0.0]);
            case.with("velocity", Bound::PerJoint(vec![(dof, wanted)]))
        }
        "swivel_angle" => {
            let angles = (case.slot(&[0.3], &[0.0]), case.slot(&[0.3], &[0.0]));
            case.with("angle", Bound::PerArm(vec![(left, angles.0), (right, angles.1)])).number("gain", &[2.0])
        }
        "keep" => {
            let state = Bound::Expression(apart(&left, &right));
            case.with("value", state)
                .number("min", &[0.1])
                .number("max", &[9.0])
                .number("gain", &[5.0])
                .number("sampled_margin", &[0.0])
        }
        "track" => case
            .with("value", Bound::Expression(apart(&left, &right)))
            .number("target", &[0.5])
            .with("turns", nearest())
            .number("gain", &[2.0]),
        "speed_separation" => case
            .with("parts", Bound::Geometries(vec![a, b]))
            .number("from", &[2.0, 0.5, 1.0])
            .with("method", Bound::Choice("slow".to_string()))
            .with("human", Bound::Choice("measured".to_string()))
            .number("human_speed", &[1.6])
            .number("reaction", &[0.1])
            .number("deceleration", &[3.0])
            .number("intrusion", &[0.1])
            .number("human_uncertainty", &[0.05])
            .number("robot_uncertainty", &[0.01]),
        other => panic!("`{other}` is new: say here what good parameters of it are"),
    }
}

/// The distance of two tips.
fn apart(left: &Arm, right: &Arm) -> Expression {
    let leaf = |link: LinkId| Leaf::Point { link, offset: Vector3::zeros() };
    let mut ops: Vec<Op> = (0..6).map(Op::State).collect();
    ops.extend([Op::Sub(0, 3), Op::Sub(1, 4), Op::Sub(2, 5), Op::Powi(6, 2), Op::Powi(7, 2), Op::Powi(8, 2)]);
    ops.extend([Op::Add(9, 10), Op::Add(12, 11), Op::Sqrt(13)]);
    Expression {
        ops,
        inputs: vec![],
        leaves: vec![leaf(left.tip), leaf(right.tip)],
        outputs: vec![14],
        dimension: LENGTH,
    }
}

/// Operations that read anything, also what does not exist.
fn operations() -> impl Strategy<Value = Vec<Op>> {
    let index = prop_oneof![8 => 0usize..6, 1 => Just(usize::MAX)];
    let op = (index.clone(), index.clone(), index, -9.0..9.0f64, 0..18u8).prop_map(|(a, b, c, x, kind)| match kind {
        0 => Op::Const(x),
        1 => Op::Input(a),
        2..=4 => Op::State(a),
        5 => Op::Mul(a, b),
        6 => Op::Div(a, b),
        7 => Op::Sqrt(a),
        8 => Op::Acos(a),
        9 => Op::Atan2(a, b),
        10 => Op::Powi(a, i32::MIN),
        11 => Op::Select(a, b, c),
        12 => Op::Less(a, b),
        13 => Op::Time,
        14 => Op::Log(a),
        15 => Op::Max(a, b),
        16 => Op::Sub(a, b),
        _ => Op::Neg(a),
    });
    // Mostly in an order that can be executed.
    prop::collection::vec(op, 0..8).prop_map(|ops| {
        let sorted = |(i, op): (usize, Op)| op.renumber(|a| if a == usize::MAX || i == 0 { a } else { a % i });
        ops.into_iter().enumerate().map(sorted).collect()
    })
}

/// A bound parameter of any form; every index may point nowhere.
fn anything(model: &Model) -> impl Strategy<Value = Bound> + use<> {
    let index = prop_oneof![4 => 0usize..12, 1 => Just(1000), 1 => Just(usize::MAX), 1 => Just(usize::MAX - 2)];
    let slot =
        (index.clone(), prop_oneof![Just(0usize), Just(1), Just(2), Just(3), Just(4), Just(9), Just(usize::MAX)])
            .prop_map(|(at, len)| Slot { at, len });
    let links = model.links.len() as u32;
    let link = prop_oneof![5 => 0..links, 1 => Just(links), 1 => Just(u32::MAX)].prop_map(LinkId);
    let arm = (link.clone(), prop::option::of(link.clone())).prop_map(|(tip, s)| Arm {
        name: "left".to_string(),
        shoulder: s,
        elbow: s,
        wrist: Some(tip),
        tip,
    });
    let number = prop_oneof![3 => -1.0..1.0f64, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(0.0)];
    let geometry = (link.clone(), number.clone(), number.clone()).prop_map(|(link, x, radius)| Geometry {
        name: "g".to_string(),
        link,
        origin: Isometry3::translation(x, 0.0, 0.0),
        shape: Shape::Sphere { radius },
    });
    let state = prop_oneof![
        3 => link.clone().prop_map(|link| Leaf::Point { link, offset: Vector3::new(0.1, 0.2, 0.3) }),
        1 => link.clone().prop_map(Leaf::Orientation),
        1 => index.clone().prop_map(Leaf::Joint),
        1 => (geometry.clone(), geometry.clone()).prop_map(|pair| Leaf::Distance(Box::new(pair))),
        1 => (geometry.clone(), prop::option::of(link.clone()), number.clone(), number.clone()).prop_map(
            |(part, link, z, offset)| {
                let normal = Vector3::new(0.0, (1.0 - z * z).sqrt(), z);
                Leaf::PlaneDistance(Box::new(PlaneDistance { part, plane: Plane { link, normal, offset } }))
            }
        ),
        1 => Just(Leaf::Com),
        1 => (link.clone(), prop::collection::vec(index.clone(), 0..9)).prop_map(|(link, dofs)| {
            Leaf::Manipulability(Box::new(Manipulability { link, part: MotionPart::Linear, dofs }))
        }),
        1 => (geometry.clone(), prop::array::uniform2(prop::array::uniform3(0usize..9)))
            .prop_map(|(part, ends)| Leaf::PointDistance(Box::new(PointDistance { part, ends }))),
    ];
    let outputs = prop_oneof![prop::collection::vec(0usize..8, 1), prop::collection::vec(0usize..8, 0..5)];
    let expression =
        (operations(), prop::collection::vec(index.clone(), 0..3), prop::collection::vec(state, 0..3), outputs)
            .prop_map(|(ops, inputs, leaves, outputs)| Expression { ops, inputs, leaves, outputs, dimension: LENGTH });
    let word = prop_oneof![Just("auto"), Just("left"), Just("world"), Just("")].prop_map(String::from);
    let few = 0..3usize;
    let leaf = prop_oneof![
        slot.clone().prop_map(Bound::Value),
        link.clone().prop_map(|l| Bound::Frame("f".to_string(), l)),
        prop::collection::vec(link.prop_map(|l| ("f".to_string(), l)), few.clone()).prop_map(Bound::Frames),
        arm.clone().prop_map(Bound::Arm),
        prop::collection::vec(geometry, few.clone()).prop_map(Bound::Geometries),
        prop::collection::vec((slot.clone(), slot.clone(), slot.clone()), few.clone()).prop_map(|all| {
            let form = Form::Shape(Isometry3::identity(), Shape::Sphere { radius: 0.1 });
            let one = |(position, orientation, present)| Obstacle {
                name: "o".to_string(),
                form: form.clone(),
                link: None,
                position,
                orientation,
                present: Some(present),
            };
            Bound::Obstacles(all.into_iter().map(one).collect())
        }),
        prop::collection::vec(index.clone(), few.clone()).prop_map(Bound::Joints),
        prop::collection::vec((index, slot.clone()), few.clone()).prop_map(Bound::PerJoint),
        prop::collection::vec((arm, slot.clone()), few).prop_map(Bound::PerArm),
        word.prop_map(Bound::Choice),
        prop::array::uniform3(any::<bool>()).prop_map(Bound::Axes),
        expression.prop_map(Bound::Expression),
    ];
    let group = (slot.clone(), slot).prop_map(|(p, o)| {
        Bound::Group([("position", p), ("orientation", o)].map(|(n, s)| (n.to_string(), Bound::Value(s))).into())
    });
    prop_oneof![6 => leaf, 1 => group]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// One parameter of a good task is replaced: it is refused, or the task works without a panic.
    #[test]
    fn nothing_that_is_bound_panics(kind in 0..KINDS.len(), which in any::<prop::sample::Index>(), other in anything(&arm7())) {
        let model = arm7();
        let kind = KINDS[kind];
        let mut case = valid(kind.name, &model);
        let param = kind.params[which.index(kind.params.len())].name;
        case.params.insert(param.to_string(), other);
        let speed: Vec<f64> = model.dofs.iter().map(|d| d.velocity).collect();
        if let Ok(mut task) = case.build_for(&model, 0.01, &speed) {
            let place = Place::new(&model, &model.random_configuration(&mut rng(5)));
            task.enter(&place.state(&case.values, &case.rates));
            let _ = place.write(&mut *task, &case, 0.0);
            let (mut margins, mut measures) = (vec![0.0; task.rows().len()], vec![0.0; task.measures().len()]);
            task.observe(&place.state(&case.values, &case.rates), &vec![0.1; model.nv()], &mut margins, &mut measures);
            for a in kind.current_values {
                for len in [a.ty.len(), 1] {
                    task.current_value(a.name, &place.state(&case.values, &case.rates), &mut vec![0.0; len]);
                }
            }
        }
    }
}

#[test]
fn a_place_outside_the_table_is_no_number() {
    for at in [0, 1, 5, usize::MAX - 1, usize::MAX] {
        assert!(Input::<3> { at }.of(&[1.0, 2.0, 3.0]).iter().all(|x| x.is_nan() == (at != 0)));
    }
}

#[test]
fn a_wrong_form_is_an_error_that_names_the_parameter() {
    let model = canopies(Base::Planar);
    let forms = [
        Bound::Value(Slot { at: 0, len: 8 }),
        Bound::Frame("f".to_string(), LinkId(0)),
        Bound::Frames(Vec::new()),
        Bound::Arm(arms(&model)[0].clone()),
        Bound::Geometries(Vec::new()),
        Bound::Obstacles(Vec::new()),
        Bound::Joints(Vec::new()),
        Bound::PerJoint(Vec::new()),
        Bound::PerArm(Vec::new()),
        Bound::Choice("nothing".to_string()),
        Bound::Group(BTreeMap::new()),
    ];
    for kind in KINDS {
        for p in kind.params {
            let mut good = valid(kind.name, &model);
            // One of the two says how the robot stops.
            let either = ["stopping", "deceleration"].contains(&p.name);
            if p.name == "stopping" {
                let number = good.params.remove("deceleration").expect("the other one is given");
                good = good.with(p.name, number);
            }
            let own = std::mem::discriminant(&good.params[p.name]);
            for form in &forms {
                // Good ones: any frame, any arm, and no exception from the robot's limits.
                let alike = std::mem::discriminant(form) == own;
                let none_replaced = matches!(form, Bound::PerJoint(_)) && p.presence == Presence::Optional;
                let optional = |infos: &[ParamInfo]| infos.iter().all(|i| i.presence == Presence::Optional);
                let none_needed = matches!(p.ty, ParamType::Group(infos) if optional(infos));
                if alike && (matches!(form, Bound::Frame(..) | Bound::Arm(_)) || none_replaced || none_needed) {
                    continue;
                }
                let mut case = good.clone().with(p.name, form.clone());
                case.values.resize(40, 0.0);
                let error = case.build_for(&model, 0.01, &vec![1.0; model.nv()]).err();
                let error = error.unwrap_or_else(|| panic!("`{}` takes {form:?} as `{}`", kind.name, p.name));
                let inner = ["position", "orientation"].contains(&error.param.as_str());
                assert!(error.param == p.name || inner, "`{}` `{}`: {error:?}", kind.name, p.name);
                assert!(!error.message.is_empty());
            }
            // Left out: an error where it must be there, or has a default that the compiler writes.
            let mut case = good.clone();
            case.params.remove(p.name);
            let built = case.build_for(&model, 0.01, &vec![1.0; model.nv()]);
            assert_eq!(
                built.is_ok(),
                p.presence == Presence::Optional && !either,
                "`{}` without `{}`",
                kind.name,
                p.name
            );
        }
    }
}

#[test]
fn impossible_parameters_are_explained() {
    let model = canopies(Base::Planar);
    let refused = |case: &Case, param: &str| {
        let error = case.build_for(&model, 0.01, &vec![1.0; model.nv()]).err().unwrap();
        assert_eq!(error.param, param, "{error:?}");
        assert!(!error.message.is_empty());
    };
    let with = |name: &'static str, path: &str, values: &[f64]| {
        let mut case = valid(name, &model);
        case.set(path, values);
        case
    };
    refused(&with("cooperative_motion", "beta", &[0.5]), "beta");
    refused(&with("cooperative_motion", "beta", &[f64::NAN]), "beta");
    let [left, right] = arms(&model);
    for name in ["cooperative_motion", "uncooperative_motion"] {
        refused(&valid(name, &model).with("right_arm", Bound::Arm(left.clone())), "right_arm");
    }
    for x in [f64::NAN, 0.0, 1e-300, 1e200] {
        refused(
            &with("virtual_wall", "through", &[x, x, x, 2.0 * x, 2.0 * x, 2.0 * x, 3.0 * x, 3.0 * x, 3.0 * x]),
            "through",
        );
    }
    // Parts of links that a fixed joint ties together cannot move apart.
    let tied = |name: &str| Bound::Geometries(vec![Geometry::point(name, model.link(name).unwrap(), Vector3::zeros())]);
    refused(&valid("self_collision", &model).with("between", tied("left_ft")).with("and", tied("left_tool")), "and");
    let per_joint = |name: &'static str, param: &str, dof: usize, x: f64| {
        let mut case = valid(name, &model);
        let slot = case.slot(&[x], &[0.0]);
        case.with(param, Bound::PerJoint(vec![(dof, slot)]))
    };
    let dof = model.nv() - 1;
    refused(&per_joint("joint_position_limits", "lower", dof, 1.5), "lower");
    refused(&per_joint("joint_position_limits", "lower", dof, f64::NAN), "lower");
    for max in [0.0, -1.0, f64::NAN] {
        refused(&per_joint("joint_velocity_limits", "max", dof, max), "max");
    }
    for max in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(&per_joint("joint_acceleration_limits", "max", dof, max), "max");
    }
    // One that `joints` names and `max` does not, and the other way round.
    refused(&valid("joint_acceleration_limits", &model).with("joints", Bound::Joints(vec![dof, dof - 1])), "max");
    refused(&valid("joint_acceleration_limits", &model).with("joints", Bound::Joints(vec![dof - 1])), "max");
    refused(&with("admittance", "stiffness.linear", &[800.0, 9e5, 800.0]), "stiffness");
    refused(&with("admittance", "stiffness.angular", &[60.0, 60.0, 2e5]), "stiffness");
    refused(&per_joint("joint_position", "target", 0, 0.1), "target");
    let bare = Arm { shoulder: None, ..right };
    let mut case = valid("swivel_angle", &model);
    let slot = case.slot(&[0.0], &[0.0]);
    refused(&case.with("angle", Bound::PerArm(vec![(bare, slot)])), "angle");
    let mut skewed = Geometry::point("skewed", model.root(), Vector3::zeros());
    skewed.origin.rotation = UnitQuaternion::new_unchecked(Quaternion::new(2.0, 0.0, 0.0, 0.0));
    refused(&valid("virtual_wall", &model).with("points", Bound::Geometries(vec![skewed])), "points");
}

//! Contents of real URDF files (`workcell.urdf`): tags of controllers and simulators, textures without a file, meshes
//! that are elsewhere, joints without limits or with absurd ones.

use hierarq_robot::{Base, Data, Drive, Model, Options, Shape, UrdfCode};

use crate::common::rng;

const WORKCELL: &str = include_str!("workcell.urdf");

fn workcell(options: &Options) -> Model {
    Model::from_urdf(WORKCELL, options).unwrap().0
}

#[test]
fn a_workcell_loads_with_a_word_on_each_oddity() {
    let options = Options { base: Base::Planar, read_meshes: true, ..Options::default() };
    let (model, warnings) = Model::from_urdf(WORKCELL, &options).unwrap();
    let said: Vec<(UrdfCode, &str)> = warnings.iter().map(|w| (w.code, w.text.as_str())).collect();
    assert_eq!(
        said,
        [
            (
                UrdfCode::MeshMissing,
                "mesh `package://workcell/meshes/chassis.stl` not found; the link has no shape there"
            ),
            (UrdfCode::NoVelocityLimit, "joint `wheel_right_joint` has no limit of speed"),
            (UrdfCode::NoVelocityLimit, "joint `mast_joint` has the limit of speed 0, which is taken as none"),
            (UrdfCode::NoLimits, "joint `elbow` has no limits of position; it is taken to be unlimited"),
            (UrdfCode::NoVelocityLimit, "joint `elbow` has no limit of speed"),
            (
                UrdfCode::NoVelocityLimit,
                "joint `wrist` has the limit of speed 1000000000000000000000000000000, which is taken as none"
            ),
        ]
    );
    let help = warnings[0].help.as_deref().unwrap();
    assert!(help.contains("`workcell`") && help.contains("ROS_PACKAGE_PATH"), "{help}");
    let dofs: Vec<&str> = model.dofs.iter().skip(3).map(|d| d.name.as_str()).collect();
    assert_eq!(dofs, ["wheel_left_joint", "wheel_right_joint", "mast_joint", "elbow", "wrist", "finger_left_joint"]);
    // Only the tree counts: no link or joint of a simulator's or a controller's tag came in.
    assert_eq!((model.links.len(), model.joints.len()), (9, 8));
    assert_eq!(model.link_ref(model.link("chassis").unwrap()).visual.len(), 2);
    let steel = model.link_ref(model.link("forearm").unwrap()).visual[0].color;
    assert_eq!(steel, Some([0.6, 0.6, 0.65, 1.0]));
    // The mast's soft limits are a controller's matter; its own count.
    let mast = &model.dofs[model.dof("mast_joint").unwrap()];
    assert_eq!((mast.lower, mast.upper, mast.velocity), (0.0, 0.5, f64::INFINITY));
    let wheel = &model.link_ref(model.link("wheel_left").unwrap()).collision[0].shape;
    assert_eq!(*wheel, Shape::Capsule { radius: 0.1, half_length: 0.025 });
}

#[test]
fn tags_that_are_no_part_of_the_tree_change_nothing() {
    let start = WORKCELL.find("  <transmission").unwrap();
    let bare = format!("{}</robot>\n", &WORKCELL[..start]);
    let (model, _) = Model::from_urdf(&bare, &Options::default()).unwrap();
    assert_eq!(model, workcell(&Options::default()));
}

#[test]
fn fingers_close_symmetrically() {
    let model = workcell(&Options::default());
    let mut data = Data::new(&model);
    let (palm, left, right) =
        (model.link("palm").unwrap(), model.link("finger_left").unwrap(), model.link("finger_right").unwrap());
    let mut rng = rng(5);
    for _ in 0..20 {
        let q = model.random_configuration(&mut rng);
        model.forward(&q, &mut data);
        let opening = q[model.dofs[model.dof("finger_left_joint").unwrap()].q_index.unwrap()];
        let in_palm = |link| data.pose(palm).inverse() * data.pose(link);
        assert!((in_palm(left).translation.y - 0.01 - opening).abs() < 1e-14);
        assert!((in_palm(left).translation.y + in_palm(right).translation.y).abs() < 1e-14);
    }
}

#[test]
fn wheels_turn_without_end() {
    let model = workcell(&Options::default());
    let dof = model.dof("wheel_right_joint").unwrap();
    assert_eq!((model.dofs[dof].lower, model.dofs[dof].upper), (f64::NEG_INFINITY, f64::INFINITY));
    let wheel = model.link("wheel_right").unwrap();
    let (mut once, mut later) = (Data::new(&model), Data::new(&model));
    let mut q = model.neutral();
    let i = model.dofs[dof].q_index.unwrap();
    q[i] = 0.4;
    model.forward(&q, &mut once);
    q[i] += 1000.0 * std::f64::consts::TAU;
    model.forward(&q, &mut later);
    assert!((once.rotation(wheel) - later.rotation(wheel)).norm() < 1e-11);
    // The neutral rotation is another one: turning does turn.
    assert!((Data::new(&model).rotation(wheel) - once.rotation(wheel)).norm() > 0.1);
}

#[test]
fn a_leader_named_in_short_is_guessed_in_the_help_and_a_lock_does_without_it() {
    let broken = WORKCELL.replacen("<mimic joint=\"finger_left_joint\"", "<mimic joint=\"left_joint\"", 1);
    let errors = Model::from_urdf(&broken, &Options::default()).unwrap_err();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert_eq!(errors[0].code, UrdfCode::UnknownJoint);
    assert_eq!(&broken[errors[0].span.clone()], "left_joint");
    let help = errors[0].help.as_deref().unwrap();
    assert!(help.contains("`wheel_left_joint`, `finger_left_joint`"), "{help}");
    // Whoever holds the follower does not need its leader.
    let options = Options { lock: [("finger_right_joint".to_owned(), -0.01)].into(), ..Options::default() };
    let (model, _) = Model::from_urdf(&broken, &options).unwrap();
    assert_eq!(model.joint_ref(model.joint("finger_right_joint").unwrap()).drive, Drive::Locked(-0.01));
}

#[test]
fn an_empty_robot_from_macros_is_told_apart() {
    let help = |text: &str| {
        let errors = Model::from_urdf(text, &Options::default()).unwrap_err();
        assert_eq!(errors.iter().map(|e| e.code).collect::<Vec<_>>(), [UrdfCode::NoLinks]);
        errors[0].help.clone()
    };
    assert_eq!(help("<robot name='r'/>"), None);
    let expanded = help("<robot xmlns:xacro='http://wiki.ros.org/xacro'>\n<!-- macros only -->\n</robot>").unwrap();
    assert!(expanded.contains("macros"), "{expanded}");
}

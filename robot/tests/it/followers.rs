//! Limits of followers: the leader keeps them, and a file that leaves no motion is refused.

use hierarq_robot::{Data, Drive, JointId, Limits, Model, Options, UrdfCode};

use crate::common::{load, rng};
use hierarq_robot::Base;

const WORKCELL: &str = include_str!("workcell.urdf");
const MIMIC: &str = "<mimic joint=\"finger_left_joint\" multiplier=\"-1\"/>";

/// Tolerance of the position of a follower, as `ROUNDING` of the crate, and of the sums here.
const TOLERANCE: f64 = 1.1e-6;

/// A hand: a leader and a few followers, some of them of followers.
fn hand(rng: &mut impl FnMut() -> f64) -> String {
    let mut text = String::from("<robot name='hand'><link name='l0'/>");
    for k in 0..1 + (5.0 * rng()) as usize {
        // Zero is within all limits, so that none excludes the others.
        let (lower, upper, velocity) = (-0.1 - 2.0 * rng(), 0.1 + 2.0 * rng(), 0.1 + rng());
        let multiplier = (0.2 + 2.0 * rng()) * if rng() < 0.5 { -1.0 } else { 1.0 };
        let (leader, offset) = ((k as f64 * rng()) as usize, 0.02 * (rng() - 0.5));
        let mimic = match k {
            0 => String::new(),
            _ => format!("<mimic joint='j{leader}' multiplier='{multiplier}' offset='{offset}'/>"),
        };
        text += &format!(
            "<link name='l{0}'/><joint name='j{k}' type='revolute'><parent link='l{k}'/><child link='l{0}'/>\
             <axis xyz='0 0 1'/>{mimic}<limit lower='{lower}' upper='{upper}' velocity='{velocity}' effort='1'/></joint>",
            k + 1
        );
    }
    text + "</robot>"
}

/// True if all joints are within their own limits where the leader is at `x`, less a tolerance.
fn all_within(model: &Model, x: f64, tolerance: f64) -> bool {
    model.joints.iter().enumerate().all(|(k, joint)| {
        let at = model.joint_position(JointId(k as u32), &[x]);
        at >= joint.lower - tolerance && at <= joint.upper + tolerance
    })
}

#[test]
fn the_limits_of_a_leader_are_where_all_its_followers_are_within_theirs() {
    let mut rng = rng(8);
    let mut narrowed = 0;
    for _ in 0..300 {
        let model = load(&hand(&mut rng), Base::Fixed);
        let dof = &model.dofs[0];
        narrowed += usize::from(dof.lower > model.joints[0].lower || dof.upper < model.joints[0].upper);
        for k in 0..=600 {
            let x = -3.0 + 0.01 * k as f64;
            if x >= dof.lower && x <= dof.upper {
                assert!(all_within(&model, x, TOLERANCE), "{x} of {dof:?}");
            } else {
                // Beyond the limit by more than the tolerance of each follower.
                let beyond = (dof.lower - x).max(x - dof.upper);
                assert!(beyond < 10.0 * TOLERANCE || !all_within(&model, x, 0.0), "{x} of {dof:?}");
            }
        }
        // The speed of each joint by differences of its position.
        let speed = |v: f64, k: usize| {
            let at = |x: f64| model.joint_position(JointId(k as u32), &[x]);
            (at(v) - at(0.0)).abs()
        };
        let all = |v: f64| model.joints.iter().enumerate().all(|(k, joint)| speed(v, k) <= joint.velocity + TOLERANCE);
        assert!(all(dof.velocity) && !all(dof.velocity * 1.0001), "{dof:?}");
    }
    assert!(narrowed > 100, "{narrowed} of 300 leaders are narrowed");
}

#[test]
fn random_configurations_keep_the_limits_of_followers() {
    let narrow = WORKCELL.replacen("lower=\"-0.04\" upper=\"0\"", "lower=\"-0.03\" upper=\"-0.01\"", 1);
    let model = load(&narrow, Base::Fixed);
    let dof = &model.dofs[model.dof("finger_left_joint").unwrap()];
    assert_eq!((dof.lower, dof.upper, dof.velocity), (0.01, 0.03, 0.1));
    let own = model.joint_ref(dof.joint.unwrap());
    assert_eq!((own.lower, own.upper), (0.0, 0.04));
    let (palm, right) = (model.link("palm").unwrap(), model.link("finger_right").unwrap());
    let (mut data, mut rng) = (Data::new(&model), rng(5));
    for _ in 0..50 {
        model.forward(&model.random_configuration(&mut rng), &mut data);
        let y = (data.pose(palm).inverse() * data.pose(right)).translation.y + 0.01;
        assert!((-0.03 - 1e-14..=-0.01 + 1e-14).contains(&y), "{y}");
    }
}

#[test]
fn limits_that_are_set_later_are_kept_by_all() {
    let mut model = load(WORKCELL, Base::Fixed);
    let joint = |model: &Model, name: &str| model.joint(name).unwrap();
    let dof = model.dof("finger_left_joint").unwrap();
    let (left, right) = (joint(&model, "finger_left_joint"), joint(&model, "finger_right_joint"));
    assert_eq!(model.followers(dof).collect::<Vec<_>>(), [right]);
    let of_left = model.joint_ref(left).limits();
    model.set_limits(left, Limits { upper: 0.1, velocity: 1.0, ..of_left });
    assert_eq!((model.dofs[dof].upper, model.dofs[dof].velocity), (0.04, 0.1));
    let of_right = model.joint_ref(right).limits();
    model.set_limits(right, Limits { lower: -0.2, velocity: 0.5, acceleration: 2.0, ..of_right });
    let kept = &model.dofs[dof];
    assert_eq!((kept.lower, kept.upper, kept.velocity, kept.acceleration), (0.0, 0.1, 0.5, 2.0));
    assert_eq!(model.limits_of_leader(right), Limits { lower: 0.0, upper: 0.2, velocity: 0.5, acceleration: 2.0 });
    let fixed = joint(&model, "ground");
    assert_eq!(model.limits_of_leader(fixed), Limits::NONE);
}

#[test]
fn a_follower_without_motion_in_common_is_an_error_at_its_limits() {
    let read = |mimic: &str| Model::from_urdf(&WORKCELL.replacen(MIMIC, mimic, 1), &Options::default());
    let refused = |mimic: &str| {
        let errors = read(mimic).unwrap_err();
        assert_eq!((errors.len(), errors[0].code), (1, UrdfCode::CrossedLimits), "{errors:?}");
        let text = WORKCELL.replacen(MIMIC, mimic, 1);
        assert!(text[errors[0].span.clone()].starts_with("<limit lower=\"-0.04\""));
        errors[0].text.clone()
    };
    let wrong_way = refused("<mimic joint=\"finger_left_joint\"/>");
    assert_eq!(
        wrong_way,
        "joint `finger_right_joint` follows `finger_left_joint`, which cannot move within the limits of both"
    );
    refused("<mimic joint=\"finger_left_joint\" multiplier=\"-1\" offset=\"0.05\"/>");
    // A leader without limits has those of its follower; in a circle of wheels there are none.
    let (model, _) = read("<mimic joint=\"wheel_right_joint\" multiplier=\"-0.5\" offset=\"0.01\"/>").unwrap();
    let wheel = &model.dofs[model.dof("wheel_right_joint").unwrap()];
    assert_eq!((wheel.lower, wheel.upper, wheel.velocity), (0.02, 0.1, 0.2));
    // A locked leader has no motion to lose.
    let lock = |at: f64| Options { lock: [("finger_left_joint".to_owned(), at)].into(), ..Options::default() };
    let text = WORKCELL.replacen(MIMIC, "<mimic joint=\"finger_left_joint\"/>", 1);
    let warnings = |at: f64| {
        let (_, warnings) = Model::from_urdf(&text, &lock(at)).unwrap();
        warnings.into_iter().filter(|w| w.code == UrdfCode::Ignored).map(|w| w.text).collect::<Vec<_>>()
    };
    assert_eq!(warnings(0.0), [""; 0]);
    let outside = "joint `finger_right_joint` follows `finger_left_joint` to 0.01, outside its own limits";
    assert_eq!(warnings(0.01), [outside]);
}

#[test]
fn a_follower_that_never_moves_or_has_one_position_is_remarked() {
    let read = |text: &str| {
        let (model, warnings) = Model::from_urdf(text, &Options::default()).unwrap();
        (model, warnings.into_iter().filter(|w| w.code == UrdfCode::Ignored).map(|w| w.text).collect::<Vec<_>>())
    };
    let still = |offset: f64| {
        let mimic = format!("<mimic joint=\"finger_left_joint\" multiplier=\"0\" offset=\"{offset}\"/>");
        read(&WORKCELL.replacen(MIMIC, &mimic, 1)).1.len()
    };
    assert_eq!((still(0.01), still(-0.01)), (1, 0));
    let (model, said) = read(&WORKCELL.replacen("lower=\"-0.04\" upper=\"0\"", "lower=\"0\" upper=\"0\"", 1));
    assert_eq!(said, ["joint `finger_right_joint` follows another one, but its limits leave it only 0"]);
    let dof = &model.dofs[model.dof("finger_left_joint").unwrap()];
    assert_eq!((dof.lower, dof.upper), (0.0, 0.04));
    assert!(matches!(model.joint_ref(model.joint("finger_right_joint").unwrap()).drive, Drive::Mimic { .. }));
    // Multipliers that are written rounded change no limit.
    let (model, _) = read(&WORKCELL.replacen("upper=\"0.04\"", "upper=\"0.06\"", 1).replacen(
        "multiplier=\"-1\"",
        "multiplier=\"-0.66667\"",
        1,
    ));
    assert_eq!(model.dofs[model.dof("finger_left_joint").unwrap()].upper, 0.06);
}

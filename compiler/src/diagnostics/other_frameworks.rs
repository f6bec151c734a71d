//! Words of other frameworks for whole-body control, and the words for the same thing here. The pages of the book for those
//! who come from one, `docs/src/coming`, say what differs.
//!
//! Names are compared without case, separators, `add`, `task`, `constraint` and `limit`, so that `ComTask` of Pink,
//! `add_com_task` of PlaCo, `CoMTask` of mc_rtc and `com` are one word.

/// A word of other frameworks.
struct Word {
    /// Its spellings, in the form of [`plain`].
    names: &'static [&'static str],
    /// Frameworks that use it.
    of: &'static str,
    /// The same thing here, in Markdown.
    here: &'static str,
}

const fn word(names: &'static [&'static str], of: &'static str, here: &'static str) -> Word {
    Word { names, of, here }
}

static WORDS: &[Word] = &[
    word(
        &[
            "frame",
            "cartesian",
            "se3equality",
            "endeffector",
            "transform",
            "surfacetransform",
            "bsplinetrajectory",
            "exactcubictrajectory",
        ],
        "Pink, TSID, OpenSoT, PlaCo and mc_rtc",
        "`frame_pose(FRAME) { position ..  orientation .. }`, with `axes` for a mask and `axis_weights` for costs",
    ),
    word(&["position"], "PlaCo and mc_rtc", "`frame_position(FRAME) { position .. }`"),
    word(&["orientation"], "PlaCo and mc_rtc", "`frame_orientation(FRAME) { orientation .. }`"),
    word(
        &["axisalign", "vectororientation", "axis"],
        "PlaCo and mc_rtc",
        "`track(frame(FRAME).orientation*[0, 0, 1]) { target [0, 0, -1] }`",
    ),
    word(
        &[
            "relativeframe",
            "twoframesequality",
            "relativeendeffector",
            "relativeposition",
            "relativeorientation",
            "relativepose",
        ],
        "Pink, TSID, PlaCo and mc_rtc",
        "`track(inverse(frame(A).pose)*frame(B).pose) { target .. }`",
    ),
    word(
        &["com", "comequality", "centerofmass", "centreofmass"],
        "Pink, TSID, OpenSoT, PlaCo and mc_rtc",
        "`track(com) { target .. }`, and `keep(com) { min ..  max .. }` as a limit",
    ),
    word(
        &["posture", "postural", "jointposture", "joints", "jointspace", "configuration"],
        "Pink, TSID, OpenSoT, PlaCo and mc_rtc",
        "`joint_position { target .. }`, and `joints [..]` for some joints",
    ),
    word(
        &["damping", "regularization", "regularisation", "minimumvelocity", "minimizevelocity"],
        "Pink, OpenSoT, PlaCo and mc_rtc",
        "`least_motion(velocity)` on the last level, or `damping 0.01` in a level",
    ),
    word(
        &["lowacceleration", "minimizeacceleration", "minimumacceleration"],
        "Pink and OpenSoT",
        "`least_motion(acceleration)`, or `joint_acceleration_limits` as a bound",
    ),
    word(
        &["gear", "jointcoupling", "coupling", "mimic"],
        "Pink and PlaCo",
        "`track(joint(A) - 0.5*joint(B)) { target 0 rad }`",
    ),
    word(
        &["linearholonomic", "jointspacehalfspaces", "halfspaces", "compoundjoint"],
        "Pink, PlaCo and mc_rtc",
        "`track(..)` or `keep(..)` of a sum of joints, `joint(A) + 2*joint(B)`",
    ),
    word(
        &["distance"],
        "PlaCo",
        "`track(norm(frame(A).position - frame(B).position)) { target .. }`, and `keep(..)` of it as a limit",
    ),
    word(
        &["manipulability"],
        "Pink, OpenSoT and PlaCo",
        "`track(manipulability(FRAME)) { target .. }`, and `keep(manipulability(FRAME)) { min .. }` as a limit",
    ),
    word(
        &["gaze", "lookat", "lookatframe", "lookatsurface", "lookattf"],
        "OpenSoT and mc_rtc",
        "`look_at(FRAME) { target [..] m }`",
    ),
    word(
        &["cone", "fieldofview", "visibility"],
        "PlaCo",
        "`keep(angle_between(frame(FRAME).orientation*[0, 0, 1], [0, 0, 1])) { max 20 deg }`",
    ),
    word(
        &["impedance", "firstorderimpedance", "cartesianadmittance", "compliance"],
        "OpenSoT and mc_rtc",
        "`admittance(FRAME) { .. }`",
    ),
    word(
        &["omniwheel", "rolling", "purerolling", "omniwheels4x"],
        "Pink and OpenSoT",
        "`base planar` or `base unicycle` of the robot, without wheels",
    ),
    word(&["twist", "deltatwist"], "MoveIt Servo", "`frame_pose(FRAME)` with a gain of zero and a target that moves"),
    word(&["jointjog", "deltajoint"], "MoveIt Servo", "`joint_velocity { velocity .. }`"),
    word(
        &[
            "config",
            "configuration",
            "jointbounds",
            "jointposvelaccbounds",
            "joint",
            "kinematics",
            "dynamics",
            "jointlimits",
            "positionlimits",
        ],
        "Pink, TSID, OpenSoT and mc_rtc",
        "`joint_position_limits`, with `joint_velocity_limits` and `joint_acceleration_limits`",
    ),
    word(
        &["velocity", "velocitylimits", "boundedspeed", "jointvelocitylimits", "floatingbasevelocity"],
        "Pink, OpenSoT and mc_rtc",
        "`joint_velocity_limits`",
    ),
    word(&["acceleration", "accelerationlimits"], "Pink", "`joint_acceleration_limits`"),
    word(
        &["selfcollisionbarrier", "selfcollisionavoidance", "collisionavoidance", "avoidselfcollisions", "collisions"],
        "Pink, OpenSoT, PlaCo and mc_rtc",
        "`self_collision { between ..  and .. }`, and `keep_clear { links ..  of .. }` for obstacles",
    ),
    word(
        &["positionbarrier", "cartesianposition"],
        "Pink and OpenSoT",
        "`keep(frame(FRAME).position) { min ..  max .. }`, or `virtual_wall`",
    ),
    word(
        &["bodysphericalbarrier", "sphericalbarrier"],
        "Pink",
        "`keep(norm(frame(A).position - frame(B).position)) { min .. }`",
    ),
    word(
        &["convexhull", "compolygon", "comincplane", "supportpolygon"],
        "OpenSoT, PlaCo and mc_rtc",
        "`keep(com) { min ..  max .. }` for a box, or a `keep(dot(com - POINT, NORMAL)) { min .. }` for each edge of a polygon",
    ),
    word(&["contact", "contact6d", "contactpoint", "addcontact"], "TSID and mc_rtc", "`hold(FRAME)` on a hard level"),
];

/// A name without case, separators, and words that say no more than that it is a task or a limit.
fn plain(name: &str) -> String {
    let mut rest: String = name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    for prefix in ["add", "task"] {
        if let Some(short) = rest.strip_prefix(prefix).filter(|s| !s.is_empty()) {
            rest = short.to_string();
        }
    }
    for suffix in ["task", "constraint", "constr", "limit"] {
        if let Some(short) = rest.strip_suffix(suffix).filter(|s| !s.is_empty()) {
            rest = short.to_string();
        }
    }
    rest
}

/// Sentence that says what a word of other frameworks is here.
pub(crate) fn known_elsewhere(name: &str) -> Option<String> {
    let plain = plain(name);
    let limit = name.to_lowercase().contains("limit");
    let limits = |w: &&Word| w.here.contains("_limits");
    let matching = || WORDS.iter().filter(|w| w.names.contains(&plain.as_str()));
    let found = matching().find(|w| limits(w) == limit).or_else(|| matching().next())?;
    Some(format!("`{name}` of {} is here {}", found.of, found.here))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_one_thing_are_one_word() {
        for name in ["com", "ComTask", "CoMTask", "TaskComEquality", "add_com_task", "CoM"] {
            let said = known_elsewhere(name).unwrap_or_default();
            assert!(said.contains("`track(com)"), "{name}: {said}");
        }
        for (name, here) in [
            ("FrameTask", "`frame_pose"),
            ("TaskSE3Equality", "`frame_pose"),
            ("posture", "`joint_position"),
            ("TaskJointPosture", "`joint_position"),
            ("relative_frame", "inverse(frame(A).pose)"),
            ("damping", "`least_motion"),
            ("config_limit", "`joint_position_limits"),
            ("ConfigurationLimit", "`joint_position_limits"),
            ("VelocityLimit", "`joint_velocity_limits"),
            ("self_collision_barrier", "`self_collision"),
            ("add_avoid_self_collisions_constraint", "`self_collision"),
            ("add_manipulability_task", "manipulability(FRAME)"),
            ("GazeTask", "`look_at"),
            ("add_gear_task", "joint(A)"),
            ("CollisionsConstraint", "`self_collision"),
            ("BodySphericalBarrier", "norm(frame(A)"),
            ("LookAtTask", "`look_at"),
            ("DynamicsConstraint", "`joint_position_limits"),
            ("JOINT_JOG", "`joint_velocity"),
            ("OmniwheelTask", "`base planar`"),
        ] {
            let said = known_elsewhere(name).unwrap_or_default();
            assert!(said.contains(here), "{name}: {said}");
        }
        assert_eq!(known_elsewhere("reach"), None);
    }

    #[test]
    fn nothing_here_is_called_a_word_from_elsewhere() {
        for kind in stdlib_tasks::KINDS {
            let word = WORDS.iter().flat_map(|w| w.names).find(|n| **n == kind.name);
            assert!(word.is_none(), "`{}` is a task type", kind.name);
        }
    }

    /// The task types that sentences name exist.
    #[test]
    fn sentences_name_what_there_is() {
        for here in WORDS.iter().map(|w| w.here) {
            for quoted in here.split('`').skip(1).step_by(2) {
                let kind = quoted.split(['(', ' ']).next().unwrap_or_default();
                let expression = ["axes", "axis_weights", "joints", "joint", "damping", "base"].contains(&kind);
                assert!(expression || stdlib_tasks::find(kind).is_some(), "`{kind}` in `{here}`");
            }
        }
    }
}

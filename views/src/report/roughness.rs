//! Sentences about joints that jumped or reversed in a run.

use std::collections::BTreeMap;

use runtime::record::joint_motion::JointMotion;

/// A joint with its motion statistics.
pub type Joint<'s> = (&'s str, &'s JointMotion);

/// Joints that jumped or reversed, sorted by the number of reversals, then of jumps, in descending order.
pub fn rough(joints: &BTreeMap<String, JointMotion>) -> Vec<Joint<'_>> {
    let mut rough: Vec<Joint> =
        joints.iter().filter(|(_, j)| j.is_rough()).map(|(name, j)| (name.as_str(), j)).collect();
    rough.sort_by_key(|(_, j)| std::cmp::Reverse((j.reversals, j.jumps)));
    rough
}

/// Sentence about rough joints: "`joint_2` reversed 455 times (first at 1.40 s), and so did 2 more joints; `joint_1`
/// jumped once (at 2.00 s)"; `None` without any.
pub fn sentence(joints: &BTreeMap<String, JointMotion>) -> Option<String> {
    let reversed = clause(joints, "reversed", |j| (j.reversals, j.first_reversal_s));
    let jumped = clause(joints, "jumped", |j| (j.jumps, j.first_jump_s));
    let all: Vec<String> = reversed.into_iter().chain(jumped).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

fn clause(
    joints: &BTreeMap<String, JointMotion>,
    did: &str,
    of: fn(&JointMotion) -> (usize, Option<f64>),
) -> Option<String> {
    let mut all: Vec<(&String, usize, Option<f64>)> =
        joints.iter().map(|(name, j)| (name, of(j).0, of(j).1)).filter(|(_, count, _)| *count > 0).collect();
    all.sort_by_key(|(_, count, _)| std::cmp::Reverse(*count));
    let (name, count, first) = *all.first()?;
    let first = first.unwrap_or(0.0);
    let times = match count {
        1 => format!("once (at {first:.2} s)"),
        n => format!("{n} times (first at {first:.2} s)"),
    };
    let others = match all.len() - 1 {
        0 => String::new(),
        1 => ", and so did 1 more joint".to_string(),
        n => format!(", and so did {n} more joints"),
    };
    Some(format!("`{name}` {did} {times}{others}"))
}

/// Advice against rough motion; `None` if no joint jumped or reversed.
pub fn advice(joints: &BTreeMap<String, JointMotion>) -> Option<&'static str> {
    if joints.values().any(|j| j.reversals > 0) {
        return Some(
            "velocities that turn round and back at once wear a robot out: `damping` on the level that asks for them or \
             `joint_acceleration_limits` calms them, and `expect always reversals(all) <= 0` tests for them",
        );
    }
    joints.values().any(|j| j.jumps > 0).then_some(
        "no drive follows a velocity that jumps: let targets move along a `trapezoid`, go over to another stack with \
         `blend`, or add `joint_acceleration_limits`",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(jumps: usize, reversals: usize) -> JointMotion {
        let first = |n: usize, at: f64| (n > 0).then_some(at);
        JointMotion {
            unit: "rad/s^2".to_string(),
            max_acceleration: 1.0,
            at_s: 0.0,
            jumps,
            first_jump_s: first(jumps, 0.5),
            reversals,
            first_reversal_s: first(reversals, 1.4),
        }
    }

    fn joints(all: &[(&str, usize, usize)]) -> BTreeMap<String, JointMotion> {
        all.iter().map(|(name, jumps, reversals)| (name.to_string(), motion(*jumps, *reversals))).collect()
    }

    #[test]
    fn the_worst_joint_is_named_and_the_others_are_counted() {
        let said = |all: &[(&str, usize, usize)]| sentence(&joints(all)).unwrap_or_default();
        assert_eq!(said(&[("a", 0, 0)]), "");
        assert_eq!(
            said(&[("a", 0, 3), ("b", 0, 455)]),
            "`b` reversed 455 times (first at 1.40 s), and so did 1 more joint"
        );
        assert_eq!(
            said(&[("a", 1, 0), ("b", 0, 1), ("c", 0, 1), ("d", 0, 1)]),
            "`b` reversed once (at 1.40 s), and so did 2 more joints; `a` jumped once (at 0.50 s)"
        );
        let all = joints(&[("a", 9, 1), ("b", 0, 0), ("c", 0, 2)]);
        assert_eq!(rough(&all).iter().map(|j| j.0).collect::<Vec<_>>(), ["c", "a"]);
        assert!(advice(&all).is_some_and(|a| a.contains("reversals(all)")));
        assert!(advice(&joints(&[("a", 1, 0)])).is_some_and(|a| a.contains("jumps")));
        assert_eq!(advice(&joints(&[("a", 0, 0)])), None);
    }
}

//! Converts helps to YAML syntax in a YAML spec. Helps are written in the syntax of `*.hq` files.

use crate::diagnostics::snippets;

/// Texts of helps in both syntaxes, for cases that the general rule does not cover.
static PAIRS: &[(&str, &str)] = &[
    ("`{ name value .. }`", "`{ name: value, .. }`"),
    ("`{ joint value .. }`", "`{ joint: value, .. }`"),
    ("`{ ARM value .. }`", "`{ ARM: value, .. }`"),
    ("`robot NAME { urdf \"..\"  rate 100 Hz }`", "`robots: { NAME: { urdf: .., rate: 100 Hz } }`"),
    ("`stack NAME { level NAME { task } }`", "`stacks: { NAME: { levels: [ { name: NAME, tasks: [task] } ] } }`"),
    ("`level NAME { task }`", "`levels: [ { name: NAME, tasks: [task] } ]`"),
    (
        "`level limits hard { joint_acceleration_limits }`",
        "`{ name: limits, hard: true, tasks: [joint_acceleration_limits] }`",
    ),
    ("`level gentle { joint_acceleration_limits }`", "`{ name: gentle, tasks: [joint_acceleration_limits] }`"),
    ("`param NAME = VALUE`", "`params: { NAME: VALUE }`"),
    ("`task NAME = TYPE { .. }`", "`tasks: { NAME: { TYPE: { .. } } }`"),
    ("`run { stack ", "`run: { stack: "),
    ("  duration 10 s }`", ", duration: 10 s }`"),
    ("`keep((VALUE).x) { min .. }`", "`\"keep((VALUE).x)\": { min: .. }`"),
    ("`keep((VALUE).x) { max .. }`", "`\"keep((VALUE).x)\": { max: .. }`"),
    ("`urdf \"robots/arm7.urdf\"`", "`urdf: robots/arm7.urdf`"),
    ("`package_path \"..\"`", "`package_path: \"..\"`"),
    ("`tip left_tool`", "`tip: left_tool`"),
    ("`arms { left { tip left_tool } }`", "`arms: { left: { tip: left_tool } }`"),
    (
        "`arms { left { shoulder .. elbow .. wrist .. tip .. } }`",
        "`arms: { left: { shoulder: .., elbow: .., wrist: .., tip: .. } }`",
    ),
    ("`points { left_elbow arm_left_4_link }`", "`points: { left_elbow: arm_left_4_link }`"),
    (
        "`{ link NAME  from [x, y, z] m  to [x, y, z] m }`",
        "`{ link: NAME, from: \"[x, y, z] m\", to: \"[x, y, z] m\" }`",
    ),
    ("`lock [head_pan]`, or `lock { head_pan 0.1 rad }`", "`lock: [head_pan]`, or `lock: { head_pan: 0.1 rad }`"),
    ("`NAME LINK`, such as `elbow link_4`", "`NAME: LINK`, such as `elbow: link_4`"),
    ("`base fixed`", "`base: fixed`"),
    ("`lock [base]`", "`lock: [base]`"),
    ("in quotes", "as a text"),
    ("in braces", "as a mapping, `{ name: value }`"),
];

/// Converts a help to YAML syntax, unless it shows both.
pub fn in_yaml(help: &str) -> String {
    if help.contains("in YAML") {
        return help.to_string();
    }
    let help = PAIRS.iter().fold(help.to_string(), |text, (hq, yaml)| text.replace(hq, yaml));
    let pieces = help.split('`').enumerate().map(|(i, piece)| match i % 2 {
        1 => snippets::in_yaml(piece).unwrap_or_else(|| piece.to_string()),
        _ => piece.to_string(),
    });
    pieces.collect::<Vec<_>>().join("`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn helps_in_yaml() {
        assert_eq!(in_yaml("write `run { stack a  duration 10 s }`"), "write `run: { stack: a, duration: 10 s }`");
        assert_eq!(in_yaml("write `[x, y, z]`"), "write `[x, y, z]`");
        assert_eq!(in_yaml("write `[1, 2] m` or `2 m`"), "write `\"[1, 2] m\"` or `2 m`");
        for (hq, yaml) in PAIRS {
            assert!(!yaml.contains(hq), "{hq} would be replaced twice");
        }
    }
}

//! Helps are written for `*.hq` files; in a YAML spec they show the YAML spelling.

/// What a help shows in a `*.hq` file, and the same in YAML.
static PAIRS: &[(&str, &str)] = &[
    ("`{ name value .. }`", "`{ name: value, .. }`"),
    ("`{ joint value .. }`", "`{ joint: value, .. }`"),
    ("`{ ARM value .. }`", "`{ ARM: value, .. }`"),
    ("`robot NAME { urdf \"..\"  rate 100 Hz }`", "`robots: { NAME: { urdf: .., rate: 100 Hz } }`"),
    ("`stack NAME { level NAME { task } }`", "`stacks: { NAME: { levels: [ { name: NAME, tasks: [task] } ] } }`"),
    ("`level NAME { task }`", "`levels: [ { name: NAME, tasks: [task] } ]`"),
    ("`param NAME = VALUE`", "`params: { NAME: VALUE }`"),
    ("`task NAME = TYPE { .. }`", "`tasks: { NAME: { TYPE: { .. } } }`"),
    ("`run { stack ", "`run: { stack: "),
    ("  duration 10 s }`", ", duration: 10 s }`"),
    ("`duration 10 s`", "`duration: 10 s`"),
    ("`keep((VALUE).x) { min .. }`", "`\"keep((VALUE).x)\": { min: .. }`"),
    ("`keep((VALUE).x) { max .. }`", "`\"keep((VALUE).x)\": { max: .. }`"),
    ("`rate 100 Hz`", "`rate: 100 Hz`"),
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
    ("`max 1 rad/s`", "`max: 1 rad/s`"),
    ("`base fixed`", "`base: fixed`"),
    ("`lock [base]`", "`lock: [base]`"),
    ("`depot [4, -1.5] m`", "`depot: \"[4, -1.5] m\"`"),
    ("`place [4, -1.5] m`", "`place: \"[4, -1.5] m\"`"),
    ("`speed [0.05, 0.2] m/s`", "`speed: \"[0.05, 0.2] m/s\"`"),
    ("`proximity_speed [0.05, 0.2] m/s`", "`proximity_speed: \"[0.05, 0.2] m/s\"`"),
    ("`duration normal(204 s, 20 s)`", "`duration: \"normal(204 s, 20 s)\"`"),
    ("`serve 20 s`", "`serve: 20 s`"),
    ("`makespan 1`", "`makespan: 1`"),
    ("`batch 4`", "`batch: 4`"),
    (
        "`robot NAME { depot [x, y] m  speed [0.05, 0.2] m/s  serve 20 s }`",
        "`robots: { NAME: { depot: \"[x, y] m\", speed: \"[0.05, 0.2] m/s\", serve: 20 s } }`",
    ),
    ("`human NAME { place [x, y] m  duration 200 s }`", "`humans: { NAME: { place: \"[x, y] m\", duration: 200 s } }`"),
    ("in quotes", "as a text"),
    ("in braces", "as a mapping, `{ name: value }`"),
];

/// A help in the YAML spelling. There a list with something behind it, `[0.05, 0.2] m/s`, stands in quotes.
pub fn in_yaml(help: &str) -> String {
    let help = PAIRS.iter().fold(help.to_string(), |text, (hq, yaml)| text.replace(hq, yaml));
    let pieces = help.split('`').enumerate().map(|(i, piece)| {
        let bare = i % 2 == 1 && piece.starts_with('[') && piece.contains("] ");
        if bare { format!("\"{piece}\"") } else { piece.to_string() }
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

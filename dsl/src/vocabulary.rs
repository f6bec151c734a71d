//! The words that the readers themselves must know: unit symbols, the keys whose value is text, the roles of a mission.

/// Unit symbols, so that `0.15 m  gain 5 /s` can be told from two entries. What they mean is the compiler's.
pub static UNITS: &[&str] = &[
    "m", "cm", "mm", "km", "um", "rad", "mrad", "deg", "turn", "s", "ms", "us", "min", "h", "Hz", "kHz", "rpm", "kg",
    "g", "N", "kN", "mN", "Nm", "J", "W",
];

/// Keys whose value is text, or a list of texts, so that YAML may write it without quotes of ours around it.
pub static TEXT_KEYS: &[&str] =
    &["urdf", "title", "package_path", "file", "instruction", "directives", "layers_from", "spec", "scenario", "label"];

/// What a member of a mission can be: `robot m1 { .. }`; in YAML the members stand below the plural, `robots:`. None of
/// the plurals can be a setting of a mission.
pub static ROLES: &[&str] = &["robot", "human", "worker", "object", "place", "layer", "task"];

/// The kinds of missions, which stand above everything else of a mission in YAML.
pub static MISSION_KINDS: &[&str] = &["schedule", "layers"];

/// What a task of a layer says of its action; none of these is one.
pub static TASK_SETTINGS: &[&str] = &["label", "features", "to", "via", "object", "agent"];

/// True for a word that begins a part of a state in the native spelling.
pub(crate) fn begins_part(word: &str) -> bool {
    matches!(word, "state" | "final" | "stack" | "enter" | "do" | "exit" | "on" | "when" | "after")
}

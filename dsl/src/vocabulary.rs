//! The words that the readers need to know: unit symbols, the sections of a repetition, the keys whose value is text, the
//! roles of a mission.

/// Unit symbols, so that the readers can distinguish a unit from the next key, as in `0.15 m  gain 5 /s`. The compiler
/// defines their meaning.
pub static UNITS: &[&str] = &[
    "m", "cm", "mm", "km", "um", "rad", "mrad", "deg", "turn", "s", "ms", "us", "min", "h", "Hz", "kHz", "rpm", "kg",
    "g", "N", "kN", "mN", "Nm", "J", "W",
];

/// The key of every block below which warnings are allowed, by their codes.
pub const ALLOW: &str = "allow";

/// Lists the sections of YAML with named declarations that a repetition may contain.
macro_rules! sections {
    ($($section:literal),*) => {
        /// Sections of YAML that a repetition may contain.
        pub static REPEATED: &[&str] = &[$($section,)* "scenarios", "for", "coverage"];

        /// Sections of YAML that contain named declarations of one form.
        pub(crate) static LISTS: &[&str] = &["robots", $($section),*];

        /// The keys at the top of a YAML file.
        pub(crate) static SECTIONS: &[&str] =
            &["hierarq", "import", "robots", $($section,)* "scenarios", "for", "coverage", "run"];
    };
}

sections!(
    "allow",
    "params",
    "lets",
    "tasks",
    "stacks",
    "signals",
    "humans",
    "safety_fields",
    "obstacles",
    "variables",
    "machines",
    "missions"
);

/// Keys whose value is a text, or a list of texts, so that it needs no quotes of this language in YAML.
pub static TEXT_KEYS: &[&str] = &[
    "urdf",
    "srdf",
    "title",
    "package_path",
    "file",
    "instruction",
    "directives",
    "layers_from",
    "map",
    "spec",
    "mesh",
    "cloud",
    "heightfield",
    "scenario",
    "label",
    "topic",
    "message",
    "prefix",
    "frame_id",
    "node",
    "namespace",
    "world_frame",
    "odometry",
];

/// Lists the roles of members of a mission.
macro_rules! roles {
    ($($role:literal),*) => {
        /// The roles of members of a mission: `robot m1 { .. }`; in YAML the members are listed below the plural,
        /// `robots:`. None of the plurals can be a setting of a mission.
        pub static ROLES: &[&str] = &[$($role),*];

        /// The keys of YAML below which members are listed, and `for`.
        pub(crate) static MEMBER_KEYS: &[&str] = &[$(concat!($role, "s"),)* "for"];
    };
}

roles!("robot", "human", "worker", "object", "place", "layer", "task", "source", "wall", "target", "obstacle");

/// Settings of the action of a task of a layer; none of these is an action.
pub static TASK_SETTINGS: &[&str] = &["label", "features", "to", "via", "object", "agent"];

/// Returns true for a word that begins a part of a state in the native syntax.
pub(crate) fn begins_part(word: &str) -> bool {
    matches!(word, "state" | "region" | "final" | "stack" | "enter" | "do" | "exit" | "on" | "when" | "after" | "check")
}

//! The compiler's diagnostic codes with their pages for `hierarq explain`.
//!
//! Families: `HQ01` form (in `dsl`), `HQ02` names, `HQ03` types and units, `HQ04` robot, `HQ05` safety,
//! `HQ06` hierarchy and run, `HQ07` machines, `HQ08` scenarios, `HQ09` missions. Their pages are the `*.md` files beside this one;
//! [`dsl::codes`] says how they are read.

use std::sync::LazyLock;

use dsl::codes::read;
pub use dsl::codes::{Page, Part};

/// The pages of this crate, in rising order of their codes.
pub static PAGES: LazyLock<Vec<Page>> = LazyLock::new(|| {
    let families = [
        include_str!("names.md"),
        include_str!("types.md"),
        include_str!("robot.md"),
        include_str!("safety.md"),
        include_str!("hierarchy.md"),
        include_str!("machine.md"),
        include_str!("scenarios.md"),
        include_str!("missions.md"),
        include_str!("mission_scenarios.md"),
        include_str!("mission_workers.md"),
    ];
    families.into_iter().flat_map(read).collect()
});

/// The robot of the examples that show none, in the native spelling.
pub const EXAMPLE_ROBOT: &str = include_str!("robot.hq");

/// The same robot in YAML.
pub const EXAMPLE_ROBOT_YAML: &str = include_str!("robot.yaml");

/// The page of a code of any family, whatever the case of its letters.
pub fn explain(code: &str) -> Option<Page> {
    all().find(|p| p.code.eq_ignore_ascii_case(code)).copied()
}

/// The pages of all families, in order.
pub fn all() -> impl Iterator<Item = &'static Page> {
    dsl::codes::PAGES.iter().chain(PAGES.iter())
}

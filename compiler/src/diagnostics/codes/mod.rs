//! The compiler's diagnostic codes, with their pages for `hierarq explain`.
//!
//! Families: `HQ01` syntax (in `dsl`), `HQ02` names, `HQ03` types and units, `HQ04` robot, `HQ05` safety, `HQ06`
//! hierarchy and run, `HQ07` machines, `HQ08` scenarios, `HQ09` missions. Their pages are the `*.md` files beside this
//! one; [`dsl::codes`] describes their format.

use std::sync::LazyLock;

use dsl::codes::read;
pub use dsl::codes::{Page, Part};

/// Pages of this crate, sorted by code.
pub static PAGES: LazyLock<Vec<Page>> = LazyLock::new(|| {
    let families = [
        include_str!("names.md"),
        include_str!("types.md"),
        include_str!("robot.md"),
        include_str!("safety.md"),
        include_str!("postures.md"),
        include_str!("people_and_sensors.md"),
        include_str!("guards.md"),
        include_str!("coverage.md"),
        include_str!("obstacles.md"),
        include_str!("sampled.md"),
        include_str!("hierarchy.md"),
        include_str!("machine.md"),
        include_str!("scenarios.md"),
        include_str!("missions.md"),
        include_str!("mission_scenarios.md"),
        include_str!("mission_workers.md"),
        include_str!("searches.md"),
        include_str!("mission_driven.md"),
        include_str!("explorations.md"),
    ];
    families.into_iter().flat_map(read).collect()
});

/// True for the codes of findings at sampled postures, which only [`crate::compile_deep`] looks for.
pub fn is_deep(code: &str) -> bool {
    ("HQ0590".."HQ0600").contains(&code)
}

/// Robot for examples that declare none, in `*.hq` syntax.
pub const EXAMPLE_ROBOT: &str = include_str!("robot.hq");

/// The same robot in YAML.
pub const EXAMPLE_ROBOT_YAML: &str = include_str!("robot.yaml");

/// Page of a code of any family, case-insensitive.
pub fn explain(code: &str) -> Option<Page> {
    all().find(|p| p.code.eq_ignore_ascii_case(code)).copied()
}

/// Pages of all families, in order.
pub fn all() -> impl Iterator<Item = &'static Page> {
    dsl::codes::PAGES.iter().chain(PAGES.iter())
}

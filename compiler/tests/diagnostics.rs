//! Every mistake that the compiler reports: its span, its message, and that it is reported once.
//!
//! The cases are in `cases/*.txt`; the snapshots show each diagnostic under the line that it refers to.

use crate::common;

use common::{annotated, cases};
use dsl::{Severity, Syntax};
use hierarq_compiler::codes;
use std::collections::BTreeSet;

const FILES: &[(&str, &str, Syntax)] = &[
    ("names", include_str!("cases/names.txt"), Syntax::Native),
    ("values", include_str!("cases/values.txt"), Syntax::Native),
    ("robot", include_str!("cases/robot.txt"), Syntax::Native),
    ("plants", include_str!("cases/plants.txt"), Syntax::Native),
    ("plants_yaml", include_str!("cases/plants_yaml.txt"), Syntax::Yaml),
    ("ros", include_str!("cases/ros.txt"), Syntax::Native),
    ("ros_yaml", include_str!("cases/ros_yaml.txt"), Syntax::Yaml),
    ("robots", include_str!("cases/robots.txt"), Syntax::Native),
    ("robots_yaml", include_str!("cases/robots_yaml.txt"), Syntax::Yaml),
    ("state", include_str!("cases/state.txt"), Syntax::Native),
    ("stance", include_str!("cases/stance.txt"), Syntax::Native),
    ("stance_yaml", include_str!("cases/stance_yaml.txt"), Syntax::Yaml),
    ("frames", include_str!("cases/frames.txt"), Syntax::Native),
    ("poses", include_str!("cases/poses.txt"), Syntax::Native),
    ("trajectories", include_str!("cases/trajectories.txt"), Syntax::Native),
    ("checks", include_str!("cases/checks.txt"), Syntax::Native),
    ("urdf", include_str!("cases/urdf.txt"), Syntax::Native),
    ("srdf", include_str!("cases/srdf.txt"), Syntax::Native),
    ("srdf_yaml", include_str!("cases/srdf_yaml.txt"), Syntax::Yaml),
    ("yaml", include_str!("cases/yaml.txt"), Syntax::Yaml),
    ("imports", include_str!("cases/imports.txt"), Syntax::Native),
    ("reuse", include_str!("cases/reuse.txt"), Syntax::Native),
    ("scenarios", include_str!("cases/scenarios.txt"), Syntax::Native),
    ("scenarios_yaml", include_str!("cases/scenarios_yaml.txt"), Syntax::Yaml),
    ("humans", include_str!("cases/humans.txt"), Syntax::Native),
    ("humans_yaml", include_str!("cases/humans_yaml.txt"), Syntax::Yaml),
    ("fields", include_str!("cases/fields.txt"), Syntax::Native),
    ("fields_yaml", include_str!("cases/fields_yaml.txt"), Syntax::Yaml),
    ("planners", include_str!("cases/planners.txt"), Syntax::Native),
    ("machines", include_str!("cases/machines.txt"), Syntax::Native),
    ("regions", include_str!("cases/regions.txt"), Syntax::Native),
    ("missions", include_str!("cases/missions.txt"), Syntax::Native),
    ("missions_runs", include_str!("cases/missions_runs.txt"), Syntax::Native),
    ("missions_runs_yaml", include_str!("cases/missions_runs_yaml.txt"), Syntax::Yaml),
    ("missions_driven", include_str!("cases/missions_driven.txt"), Syntax::Native),
    ("missions_driven_yaml", include_str!("cases/missions_driven_yaml.txt"), Syntax::Yaml),
    ("missions_yaml", include_str!("cases/missions_yaml.txt"), Syntax::Yaml),
    ("mission_scenarios", include_str!("cases/mission_scenarios.txt"), Syntax::Native),
    ("mission_scenarios_yaml", include_str!("cases/mission_scenarios_yaml.txt"), Syntax::Yaml),
    ("searches", include_str!("cases/searches.txt"), Syntax::Native),
    ("explorations", include_str!("cases/explorations.txt"), Syntax::Native),
    ("explorations_yaml", include_str!("cases/explorations_yaml.txt"), Syntax::Yaml),
    ("missions_reuse", include_str!("cases/missions_reuse.txt"), Syntax::Native),
    ("yardstick", include_str!("cases/yardstick.txt"), Syntax::Native),
    ("unusual", include_str!("cases/unusual.txt"), Syntax::Native),
    ("unusual_yaml", include_str!("cases/unusual_yaml.txt"), Syntax::Yaml),
    ("allowances", include_str!("cases/allowances.txt"), Syntax::Native),
    ("allowances_yaml", include_str!("cases/allowances_yaml.txt"), Syntax::Yaml),
    ("people_sensors", include_str!("cases/people_sensors.txt"), Syntax::Native),
    ("people_sensors_yaml", include_str!("cases/people_sensors_yaml.txt"), Syntax::Yaml),
    ("guards", include_str!("cases/guards.txt"), Syntax::Native),
    ("guards_yaml", include_str!("cases/guards_yaml.txt"), Syntax::Yaml),
    ("coverage", include_str!("cases/coverage.txt"), Syntax::Native),
    ("obstacles", include_str!("cases/obstacles.txt"), Syntax::Native),
    ("obstacles_yaml", include_str!("cases/obstacles_yaml.txt"), Syntax::Yaml),
    ("coverage_yaml", include_str!("cases/coverage_yaml.txt"), Syntax::Yaml),
    ("reuse_yaml", include_str!("cases/reuse_yaml.txt"), Syntax::Yaml),
    ("motions", include_str!("cases/motions.txt"), Syntax::Native),
    ("motions_yaml", include_str!("cases/motions_yaml.txt"), Syntax::Yaml),
    ("other_frameworks", include_str!("cases/other_frameworks.txt"), Syntax::Native),
    ("other_frameworks_yaml", include_str!("cases/other_frameworks_yaml.txt"), Syntax::Yaml),
    ("sampled", include_str!("cases/sampled.txt"), Syntax::Native),
    ("sampled_yaml", include_str!("cases/sampled_yaml.txt"), Syntax::Yaml),
];

/// Text of the snapshot, reported codes, and titles of cases with an unexpected number of diagnostics.
fn outcome(text: &str, syntax: Syntax) -> (String, BTreeSet<&'static str>, Vec<String>) {
    let (mut out, mut codes, mut wrong) = (String::new(), BTreeSet::new(), Vec::new());
    for case in cases(text, syntax) {
        let compiled = case.compile();
        let found = &compiled.report.diagnostics;
        if found.len() != case.count {
            wrong.push(format!("{}: {} diagnostics, not {}", case.title, found.len(), case.count));
        }
        assert_eq!(compiled.is_good(), compiled.report.errors() == 0, "{}", case.title);
        codes.extend(found.iter().map(|d| d.code));
        out.push_str(&format!("==== {}\n{}", case.title, annotated(&compiled)));
    }
    (out, codes, wrong)
}

/// Every error has a help, because users must be able to fix it.
#[test]
fn errors_help() {
    let mut without = BTreeSet::new();
    for (_, text, syntax) in FILES {
        for case in cases(text, *syntax) {
            for d in case.compile().report.diagnostics {
                if d.severity == Severity::Error && d.help.is_none() && d.code != "HQ0402" && d.code >= "HQ02" {
                    without.insert(format!("{}: {}", d.code, d.message));
                }
            }
        }
    }
    assert!(without.is_empty(), "{without:#?}");
}

#[test]
fn every_code_has_a_case() {
    let seen: BTreeSet<&str> = FILES.iter().flat_map(|(_, text, syntax)| outcome(text, *syntax).1).collect();
    // HQ0584 and HQ0585 are about meshes and files beside a spec (tests/pieces.rs), HQ0607 about files that are not compiled
    // programs, HQ0623 about stacks too large for a file of cases.
    let elsewhere = ["HQ0584", "HQ0585", "HQ0607", "HQ0623"];
    let unseen: Vec<&str> =
        codes::PAGES.iter().map(|p| p.code).filter(|c| !elsewhere.contains(c) && !seen.contains(c)).collect();
    assert!(unseen.is_empty(), "no case for {unseen:?}");
}

fn check(name: &str) {
    let (_, text, syntax) = FILES.iter().find(|f| f.0 == name).expect("a file of cases");
    let (out, codes, wrong) = outcome(text, *syntax);
    for code in codes {
        assert!(codes::explain(code).is_some(), "{code} has no page");
    }
    insta::assert_snapshot!(name, out);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn allowances() {
    check("allowances");
}

#[test]
fn allowances_yaml() {
    check("allowances_yaml");
}

#[test]
fn plants() {
    check("plants");
}

#[test]
fn plants_yaml() {
    check("plants_yaml");
}

#[test]
fn ros() {
    check("ros");
}

#[test]
fn ros_yaml() {
    check("ros_yaml");
}

#[test]
fn robots() {
    check("robots");
}

#[test]
fn robots_yaml() {
    check("robots_yaml");
}

#[test]
fn motions() {
    check("motions");
}

#[test]
fn motions_yaml() {
    check("motions_yaml");
}

#[test]
fn other_frameworks() {
    check("other_frameworks");
}

#[test]
fn other_frameworks_yaml() {
    check("other_frameworks_yaml");
}

#[test]
fn obstacles() {
    check("obstacles");
}

#[test]
fn obstacles_yaml() {
    check("obstacles_yaml");
}

#[test]
fn srdf() {
    check("srdf");
}

#[test]
fn srdf_yaml() {
    check("srdf_yaml");
}

#[test]
fn coverage() {
    check("coverage");
}

#[test]
fn coverage_yaml() {
    check("coverage_yaml");
}

#[test]
fn people_sensors() {
    check("people_sensors");
}

#[test]
fn people_sensors_yaml() {
    check("people_sensors_yaml");
}

#[test]
fn guards() {
    check("guards");
}

#[test]
fn guards_yaml() {
    check("guards_yaml");
}

#[test]
fn names() {
    check("names");
}

#[test]
fn planners() {
    check("planners");
}

#[test]
fn missions() {
    check("missions");
}

#[test]
fn explorations() {
    check("explorations");
}

#[test]
fn explorations_yaml() {
    check("explorations_yaml");
}

#[test]
fn searches() {
    check("searches");
}

#[test]
fn missions_runs() {
    check("missions_runs");
}

#[test]
fn missions_runs_yaml() {
    check("missions_runs_yaml");
}

#[test]
fn missions_driven() {
    check("missions_driven");
}

#[test]
fn missions_driven_yaml() {
    check("missions_driven_yaml");
}

#[test]
fn mission_scenarios() {
    check("mission_scenarios");
}

#[test]
fn mission_scenarios_yaml() {
    check("mission_scenarios_yaml");
}

#[test]
fn missions_reuse() {
    check("missions_reuse");
}

#[test]
fn missions_yaml() {
    check("missions_yaml");
}

#[test]
fn humans() {
    check("humans");
}

#[test]
fn fields() {
    check("fields");
}

#[test]
fn fields_yaml() {
    check("fields_yaml");
}

#[test]
fn humans_yaml() {
    check("humans_yaml");
}

#[test]
fn values() {
    check("values");
}

#[test]
fn unusual() {
    check("unusual");
}

#[test]
fn unusual_yaml() {
    check("unusual_yaml");
}

#[test]
fn state() {
    check("state");
}

#[test]
fn stance() {
    check("stance");
    check("stance_yaml");
}

#[test]
fn scenarios() {
    check("scenarios");
}

#[test]
fn scenarios_yaml() {
    check("scenarios_yaml");
}

#[test]
fn frames() {
    check("frames");
}

#[test]
fn poses() {
    check("poses");
}

#[test]
fn robot() {
    check("robot");
}

#[test]
fn checks() {
    check("checks");
}

#[test]
fn urdf() {
    check("urdf");
}

#[test]
fn yaml() {
    check("yaml");
}

#[test]
fn imports() {
    check("imports");
}

#[test]
fn reuse() {
    check("reuse");
}

#[test]
fn reuse_yaml() {
    check("reuse_yaml");
}

#[test]
fn machines() {
    check("machines");
}

#[test]
fn regions() {
    check("regions");
}

/// Defects found in public controllers of other frameworks, each written as a spec.
#[test]
fn yardstick() {
    check("yardstick");
}

#[test]
fn trajectories() {
    check("trajectories");
}

#[test]
fn sampled() {
    check("sampled");
}

#[test]
fn sampled_yaml() {
    check("sampled_yaml");
}

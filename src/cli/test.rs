//! `hierarq test SPEC ..`

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use files::Target;
use hierarq::report::roughness;
use hierarq::scenario_runner::MAX_SEED;
use hierarq::scenario_runner::{self, ScenarioResult};
use hierarq::{outputs, project};
use runtime::expect::Verdict;
use serde_json::json;
use views::xml::escaped;

use super::{Outcome, SpecOptions, output, table};

#[derive(Args)]
pub struct Arguments {
    /// Specs (`*.hq`, `*.yaml`), compiled programs (`*.json`), or folders of specs.
    #[arg(required = true)]
    specs: Vec<PathBuf>,
    #[command(flatten)]
    options: SpecOptions,
    /// Run only the scenarios of this name.
    #[arg(long, value_name = "NAME")]
    scenario: Option<String>,
    /// Seed of all random numbers, in place of each scenario's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=MAX_SEED))]
    seed: Option<u64>,
    /// Print the results as JSON.
    #[arg(long)]
    json: bool,
    /// Write the results to a file in JUnit's format, for build servers.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let specs = scenario_runner::specs(&a.specs).map_err(|e| e.to_string())?;
    let tested = scenario_runner::compiled(&specs, &a.options.settings());
    let sources: Vec<PathBuf> = tested.iter().flat_map(|t| project::sources(Path::new(&t.spec), &t.report)).collect();
    let target = a.junit.as_deref().map(|path| Target::new("--junit", path, outputs::JUNIT, &sources)).transpose()?;
    for t in &tested {
        output::show(&t.report);
    }
    let broken: Vec<&str> = tested.iter().filter(|t| t.report.errors() > 0).map(|t| t.spec.as_str()).collect();
    let results = scenario_runner::all(&tested, a.scenario.as_deref(), a.seed)?;
    if results.is_empty() && broken.is_empty() {
        return Err(nothing(a, &tested));
    }
    let ok = broken.is_empty() && results.iter().all(|t| t.ok);
    target.map(|target| target.write(&junit(&results, &broken))).transpose()?;
    if a.json {
        let data = json!({ "version": 1, "ok": ok, "broken": broken, "scenarios": results });
        output::data(&format!("{data:#}\n"));
    } else {
        output::print(&text(&results, &broken));
    }
    Ok(Outcome::of(ok))
}

/// Returns the reason why there was no scenario to run.
fn nothing(a: &Arguments, tested: &[scenario_runner::Tested]) -> String {
    let Some(name) = &a.scenario else {
        return "the given files declare no scenario: write `scenario NAME { expect .. }`".to_string();
    };
    let all = |t: &'_ scenario_runner::Tested| -> Vec<String> {
        scenario_runner::scenarios(t.program.as_ref(), &t.missions).map(|s| s.name().to_string()).collect()
    };
    let names: Vec<String> = tested.iter().flat_map(all).collect();
    let names = || names.iter().map(String::as_str);
    match hierarq::compiler::names::suggest(name, names()) {
        Some(near) => format!("no scenario is called `{name}`: did you mean `{near}`?"),
        None => format!("no scenario is called `{name}`"),
    }
}

/// Returns the failures of a run other than its expectations; empty without any.
fn trouble(t: &ScenarioResult) -> String {
    if let Some(mission) = &t.mission {
        let all: Vec<&str> = mission.trouble.iter().map(|(_, text)| text.as_str()).collect();
        return all.join("; ");
    }
    if let Some(why) = &t.diverged {
        return format!("ended early: {why}");
    }
    match t.faults.iter().find(|f| !f.answered) {
        Some(fault) if t.halted => format!("halted at {:.2} s: {}", fault.time, fault.text),
        Some(fault) => format!("stopped at {:.2} s, with a transition to the state itself: {}", fault.time, fault.text),
        None if !t.passed.is_empty() => format!("violated limits: {}", t.passed.join(", ")),
        None => String::new(),
    }
}

/// Returns the table of all scenarios.
fn text(results: &[ScenarioResult], broken: &[&str]) -> String {
    let mut rows = table::wide_table(&["spec", "scenario", "expectation", "verdict", "margin", "at"]);
    let mut last = "";
    for t in results {
        let mut head = [if t.spec == last { String::new() } else { t.spec.clone() }, t.scenario.clone()];
        last = &t.spec;
        let mut add = |cells: [String; 4]| {
            let [spec, scenario] = std::mem::take(&mut head);
            let [what, verdict, margin, at] = cells;
            rows.add_row([spec, scenario, what, verdict, margin, at]);
        };
        for e in &t.expectations {
            let [verdict, margin, at] = table::expectation(e);
            add([table::expected(e), verdict, margin, at]);
        }
        let trouble = trouble(t);
        let verdict = if t.ok { "holds" } else { "FAILS" };
        if t.expectations.is_empty() {
            let what = match &t.mission {
                Some(_) => "no expectations; checked: the mission is done",
                None => "no expectations; checked: faults and margins",
            };
            let what = if trouble.is_empty() { what.to_string() } else { format!("{what}: {trouble}") };
            add([what, verdict.to_string(), String::new(), String::new()]);
        } else if !trouble.is_empty() {
            let time = t.mission.as_ref().and_then(|m| m.trouble.iter().find_map(|(at, _)| *at));
            let time = t.faults.last().map(|f| f.time).or(time);
            let at = time.map_or_else(String::new, |t| format!("{t:.2} s"));
            let bad = !t.ok && t.expectations.iter().all(|e| e.verdict == Verdict::Holds);
            add([trouble, if bad { "FAILS" } else { "" }.to_string(), String::new(), at]);
        }
    }
    let count = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    let failed = results.iter().filter(|t| !t.ok).count();
    let mut out = format!("{rows}\n");
    let simulated: f64 = results.iter().map(|t| t.duration_s).sum();
    let verdict = if failed == 0 { "all as expected".to_string() } else { format!("{failed} FAILED") };
    if results.is_empty() {
        out.clear();
    } else {
        let _ = writeln!(out, "{}, {simulated:.0} s simulated: {verdict}", count(results.len(), "scenario"));
    }
    for (t, plant) in results.iter().filter_map(|t| Some((t, t.plant.as_ref()?))) {
        let _ = writeln!(out, "{}, {}: {}", t.spec, t.scenario, plant.describe());
    }
    for (t, rough) in results.iter().filter_map(|t| Some((t, roughness::sentence(&t.rough)?))) {
        let _ = writeln!(out, "warning: {}, {}: {rough}", t.spec, t.scenario);
    }
    for spec in broken {
        let _ = writeln!(out, "{spec}: not run, because it does not compile");
    }
    out
}

/// Returns the results in JUnit's format: a suite for each scenario, a case for each expectation.
fn junit(results: &[ScenarioResult], broken: &[&str]) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n");
    for t in results {
        let mut cases: Vec<(String, Option<String>)> = Vec::new();
        for e in &t.expectations {
            let [verdict, margin, at] = table::expectation(e);
            let wrong =
                (e.verdict != Verdict::Holds).then(|| format!("{verdict}, margin {margin}, at {at}: {}", e.text));
            cases.push((e.title().to_string(), wrong));
        }
        let trouble = trouble(t);
        let bad = !t.ok && t.expectations.iter().all(|e| e.verdict == Verdict::Holds);
        let whole = if t.mission.is_some() { "the mission has no trouble" } else { "faults are handled" };
        cases.push((whole.to_string(), bad.then_some(trouble)));
        let failures = cases.iter().filter(|c| c.1.is_some()).count();
        let name = escaped(&format!("{}: {}", t.spec, t.scenario));
        let _ = writeln!(out, "  <testsuite name=\"{name}\" tests=\"{}\" failures=\"{failures}\">", cases.len());
        for (case, wrong) in cases {
            let head = format!("    <testcase classname=\"{name}\" name=\"{}\"", escaped(&case));
            let _ = match wrong {
                None => writeln!(out, "{head}/>"),
                Some(why) => writeln!(out, "{head}><failure message=\"{}\"/></testcase>", escaped(&why)),
            };
        }
        out.push_str("  </testsuite>\n");
    }
    for spec in broken {
        let name = escaped(spec);
        let _ = writeln!(
            out,
            "  <testsuite name=\"{name}\" tests=\"1\" errors=\"1\">\n    <testcase classname=\"{name}\" \
             name=\"compiles\"><error message=\"it does not compile\"/></testcase>\n  </testsuite>"
        );
    }
    out.push_str("</testsuites>\n");
    out
}

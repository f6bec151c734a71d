//! Experiment 6.A with its baselines (thesis 6.4.4, Tables 6.3 to 6.8), with a recorded stand-in for the model.
//!
//! The stand-in reads only the prompt, which shows that the prompt is sufficient: a plan computed from its words is
//! accepted. It produces the recordings (`HIERARQ_UPDATE_DOCS=1 cargo test --test it baselines`), and `hierarq context
//! --trials` produces the tables of the book from the recordings.

use crate::common::cli;
use crate::common::reckoner;

use std::path::{Path, PathBuf};

use cli::{hierarq, text};
use context::generate::{Bounds, GenerateError, Question, Wish, generate, prompt};
use context::transcript::{self, Exchange};
use mission::kind::generation::{Decides, Generation};
use mission::kinds::layers::Layers;
use mission::kinds::layers::cost::cost;
use mission::kinds::layers::generation::prompt::VERSION;
use mission::kinds::layers::json::{Imported, Mode, import};
use mission::kinds::layers::steps::from_plan;
use mission::kinds::layers::validate::validate;
use reckoner::Reckoner;
use serde_json::Value;

const MISSIONS: [&str; 3] = ["letter_h", "letter_d", "sorting"];
const TRIALS: u64 = 10;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn program(mission: &str) -> Layers {
    let compiled = hierarq::project::load(&root().join("examples/letters.hq"), &Default::default());
    let found = compiled.missions.iter().find(|m| m.name == mission).expect("a mission");
    found.kind.downcast::<Layers>().expect("layers").clone()
}

fn stand_in(mission: &str, noise: u64, forgets: bool) -> Reckoner {
    let text = std::fs::read_to_string(root().join(format!("examples/layers/{mission}.json"))).expect("layers");
    Reckoner { layers: serde_json::from_str(&text).expect("JSON"), noise, forgets }
}

const MODES: [(Decides, Mode); 3] =
    [(Decides::Tasks, Mode::Context), (Decides::Allocation, Mode::Allocated), (Decides::Everything, Mode::Scheduled)];

fn wish(program: &Layers, decides: Decides) -> Wish<'_> {
    Wish { mission: program, instruction: program.instruction().expect("an instruction"), decides }
}

/// Asks once for the layers.
fn layers(
    chat: &mut Reckoner,
    program: &Layers,
    (decides, mode): (Decides, Mode),
    keep: impl FnMut(&Exchange) -> std::io::Result<()>,
) -> Result<Imported, GenerateError> {
    let once = Bounds { attempts: 1, ..Bounds::default() };
    let question = Question { prompt: &prompt(&wish(program, decides)), keys: program.answer_keys() };
    let judge = |text: &str| {
        import(text, &program.problem, mode).map_err(|faults| faults.iter().map(ToString::to_string).collect())
    };
    generate(chat, &question, &once, judge, keep)
}

/// A model that computes correctly from the prompt is accepted, with any choice of agents and objects.
#[test]
fn a_plan_reckoned_from_the_prompt_is_taken() {
    for mission in MISSIONS {
        let program = program(mission);
        for noise in 0..20 {
            let taken = layers(&mut stand_in(mission, noise, false), &program, MODES[2], |_| Ok(()));
            let imported = taken.unwrap_or_else(|why| panic!("{mission}, {noise}: {why:?}"));
            let plan = imported.plan.expect("a plan");
            assert!(validate(&imported.problem, &plan).is_empty());
            assert!((cost(&imported.problem, &from_plan(&plan)).total() - plan.cost).abs() < 1e-12);
        }
    }
}

/// The prompt is relevant: without the return to the base the times are too short.
#[test]
fn a_plan_without_the_way_back_is_refused() {
    let program = program("letter_h");
    let refused = layers(&mut stand_in("letter_h", 1, true), &program, MODES[2], |_| Ok(()));
    let Err(GenerateError::Refused { reasons, .. }) = refused else { panic!("{refused:?}") };
    assert!(reasons.iter().any(|reason| reason.contains("s at least")), "{reasons:?}");
}

/// The prompts of the baselines contain the additions of thesis 6.4.4; the prompt of the layers alone contains none of
/// them.
#[test]
fn prompts_say_what_is_minimised_and_what_is_reckoned() {
    let program = program("letter_h");
    let told =
        |decides| prompt(&wish(&program, decides)).iter().map(|m| m.content.clone()).collect::<Vec<_>>().join("\n");
    let (alone, allocation, everything) = (told(Decides::Tasks), told(Decides::Allocation), told(Decides::Everything));
    let shared = [
        "\"slowing\": 3.0",
        "\"pace\"",
        "\"standby\": 4.0",
        "the way back",
        "4 * workload + 1 * energy + 10 * makespan",
    ];
    for words in shared {
        assert!(!alone.contains(words) && allocation.contains(words) && everything.contains(words), "{words}");
    }
    for words in
        ["workload, robot energy use and total makespan are all minimised", "simultaneously", "at most one task"]
    {
        assert!(!alone.contains(words) && allocation.contains(words), "{words}");
    }
    for words in ["minimising the makespan", "before all tasks of all layers before it have ended", "round `end` up"] {
        assert!(!alone.contains(words) && !allocation.contains(words) && everything.contains(words), "{words}");
    }
    let version = format!("\"prompt\": {}", VERSION);
    assert!([&alone, &allocation, &everything].iter().all(|told| told.contains(&version)));
}

fn recording(mission: &str) -> PathBuf {
    root().join(format!("examples/layers/transcripts/stand_in_{mission}.jsonl"))
}

/// Recorded answers of the stand-in in all trials of all cases. If it decides everything, it forgets the return to the
/// base in four of ten trials.
fn recorded(mission: &str) -> String {
    let program = program(mission);
    let mut out = Vec::new();
    for (case, mode) in MODES.into_iter().enumerate() {
        for trial in 0..TRIALS {
            let forgets = mode.1 == Mode::Scheduled && trial % 5 < 2;
            let mut chat = stand_in(mission, 1000 * case as u64 + trial, forgets);
            let taken = layers(&mut chat, &program, mode, |exchange| {
                // The prompts are omitted, since `--prompt` prints them; times are set to zero.
                let kept = Exchange { asked: Vec::new(), seconds: 0.0, ..exchange.clone() };
                transcript::write(&mut out, &kept)
            });
            assert_eq!(taken.is_err(), forgets, "{mission} {mode:?} {trial}: {taken:?}");
        }
    }
    String::from_utf8(out).expect("UTF-8")
}

fn fresh(path: &Path, text: &str) {
    if std::env::var_os("HIERARQ_UPDATE_DOCS").is_some() {
        std::fs::write(path, text).expect("writable");
    }
    let there = std::fs::read_to_string(path).unwrap_or_default();
    assert!(there == text, "{} is not fresh: HIERARQ_UPDATE_DOCS=1 cargo test --test it baselines", path.display());
}

/// The table of the cases, without the times, which differ between runs.
fn table(mission: &str) -> String {
    let (count, file) = (TRIALS.to_string(), recording(mission));
    let decides = "layers,allocation,everything";
    let args =
        ["context", "examples/letters.hq", mission, "--replay", file.to_str().expect("UTF-8"), "--trials", &count];
    let out = hierarq(&[&args[..], &["--decides", decides]].concat());
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    text(&out.stdout)
}

fn cells(table: &str, case: &str) -> Vec<String> {
    let row = table.lines().find(|line| line.starts_with(case)).unwrap_or_else(|| panic!("{case} in {table}"));
    row.replace(" ± ", "±").split_whitespace().map(str::to_string).collect()
}

/// The recordings and the book are up to date; the plan of the layers alone costs least, and every trial with wrong
/// times has no valid plan.
#[test]
fn the_tables_of_letters_and_sorting() {
    let mut book = String::new();
    for mission in MISSIONS {
        fresh(&recording(mission), &recorded(mission));
        let table = table(mission);
        let [alone, allocation, everything] = ["layers", "allocation", "everything"].map(|case| cells(&table, case));
        assert_eq!([&alone[2], &allocation[2], &everything[2]], ["100", "100", "60"], "{table}");
        let mean = |cells: &[String]| cells[7].split('±').next().expect("a mean").parse::<f64>().expect("a number");
        assert!(mean(&alone) < mean(&allocation) && mean(&alone) < mean(&everything), "{table}");
        let least = |cells: &[String]| cells[5].parse::<f64>().expect("a number");
        assert!(least(&allocation) > 0.0 && least(&everything) > 0.0, "{table}");
        for cells in [alone, allocation, everything] {
            let (shown, rest) = (&cells[..3], &cells[5..]);
            let row: Vec<&str> = [mission].into_iter().chain(shown.iter().chain(rest).map(String::as_str)).collect();
            book += &format!("| {} |\n", row.join(" | ").replace('±', " ± "));
        }
    }
    let page = root().join("docs/src/experiments/letters.md");
    let text = std::fs::read_to_string(&page).expect("a page");
    let (before, rest) = text.split_once("<!-- stand-in -->\n").expect("a mark");
    let (_, after) = rest.split_once("<!-- end -->").expect("a mark");
    let head = "| mission | decides | trials | f % | ε_m | ε_M | J | μ | ω | e |\n|---|---|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    fresh(&page, &format!("{before}<!-- stand-in -->\n{head}{book}<!-- end -->{after}"));
}

/// The plan of a model that decided everything is printed with its cost, as text and as data that satisfies the schema.
#[test]
fn a_given_plan_has_a_cost() {
    let file = recording("letter_h");
    let all = std::fs::read_to_string(&file).expect("recorded");
    // The first conversation with a correct complete plan.
    let line = all.lines().nth(2 * TRIALS as usize + 2).expect("an exchange");
    let one = Path::new(env!("CARGO_TARGET_TMPDIR")).join("given.jsonl");
    std::fs::write(&one, line).expect("writable");
    let args = [
        "context",
        "examples/letters.hq",
        "letter_h",
        "--replay",
        one.to_str().expect("UTF-8"),
        "--decides",
        "everything",
    ];
    let out = hierarq(&[&args[..], &["--json"]].concat());
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{said}");
    let plan: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    let schema = mission::kinds::plan_schema();
    let judge = jsonschema::draft202012::new(&schema).expect("a schema");
    assert!(judge.is_valid(&plan), "{plan}");
    assert_eq!(plan["formulation"], "given");
    let total = plan["cost"]["total"].as_f64().expect("a number");
    assert!(said.contains(&format!("cost {total:.4}, from workload")), "{said}");
    let optimum = hierarq(&["plan", "examples/letters.hq", "letter_h", "--json"]);
    let optimum: Value = serde_json::from_slice(&optimum.stdout).expect("JSON");
    assert!(optimum["cost"]["total"].as_f64().expect("a number") < total);
}

#[test]
fn trials_that_make_no_sense_are_refused() {
    let file = recording("letter_h");
    let args = ["context", "examples/letters.hq", "letter_h", "--replay", file.to_str().expect("UTF-8")];
    for (more, code, words) in [
        (&["--decides", "layers,everything"][..], 2, "--trials"),
        (&["--decides", "layers,layers", "--trials", "2"][..], 2, "twice"),
        (&["--trials", "2", "--out", "x.json"][..], 2, "cannot be used with"),
        (&["--trials", "0"][..], 2, "--trials"),
        (&["--json"][..], 2, "--decides everything"),
        // The recording has thirty conversations.
        (&["--trials", "40", "--attempts", "2"][..], 1, "trials of `layers` are done"),
    ] {
        let out = hierarq(&[&args[..], more].concat());
        assert_eq!(out.status.code(), Some(code), "{more:?}: {}", text(&out.stderr));
        assert!(text(&out.stderr).contains(words), "{more:?}: {}", text(&out.stderr));
    }
}

//! The specs of `examples/coming`, which say in this language what the examples of other frameworks say in theirs: both
//! syntaxes are one program, nothing is warned of, every expectation holds, and the book shows them as they are.

use crate::common;

use common::{example, judged, program};
use dsl::Syntax;
use hierarq::project::{Settings, compile};
use runtime::expect::Verdict;
use runtime::record::All;

/// Specs in `examples/coming`; each exists in both syntaxes.
const EXAMPLES: &[&str] = &[
    "mc_rtc_com",
    "mc_rtc_fsm",
    "opensot_arm",
    "pink_arm_ur5",
    "pink_barriers_ur5",
    "pink_dual_ur3",
    "pink_humanoid_com",
    "servo_twist",
    "shelf",
    "tsid_ur5",
];

#[test]
fn no_spec_of_another_framework_is_forgotten() {
    let mut stems: Vec<String> = std::fs::read_dir(example("coming"))
        .expect("the folder is there")
        .filter_map(|e| {
            let path = e.expect("readable").path();
            Syntax::of_path(&path)?;
            Some(path.file_stem()?.to_str()?.to_string())
        })
        .collect();
    stems.sort();
    let expected: Vec<String> = EXAMPLES.iter().flat_map(|n| [n.to_string(), n.to_string()]).collect();
    assert_eq!(stems, expected);
}

#[test]
fn specs_of_other_frameworks_are_formatted_and_the_same_in_both_syntaxes() {
    for name in EXAMPLES {
        let [hq, yaml] = [("hq", Syntax::Native), ("yaml", Syntax::Yaml)].map(|(ending, syntax)| {
            let file = format!("coming/{name}.{ending}");
            let text = std::fs::read_to_string(example(&file)).expect("readable");
            let (tree, diagnostics) = dsl::parse(dsl::SourceId(0), &text, syntax);
            assert!(diagnostics.is_empty(), "{file}: {diagnostics:?}");
            assert_eq!(dsl::print(&tree, syntax), text, "{file} is formatted");
            let compiled = compile(&example(&file), &Settings::default());
            let report = compiled.report.render(compiler::Style::Plain, 100);
            assert!(compiled.report.diagnostics.is_empty(), "{report}");
            compiled.program.unwrap_or_else(|| panic!("{report}"))
        });
        assert!(hq == yaml, "{name} differs between the syntaxes");
    }
}

#[test]
fn what_specs_of_other_frameworks_expect_holds() {
    for name in EXAMPLES {
        let program = program(&format!("coming/{name}.hq"));
        assert!(!program.scenarios.is_empty(), "{name}");
        for scenario in &program.scenarios {
            let (_, outcomes) = judged(&program, scenario, &mut All(Vec::new()));
            assert!(outcomes.len() >= 3, "{name}");
            let titles = scenario.expectations.iter().map(|e| e.title());
            for (outcome, title) in outcomes.iter().zip(titles) {
                assert_eq!(outcome.verdict, Verdict::Holds, "{name}: {title}: {outcome:?}");
            }
        }
    }
}

/// Every line of the pieces of specs in the pages stands in one of the examples, but for `..`, which stands for more.
#[test]
fn the_book_shows_them_as_they_are() {
    let specs: Vec<String> = EXAMPLES
        .iter()
        .map(|name| std::fs::read_to_string(example(&format!("coming/{name}.hq"))).expect("readable"))
        .collect();
    let folder = example("../docs/src/coming");
    let mut pieces = 0;
    for page in std::fs::read_dir(folder).expect("the pages are there") {
        let page = page.expect("readable").path();
        let text = std::fs::read_to_string(&page).expect("readable");
        for piece in text.split("```hq\n").skip(1).map(|rest| rest.split("```").next().unwrap_or_default()) {
            pieces += 1;
            let lines = || piece.lines().map(str::trim_end).filter(|l| !l.is_empty() && l.trim() != "..");
            let shown = |spec: &&String| lines().all(|line| spec.lines().any(|l| l == line));
            assert!(specs.iter().any(|spec| shown(&spec)), "{}:\n{piece}", page.display());
        }
    }
    assert!(pieces >= 2, "only {pieces} pieces");
}

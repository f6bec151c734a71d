//! Pages of `hierarq explain`: their wrong examples give the code of the page and no other, their correct examples
//! compile without diagnostics.

use crate::common;

use common::{POSTURES, annotated, compile_text, compile_text_deep, examples, whole};
use dsl::codes::{Page, Part};
use dsl::{Severity, Syntax};
use hierarq_compiler::{Compiled, codes};
use std::path::Path;

/// Codes without a wrong example: it would be too long for a page, or is not a text.
const NOT_SHOWN: &[&str] = &[
    "HQ0190", "HQ0192", "HQ0193", "HQ0194", "HQ0195", "HQ0212", "HQ0218", "HQ0406", "HQ0585", "HQ0592", "HQ0607",
    "HQ0623", "HQ0934", "HQ0951",
];

/// Compiles an example, completed by the parts that it omits.
fn compiled(page: &Page, part: &Part) -> Compiled {
    let Part::Example { language, bad, alone, text } = *part else { panic!("no example") };
    let syntax = if language == "yaml" { Syntax::Yaml } else { Syntax::Native };
    if language == "xml" {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}_{bad}", page.code));
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("robot.urdf"), text).expect("a file");
        let spec = whole("robot r { urdf \"robot.urdf\"  rate 100 Hz }\ntask still = hold(hand)\n", syntax, true, true);
        return compile_text(&spec, syntax, &folder, &[]);
    }
    if language == "srdf" {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}_{bad}", page.code));
        std::fs::create_dir_all(folder.join("robots")).expect("a folder");
        std::fs::copy(examples().join("robots/arm7.urdf"), folder.join("robots/arm7.urdf")).expect("a file");
        std::fs::write(folder.join("arm.srdf"), text).expect("a file");
        let robot = "robot r { urdf \"robots/arm7.urdf\"  srdf \"arm.srdf\"  rate 100 Hz  home { joint_4 1 rad } }";
        let spec = whole(&format!("{robot}\ntask still = hold(tool)\n"), syntax, true, true);
        return compile_text(&spec, syntax, &folder, &[]);
    }
    let text = if alone { text.to_string() } else { whole(text, syntax, true, true) };
    if codes::is_deep(page.code) {
        return compile_text_deep(&text, syntax, &examples(), POSTURES, 0);
    }
    compile_text(&text, syntax, &examples(), &[])
}

#[test]
fn every_page_shows_the_mistake_and_how_to_mend_it() {
    let mut wrong = Vec::new();
    for page in codes::all() {
        let examples: Vec<Part> = page.parts().into_iter().filter(|p| matches!(p, Part::Example { .. })).collect();
        let is_bad = |p: &&Part| matches!(p, Part::Example { bad: true, .. });
        let shows = examples.iter().any(|p| is_bad(&p));
        if shows == NOT_SHOWN.contains(&page.code) || examples.iter().all(|p| is_bad(&p)) {
            wrong.push(format!("{} lacks an example", page.code));
        }
        for part in &examples {
            let compiled = compiled(page, part);
            let found: Vec<&str> = compiled.report.diagnostics.iter().map(|d| d.code).collect();
            let warns = compiled.report.diagnostics.iter().find(|d| d.severity == Severity::Warning);
            if let Some(d) = warns.filter(|d| codes::explain(d.code).is_some_and(|page| !page.warning)) {
                wrong.push(format!("{} is a warning, and its heading does not say so", d.code));
            }
            let as_it_says = if is_bad(&part) {
                !found.is_empty() && found.iter().all(|c| *c == page.code)
            } else {
                found.is_empty()
            };
            if !as_it_says {
                let kind = if is_bad(&part) { "wrong" } else { "right" };
                wrong.push(format!("{} {kind} example gives {found:?}\n{}", page.code, annotated(&compiled)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn pages_are_short_and_in_order() {
    let pages: Vec<&Page> = codes::all().collect();
    assert!(pages.windows(2).all(|w| w[0].code < w[1].code));
    for page in pages {
        assert!(!page.title.is_empty() && page.text.lines().count() < 60, "{}", page.code);
        assert!(matches!(page.parts().first(), Some(Part::Text(_))), "{} begins without a word", page.code);
        for part in page.parts() {
            if let Part::Example { text, .. } = part {
                assert!(text.lines().all(|l| l.chars().count() <= 150), "{}", page.code);
            }
        }
    }
}

//! The figures of the corpus in the book: shares by class, false alarms, and what stays silent.

use std::path::Path;

use super::judge::{Outcome, Verdict};

const PAGE: &str = "../docs/src/internals/meaning.md";
const BEGIN: &str = "<!-- figures: written by compiler/tests/meaning.rs -->\n";
const END: &str = "<!-- end of figures -->";

/// Returns one row of the table.
fn row(name: &str, outcomes: &[&Outcome]) -> String {
    let count = |verdict: Verdict| outcomes.iter().filter(|o| o.verdict == verdict).count();
    let [exact, elsewhere, silent] = [Verdict::Exact, Verdict::Elsewhere, Verdict::Silent].map(count);
    let [quiet, alarms] = [Verdict::Quiet, Verdict::FalseAlarm].map(count);
    let (bad, good) = (exact + elsewhere + silent, quiet + alarms);
    let provable = |o: &&&Outcome| o.verdict == Verdict::Silent && o.provable.starts_with("yes");
    let unproven = outcomes.iter().filter(provable).count();
    format!("| {name} | {bad} | {exact} | {elsewhere} | {silent} | {unproven} | {good} | {alarms} |\n")
}

/// Returns the text between the two marks in the book.
pub fn figures(classes: &[(&str, Vec<Outcome>)]) -> String {
    let mut out = String::from(
        "| class | mistakes | exact | elsewhere | silent | of these provable | good specs | false alarms |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for (title, outcomes) in classes {
        out.push_str(&row(title, &outcomes.iter().collect::<Vec<_>>()));
    }
    out.push_str(&row("**all**", &classes.iter().flat_map(|c| &c.1).collect::<Vec<_>>()));
    out.push_str("\n## Silent\n");
    for (title, outcomes) in classes {
        let silent: Vec<_> = outcomes.iter().filter(|o| o.verdict == Verdict::Silent).collect();
        if !silent.is_empty() {
            out.push_str(&format!("\n### Silent: {title}\n\n| spec | mistake | provable |\n|---|---|---|\n"));
        }
        for o in silent {
            out.push_str(&format!("| `{}` | {} | {} |\n", o.name, cell(&o.mistake), cell(&o.provable)));
        }
    }
    for (title, verdict) in [("Elsewhere", Verdict::Elsewhere), ("False alarms", Verdict::FalseAlarm)] {
        out.push_str(&format!("\n## {title}\n\n| spec | | reported |\n|---|---|---|\n"));
        for o in classes.iter().flat_map(|c| &c.1).filter(|o| o.verdict == verdict) {
            let said =
                o.found.iter().filter(|f| !f.aside).map(|f| format!("{} at `{}`", f.code, f.text.replace('`', "")));
            let said = said.collect::<Vec<_>>().join(", ");
            out.push_str(&format!("| `{}` | {} | {} |\n", o.name, cell(&o.mistake), cell(&said)));
        }
    }
    out
}

fn cell(text: &str) -> String {
    text.replace('|', "/")
}

/// Compares the figures with those of the book; `HIERARQ_UPDATE_DOCS=1` writes them instead.
pub fn published(figures: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let page = std::fs::read_to_string(&path).expect("the page exists");
    let parts = page.split_once(BEGIN).and_then(|(head, rest)| Some((head, rest.split_once(END)?)));
    let (head, (is, tail)) = parts.expect("the page has the marks of the figures");
    if std::env::var_os("HIERARQ_UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{head}{BEGIN}{figures}{END}{tail}")).expect("writable");
    } else {
        assert!(is == figures, "{PAGE} is stale: run `HIERARQ_UPDATE_DOCS=1 cargo test -p hierarq-compiler meaning`");
    }
}

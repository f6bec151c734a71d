//! Reads the specs of a class.
//!
//! A spec begins with `==== NAME`, or `==== good: NAME` if it is right. Lines `KEY: TEXT` follow, then an empty line, then the
//! spec:
//!
//! - `source`: where the mistake comes from: a thread, a publication, or `practice` for what is common among engineers;
//! - `mistake`: the mistake in one sentence; `right` instead, of a good spec, says why there is none;
//! - `provable`: `yes`, `partly` or `no`, and why: whether it follows from the spec, the URDF and the start;
//! - `aside`: codes of diagnostics about something else, which do not count as an answer.
//!
//! `«` and `»` surround what an answer points at; a spec may have several such places. They are removed. The header is added,
//! and the arm of the first examples, if there is no robot, import or mission.

use std::collections::BTreeSet;

/// The robot of specs that have none.
const ARM: &str =
    "robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }\n";

/// A spec, and what is known of it.
pub struct Sample {
    /// Name, unique in the corpus.
    pub name: String,
    /// True if the spec is right.
    pub good: bool,
    /// The mistake, or the reason why there is none.
    pub mistake: String,
    /// Source of the mistake.
    pub source: String,
    /// Judgement if a compiler could prove it, with the reason.
    pub provable: String,
    /// Codes of diagnostics that are about something else.
    pub aside: Vec<String>,
    /// The whole spec.
    pub text: String,
    /// Lines that an answer points at, from 1.
    pub lines: BTreeSet<usize>,
}

/// Reads all specs of a class; `//` before the first begins a comment.
pub fn samples(class: &str, text: &str) -> Vec<Sample> {
    let parts = text.split("\n==== ").enumerate();
    let parts = parts.filter_map(|(i, p)| if i == 0 { p.strip_prefix("==== ") } else { Some(p) });
    parts.map(|part| sample(class, part)).collect()
}

fn sample(class: &str, part: &str) -> Sample {
    let (head, body) = part.split_once("\n\n").unwrap_or_else(|| panic!("{class}: no spec in {part}"));
    let (title, keys) = head.split_once('\n').unwrap_or((head, ""));
    let key = |name: &str| {
        let lines = keys.lines().filter_map(|l| l.split_once(':'));
        lines.filter(|(k, _)| k.trim() == name).map(|(_, v)| v.trim().to_string()).collect::<Vec<_>>().join(" ")
    };
    let (good, name) = title.strip_prefix("good: ").map_or((false, title), |n| (true, n));
    let (text, lines) = unmarked(&whole(body));
    assert!(good == lines.is_empty(), "{class}: {name}: a mistake has a place, a good spec has none");
    let aside = key("aside");
    Sample {
        name: name.trim().to_string(),
        good,
        mistake: key(if good { "right" } else { "mistake" }),
        source: key("source"),
        provable: key("provable"),
        aside: aside.split_whitespace().filter(|c| c.starts_with("HQ")).map(str::to_string).collect(),
        text,
        lines,
    }
}

/// Adds what every spec has.
fn whole(body: &str) -> String {
    let begins = |word: &str| body.lines().any(|l| l.trim_start_matches('«').starts_with(word));
    let robot = if ["robot ", "import ", "mission "].into_iter().any(begins) { "" } else { ARM };
    format!("hierarq 1\n\n{}{}\n", if robot.is_empty() { String::new() } else { format!("{robot}\n") }, body.trim_end())
}

/// Removes the marks, and returns the lines that have some.
fn unmarked(text: &str) -> (String, BTreeSet<usize>) {
    let (mut out, mut lines, mut inside) = (String::new(), BTreeSet::new(), false);
    for (i, line) in text.lines().enumerate() {
        if inside || line.contains('«') {
            lines.insert(i + 1);
        }
        for c in line.chars() {
            match c {
                '«' => inside = true,
                '»' => inside = false,
                c => out.push(c),
            }
        }
        out.push('\n');
    }
    (out, lines)
}

//! Robustness that rtamt computed for random formulas (`tests/data/oracle_rtamt.json`).

use hierarq_runtime::expect::{Formula, Monitor, Node, Unit, offline};
use serde::Deserialize;

#[derive(Deserialize)]
struct Oracle {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    text: String,
    nodes: Vec<Node>,
    log: Vec<Vec<f64>>,
    robustness: Number,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Number {
    Finite(f64),
    /// `inf` or `-inf`.
    Infinite(String),
}

#[test]
fn robustness_is_that_of_rtamt() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/oracle_rtamt.json");
    let oracle: Oracle = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let units = [Unit::Truth; 3];
    let mut exact = 0;
    for case in &oracle.cases {
        let formula = Formula { nodes: case.nodes.clone(), period: 1.0 };
        let rtamt = match &case.robustness {
            Number::Finite(x) => *x,
            Number::Infinite(text) => text.parse().unwrap(),
        };
        let offline = offline::evaluate(&formula, &units, &case.log).unwrap();
        assert!((offline.lower..=offline.upper).contains(&rtamt), "{}: {offline:?}, rtamt {rtamt}", case.text);
        exact += usize::from(offline.lower == offline.upper);

        let ticks = case.log[0].len();
        let mut monitor = Monitor::new(&formula, &units, ticks as u32).unwrap();
        for t in 0..ticks {
            monitor.push(&[case.log[0][t], case.log[1][t], case.log[2][t]]).unwrap();
        }
        assert_eq!(monitor.finish(), offline, "{}", case.text);
    }
    // The numbers are equal if the end cuts nothing off.
    assert!(oracle.cases.len() == 160 && exact >= 100, "{exact} exact of {}", oracle.cases.len());
    println!("{exact} of {} formulas are exact", oracle.cases.len());
}

//! Tables that must agree: unit symbols of grammar and vocabulary, codes of readers and explanations.

use hierarq_dsl::codes::PAGES;
use hierarq_dsl::tree::{ItemKind, ValueKind};
use hierarq_dsl::vocabulary::{ROLES, UNITS};
use hierarq_dsl::{SourceId, Syntax, parse};
use std::collections::BTreeSet;

#[test]
fn the_grammar_knows_the_units_of_the_vocabulary_and_no_others() {
    let grammar = include_str!("../src/grammar.pest");
    let rule = grammar.split_once("unit_symbol = @{").and_then(|g| g.1.split_once('}')).unwrap().0;
    let symbols: BTreeSet<&str> = rule.split('"').skip(1).step_by(2).collect();
    assert_eq!(symbols, UNITS.iter().copied().collect());
    for unit in UNITS {
        let (spec, diags) = parse(SourceId(0), &format!("hierarq 1\nparam a = 1 {unit}"), Syntax::Native);
        assert!(diags.is_empty());
        let ItemKind::Param(param) = &spec.items[0].kind else { panic!("no param") };
        let ValueKind::Unit(_, read) = &param.value.kind else { panic!("no unit") };
        assert_eq!(read.factors, [(unit.to_string(), 1)]);
    }
}

#[test]
fn codes_rise_and_every_reported_one_is_explained() {
    assert!(PAGES.windows(2).all(|w| w[0].code < w[1].code));
    let sources = [
        include_str!("../src/actions.rs"),
        include_str!("../src/calls.rs"),
        include_str!("../src/checks.rs"),
        include_str!("../src/explain.rs"),
        include_str!("../src/expr/mod.rs"),
        include_str!("../src/expr/literals.rs"),
        include_str!("../src/expr/operators.rs"),
        include_str!("../src/formulas.rs"),
        include_str!("../src/limits.rs"),
        include_str!("../src/missions.rs"),
        include_str!("../src/transitions.rs"),
        include_str!("../src/hq/blocks.rs"),
        include_str!("../src/hq/items.rs"),
        include_str!("../src/hq/levels.rs"),
        include_str!("../src/hq/machines.rs"),
        include_str!("../src/hq/missions.rs"),
        include_str!("../src/hq/parts.rs"),
        include_str!("../src/hq/reuse.rs"),
        include_str!("../src/hq/scenarios.rs"),
        include_str!("../src/hq/states.rs"),
        include_str!("../src/yaml/mod.rs"),
        include_str!("../src/yaml/repeat.rs"),
        include_str!("../src/yaml/reuse.rs"),
        include_str!("../src/yaml/events.rs"),
        include_str!("../src/yaml/items.rs"),
        include_str!("../src/yaml/levels.rs"),
        include_str!("../src/yaml/machines.rs"),
        include_str!("../src/yaml/missions.rs"),
        include_str!("../src/yaml/scenarios.rs"),
        include_str!("../src/yaml/signals.rs"),
        include_str!("../src/yaml/quotes.rs"),
        include_str!("../src/yaml/scalars.rs"),
        include_str!("../src/yaml/syntax.rs"),
        include_str!("../src/yaml/transitions.rs"),
    ]
    .concat();
    let used: BTreeSet<&str> = sources.split("\"HQ").skip(1).map(|s| &s[..4]).collect();
    let table: BTreeSet<&str> = PAGES.iter().map(|p| &p.code[2..]).collect();
    assert_eq!(used, table);
}

#[test]
fn the_grammar_knows_the_roles_of_the_vocabulary_and_no_others() {
    let grammar = include_str!("../src/missions.pest");
    let rule = grammar.split_once("role_word    = _{").and_then(|g| g.1.split_once('}')).unwrap().0;
    let words: Vec<&str> = rule.split('"').skip(1).step_by(2).collect();
    assert_eq!(words, ROLES);
}

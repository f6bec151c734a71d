//! One tree for both syntaxes, and printers that give back what was read.

use crate::common;

use common::trees;
use common::{HQ, YAML, good};
use hierarq_dsl::{Syntax, print};
use proptest::prelude::*;

#[test]
fn the_syntaxes_of_the_example_are_equal() {
    assert_eq!(good(HQ, Syntax::Native), good(YAML, Syntax::Yaml));
}

#[test]
fn the_formatted_example_stays_as_it_is() {
    assert_eq!(print(&good(HQ, Syntax::Native), Syntax::Native), HQ);
}

#[test]
fn converted_texts_keep_tree_and_comments() {
    for (text, from, to) in [(HQ, Syntax::Native, Syntax::Yaml), (YAML, Syntax::Yaml, Syntax::Native)] {
        let spec = good(text, from);
        let there = print(&spec, to);
        let over = good(&there, to);
        assert_eq!(over, spec, "{there}");
        assert_eq!(print(&over, to), there);
        for comment in [
            "pick of the",
            "the language",
            "overridden",
            "The arms",
            "Nothing more",
            "measured",
            "Below",
            "The two",
            "The end",
        ] {
            assert!(there.contains(comment), "`{comment}` was lost:\n{there}");
        }
        let back = print(&over, from);
        assert_eq!(good(&back, from), spec, "{back}");
        assert_eq!(print(&good(&back, from), from), back);
    }
    insta::assert_snapshot!("example_in_yaml", print(&good(HQ, Syntax::Native), Syntax::Yaml));
    insta::assert_snapshot!("example_in_hq", print(&good(YAML, Syntax::Yaml), Syntax::Native));
}

/// Words of the comments, so that a lost one is noticed. Empty comments may vanish.
fn comment_words(text: &str) -> usize {
    text.matches("kept_").count()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn expressions_keep_their_meaning(value in trees::expressions::expr()) {
        use hierarq_dsl::tree::{Item, ItemKind, Param, Spec};
        use hierarq_dsl::{Span, Spanned};
        let param = Param { name: Spanned::new("a".into(), Span::default()), value, range: Default::default() };
        let item = Item { kind: ItemKind::Param(param), span: Span::default(), comments: Default::default() };
        let spec = Spec { version: Some(Spanned::new(1, Span::default())), items: vec![item], ..Spec::default() };
        for syntax in [Syntax::Native, Syntax::Yaml] {
            let text = print(&spec, syntax);
            prop_assert_eq!(&good(&text, syntax), &spec, "{}", text);
        }
    }

    #[test]
    fn printed_trees_are_read_back(spec in trees::spec()) {
        let spec = spec.normalised();
        for syntax in [Syntax::Native, Syntax::Yaml] {
            let text = print(&spec, syntax);
            let read = good(&text, syntax);
            prop_assert_eq!(&read, &spec, "{}", text);
            let again = print(&read, syntax);
            let settled = print(&good(&again, syntax), syntax);
            prop_assert_eq!(&again, &settled);
            prop_assert_eq!(&text, &again);
        }
    }

    #[test]
    fn translations_agree(spec in trees::spec()) {
        let hq = print(&spec, Syntax::Native);
        let yaml = print(&good(&hq, Syntax::Native), Syntax::Yaml);
        let back = print(&good(&yaml, Syntax::Yaml), Syntax::Native);
        prop_assert_eq!(good(&back, Syntax::Native), spec.normalised(), "{}", yaml);
        prop_assert_eq!(comment_words(&hq), comment_words(&yaml), "{}\n{}", hq, yaml);
        prop_assert_eq!(comment_words(&hq), comment_words(&back), "{}\n{}", hq, back);
    }
}

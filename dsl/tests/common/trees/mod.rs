//! Random trees: everything the language can say, and comments in every place that keeps them.

pub mod expressions;
mod machines;
mod missions;
pub mod scenarios;
mod stacks;

use expressions::{allowance, any_value, before, block, comments, expr, name, settings, spanned, text};
use hierarq_dsl::Span;
use hierarq_dsl::tree::*;
use machines::{machine, signal, variable};
use missions::mission;
use proptest::prelude::*;
use scenarios::scenario;
use stacks::{definition, parameters, range, stack, values};
use std::collections::BTreeSet;

fn import() -> BoxedStrategy<Import> {
    let one = (name(), prop::option::of(name()), comments()).prop_map(|(name, alias, comments)| ImportName {
        name: spanned(name),
        alias: alias.map(spanned),
        comments,
    });
    let path = text().prop_map(|t| format!("{t}.hq"));
    (path, prop::collection::vec(one, 0..4), before())
        .prop_map(|(path, names, closing_comments)| Import { path: spanned(path), names, closing_comments })
        .boxed()
}

/// Random declarations that may be repeated.
fn repeated() -> BoxedStrategy<ItemKind> {
    prop_oneof![
        (name(), expr(), range()).prop_map(|(n, value, range)| ItemKind::Param(Param {
            name: spanned(n),
            value,
            range
        })),
        allowance().prop_map(|(code, reason)| ItemKind::Allow(Allow { code: spanned(code), reason })),
        (name(), expr()).prop_map(|(n, value)| ItemKind::Let(Let { name: spanned(n), value })),
        (name(), parameters(), definition()).prop_map(|(n, parameters, definition)| ItemKind::Task(Task {
            name: spanned(n),
            parameters,
            definition
        })),
        stack().prop_map(ItemKind::Stack),
        signal().prop_map(ItemKind::Signal),
        (prop::sample::select(&BlockKind::ALL[..]), name(), settings(&[], any_value(), true))
            .prop_map(|(kind, name, body)| ItemKind::Block(NamedBlock { kind, name: spanned(name), body })),
        variable().prop_map(ItemKind::Variable),
        machine().prop_map(ItemKind::Machine),
        mission().prop_map(ItemKind::Mission),
        scenario().prop_map(ItemKind::Scenario),
    ]
    .boxed()
}

fn repeat(inner: BoxedStrategy<ItemKind>) -> impl Strategy<Value = ItemKind> {
    let body = prop::collection::vec((inner, comments()), 0..3).prop_map(unique);
    (name(), values(), body, before()).prop_map(|(variable, values, body, closing_comments)| {
        ItemKind::For(RepeatItems { variable: spanned(variable), values, body, closing_comments })
    })
}

fn item() -> BoxedStrategy<ItemKind> {
    let nested = prop_oneof![4 => repeated(), 1 => repeat(repeated().boxed())].boxed();
    let robot = (name(), prop::option::of(name()), block()).prop_map(|(n, base, mut body)| {
        body.entries.retain(|e| e.key.value != "from");
        ItemKind::Robot(Robot { name: spanned(n), base: base.map(spanned), body })
    });
    prop_oneof![
        4 => repeated(),
        1 => import().prop_map(ItemKind::Import),
        1 => robot,
        1 => repeat(nested),
        1 => block().prop_map(|body| ItemKind::Coverage(Coverage { body })),
        1 => block().prop_map(|body| ItemKind::Run(Run { body })),
    ]
    .boxed()
}

/// Without what has the kind and name of an earlier one.
fn unique(items: Vec<(ItemKind, Comments)>) -> Vec<Item> {
    let mut seen = BTreeSet::new();
    let distinct = |kind: &ItemKind| match kind {
        ItemKind::Import(i) => (5, i.path.value.clone()),
        ItemKind::Param(p) => (0, p.name.value.clone()),
        ItemKind::Let(l) => (6, l.name.value.clone()),
        ItemKind::Robot(r) => (1, r.name.value.clone()),
        ItemKind::Task(t) => (2, t.name.value.clone()),
        ItemKind::Stack(s) => (3, s.name.value.clone()),
        ItemKind::Signal(s) => (8, s.name.value.clone()),
        ItemKind::Variable(v) => (11, v.name.value.clone()),
        ItemKind::Machine(m) => (9, m.name.value.clone()),
        ItemKind::Scenario(s) => (10, s.name.value.clone()),
        ItemKind::Block(b) => (20 + b.kind as usize, b.name.value.clone()),
        ItemKind::Mission(m) => (14, m.name.value.clone()),
        ItemKind::For(_) => (7, String::new()),
        ItemKind::Coverage(_) => (16, String::new()),
        ItemKind::Run(_) => (4, String::new()),
        ItemKind::Allow(a) => (15, a.code.value.clone()),
    };
    let new = items
        .into_iter()
        .filter(|(kind, _)| matches!(kind, ItemKind::For(_) | ItemKind::Coverage(_)) || seen.insert(distinct(kind)));
    new.map(|(kind, comments)| Item { kind, comments, span: Span::default() }).collect()
}

/// A spec whose names differ within their kind, with one run at most: what both syntaxes can say.
pub fn spec() -> impl Strategy<Value = Spec> {
    (prop::collection::vec((item(), comments()), 0..6), comments(), before()).prop_map(
        |(items, opening_comments, closing_comments)| {
            let items = unique(items);
            Spec { opening_comments, version: Some(spanned(1)), items, closing_comments, unread: Vec::new() }
        },
    )
}

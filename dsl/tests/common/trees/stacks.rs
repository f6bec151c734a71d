//! Tasks, stacks and their levels, and what parameters and repetitions of them are written with.

use super::expressions::*;
use hierarq_dsl::Span;
use hierarq_dsl::tree::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

pub(super) fn definition() -> BoxedStrategy<TaskDefinition> {
    // `for` in the place of a kind begins a repetition.
    let kind = name().prop_filter("no kind", |n| n != "for");
    (kind, prop::collection::vec(expr(), 0..3), named(), prop_oneof![Just(Block::default()), block()])
        .prop_map(|(kind, args, named, body)| TaskDefinition {
            kind: spanned(kind),
            args,
            named,
            body,
            span: Span::default(),
        })
        .boxed()
}

pub(super) fn parameters() -> BoxedStrategy<Vec<Parameter>> {
    let one = (name(), name(), prop::option::of(expr())).prop_map(|(name, ty, default)| Parameter {
        name: spanned(name),
        ty: spanned(ty),
        default,
        span: Span::default(),
    });
    let some = prop::collection::vec(one, 0..3).prop_map(|mut all| {
        let mut seen = BTreeSet::new();
        all.retain(|p| seen.insert(p.name.value.clone()));
        all
    });
    prop_oneof![2 => Just(Vec::new()), 1 => some].boxed()
}

pub(super) fn call() -> BoxedStrategy<Call> {
    (name(), prop::collection::vec(expr(), 0..3), named())
        .prop_map(|(name, args, named)| Call { name: spanned(name), args, named, span: Span::default() })
        .boxed()
}

pub(super) fn values() -> BoxedStrategy<Values> {
    let list = prop::collection::vec(expr(), 0..3).prop_map(|items| Values::List(value(ValueKind::List(items))));
    let named = name().prop_map(|n| Values::List(value(ValueKind::Name(n))));
    prop_oneof![2 => list, 1 => named, 2 => (expr(), expr()).prop_map(|(a, b)| Values::Range(a, b))].boxed()
}

pub(super) fn range() -> BoxedStrategy<Block> {
    let entry = |key: &'static str| {
        (expr(), comments()).prop_map(move |(value, comments)| Entry { key: spanned(key.to_owned()), value, comments })
    };
    let some = (prop::option::of(entry("min")), prop::option::of(entry("max")), before());
    let some = some.prop_map(|(min, max, closing_comments)| {
        let entries: Vec<Entry> = min.into_iter().chain(max).collect();
        // Comments of a range stand between its entries.
        let closing_comments = if entries.is_empty() { Comments::default() } else { closing_comments };
        Block { entries, closing_comments, ..Block::default() }
    });
    prop_oneof![2 => Just(Block::default()), 1 => some].boxed()
}

fn plain_member() -> BoxedStrategy<Member> {
    let task =
        prop_oneof![name().prop_map(|n| MemberTask::Name(spanned(n))), definition().prop_map(MemberTask::Inline),];
    (task, prop::option::of(expr()), comments())
        .prop_map(|(task, weight, comments)| Member { task, weight, comments, span: Span::default() })
        .boxed()
}

fn member() -> BoxedStrategy<Member> {
    let repeat = |inner: BoxedStrategy<Member>| {
        (name(), values(), prop::collection::vec(inner, 0..3), before(), comments()).prop_map(
            |(variable, values, body, closing_comments, comments)| {
                let repeat = RepeatMembers { variable: spanned(variable), values, body, closing_comments };
                Member { task: MemberTask::For(Box::new(repeat)), weight: None, comments, span: Span::default() }
            },
        )
    };
    prop_oneof![6 => plain_member(), 1 => repeat(prop_oneof![4 => plain_member(), 1 => repeat(plain_member().boxed())].boxed())].boxed()
}

fn level() -> BoxedStrategy<Level> {
    let settings = settings(
        &["name", "tasks", "hard", "level", "hrad", "replace", "add", "remove", "before", "after"],
        expr().boxed(),
        false,
    )
    .prop_map(|mut b| {
        // A key that looks like `hard` misspelt is taken for that.
        b.entries.retain(|e| e.key.len() != 4 && e.key.len() != 3 && e.key.len() != 5);
        b
    });
    let name = name().prop_filter("a level cannot be called `hard`", |n| n != "hard");
    (name, any::<bool>(), settings, prop::collection::vec(member(), 0..4), comments())
        .prop_map(|(name, hard, settings, members, comments)| Level {
            name: spanned(name),
            hard: hard.then(Span::default),
            settings,
            members,
            comments,
            span: Span::default(),
        })
        .boxed()
}

pub(super) fn stack() -> BoxedStrategy<Stack> {
    const RESERVED: &[&str] = &["level", "levels", "from", "changes", "replace", "add", "remove"];
    let beside = (any::<bool>(), name()).prop_map(|(before, level)| Beside { before, level: spanned(level) });
    let removal = (name(), comments()).prop_map(|(level, comments)| {
        Change::Remove(Removal { level: spanned(level), span: Span::default(), comments })
    });
    let change = prop_oneof![
        level().prop_map(Change::Replace),
        (level(), prop::option::of(beside)).prop_map(|(level, beside)| Change::Add(level, beside)),
        removal
    ];
    let plain = prop::collection::vec(level(), 0..3).prop_map(|levels| (None, levels, Vec::new()));
    let made =
        (call(), prop::collection::vec(change, 0..3)).prop_map(|(base, changes)| (Some(base), Vec::new(), changes));
    let content = prop_oneof![2 => plain, 1 => made];
    (name(), parameters(), settings(RESERVED, any_value(), true), content)
        .prop_map(|(name, parameters, settings, (base, levels, changes))| Stack {
            name: spanned(name),
            parameters,
            base,
            settings,
            levels,
            changes,
        })
        .boxed()
}

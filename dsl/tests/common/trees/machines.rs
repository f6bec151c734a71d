//! Signals, variables, machines and their states.

use super::expressions::*;
use super::scenarios::{expect, formula};
use super::stacks::call;
use hierarq_dsl::Span;
use hierarq_dsl::tree::*;
use hierarq_dsl::vocabulary::TEXT_KEYS;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Settings on one line: without comments and blocks.
fn plain_settings() -> BoxedStrategy<Block> {
    let reserved = [STATE_WORDS, &["for", "to"]].concat();
    settings(&["allow"], expr().boxed(), false)
        .prop_map(move |mut block| {
            block.entries.retain(|e| !reserved.contains(&e.key.as_str()));
            Block { closing_comments: Comments::default(), ..block }
        })
        .boxed()
}

const STATE_WORDS: &[&str] = &[
    "state",
    "states",
    "region",
    "regions",
    "final",
    "stack",
    "enter",
    "do",
    "exit",
    "on",
    "when",
    "after",
    "check",
    "transitions",
];

pub(super) fn signal() -> BoxedStrategy<Signal> {
    (name(), name(), any::<bool>(), settings(&["type"], any_value(), true))
        .prop_map(|(name, ty, optional, settings)| {
            // Comments of settings stand between their entries.
            let bare = settings.entries.is_empty();
            let settings = if bare { Block::default() } else { settings };
            Signal { name: spanned(name), ty: spanned(ty), optional: optional.then(Span::default), settings }
        })
        .boxed()
}

pub(super) fn variable() -> BoxedStrategy<Variable> {
    (name(), name(), any::<bool>(), prop::option::of(expr()))
        .prop_map(|(name, ty, optional, value)| Variable {
            name: spanned(name),
            ty: spanned(ty),
            optional: optional.then(Span::default),
            value,
        })
        .boxed()
}

fn action() -> BoxedStrategy<Action> {
    let moment = prop::sample::select(&Moment::ALL[..]);
    let verb = prop_oneof![3 => name(), 1 => prop::sample::select(STATE_WORDS).prop_map(str::to_owned)];
    (moment, verb, prop::collection::vec(expr(), 0..3), named(), any::<bool>(), comments())
        .prop_map(|(moment, verb, args, named, bare, comments)| Action {
            moment: spanned(moment),
            verb: spanned(verb),
            args,
            named,
            bare,
            span: Span::default(),
            comments,
        })
        .boxed()
}

/// A condition, words that begin a part of a state among its names.
fn condition() -> BoxedStrategy<Value> {
    let word = prop::sample::select(&["on", "when", "after", "check", "state", "do", "for", "to", "blend"][..]);
    prop_oneof![6 => expr(), 1 => word.prop_map(|n| value(ValueKind::Name(n.to_owned())))].boxed()
}

fn transition() -> BoxedStrategy<Transition> {
    let trigger = prop_oneof![
        condition().prop_map(Trigger::On),
        (condition(), prop::option::of(condition())).prop_map(|(condition, hold)| Trigger::When { condition, hold }),
        condition().prop_map(Trigger::After),
    ];
    let state = prop_oneof![4 => name(), 1 => (name(), name()).prop_map(|(a, b)| format!("{a}.{b}"))];
    (trigger, state, plain_settings(), comments())
        .prop_map(|(trigger, target, settings, comments)| Transition {
            trigger,
            target: spanned(target),
            settings,
            span: Span::default(),
            comments,
        })
        .boxed()
}

/// A property begins with a word of formulas, so that no word of states comes first.
fn property() -> BoxedStrategy<Expect> {
    let always = |f| Formula { kind: FormulaKind::Always(Window::default(), Box::new(f)), span: Span::default() };
    expect(formula().prop_map(always).boxed())
}

fn state_body(states: BoxedStrategy<State>, inside: bool) -> BoxedStrategy<StateBody> {
    let stack = prop_oneof![1 => Just(None), 1 => (call(), comments()).prop_map(Some)];
    let parts = (
        stack,
        settings(STATE_WORDS, any_value(), true),
        prop::collection::vec(action(), 0..3),
        prop::collection::vec(transition(), 0..3),
        prop::collection::vec(property(), 0..2),
        prop::collection::vec(states, 0..3),
    );
    (parts, any::<bool>())
        .prop_map(move |((stack, mut settings, actions, transitions, properties, mut states), small)| {
            let closing_comments = std::mem::take(&mut settings.closing_comments);
            let (stack, stack_comments) = stack.map_or((None, Comments::default()), |(s, c)| (Some(s), c));
            let mut seen = BTreeSet::new();
            states.retain(|s| seen.insert(s.name.value.clone()));
            if small && inside {
                return StateBody { stack, stack_comments, ..StateBody::default() };
            }
            // A key that looks like one of a state, with a block behind it, is taken for that.
            for (i, entry) in settings.entries.iter_mut().enumerate() {
                if matches!(entry.value.kind, ValueKind::Block(_) | ValueKind::List(_))
                    && !TEXT_KEYS.contains(&entry.key.as_str())
                {
                    entry.key.value = format!("q_q_{i}_q");
                }
            }
            StateBody { stack, stack_comments, settings, actions, transitions, properties, states, closing_comments }
        })
        .boxed()
}

fn state() -> BoxedStrategy<State> {
    let one = |states: BoxedStrategy<State>| {
        (name(), 0..3, state_body(states, true), comments())
            .prop_map(|(name, kind, body, comments)| State {
                name: spanned(name),
                region: kind == 2,
                final_: (kind == 1).then(Span::default),
                body,
                span: Span::default(),
                comments,
            })
            .boxed()
    };
    let leaf = (name(), comments()).prop_map(|(name, comments)| State {
        name: spanned(name),
        region: false,
        final_: Some(Span::default()),
        body: StateBody::default(),
        span: Span::default(),
        comments,
    });
    let leaf = leaf.boxed();
    one(prop_oneof![1 => leaf.clone(), 1 => one(leaf)].boxed())
}

pub(super) fn machine() -> BoxedStrategy<Machine> {
    (name(), state_body(state(), false)).prop_map(|(name, body)| Machine { name: spanned(name), body }).boxed()
}

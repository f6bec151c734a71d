//! Random trees: everything the language can say, and comments in every place that keeps them.

use hierarq_dsl::tree::*;
use hierarq_dsl::vocabulary::{TEXT_KEYS, UNITS};
use hierarq_dsl::{Span, Spanned};
use proptest::prelude::*;
use std::collections::BTreeSet;

fn spanned<T>(value: T) -> Spanned<T> {
    Spanned::new(value, Span::default())
}

fn value(kind: ValueKind) -> Value {
    Value { kind, span: Span::default() }
}

/// Names, with those that have a meaning somewhere among them.
fn name() -> impl Strategy<Value = String> {
    static SPECIAL: &[&str] = &[
        "m", "s", "h", "g", "N", "param", "task", "tasks", "stack", "level", "levels", "run", "hard", "weight", "name",
        "null", "true", "on", "no", "hierarq", "e3", "_", "w", "from", "let", "import", "in", "as", "min", "value",
        "add", "before", "for", "signal", "machine", "scenario", "state",
    ];
    prop_oneof![
        6 => "[a-zA-Z_][a-zA-Z0-9_]{0,8}",
        2 => prop::sample::select(SPECIAL).prop_map(str::to_owned),
        1 => "[a-z_]{0,3}\\$\\{[a-z_]{1,3}\\}[a-z0-9]{0,2}"
    ]
    .prop_filter("an operator", |n| !["and", "or", "not"].contains(&n.as_str()))
}

fn text() -> impl Strategy<Value = String> {
    prop_oneof![
        "[a-z_/.*? -]{0,12}",
        "\\PC{0,8}",
        "[\"'\\\\:#{}\\[\\],&*!|>%@`\n\t\r\u{7}\u{85}\u{2028}\u{feff} a-z~]{0,10}",
        Just("null".to_owned()),
        Just("~".to_owned()),
        Just("*_elbow".to_owned()),
        Just("3.A".to_owned()),
        Just("---".to_owned()),
    ]
}

fn number() -> impl Strategy<Value = Value> {
    prop_oneof![Just("0.5".to_owned()), Just("1e-3".to_owned()), "[0-9]{1,4}", "[0-9]{1,3}\\.[0-9]{1,3}"]
        .prop_map(|text| value(ValueKind::Number(Number { value: text.parse().unwrap_or(f64::NAN), text })))
}

fn unit() -> impl Strategy<Value = Unit> {
    prop::collection::vec((prop::sample::select(UNITS), prop_oneof![3 => Just(1), 2 => Just(-1), 1 => -3i32..4]), 1..4)
        .prop_map(|f| Unit { factors: f.into_iter().map(|(s, p)| (s.to_owned(), p)).collect(), span: Span::default() })
}

fn op() -> impl Strategy<Value = Spanned<BinaryOp>> {
    use BinaryOp::*;
    prop::sample::select(&[Add, Sub, Mul, Div, Pow, Add, Sub, Mul, Less, LessEqual, Greater, GreaterEqual, And, Or][..])
        .prop_map(spanned)
}

pub fn expr() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        4 => number(),
        3 => name().prop_map(|n| value(ValueKind::Name(n))),
        1 => text().prop_map(|t| value(ValueKind::Text(t))),
    ];
    leaf.prop_recursive(5, 24, 4, |inner| {
        let boxed = inner.clone().prop_map(Box::new).boxed();
        prop_oneof![
            3 => (boxed.clone(), unit()).prop_map(|(v, u)| value(ValueKind::Unit(v, u))),
            2 => (name(), prop::collection::vec(inner.clone(), 0..4), prop::collection::vec((name(), inner.clone()), 0..2))
                .prop_map(|(n, mut args, named)| {
                    args.extend(named.into_iter().map(|(n, v)| value(ValueKind::Named(spanned(n), Box::new(v)))));
                    value(ValueKind::Call(spanned(n), args))
                }),
            1 => (boxed.clone(), name()).prop_map(|(v, n)| value(ValueKind::Field(v, spanned(n)))),
            1 => (boxed.clone(), name()).prop_map(|(v, n)| value(ValueKind::In(v, spanned(n)))),
            2 => prop::collection::vec(inner, 0..5).prop_map(|items| value(ValueKind::List(items))),
            2 => boxed.clone().prop_map(|v| value(ValueKind::Negate(v))),
            1 => boxed.clone().prop_map(|v| value(ValueKind::Not(v))),
            5 => (op(), boxed.clone(), boxed).prop_map(|(op, a, b)| value(ValueKind::Binary(op, a, b))),
        ]
    })
}

fn comment() -> impl Strategy<Value = String> {
    "kept_[a-zA-Z0-9 :{}\\[\\],\"'=/#-]{0,12}[a-z]"
}

fn comments() -> impl Strategy<Value = Comments> {
    let some = (prop::collection::vec(comment(), 0..3), any::<bool>(), prop::option::of(comment()));
    let some = some.prop_map(|(mut before, blank, behind)| {
        if blank && before.len() > 1 {
            before.insert(1, String::new());
        }
        Comments { before, behind }
    });
    prop_oneof![6 => Just(Comments::default()), 1 => some]
}

fn before() -> impl Strategy<Value = Comments> {
    comments().prop_map(|c| Comments { before: c.before, behind: None })
}

/// A list of text, where text must stand.
fn text_value() -> impl Strategy<Value = Value> {
    let one = text().prop_map(|t| value(ValueKind::Text(t))).boxed();
    prop_oneof![3 => one.clone(), 1 => prop::collection::vec(one, 0..3).prop_map(|v| value(ValueKind::List(v)))]
}

fn entry(inner: BoxedStrategy<Value>) -> impl Strategy<Value = Entry> {
    let plain = (name(), inner).prop_filter("takes text", |(key, _)| !TEXT_KEYS.contains(&key.as_str()));
    let patterns = ("[a-z_]{0,3}[*?][a-z0-9_*?]{0,3}(\\$\\{k\\})?", expr());
    let quoted = ("[a-z0-9_]{0,3}[./:-][a-z0-9_./:-]{0,3}", expr());
    let texts = (prop::sample::select(TEXT_KEYS).prop_map(str::to_owned), text_value());
    (prop_oneof![6 => plain, 1 => patterns, 1 => quoted, 1 => texts], comments())
        .prop_map(|((key, value), comments)| Entry { key: spanned(key), value, comments })
}

fn distinct(mut entries: Vec<Entry>, reserved: &[&str]) -> Vec<Entry> {
    let mut seen = BTreeSet::new();
    entries.retain(|e| !reserved.contains(&e.key.as_str()) && seen.insert(e.key.value.clone()));
    entries
}

fn block_of(inner: BoxedStrategy<Value>) -> impl Strategy<Value = Block> {
    (prop::collection::vec(entry(inner), 0..5), any::<bool>(), before()).prop_map(
        |(entries, tagged, closing_comments)| {
            let entries = distinct(entries, &[]);
            let tagged = tagged && entries.len() == 1 && matches!(entries[0].value.kind, ValueKind::Block(_));
            Block { entries, tagged, closing_comments, span: Span::default() }
        },
    )
}

fn any_value() -> BoxedStrategy<Value> {
    let leaf = expr().boxed();
    leaf.prop_recursive(3, 16, 4, |inner| {
        let inner = inner.boxed();
        prop_oneof![
            1 => block_of(inner.clone()).prop_map(|b| value(ValueKind::Block(b))),
            1 => expr(),
            1 => prop::collection::vec(inner, 0..3).prop_map(|v| value(ValueKind::List(v))),
        ]
    })
    .boxed()
}

fn block() -> BoxedStrategy<Block> {
    block_of(any_value()).prop_map(|b| Block { tagged: false, ..b }).boxed()
}

fn named() -> BoxedStrategy<Vec<Entry>> {
    let one =
        (name(), expr()).prop_map(|(key, value)| Entry { key: spanned(key), value, comments: Comments::default() });
    prop_oneof![2 => Just(Vec::new()), 1 => prop::collection::vec(one, 0..3).prop_map(|all| distinct(all, &[]))].boxed()
}

fn definition() -> BoxedStrategy<TaskDefinition> {
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

fn parameters() -> BoxedStrategy<Vec<Parameter>> {
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

fn call() -> BoxedStrategy<Call> {
    (name(), prop::collection::vec(expr(), 0..3), named())
        .prop_map(|(name, args, named)| Call { name: spanned(name), args, named, span: Span::default() })
        .boxed()
}

fn values() -> BoxedStrategy<Values> {
    let list = prop::collection::vec(expr(), 0..3).prop_map(|items| Values::List(value(ValueKind::List(items))));
    let named = name().prop_map(|n| Values::List(value(ValueKind::Name(n))));
    prop_oneof![2 => list, 1 => named, 2 => (expr(), expr()).prop_map(|(a, b)| Values::Range(a, b))].boxed()
}

fn range() -> BoxedStrategy<Block> {
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

fn settings(
    reserved: &'static [&'static str],
    inner: BoxedStrategy<Value>,
    loud: bool,
) -> impl Strategy<Value = Block> {
    (prop::collection::vec(entry(inner), 0..3), before()).prop_map(move |(entries, closing_comments)| {
        let mut entries = distinct(entries, reserved);
        entries.retain(|e| !e.key.contains(['*', '?', '.', '/', ':', '-']));
        if !loud {
            entries.iter_mut().for_each(|e| e.comments = Comments::default());
        }
        Block { entries, closing_comments, ..Block::default() }
    })
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

fn stack() -> BoxedStrategy<Stack> {
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

/// Settings on one line: without comments and blocks.
fn plain_settings() -> BoxedStrategy<Block> {
    let reserved = [STATE_WORDS, &["for", "to"]].concat();
    settings(&[], expr().boxed(), false)
        .prop_map(move |mut block| {
            block.entries.retain(|e| !reserved.contains(&e.key.as_str()));
            Block { closing_comments: Comments::default(), ..block }
        })
        .boxed()
}

const STATE_WORDS: &[&str] =
    &["state", "states", "final", "stack", "enter", "do", "exit", "on", "when", "after", "transitions"];

fn signal() -> BoxedStrategy<Signal> {
    (name(), name(), any::<bool>(), settings(&["type"], any_value(), true))
        .prop_map(|(name, ty, optional, settings)| {
            // Comments of settings stand between their entries.
            let bare = settings.entries.is_empty();
            let settings = if bare { Block::default() } else { settings };
            Signal { name: spanned(name), ty: spanned(ty), optional: optional.then(Span::default), settings }
        })
        .boxed()
}

fn variable() -> BoxedStrategy<Variable> {
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
    let word = prop::sample::select(&["on", "when", "after", "state", "do", "for", "to", "blend"][..]);
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

fn state_body(states: BoxedStrategy<State>, inside: bool) -> BoxedStrategy<StateBody> {
    let stack = prop_oneof![1 => Just(None), 1 => (call(), comments()).prop_map(Some)];
    let parts = (
        stack,
        settings(STATE_WORDS, any_value(), true),
        prop::collection::vec(action(), 0..3),
        prop::collection::vec(transition(), 0..3),
        prop::collection::vec(states, 0..3),
    );
    (parts, any::<bool>())
        .prop_map(move |((stack, mut settings, actions, transitions, mut states), small)| {
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
            StateBody { stack, stack_comments, settings, actions, transitions, states, closing_comments }
        })
        .boxed()
}

fn state() -> BoxedStrategy<State> {
    let one = |states: BoxedStrategy<State>| {
        (name(), any::<bool>(), state_body(states, true), comments())
            .prop_map(|(name, is_final, body, comments)| State {
                name: spanned(name),
                final_: is_final.then(Span::default),
                body,
                span: Span::default(),
                comments,
            })
            .boxed()
    };
    let leaf = (name(), comments()).prop_map(|(name, comments)| State {
        name: spanned(name),
        final_: Some(Span::default()),
        body: StateBody::default(),
        span: Span::default(),
        comments,
    });
    let leaf = leaf.boxed();
    one(prop_oneof![1 => leaf.clone(), 1 => one(leaf)].boxed())
}

fn machine() -> BoxedStrategy<Machine> {
    (name(), state_body(state(), false)).prop_map(|(name, body)| Machine { name: spanned(name), body }).boxed()
}

fn window() -> BoxedStrategy<Window> {
    let some = (prop::option::of(expr()), prop::option::of(expr()));
    let some = some.prop_map(|(from, to)| Window { from, to, span: Span::default() });
    prop_oneof![1 => Just(Window::default()), 1 => some].boxed()
}

/// False where a value begins with a word of formulas.
fn may_stand(f: &Formula) -> bool {
    const WORDS: &[&str] = &["always", "eventually", "never", "within", "from", "to", "after", "until", "implies"];
    fn first(value: &Value) -> &str {
        match &value.kind {
            ValueKind::Name(name) => name,
            ValueKind::Call(name, _) => name,
            ValueKind::Unit(of, _) | ValueKind::Field(of, _) | ValueKind::In(of, _) => first(of),
            ValueKind::Binary(_, left, _) => first(left),
            _ => "",
        }
    }
    match &f.kind {
        FormulaKind::Value(value) => !WORDS.contains(&first(value)),
        FormulaKind::Not(a) => may_stand(a),
        FormulaKind::And(a, b) | FormulaKind::Or(a, b) => may_stand(a) && may_stand(b),
        _ => true,
    }
}

pub fn formula() -> BoxedStrategy<Formula> {
    let made = |kind| Formula { kind, span: Span::default() };
    let word = prop::sample::select(&["expect", "in", "on", "for", "m"][..]);
    let leaf = prop_oneof![
        4 => expr().prop_map(Formula::of).prop_filter("a word of formulas", may_stand),
        1 => word.prop_map(|n| Formula::of(value(ValueKind::Name(n.to_owned())))),
    ];
    leaf.prop_recursive(5, 16, 3, move |inner| {
        let f = inner.prop_map(Box::new).boxed();
        prop_oneof![
            (window(), f.clone()).prop_map(|(w, f)| FormulaKind::Always(w, f)),
            (window(), f.clone()).prop_map(|(w, f)| FormulaKind::Eventually(w, f)),
            (window(), f.clone()).prop_map(|(w, f)| FormulaKind::Never(w, f)),
            (f.clone(), window(), f.clone()).prop_map(|(a, w, b)| FormulaKind::Until(a, w, b)),
            (f.clone(), f.clone()).prop_map(|(a, b)| FormulaKind::After(a, b)),
            f.clone().prop_map(FormulaKind::Not),
            (f.clone(), f.clone()).prop_map(|(a, b)| FormulaKind::And(a, b)),
            (f.clone(), f.clone()).prop_map(|(a, b)| FormulaKind::Or(a, b)),
            (f.clone(), f).prop_map(|(a, b)| FormulaKind::Implies(a, b)),
        ]
        .prop_map(made)
    })
    .boxed()
}

fn scenario() -> BoxedStrategy<Scenario> {
    let label = prop::option::of(text());
    let expect = (label, formula(), comments()).prop_map(|(label, formula, comments)| Expect {
        label: label.map(spanned),
        formula,
        span: Span::default(),
        comments,
    });
    let name = prop_oneof![name(), text().prop_filter("a name", |t| !t.is_empty())];
    (name, settings(&["expect"], any_value(), true), prop::collection::vec(expect, 0..3))
        .prop_map(|(name, body, expects)| Scenario { name: spanned(name), body, expects })
        .boxed()
}

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

/// What may be repeated.
fn repeated() -> BoxedStrategy<ItemKind> {
    prop_oneof![
        (name(), expr(), range()).prop_map(|(n, value, range)| ItemKind::Param(Param {
            name: spanned(n),
            value,
            range
        })),
        (name(), expr()).prop_map(|(n, value)| ItemKind::Let(Let { name: spanned(n), value })),
        (name(), parameters(), definition()).prop_map(|(n, parameters, definition)| ItemKind::Task(Task {
            name: spanned(n),
            parameters,
            definition
        })),
        stack().prop_map(ItemKind::Stack),
        signal().prop_map(ItemKind::Signal),
        (name(), settings(&[], any_value(), true))
            .prop_map(|(name, body)| ItemKind::Human(Human { name: spanned(name), body })),
        (name(), settings(&[], any_value(), true))
            .prop_map(|(name, body)| ItemKind::SafetyField(SafetyField { name: spanned(name), body })),
        variable().prop_map(ItemKind::Variable),
        machine().prop_map(ItemKind::Machine),
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
        ItemKind::SafetyField(f) => (12, f.name.value.clone()),
        ItemKind::Human(h) => (13, h.name.value.clone()),
        ItemKind::For(_) => (7, String::new()),
        ItemKind::Run(_) => (4, String::new()),
    };
    let new = items.into_iter().filter(|(kind, _)| matches!(kind, ItemKind::For(_)) || seen.insert(distinct(kind)));
    new.map(|(kind, comments)| Item { kind, comments, span: Span::default() }).collect()
}

/// A spec whose names differ within their kind, with one run at most: what both spellings can say.
pub fn spec() -> impl Strategy<Value = Spec> {
    (prop::collection::vec((item(), comments()), 0..6), comments(), before()).prop_map(
        |(items, opening_comments, closing_comments)| {
            let items = unique(items);
            Spec { opening_comments, version: Some(spanned(1)), items, closing_comments, unread: Vec::new() }
        },
    )
}

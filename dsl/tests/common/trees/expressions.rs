//! Values, blocks and comments.

use hierarq_dsl::tree::*;
use hierarq_dsl::vocabulary::{TEXT_KEYS, UNITS};
use hierarq_dsl::{Span, Spanned};
use proptest::prelude::*;
use std::collections::BTreeSet;

pub(super) fn spanned<T>(value: T) -> Spanned<T> {
    Spanned::new(value, Span::default())
}

pub(super) fn value(kind: ValueKind) -> Value {
    Value { kind, span: Span::default() }
}

/// Names, with those that have a meaning somewhere among them.
pub(super) fn name() -> impl Strategy<Value = String> {
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

pub(super) fn text() -> impl Strategy<Value = String> {
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

pub(super) fn comments() -> impl Strategy<Value = Comments> {
    let some = (prop::collection::vec(comment(), 0..3), any::<bool>(), prop::option::of(comment()));
    let some = some.prop_map(|(mut before, blank, behind)| {
        if blank && before.len() > 1 {
            before.insert(1, String::new());
        }
        Comments { before, behind }
    });
    prop_oneof![6 => Just(Comments::default()), 1 => some]
}

pub(super) fn before() -> impl Strategy<Value = Comments> {
    comments().prop_map(|c| Comments { before: c.before, behind: None })
}

/// A list of text, where text must stand.
fn text_value() -> impl Strategy<Value = Value> {
    let one = text().prop_map(|t| value(ValueKind::Text(t))).boxed();
    prop_oneof![3 => one.clone(), 1 => prop::collection::vec(one, 0..3).prop_map(|v| value(ValueKind::List(v)))]
}

pub(super) fn entry(inner: BoxedStrategy<Value>) -> impl Strategy<Value = Entry> {
    let plain = (name(), inner).prop_filter("takes text", |(key, _)| !TEXT_KEYS.contains(&key.as_str()));
    let patterns = ("[a-z_]{0,3}[*?][a-z0-9_*?]{0,3}(\\$\\{k\\})?", expr());
    let quoted = ("[a-z0-9_]{0,3}[./:-][a-z0-9_./:-]{0,3}", expr());
    let texts = (prop::sample::select(TEXT_KEYS).prop_map(str::to_owned), text_value());
    (prop_oneof![6 => plain, 1 => patterns, 1 => quoted, 1 => texts], comments())
        .prop_map(|((key, value), comments)| Entry { key: spanned(key), value, comments })
}

pub(super) fn distinct(mut entries: Vec<Entry>, reserved: &[&str]) -> Vec<Entry> {
    let mut seen = BTreeSet::new();
    entries.retain(|e| !reserved.contains(&e.key.as_str()) && seen.insert(e.key.value.clone()));
    entries
}

/// A reason, and the code that it is for.
pub(super) fn allowance() -> impl Strategy<Value = (String, Value)> {
    ("HQ[0-9]{1,4}", text().prop_map(|t| value(ValueKind::Text(t))))
}

/// The entry `allow` of a block, in one of eight blocks.
fn allowed() -> impl Strategy<Value = Option<Entry>> {
    let one =
        (allowance(), comments()).prop_map(|((code, value), comments)| Entry { key: spanned(code), value, comments });
    let codes = prop::collection::vec(one, 1..3).prop_map(|all| Entry {
        key: spanned("allow".to_owned()),
        value: value(ValueKind::Block(Block { entries: distinct(all, &[]), ..Block::default() })),
        comments: Comments::default(),
    });
    prop_oneof![7 => Just(None), 1 => codes.prop_map(Some)]
}

/// An entry `allow` without comments.
fn quiet(mut entry: Entry) -> Entry {
    if let ValueKind::Block(codes) = &mut entry.value.kind {
        codes.entries.iter_mut().for_each(|code| code.comments = Comments::default());
    }
    entry
}

fn block_of(inner: BoxedStrategy<Value>) -> impl Strategy<Value = Block> {
    (prop::collection::vec(entry(inner), 0..5), allowed(), any::<bool>(), before()).prop_map(
        |(entries, allowed, tagged, closing_comments)| {
            let mut entries = distinct(entries, &[]);
            entries.extend(allowed);
            let tagged = tagged && entries.len() == 1 && matches!(entries[0].value.kind, ValueKind::Block(_));
            Block { entries, tagged, closing_comments, span: Span::default() }
        },
    )
}

pub(super) fn any_value() -> BoxedStrategy<Value> {
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

pub(super) fn block() -> BoxedStrategy<Block> {
    block_of(any_value()).prop_map(|b| Block { tagged: false, ..b }).boxed()
}

pub(super) fn named() -> BoxedStrategy<Vec<Entry>> {
    let one =
        (name(), expr()).prop_map(|(key, value)| Entry { key: spanned(key), value, comments: Comments::default() });
    prop_oneof![2 => Just(Vec::new()), 1 => prop::collection::vec(one, 0..3).prop_map(|all| distinct(all, &[]))].boxed()
}

pub(super) fn settings(
    reserved: &'static [&'static str],
    inner: BoxedStrategy<Value>,
    loud: bool,
) -> impl Strategy<Value = Block> {
    (prop::collection::vec(entry(inner), 0..3), allowed(), before()).prop_map(
        move |(entries, allowed, closing_comments)| {
            let mut entries = distinct(entries, reserved);
            let allowed = allowed.filter(|_| !reserved.contains(&"allow"));
            entries.extend(allowed.map(|entry| if loud { entry } else { quiet(entry) }));
            entries.retain(|e| !e.key.contains(['*', '?', '.', '/', ':', '-']));
            if !loud {
                entries.iter_mut().for_each(|e| e.comments = Comments::default());
            }
            Block { entries, closing_comments, ..Block::default() }
        },
    )
}

//! Expressions: converts the flat operator lists of the grammar to trees of [`Value`].

mod literals;
mod operators;

pub(crate) use literals::{quantity, unescape};
use literals::{unit, with_unit};
use operators::{Token, climb, operator, tolerance};

use crate::grammar::{Pair, Rule};
use crate::limits::{MAX_HEIGHT, MAX_OPERATORS};
use crate::tree::{BinaryOp, Value, ValueKind};
use crate::{Diagnostic, SourceId, Span, Spanned};

/// Location of a parsed text in the source.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// The text is a part of the source that begins at this byte.
    Exact(SourceId, usize),
    /// The text was decoded (escapes, folded lines): all locations are the whole scalar.
    Whole(Span),
}

impl Place {
    /// Returns the span of bytes `start..end` of the parsed text.
    pub fn span(self, start: usize, end: usize) -> Span {
        match self {
            Place::Exact(source, base) => Span::new(source, base + start, base + end),
            Place::Whole(span) => span,
        }
    }

    /// Returns the span of a node.
    pub fn of(self, pair: &Pair<'_>) -> Span {
        let span = pair.as_span();
        self.span(span.start(), span.end())
    }

    /// Returns the text of a node with its span.
    pub fn spanned(self, pair: &Pair<'_>) -> Spanned<String> {
        Spanned::new(pair.as_str().to_owned(), self.of(pair))
    }
}

/// Returns the placeholder for a value that could not be read.
pub(crate) fn missing(span: Span) -> Value {
    Value { kind: ValueKind::Missing, span }
}

/// Builds the blocks that a list may contain (`[{ a x }, { a y }]`); expressions have none.
pub(crate) type BlockReader<'f> = &'f mut dyn FnMut(Pair<'_>, &mut Vec<Diagnostic>) -> Value;

/// Converts a node `expr` or `within` to a value.
pub(crate) fn value(pair: Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>, blocks: BlockReader<'_>) -> Value {
    let mut value = expr(pair, place, diags, blocks).0;
    if let Some(span) = stray_block(&value, true) {
        diags.push(
            Diagnostic::unreadable("HQ0113", span, "a block is not allowed inside an expression")
                .note("blocks are allowed as values of keys, and in lists that are values of keys"),
        );
        value.kind = ValueKind::Missing;
    }
    value
}

/// Returns a block in place of a value of an expression. `free` is true while a list may still contain blocks.
fn stray_block(value: &Value, free: bool) -> Option<Span> {
    match &value.kind {
        ValueKind::Block(_) => (!free).then_some(value.span),
        ValueKind::List(items) => items.iter().find_map(|item| stray_block(item, free)),
        ValueKind::Call(_, args) => args.iter().find_map(|arg| stray_block(arg, false)),
        ValueKind::Unit(of, _)
        | ValueKind::Field(of, _)
        | ValueKind::In(of, _)
        | ValueKind::Named(_, of)
        | ValueKind::Negate(of)
        | ValueKind::Not(of) => stray_block(of, false),
        ValueKind::Binary(_, left, right) => stray_block(left, false).or_else(|| stray_block(right, false)),
        _ => None,
    }
}

/// Returns the value and height of a node `expr` or `within`.
fn expr(pair: Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>, blocks: BlockReader<'_>) -> (Value, u32) {
    let whole = place.of(&pair);
    let mut tokens: Vec<Token> = Vec::new();
    let mut operators = 0usize;
    let mut equality = None;
    for part in pair.into_inner() {
        let span = place.of(&part);
        match part.as_rule() {
            Rule::sign => {
                operators += 1;
                tokens.push(Token::Sign(span));
            }
            Rule::not => {
                operators += 1;
                tokens.push(Token::Not(place.span(part.as_span().start(), part.as_span().start() + "not".len())));
            }
            Rule::op | Rule::joint => {
                operators += 1;
                let text = part.as_str();
                let Some(op) = operator(text) else {
                    equality.get_or_insert((tokens.len(), span));
                    tokens.push(Token::Op(BinaryOp::Less, span));
                    continue;
                };
                tokens.push(Token::Op(op, span));
            }
            Rule::field => {
                operators += 1;
                if let Some(name) = part.into_inner().next().filter(|_| operators <= MAX_OPERATORS) {
                    wrap(&mut tokens, |of| {
                        let span = of.span.to(place.of(&name));
                        Value { kind: ValueKind::Field(Box::new(of), place.spanned(&name)), span }
                    });
                }
            }
            Rule::unit => {
                let unit = unit(part, place, diags);
                wrap(&mut tokens, |of| with_unit(of, unit));
            }
            Rule::in_frame => {
                operators += 1;
                let mut parts = part.into_inner();
                let (frame, args) = (parts.next(), parts.next());
                if let Some(args) = args {
                    let inside = args.as_str().trim_matches(['(', ')', ' ']);
                    diags.push(
                        Diagnostic::unreadable("HQ0113", span, "only the name of a link can follow `in`")
                            .help(format!("write `in {inside}`")),
                    );
                }
                if let Some(frame) = frame.filter(|_| operators <= MAX_OPERATORS) {
                    wrap(&mut tokens, |of| {
                        let span = of.span.to(place.of(&frame));
                        Value { kind: ValueKind::In(Box::new(of), place.spanned(&frame)), span }
                    });
                }
            }
            _ => {
                let (value, height) = operand(part, place, diags, blocks);
                tokens.push(Token::Operand(value, height));
            }
        }
    }
    let too_long = |diags: &mut Vec<Diagnostic>| {
        diags.push(
            Diagnostic::error("HQ0195", whole, "this expression is too long")
                .note(format!("at most {MAX_OPERATORS} operators in a row, {MAX_HEIGHT} operations inside each other"))
                .help("name a part of it with `param`"),
        );
        (missing(whole), 1)
    };
    if operators > MAX_OPERATORS {
        return too_long(diags);
    }
    if let Some((at, span)) = equality {
        diags.push(
            Diagnostic::error("HQ0122", span, "numbers cannot be compared by `==` or `!=`")
                .note("two numbers that were computed differ by rounding where they should be equal")
                .help(tolerance(&tokens, at)),
        );
        return (missing(whole), 1);
    }
    let mut tokens = tokens.into_iter().peekable();
    let mut chain = None;
    let (value, height) = climb(&mut tokens, 0, whole, &mut chain);
    if let Some(span) = chain {
        diags.push(
            Diagnostic::error("HQ0122", span, "comparisons cannot be chained")
                .here("compares a truth value")
                .help("write `(a < b and b < c)`"),
        );
        return (missing(whole), 1);
    }
    if height > MAX_HEIGHT { too_long(diags) } else { (value, height) }
}

/// Replaces the last operand.
fn wrap(tokens: &mut [Token], f: impl FnOnce(Value) -> Value) {
    if let Some(Token::Operand(value, height)) = tokens.last_mut() {
        let inner = std::mem::replace(value, missing(value.span));
        *value = f(inner);
        *height += 1;
    }
}

/// Returns a named argument, and its height.
fn by_name(pair: Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>, blocks: BlockReader<'_>) -> (Value, u32) {
    let span = place.of(&pair);
    let mut parts = pair.into_inner();
    let (Some(name), Some(value)) = (parts.next(), parts.next()) else { return (missing(span), 1) };
    let (value, height) = expr(value, place, diags, blocks);
    (Value { kind: ValueKind::Named(place.spanned(&name), Box::new(value)), span }, height + 1)
}

/// Returns the value of one operand, and its height.
fn operand(pair: Pair<'_>, place: Place, diags: &mut Vec<Diagnostic>, blocks: BlockReader<'_>) -> (Value, u32) {
    let span = place.of(&pair);
    match pair.as_rule() {
        Rule::quantity => {
            let value = quantity(pair, place, diags);
            let height = if matches!(value.kind, ValueKind::Unit(..)) { 2 } else { 1 };
            (value, height)
        }
        Rule::text => (Value { kind: ValueKind::Text(unescape(&pair, place, diags)), span }, 1),
        Rule::name => (Value { kind: ValueKind::Name(pair.as_str().to_owned()), span }, 1),
        Rule::paren => match pair.into_inner().next() {
            Some(inner) => {
                let (mut value, height) = expr(inner, place, diags, blocks);
                value.span = span;
                (value, height)
            }
            None => (missing(span), 1),
        },
        Rule::call => {
            let mut parts = pair.into_inner();
            let name = parts.next().map_or_else(|| Spanned::new(String::new(), span), |p| place.spanned(&p));
            let mut height = 1;
            let mut args = Vec::new();
            for arg in parts.next().into_iter().flat_map(Pair::into_inner) {
                let (value, h) = if arg.as_rule() == Rule::by_name {
                    by_name(arg, place, diags, blocks)
                } else {
                    expr(arg, place, diags, blocks)
                };
                height = height.max(h + 1);
                args.push(value);
            }
            (Value { kind: ValueKind::Call(name, args), span }, height)
        }
        Rule::list => {
            let (mut items, mut height) = (Vec::new(), 1);
            for part in pair.into_inner() {
                if part.as_rule() == Rule::within {
                    let (value, h) = expr(part, place, diags, blocks);
                    height = height.max(h + 1);
                    items.push(value);
                } else {
                    items.push(blocks(part, diags));
                }
            }
            (Value { kind: ValueKind::List(items), span }, height)
        }
        _ => (missing(span), 1),
    }
}

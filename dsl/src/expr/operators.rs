//! Operators: their precedence, and the conversion of the grammar's flat lists to trees.

use super::missing;
use crate::print::expression;
use crate::tree::{BinaryOp, Value, ValueKind};
use crate::{Span, Spanned};

/// One element of a flat operator list.
pub(super) enum Token {
    Sign(Span),
    Not(Span),
    Op(BinaryOp, Span),
    Operand(Value, u32),
}

/// Returns the operator of a sign or word; `None` for `==` and `!=`, which the language does not have.
pub(super) fn operator(text: &str) -> Option<BinaryOp> {
    use BinaryOp::{Add, And, Div, Greater, GreaterEqual, Less, LessEqual, Mul, Or, Pow, Sub};
    [Add, Sub, Mul, Div, Pow, Less, LessEqual, Greater, GreaterEqual, And, Or].into_iter().find(|op| op.text() == text)
}

/// Proposes a comparison to replace the `==` or `!=` at an index of the list: with a tolerance in the unit of the
/// literal operand.
pub(super) fn tolerance(tokens: &[Token], at: usize) -> String {
    let operand = |at: Option<usize>| match tokens.get(at?) {
        Some(Token::Operand(value, _)) => Some(value),
        _ => None,
    };
    let tolerance = |value: &Value| match &value.kind {
        // Zero has any unit.
        ValueKind::Number(number) => number.text.contains(|c| ('1'..='9').contains(&c)).then(|| "0.001".to_owned()),
        ValueKind::Unit(of, unit) if matches!(of.kind, ValueKind::Number(_)) => Some(format!("0.001 {unit}")),
        _ => None,
    };
    let (left, right) = (operand(at.checked_sub(1)), operand(Some(at + 1)));
    let least = right.and_then(tolerance).or_else(|| left.and_then(tolerance));
    let both = left.zip(right).filter(|_| tokens.len() == 3);
    let (a, b) = both.map_or(("a".to_owned(), "b".to_owned()), |(a, b)| (expression(a), expression(b)));
    match least {
        Some(least) => format!("compare with a tolerance: `abs({a} - {b}) < {least}`"),
        None => format!("compare with a small number in the unit of both: `abs({a} - {b}) < TOLERANCE`"),
    }
}

/// Returns the binding power of an operator on its left and right side.
fn binding(op: BinaryOp) -> (u8, u8) {
    match op {
        BinaryOp::Or => (1, 2),
        BinaryOp::And => (3, 4),
        BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual => (6, 7),
        BinaryOp::Add | BinaryOp::Sub => (8, 9),
        BinaryOp::Mul | BinaryOp::Div => (10, 11),
        BinaryOp::Pow => (15, 14),
    }
}

const NOT: u8 = 5;
const SIGN: u8 = 12;

/// Precedence climbing over a list that the grammar has checked. `chain` is set to the location of a comparison of a
/// comparison.
pub(super) fn climb(
    tokens: &mut std::iter::Peekable<impl Iterator<Item = Token>>,
    least: u8,
    whole: Span,
    chain: &mut Option<Span>,
) -> (Value, u32) {
    let (mut left, mut height) = match tokens.next() {
        Some(Token::Operand(value, height)) => (value, height),
        Some(Token::Sign(span)) => {
            let (value, height) = climb(tokens, SIGN, whole, chain);
            let span = span.to(value.span);
            (Value { kind: ValueKind::Negate(Box::new(value)), span }, height + 1)
        }
        Some(Token::Not(span)) => {
            let (value, height) = climb(tokens, NOT, whole, chain);
            let span = span.to(value.span);
            (Value { kind: ValueKind::Not(Box::new(value)), span }, height + 1)
        }
        _ => (missing(whole), 1),
    };
    let mut compared = false;
    while let Some(Token::Op(op, span)) = tokens.peek() {
        let (op, span) = (*op, *span);
        let (before, after) = binding(op);
        if before < least {
            break;
        }
        tokens.next();
        if op.compares() && compared {
            chain.get_or_insert(span);
        }
        compared = op.compares();
        let (right, right_height) = climb(tokens, after, whole, chain);
        height = height.max(right_height) + 1;
        let all = left.span.to(right.span);
        let kind = ValueKind::Binary(Spanned::new(op, span), Box::new(left), Box::new(right));
        left = Value { kind, span: all };
    }
    (left, height)
}

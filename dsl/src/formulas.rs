//! Formulas of signal temporal logic: converts the flat lists of the grammar to trees; both readers share this file.

use crate::calls::ReadExpr;
use crate::explain::After;
use crate::expr::Place;
use crate::grammar::{Pair, Rule};
use crate::limits::MAX_OPERATORS;
use crate::tree::{Formula, FormulaKind, ValueKind, Window};
use crate::{Diagnostic, Span};
use std::iter::Peekable;

/// One element of a flat list.
enum Token {
    Temporal(Word, Window, Span),
    /// A window that is not preceded by a temporal operator.
    Window(Window),
    After(Span),
    Not(Span),
    Joined(Join),
    Until(Window),
    Colon(Span),
    Atom(Formula),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Word {
    Always,
    Eventually,
    Never,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Join {
    Implies,
    Or,
    And,
}

/// Precedences of the operators: one with a lower precedence ends an operand.
const IMPLIES: u8 = 1;
const UNTIL: u8 = 2;
const OR: u8 = 3;
const AND: u8 = 4;
const NOT: u8 = 5;

/// Converts a node `formula`.
pub(crate) fn formula(pair: Pair<'_>, place: Place, read: ReadExpr<'_>, diags: &mut Vec<Diagnostic>) -> Formula {
    let whole = place.of(&pair);
    let mut tokens = Vec::new();
    let mut operators = 0usize;
    for part in pair.into_inner() {
        let span = place.of(&part);
        let rule = part.as_rule();
        operators += usize::from(!matches!(rule, Rule::expr | Rule::in_brackets));
        let token = match rule {
            Rule::temporal => {
                let word = match part.as_str() {
                    text if text.starts_with("always") => Word::Always,
                    text if text.starts_with("never") => Word::Never,
                    _ => Word::Eventually,
                };
                Token::Temporal(word, first_window(part, place, &mut *read, diags), span)
            }
            Rule::window_ahead => Token::Window(first_window(part, place, &mut *read, diags)),
            Rule::until => Token::Until(first_window(part, place, &mut *read, diags)),
            Rule::whenever => Token::After(span),
            Rule::negation => Token::Not(span),
            Rule::colon => Token::Colon(span),
            Rule::joined => Token::Joined(match part.as_str() {
                "implies" => Join::Implies,
                "or" => Join::Or,
                _ => Join::And,
            }),
            Rule::in_brackets => {
                let inner = part.into_inner().next();
                let formula = inner.map_or(missing(span), |inner| formula(inner, place, &mut *read, diags));
                Token::Atom(Formula { span, ..formula })
            }
            _ => Token::Atom(Formula::of(read(part))),
        };
        tokens.push(token);
    }
    if operators > MAX_OPERATORS {
        diags.push(
            Diagnostic::error("HQ0195", whole, "this formula is too long")
                .note(format!("at most {MAX_OPERATORS} temporal and logical operators in a row"))
                .help("split it into several expectations"),
        );
        return missing(whole);
    }
    let mut climber = Climber { tokens: tokens.into_iter().peekable(), diags, end: Span { start: whole.end, ..whole } };
    let formula = climber.climb(IMPLIES);
    if let Some(Token::Colon(span)) = climber.tokens.next() {
        climber.diags.push(
            Diagnostic::error("HQ0143", span, "unexpected `:`")
                .note("a `:` follows a time window, and the condition of `after`")
                .help("write `after in(ask) : within 25 s : in(grasp)`"),
        );
        return missing(whole);
    }
    formula
}

/// Returns the context of text after a formula: its last value, and true if only a unit can follow it.
pub(crate) fn after(formula: Option<&Formula>) -> (After<'_>, bool) {
    use FormulaKind as F;
    let mut formula = formula;
    while let Some(it) = formula {
        formula = match &it.kind {
            F::Always(_, last) | F::Eventually(_, last) | F::Never(_, last) | F::Not(last) => Some(last),
            F::Until(_, _, last) | F::After(_, last) | F::And(_, last) | F::Or(_, last) | F::Implies(_, last) => {
                Some(last)
            }
            F::Value(value) => {
                let mut last = value;
                while let ValueKind::Binary(_, _, right) | ValueKind::Negate(right) = &last.kind {
                    last = right;
                }
                return (After::Value(value), matches!(last.kind, ValueKind::Number(_)));
            }
            F::Missing => None,
        };
    }
    (After::Start("a formula"), false)
}

fn missing(span: Span) -> Formula {
    Formula { kind: FormulaKind::Missing, span }
}

/// Returns the window in a node, or one without bounds.
fn first_window(pair: Pair<'_>, place: Place, read: ReadExpr<'_>, diags: &mut Vec<Diagnostic>) -> Window {
    let span = place.of(&pair);
    match pair.into_inner().find(|part| part.as_rule() == Rule::window) {
        Some(part) => window(part, place, read, diags),
        None => Window { span: Span { end: span.start, ..span }, ..Window::default() },
    }
}

/// Converts a node `window`.
fn window(pair: Pair<'_>, place: Place, read: ReadExpr<'_>, diags: &mut Vec<Diagnostic>) -> Window {
    let span = place.of(&pair);
    let mut window = Window { span, ..Window::default() };
    // The word that still needs its time.
    let mut open: Option<(&str, Span)> = None;
    let lacks = |open: Option<(&str, Span)>, diags: &mut Vec<Diagnostic>| {
        if let Some((word, span)) = open {
            let text = format!("`{word}` needs a time");
            diags.push(Diagnostic::error("HQ0143", span, text).help(format!("write for instance `{word} 25 s`")));
        }
    };
    let mut end = false;
    for part in pair.into_inner() {
        let at = place.of(&part);
        let word = match part.as_rule() {
            Rule::within_word => "within",
            Rule::from_word => "from",
            Rule::to_word => "to",
            _ => {
                let value = Some(read(part));
                if end {
                    window.to = value;
                } else {
                    window.from = value;
                }
                open = None;
                continue;
            }
        };
        lacks(open, diags);
        open = Some((word, at));
        end = word != "from";
    }
    lacks(open, diags);
    window
}

/// Precedence climbing over a flat list. Its recursion is bounded by the number of operators.
struct Climber<'d, I: Iterator<Item = Token>> {
    tokens: Peekable<I>,
    diags: &'d mut Vec<Diagnostic>,
    /// Position after the last word.
    end: Span,
}

impl<I: Iterator<Item = Token>> Climber<'_, I> {
    fn climb(&mut self, least: u8) -> Formula {
        let mut left = self.operand();
        loop {
            let level = match self.tokens.peek() {
                Some(Token::Joined(Join::Implies)) => IMPLIES,
                Some(Token::Until(..)) => UNTIL,
                Some(Token::Joined(Join::Or)) => OR,
                Some(Token::Joined(Join::And)) => AND,
                _ => return left,
            };
            if level < least {
                return left;
            }
            // `implies` and `until` are right-associative, the others left-associative.
            let next = self.tokens.next();
            let right = Box::new(self.climb(if level >= OR { level + 1 } else { level }));
            let span = left.span.to(right.span);
            let first = Box::new(left);
            let kind = match next {
                Some(Token::Until(window)) => FormulaKind::Until(first, window, right),
                Some(Token::Joined(Join::Implies)) => FormulaKind::Implies(first, right),
                Some(Token::Joined(Join::Or)) => FormulaKind::Or(first, right),
                _ => FormulaKind::And(first, right),
            };
            left = Formula { kind, span };
        }
    }

    fn operand(&mut self) -> Formula {
        match self.tokens.next() {
            Some(Token::Atom(formula)) => formula,
            Some(Token::Not(span)) => {
                let inner = self.climb(NOT);
                let span = span.to(inner.span);
                Formula { kind: FormulaKind::Not(Box::new(inner)), span }
            }
            Some(Token::Temporal(word, window, span)) => self.temporal(word, window, span),
            Some(Token::Window(window)) => self.windowed(window),
            Some(Token::After(span)) => self.after(span),
            _ => {
                let text = "expected a formula";
                self.diags.push(
                    Diagnostic::error("HQ0143", self.end, text)
                        .help("write a formula, for instance `margin(deck) >= 0 m` or `in(home)`"),
                );
                missing(self.end)
            }
        }
    }

    fn temporal(&mut self, word: Word, window: Window, span: Span) -> Formula {
        let inner = Box::new(self.climb(OR));
        let span = span.to(inner.span);
        let kind = match word {
            Word::Always => FormulaKind::Always(window, inner),
            Word::Eventually => FormulaKind::Eventually(window, inner),
            Word::Never => FormulaKind::Never(window, inner),
        };
        Formula { kind, span }
    }

    /// Applies a window to the temporal operator that follows it; `within D` alone means `eventually`.
    fn windowed(&mut self, window: Window) -> Formula {
        let start = window.span;
        if let Some(Token::Temporal(_, own, _)) = self.tokens.peek()
            && own.is_open()
            && let Some(Token::Temporal(word, _, span)) = self.tokens.next()
        {
            return self.temporal(word, window, start.to(span));
        }
        if window.from.is_some() {
            self.diags.push(
                Diagnostic::error("HQ0143", start, "this time window belongs to no temporal operator")
                    .help("write `always`, `eventually` or `never` before it, as in `always from 2 s to 5 s : ..`"),
            );
        }
        self.temporal(Word::Eventually, window, start)
    }

    /// Reads `after F : G`.
    fn after(&mut self, span: Span) -> Formula {
        let first = Box::new(self.climb(IMPLIES));
        if !matches!(self.tokens.peek(), Some(Token::Colon(_))) {
            self.diags.push(
                Diagnostic::error("HQ0143", span, "`after` lacks its `:`")
                    .note("the formula after `:` must hold from each time at which the condition becomes true")
                    .help("write `after in(ask) : within 25 s : in(grasp)`"),
            );
            return missing(span.to(first.span));
        }
        self.tokens.next();
        let then = Box::new(self.climb(OR));
        let span = span.to(then.span);
        Formula { kind: FormulaKind::After(first, then), span }
    }
}

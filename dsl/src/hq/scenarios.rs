//! Reader of scenarios and their expectations in `*.hq` texts.

use super::Reader;
use crate::explain;
use crate::grammar::{Pair, Rule};
use crate::tree::{Block, Comments, Expect, Formula, FormulaKind, Scenario};
use crate::{Diagnostic, Span, Spanned, checks, expr, formulas};

impl Reader<'_> {
    /// Reads `"bunch hidden by leaves" { .. }`; a body with a missing opening brace moves `end`.
    pub(super) fn scenario(
        &mut self,
        pair: Pair<'_>,
        keyword: Span,
        end: &mut usize,
        comments: &mut Comments,
    ) -> Option<Scenario> {
        let (mut name, mut mark, mut body, mut junk) = (None, None, None, Vec::new());
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                Rule::text => name = Some(self.literal(&part)),
                Rule::mark => mark = Some(self.of(&part)),
                Rule::scenario_body => body = Some(part),
                _ => junk.push(self.of(&part)),
            }
        }
        let name = self.needed_name(name, keyword);
        self.head(mark, &junk, "scenario");
        let mut read = (Block { span: keyword, ..Block::default() }, Vec::new());
        if let Some(body) = body {
            read = self.scenario_body(body, &mut comments.behind);
        } else if junk.is_empty()
            && let Some(block) = self.lost_brace("scenario", keyword, *end)
        {
            let base = std::mem::replace(&mut self.base, block.open);
            if let Some(pair) = block.pair(Rule::scenario_body) {
                read = self.scenario_body(pair, &mut comments.behind);
            }
            self.base = base;
            self.read = block.end;
            *end = block.end;
        }
        name.map(|name| Scenario { name, body: read.0, expects: read.1 })
    }

    /// Returns the content of a text literal.
    fn literal(&mut self, pair: &Pair<'_>) -> Spanned<String> {
        let (place, span) = (self.place(), self.of(pair));
        Spanned::new(expr::unescape(pair, place, &mut self.diags), span)
    }

    fn scenario_body(&mut self, pair: Pair<'_>, behind: &mut Option<String>) -> (Block, Vec<Expect>) {
        let span = self.of(&pair);
        self.pool.behind(span.range().start + 1, &[], behind);
        let (mut body, mut expects, mut open) = (Block { span, ..Block::default() }, Vec::new(), false);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::entry => self.entry(part, &mut body.entries),
                Rule::expect => expects.push(self.expect(part, "expect")),
                _ => open = true,
            }
        }
        if open {
            self.unclosed(span.range().start, span.range().end);
        } else {
            self.pool.before(span.range().end - 1, &mut body.closing_comments.before);
        }
        checks::duplicates(&body.entries, &mut self.diags);
        checks::reserved(&mut body, &["expect"], "scenario", &mut self.diags);
        (body, expects)
    }

    /// Reads `expect "hands stay" always error(hands) < 0.5 mm`, or another word and its formula.
    pub(super) fn expect(&mut self, pair: Pair<'_>, word: &str) -> Expect {
        let whole = self.of(&pair);
        let start = whole.range().start;
        let keyword = self.span(start, start + word.len());
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut label, mut formula, mut junk, mut told) = (None, None, None, false);
        let mut end = keyword.range().end;
        for part in pair.into_inner() {
            let at = self.of(&part);
            match part.as_rule() {
                Rule::text => label = Some(self.literal(&part)),
                Rule::formula => {
                    let (place, mut diags) = (self.place(), Vec::new());
                    formula = Some(formulas::formula(part, place, &mut |part| self.expr(part), &mut diags));
                    told = !diags.is_empty();
                    self.diags.extend(diags);
                }
                _ => {
                    junk = Some(at);
                    continue;
                }
            }
            end = at.range().end;
        }
        let span = self.span(start, start + self.text[start..end].trim_end().len());
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[',', ';'], &mut comments.behind);
        match (&formula, junk) {
            (_, Some(junk)) => {
                self.unread.push(junk);
                let (after, unit_only) = formulas::after(formula.as_ref());
                let (range, place) = (junk.range(), self.exact());
                let diagnostic = explain::junk(self.text, range.start, range.end, place, after, unit_only);
                if !told {
                    self.diags.push(diagnostic);
                }
            }
            (None, None) => self.diags.push(
                Diagnostic::error("HQ0143", keyword, format!("`{word}` has no formula")).help(match word {
                    "check" => "write a formula after it, for instance `check always not in(STATE)`",
                    _ => "write a formula after it, for instance `expect always margin(deck) >= 0 m`",
                }),
            ),
            _ => {}
        }
        let formula = formula.unwrap_or(Formula { kind: FormulaKind::Missing, span: keyword });
        Expect { label, formula, span, comments }
    }
}

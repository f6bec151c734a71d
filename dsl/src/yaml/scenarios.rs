//! Reader of scenarios and their expectations in YAML.

use std::collections::BTreeMap;

use super::Reader;
use super::events::{Kind, NodeId, Style};
use crate::diagnostic::clip;
use crate::explain;
use crate::expr::Place;
use crate::grammar::{Grammar, Rule};
use crate::tree::{Block, Comments, Expect, Formula, FormulaKind, Item, ItemKind, Scenario, Value, ValueKind};
use crate::{Diagnostic, Fix, Span, Spanned, checks, formulas};
use pest::Parser;

impl Reader<'_> {
    /// Reads `scenarios`: each below its name, which may be any text.
    pub(super) fn scenarios(&mut self, title: &Spanned<String>, id: NodeId, items: &mut Vec<Item>) {
        if self.is_null(id) {
            return;
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help = format!("write `NAME: ..` lines below `{}:`", clip(&title.value));
            return self.wrong_shape(id, "a mapping of names", &help);
        }
        let mut seen: BTreeMap<String, Span> = BTreeMap::new();
        for (key, value) in self.pairs(id) {
            let span = self.span(key);
            let name = self.scalar(key).map(|s| Spanned::new(s.0.to_owned(), span)).filter(|name| !name.is_empty());
            let Some(name) = name else {
                let diagnostic = Diagnostic::incomplete("HQ0116", span, "this scenario has no name");
                self.diags.push(diagnostic.help("write a word, or a text, before the `:`"));
                continue;
            };
            if let Some(first) = seen.get(&name.value) {
                self.diags.push(checks::duplicate(&name.value, *first, name.span));
                continue;
            }
            seen.insert(name.value.clone(), name.span);
            let mut comments = self.key_comments(span);
            let later = self.later(value, span);
            let kind = ItemKind::Scenario(self.scenario(name, value));
            self.pool.behind(later.range().end, &[','], &mut comments.behind);
            items.push(Item { kind, span: span.to(later), comments });
        }
    }

    fn scenario(&mut self, name: Spanned<String>, id: NodeId) -> Scenario {
        let mut body = Block { span: self.span(id), ..Block::default() };
        let mut expects = Vec::new();
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help = "write `machine: NAME`, `duration: 10 s` and `expect: [..]` below the name";
            if self.is_null(id) {
                let text = format!("the scenario `{}` is empty", clip(&name.value));
                self.diags.push(Diagnostic::incomplete("HQ0117", name.span, text).help(help));
            } else {
                self.wrong_shape(id, "a mapping with the parts of the scenario", help);
            }
            return Scenario { name, body, expects };
        }
        for (key, value) in self.distinct(id) {
            if key.value == "expect" {
                expects = self.expects(&key, value);
            } else {
                let entry = self.setting(key, value);
                body.entries.push(entry);
            }
        }
        self.closing(id, &mut body.closing_comments);
        checks::reserved(&mut body, &["expect"], "scenario", &mut self.diags);
        Scenario { name, body, expects }
    }

    /// Reads one expectation, or a sequence of them.
    pub(super) fn expects(&mut self, key: &Spanned<String>, id: NodeId) -> Vec<Expect> {
        let Kind::Sequence(items) = &self.node(id).kind else {
            let mut comments = self.key_comments(key.span);
            return self.expect(id, key, &mut comments).into_iter().collect();
        };
        let mut all = Vec::new();
        for item in items.clone() {
            let mut comments = Comments::default();
            self.pool.before(self.span(item).range().start, &mut comments.before);
            all.extend(self.expect(item, key, &mut comments));
        }
        all
    }

    /// Reads a formula, or `label: formula`.
    fn expect(&mut self, id: NodeId, key: &Spanned<String>, comments: &mut Comments) -> Option<Expect> {
        if !self.enter(id) {
            return None;
        }
        let span = self.span(id);
        let (mut label, mut said) = (None, id);
        let help = "write a formula such as `always margin(deck) >= 0 m`, or `\"LABEL\": FORMULA`, in quotes where it has a `:`";
        if matches!(self.node(id).kind, Kind::Mapping(_)) {
            let pairs = self.pairs(id);
            let one = match pairs.as_slice() {
                [(key, value)] => self.scalar(*key).map(|s| (s.0.to_owned(), *key, *value)),
                _ => None,
            };
            let Some((text, at, value)) = one else {
                self.wrong_shape(id, "a formula, or one label and its formula,", help);
                return None;
            };
            self.formula_as_label((at, value));
            label = Some(Spanned::new(text, self.span(at)));
            said = value;
        }
        let formula = if self.is_null(said) {
            let diagnostic = Diagnostic::error("HQ0143", self.later(said, key.span), "expected a formula");
            self.diags.push(diagnostic.help(help));
            Formula { kind: FormulaKind::Missing, span }
        } else if self.scalar(said).is_some() {
            self.formula(said)
        } else {
            self.wrong_shape(said, "a formula", help);
            Formula { kind: FormulaKind::Missing, span }
        };
        self.pool.before(span.range().end, &mut comments.before);
        self.pool.behind(span.range().end, &[',', '}'], &mut comments.behind);
        Some(Expect { label, formula, span, comments: std::mem::take(comments) })
    }

    /// Warns of a formula with a `:` and without quotes, whose beginning YAML takes for the label.
    fn formula_as_label(&mut self, ids: (NodeId, NodeId)) {
        let (Some((label, Style::Plain)), Some((rest, Style::Plain))) = (self.scalar(ids.0), self.scalar(ids.1)) else {
            return;
        };
        let (label, rest) = (label.to_owned(), rest.to_owned());
        let begins = |text: &str, words: &[&str]| text.split([' ', '(']).next().is_some_and(|w| words.contains(&w));
        // A formula of its own may have a label that sounds like one.
        let words = ["always", "eventually", "never", "within", "from", "to", "after", "until"];
        let joined = format!("{label} : {rest}");
        if !begins(&label, &words) || begins(&rest, &words) || !self.is_formula(&joined) {
            return;
        }
        let at = self.span(ids.0).to(self.span(ids.1));
        let d = Diagnostic::warning("HQ0138", at, format!("`{label}` is read as a label"));
        let fix = Fix::replace(at, format!("\"{joined}\""));
        let d = d.here(format!("the formula is `{rest}` alone"));
        self.diags.push(d.help(format!("put the whole formula in quotes: `\"{joined}\"`")).fix(fix));
    }

    /// Returns true for a formula without mistakes, in which a window has numbers.
    fn is_formula(&mut self, text: &str) -> bool {
        let before = self.diags.len();
        let Some(parsed) = Grammar::parse(Rule::scalar_formula, text).ok().and_then(|mut p| p.next()) else {
            return false;
        };
        let place = Place::Whole(Span::default());
        let (mut diags, mut found) = (Vec::new(), None);
        for part in parsed.into_inner().filter(|part| part.as_rule() == Rule::formula) {
            let end = part.as_span().end();
            let formula = formulas::formula(part, place, &mut |part| self.flat(part, place), &mut diags);
            found = Some((formula, end));
        }
        let mistakes = self.diags.len() > before || !diags.is_empty();
        self.diags.truncate(before);
        found.is_some_and(|(formula, end)| {
            let names = |time: &Option<Value>| time.as_ref().is_some_and(|t| matches!(t.kind, ValueKind::Name(_)));
            let named = match &formula.kind {
                FormulaKind::Always(w, _) | FormulaKind::Eventually(w, _) | FormulaKind::Never(w, _) => {
                    names(&w.from) || names(&w.to)
                }
                _ => false,
            };
            !mistakes && !named && text[end..].trim().is_empty()
        })
    }

    /// Reads a scalar as a formula.
    fn formula(&mut self, id: NodeId) -> Formula {
        let span = self.span(id);
        let (text, place) = self.spelled(id);
        let missing = Formula { kind: FormulaKind::Missing, span };
        if let Some(diagnostic) = self.unfit(&text, place) {
            self.diags.push(diagnostic);
            return missing;
        }
        let Some(parsed) = Grammar::parse(Rule::scalar_formula, &text).ok().and_then(|mut p| p.next()) else {
            return missing;
        };
        let (mut formula, mut rest, mut told) = (None, text.len(), false);
        for part in parsed.into_inner() {
            if part.as_rule() == Rule::formula {
                let mut diags = Vec::new();
                formula = Some(formulas::formula(part, place, &mut |part| self.flat(part, place), &mut diags));
                told = !diags.is_empty();
                self.diags.extend(diags);
            } else {
                rest = part.as_span().start();
            }
        }
        if !text[rest..].trim().is_empty() {
            let (after, unit_only) = formulas::after(formula.as_ref());
            let diagnostic = explain::junk(&text, rest, text.len(), place, after, unit_only);
            if !told {
                self.diags.push(diagnostic);
            }
        } else if formula.is_none() {
            let diagnostic = Diagnostic::error("HQ0143", span, "expected a formula");
            self.diags.push(diagnostic.help("write a formula, for instance `always margin(deck) >= 0 m`"));
        }
        formula.unwrap_or(missing)
    }
}

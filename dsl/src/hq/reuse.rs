//! Reader of declarations that use others, in `*.hq` texts: `import`, `let`, `for`, parameters of declarations, `from`.

use super::Reader;
use super::parts::Parts;
use crate::calls;
use crate::explain::After;
use crate::grammar::{Pair, Rule};
use crate::tree::{Call, Comments, Entry, Import, ImportName, Item, Let, Parameter, RepeatItems, Value, Values};
use crate::{Diagnostic, Span, Spanned};

/// The parts of `for NAME in VALUES { .. }`.
#[derive(Default)]
pub(super) struct Head<'p> {
    pub variable: Option<Spanned<String>>,
    pub values: Option<Values>,
    pub body: Option<Pair<'p>>,
    pub junk: Option<Span>,
}

impl<'t> Reader<'t> {
    /// Converts a node `formals`.
    pub(super) fn parameters(&mut self, pair: Pair<'_>) -> Vec<Parameter> {
        let (place, mut diags) = (self.place(), Vec::new());
        let out = calls::parameters(pair, place, &mut |part| self.expr(part), &mut diags);
        self.diags.extend(diags);
        out
    }

    /// Converts a node `actuals`.
    pub(super) fn arguments(&mut self, pair: Pair<'_>) -> (Vec<Value>, Vec<Entry>) {
        let (place, mut diags) = (self.place(), Vec::new());
        let out = calls::arguments(pair, place, &mut |part| self.expr(part), &mut diags);
        self.diags.extend(diags);
        out
    }

    /// Converts a node `from`: `from guarded(left)`.
    pub(super) fn from(&mut self, pair: Pair<'_>, what: &str) -> Option<Call> {
        let whole = self.of(&pair);
        let (mut name, mut args, mut named) = (None, Vec::new(), Vec::new());
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(self.place().spanned(&part)),
                _ => (args, named) = self.arguments(part),
            }
        }
        let Some(name) = name else {
            let word = Span::new(whole.source, whole.range().start, whole.range().start + "from".len());
            self.diags.push(
                Diagnostic::incomplete("HQ0116", word, format!("`from` names no {what}"))
                    .help(format!("write the name of the {what} after `from`")),
            );
            return None;
        };
        let span = Span::new(whole.source, name.span.range().start, whole.range().end);
        Some(Call { name, args, named, span })
    }

    pub(super) fn let_(&mut self, parts: Parts<'_>, keyword: Span, comments: &mut Comments) -> Option<Let> {
        let (name, value) = self.named_value(parts, keyword, "let", comments);
        name.map(|name| Let { name, value })
    }

    pub(super) fn import(&mut self, pair: Pair<'_>, keyword: Span, comments: &mut Comments) -> Option<Import> {
        let form = "write `import \"common/safety.hq\" { deck }`";
        let (mut path, mut body, mut junk) = (None, None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::text => {
                    let span = self.of(&part);
                    path = Some(Spanned::new(crate::expr::unescape(&part, self.place(), &mut self.diags), span));
                }
                Rule::junk => junk = Some(self.of(&part)),
                _ => body = Some(part),
            }
        }
        if path.is_none() {
            let at = junk.filter(|_| body.is_none()).unwrap_or(keyword);
            self.diags.push(Diagnostic::error("HQ0124", at, "an import names a file, in quotes").help(form));
        } else if let Some(junk) = junk {
            let help = format!("{form}, with the names that you need");
            self.diags.push(
                Diagnostic::error("HQ0124", junk, "the names to import must be in braces after the file").help(help),
            );
        } else if body.is_none() {
            let help = format!("{form}, with the names that you need");
            self.diags.push(Diagnostic::error("HQ0124", keyword, "this import names nothing to import").help(help));
        }
        let (mut names, mut closing_comments) = (Vec::new(), Comments::default());
        if let Some(body) = body {
            let span = self.of(&body);
            self.pool.before(span.range().start, &mut comments.before);
            self.pool.behind(span.range().start + 1, &[], &mut comments.behind);
            let mut open = false;
            for part in body.into_inner() {
                match part.as_rule() {
                    Rule::import_name => names.extend(self.import_name(part)),
                    _ => open = true,
                }
            }
            if open {
                self.unclosed(span.range().start, span.range().end);
            } else {
                self.pool.before(span.range().end - 1, &mut closing_comments.before);
            }
        }
        Some(Import { path: path?, names, closing_comments })
    }

    fn import_name(&mut self, pair: Pair<'_>) -> Option<ImportName> {
        let whole = self.of(&pair);
        let mut comments = Comments::default();
        self.pool.before(whole.range().start, &mut comments.before);
        let (mut name, mut alias) = (None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name if name.is_none() => name = Some(self.place().spanned(&part)),
                Rule::name => alias = Some(self.place().spanned(&part)),
                _ => {
                    self.junk(self.of(&part), After::Start("a name, or `NAME as NAME`,"));
                }
            }
        }
        self.pool.before(whole.range().end, &mut comments.before);
        self.pool.behind(whole.range().end, &[',', ';'], &mut comments.behind);
        Some(ImportName { name: name?, alias, comments })
    }

    /// Converts the head of a repetition, of declarations or of members.
    pub(super) fn repeat_head<'p>(&mut self, pair: Pair<'p>, keyword: Span) -> Head<'p> {
        let mut head = Head::default();
        let mut has_in = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => head.variable = Some(self.place().spanned(&part)),
                Rule::in_word => has_in = true,
                Rule::values => {
                    let place = self.place();
                    head.values = Some(calls::values(part, place, &mut |expr| self.expr(expr)));
                }
                Rule::junk | Rule::head_junk => head.junk = Some(self.of(&part)),
                _ => head.body = Some(part),
            }
        }
        let form = "write `for NAME in [a, b] { .. }`, or `for NAME in 1..4 { .. }`";
        if head.variable.is_none() {
            self.diags.push(calls::incomplete(keyword, "name").help(form));
        } else if !has_in || head.values.is_none() {
            self.diags.push(calls::incomplete(keyword, "values").help(form));
        }
        if let Some(junk) = head.junk {
            self.junk(junk, After::Start("a block in braces"));
        } else if head.body.is_none() {
            self.diags.push(
                Diagnostic::incomplete("HQ0117", keyword, "this `for` has no block")
                    .help("write `{ .. }` after its values"),
            );
        }
        head
    }

    pub(super) fn repeat(&mut self, pair: Pair<'_>, keyword: Span, comments: &mut Comments) -> Option<RepeatItems> {
        let head = self.repeat_head(pair, keyword);
        let (mut body, mut closing_comments) = (Vec::new(), Comments::default());
        if let Some(part) = head.body {
            let span = self.of(&part);
            self.pool.before(span.range().start, &mut comments.before);
            self.pool.behind(span.range().start + 1, &[], &mut comments.behind);
            let mut open = false;
            for part in part.into_inner() {
                match part.as_rule() {
                    Rule::unclosed => open = true,
                    _ => self.repeated(part, &mut body),
                }
            }
            if open {
                self.unclosed(span.range().start, span.range().end);
                if let Some(last) = self.diags.last_mut() {
                    last.help = Some("write the missing `}`; the contents of a `for` are indented".into());
                }
            } else {
                self.pool.before(span.range().end - 1, &mut closing_comments.before);
            }
        }
        Some(RepeatItems { variable: head.variable?, values: head.values?, body, closing_comments })
    }

    /// Reads a declaration inside a repetition.
    fn repeated(&mut self, pair: Pair<'_>, body: &mut Vec<Item>) {
        if matches!(pair.as_rule(), Rule::import | Rule::robot | Rule::run) {
            let start = self.of(&pair).range().start;
            let word = pair.as_str().split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or("").to_owned();
            let span = self.span(start, start + word.len());
            self.diags.push(
                Diagnostic::error("HQ0125", span, format!("`{word}` cannot be repeated"))
                    .note(
                        "`for` can repeat `param`, `let`, `task`, `stack`, `signal`, `human`, `safety_field`, `obstacle`, `variable`, `machine`, `mission`, `scenario`, `coverage` and `for`",
                    )
                    .help("write it outside the `for`"),
            );
            return;
        }
        let outer = std::mem::replace(&mut self.nested, true);
        self.item(pair, body);
        self.nested = outer;
    }
}

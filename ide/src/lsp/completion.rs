//! Completion. A marker is inserted at the cursor and the text is resolved: the position of the marker in the tree is
//! the completion context. The same code handles both syntaxes and incomplete texts.

use std::ops::Range;

use compiler::resolve::{
    BUILT_IN, CURSOR, CompletionContext, FAULTS, Formal, MEASURED, PRESENT, Resolution, SymbolKind, TRIGGERS,
};
use compiler::sections::{ALLOW, Argument, BlockSchema, InSyntax, SPEC};
use dsl::Syntax;
use dsl::vocabulary::UNITS;
use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionTextEdit, Documentation, MarkupContent, MarkupKind, TextEdit,
};
use stdlib_tasks::KINDS;
use stdlib_tasks::params::{ParamInfo, Presence};

use super::allowances;
use super::document::Document;
use super::hover;
use crate::catalogue::{self, describe};
use crate::keys;

/// Completion items at a byte.
pub(super) fn of(document: &Document, byte: usize) -> Option<Vec<CompletionItem>> {
    let syntax = document.syntax()?;
    let text = document.text.as_str();
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let start = text[..byte].trim_end_matches(part).len();
    let end = text.len() - text[byte..].trim_start_matches(part).len();
    let line = &text[text[..start].rfind('\n').map_or(0, |n| n + 1)..start];
    if in_comment(line, syntax) || text[start..byte].starts_with(|c: char| c.is_ascii_digit()) {
        return Some(Vec::new());
    }
    if let Some(codes) = allowances::codes(document, start) {
        let mut list = List { document, range: start..byte, colon: syntax == Syntax::Yaml, items: Vec::new() };
        for page in codes {
            list.add(page.code, CompletionItemKind::PROPERTY, 0, page.title, page.text.to_string());
        }
        return Some(list.items);
    }
    let mut list = List { document, range: start..byte, colon: syntax == Syntax::Yaml, items: Vec::new() };
    let before = line.trim_end_matches([' ', '\t']);
    let unit = before.ends_with(|c: char| c.is_ascii_digit() || matches!(c, ')' | ']')) && before != line
        || before.ends_with('/');
    if unit {
        list.units();
    }
    match imagined(document, start..end, syntax) {
        Some((_, CompletionContext::Expression { .. })) if unit => {}
        Some((names, context)) => list.context(&names, &context),
        None if top_level(&text[..start], line, syntax) => {
            list.keys(&SPEC, &[]);
        }
        None => {}
    }
    Some(list.items)
}

/// Parses the text with the marker in place of the current word.
fn imagined(document: &Document, word: Range<usize>, syntax: Syntax) -> Option<(Resolution, CompletionContext)> {
    let text = document.text.as_str();
    let read = |behind: &str| {
        let marked = [&text[..word.start], CURSOR, behind, &text[word.end..]].concat();
        let mut names = document.imagine(&marked)?;
        let context = names.context.take()?;
        Some((names, context))
    };
    if syntax == Syntax::Yaml {
        // A key is recognised only with its colon.
        return read("").or_else(|| read(":"));
    }
    let found = read("")?;
    // Without a value, a key would take the next key as its value.
    if matches!(found.1, CompletionContext::Keys(..) | CompletionContext::Parameters(..) | CompletionContext::Joint(_))
    {
        return read(" \"\"").or(Some(found));
    }
    Some(found)
}

/// True if the rest of a line is a comment. Both kinds of quotes may contain comment signs.
fn in_comment(line: &str, syntax: Syntax) -> bool {
    let mut quote = None;
    let mut last = ' ';
    for c in line.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (Some(_), _) => {}
            (None, '"') => quote = Some('"'),
            (None, '\'') if syntax == Syntax::Yaml => quote = Some('\''),
            (None, '/') if syntax == Syntax::Native && last == '/' => return true,
            (None, '#') if syntax == Syntax::Yaml && last.is_whitespace() => return true,
            _ => {}
        }
        last = c;
    }
    false
}

/// True if a declaration could start: at the beginning of a line, outside of all braces.
fn top_level(before: &str, line: &str, syntax: Syntax) -> bool {
    if syntax == Syntax::Yaml {
        return line.is_empty();
    }
    let mut depth = 0usize;
    for l in before.lines() {
        let code = l.split("//").next().unwrap_or("");
        for c in code.chars() {
            match c {
                '{' | '[' | '(' => depth += 1,
                '}' | ']' | ')' => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
    }
    depth == 0 && line.trim().is_empty()
}

/// Items under construction.
struct List<'d> {
    document: &'d Document,
    range: Range<usize>,
    /// True if a colon follows keys.
    colon: bool,
    items: Vec<CompletionItem>,
}

fn markdown(value: String) -> Option<Documentation> {
    (!value.is_empty()).then_some(Documentation::MarkupContent(MarkupContent { kind: MarkupKind::Markdown, value }))
}

impl List<'_> {
    /// Adds an item. Items are sorted by `rank`, smallest first.
    fn add(&mut self, label: &str, kind: CompletionItemKind, rank: usize, detail: &str, doc: String) {
        let colon = self.colon && kind == CompletionItemKind::PROPERTY;
        let new = if colon { format!("{label}: ") } else { label.to_string() };
        self.items.push(CompletionItem {
            label: label.to_string(),
            kind: Some(kind),
            detail: (!detail.is_empty()).then(|| detail.to_string()),
            documentation: markdown(doc),
            sort_text: Some(format!("{rank:02}{label}")),
            // Neovim does not filter items with an edit unless `filter_text` is set.
            filter_text: Some(label.to_string()),
            text_edit: Some(CompletionTextEdit::Edit(TextEdit::new(self.document.text.range(self.range.clone()), new))),
            ..CompletionItem::default()
        });
    }

    fn context(&mut self, names: &Resolution, context: &CompletionContext) {
        use CompletionContext as C;
        match context {
            C::Keys(section, used) => self.keys(section, used),
            C::Parameters(infos, used) => self.parameters(infos, used),
            C::NamedParameters(infos, used) => {
                self.colon = true;
                self.parameters(infos, used);
            }
            C::Limits(of, given) => {
                self.colon = true;
                for n in of.named.iter().filter(|n| !given.iter().any(|g| g == n.name)) {
                    self.add(n.name, CompletionItemKind::PROPERTY, 0, "", n.text.to_string());
                }
                self.expression(names, false, false);
            }
            C::Words(words) => {
                for word in *words {
                    self.add(word, CompletionItemKind::ENUM_MEMBER, 0, "", String::new());
                }
            }
            C::Outputs(all) => {
                for output in *all {
                    let (dimension, text) = (output.dimension.to_string(), output.description.to_string());
                    self.add(output.name, CompletionItemKind::PROPERTY, 0, &dimension, text);
                }
            }
            C::TaskType => self.kinds(0),
            C::Member => {
                self.names(names, SymbolKind::Task, 0);
                self.kinds(1);
            }
            C::Symbols(kinds) => kinds.iter().for_each(|kind| self.symbols(names, *kind)),
            C::Offered(all) => {
                for offered in all {
                    self.add(&offered.name, CompletionItemKind::VARIABLE, 0, offered.about, String::new());
                }
            }
            C::Argument(ty, left) => self.argument(names, ty.as_deref(), left),
            C::Expression { auto, state, arguments } => {
                self.arguments(arguments);
                self.expression(names, *auto, *state);
            }
            C::Expectation => {
                let measured: Vec<&str> = MEASURED.iter().map(|w| w.name).collect();
                self.built_in(&measured, 0);
                self.expression(names, false, true);
            }
            C::Condition => {
                self.built_in(compiler::expr::MOTION, 0);
                self.built_in(&[compiler::expr::REACHED], 0);
                self.expression(names, false, true);
            }
            C::Captured(values, prefix) => {
                for actual in *values {
                    match actual.name.strip_prefix(prefix.as_str()) {
                        Some("*") if prefix.is_empty() => {
                            self.add("angle", CompletionItemKind::FIELD, 0, "angle.ARM", String::new());
                        }
                        Some(rest) if rest != "*" => {
                            self.add(rest, CompletionItemKind::FIELD, 0, "value of the task", String::new());
                        }
                        _ => {}
                    }
                }
                if prefix.is_empty() {
                    self.built_in(PRESENT, 1);
                    self.built_in(&functions(), 2);
                }
            }
            C::Events { triggers } => self.events(names, *triggers),
            C::Faults => {
                for fault in FAULTS {
                    self.add(fault.name, CompletionItemKind::ENUM_MEMBER, 0, "fault", fault.doc.to_string());
                }
            }
            C::Verbs => {
                for verb in compiler::VERBS {
                    self.add(verb.name, CompletionItemKind::FUNCTION, 0, verb.form, hover::verb(verb));
                }
            }
            C::Unit => self.units(),
            C::Geometry { arms, people } => self.geometry(names, *arms, *people),
            C::Joint(used) => self.joints(names, used),
            C::Nothing => {}
        }
    }

    fn geometry(&mut self, names: &Resolution, arms: bool, people: bool) {
        for kind in [SymbolKind::Point, SymbolKind::Segment, SymbolKind::Group] {
            self.names(names, kind, 0);
        }
        let doc = "All links with collision shapes.".to_string();
        self.add("all", CompletionItemKind::VARIABLE, 1, "group", doc);
        // A chain of an SRDF has no points.
        let declared: Vec<&str> = names
            .visible(SymbolKind::Arm)
            .filter(|(_, id)| names.file_of(*id).syntax.is_some())
            .map(|(arm, _)| arm)
            .collect();
        if !declared.is_empty() {
            let doc = "All `points` of all arms.".to_string();
            self.add("arms", CompletionItemKind::VARIABLE, 0, "group", doc);
            for arm in declared {
                self.add(&format!("arms.{arm}"), CompletionItemKind::VARIABLE, 0, "group", String::new());
            }
        }
        if arms {
            self.names(names, SymbolKind::Arm, 0);
        }
        if people {
            self.names(names, SymbolKind::Human, 0);
        }
        self.symbols(names, SymbolKind::Link);
    }

    fn keys(&mut self, section: &'static BlockSchema, used: &[String]) {
        let syntax = if self.colon { Syntax::Yaml } else { Syntax::Native };
        for key in section.written(syntax).filter(|k| !used.iter().any(|u| u == k.name)) {
            self.add(key.name, CompletionItemKind::PROPERTY, 0, &keys::describe(&key.value), hover::key(key));
        }
        self.allow();
    }

    /// The key of every block.
    fn allow(&mut self) {
        if !self.items.iter().any(|item| item.label == ALLOW.name) {
            self.add(ALLOW.name, CompletionItemKind::PROPERTY, 3, "a warning that is intended", hover::key(&ALLOW));
        }
    }

    fn parameters(&mut self, infos: &[ParamInfo], used: &[String]) {
        for info in infos.iter().filter(|i| !used.iter().any(|u| u == i.name)) {
            let rank = usize::from(info.presence != Presence::Required);
            let detail = describe(&info.ty);
            self.add(info.name, CompletionItemKind::PROPERTY, rank, &detail, hover::parameter(info));
        }
        self.allow();
    }

    /// Candidates for the next argument of a declaration with parameters.
    fn argument(&mut self, names: &Resolution, ty: Option<&str>, left: &[Formal]) {
        match ty {
            Some("arm") => self.symbols(names, SymbolKind::Arm),
            Some("frame") => {
                self.symbols(names, SymbolKind::Arm);
                self.symbols(names, SymbolKind::Link);
            }
            Some("joints") => self.joints(names, &[]),
            Some("geometry") => self.geometry(names, false, false),
            Some("task") => self.context(names, &CompletionContext::Member),
            Some("name") | None => {}
            Some(_) => self.expression(names, false, false),
        }
        self.colon = true;
        for formal in left {
            let rank = if formal.optional { 2 } else { 1 };
            self.add(&formal.name, CompletionItemKind::PROPERTY, rank, &formal.ty, String::new());
        }
    }

    fn kinds(&mut self, rank: usize) {
        for kind in KINDS {
            self.add(kind.name, CompletionItemKind::CLASS, rank, kind.summary, hover::task_kind(kind));
        }
    }

    fn names(&mut self, names: &Resolution, kind: SymbolKind, rank: usize) {
        for (name, _) in names.visible(kind) {
            self.add(name, CompletionItemKind::VARIABLE, rank, kind.word(), String::new());
        }
    }

    /// Symbols of a kind; links, of which there are many, after the others.
    fn symbols(&mut self, names: &Resolution, kind: SymbolKind) {
        match kind {
            SymbolKind::Link => self.parts(names, kind, &[]),
            _ => self.names(names, kind, 0),
        }
    }

    fn built_in(&mut self, names: &[&str], rank: usize) {
        for name in names {
            self.add(name, CompletionItemKind::FUNCTION, rank, "", hover::built_in(name).unwrap_or_default());
        }
    }

    /// Arguments of a function.
    fn arguments(&mut self, arguments: &[Argument]) {
        for argument in arguments {
            let unit = catalogue::unit(argument.dimension);
            self.add(argument.name, CompletionItemKind::VARIABLE, 0, &unit, argument.doc.to_string());
        }
    }

    fn expression(&mut self, names: &Resolution, auto: bool, state: bool) {
        if auto {
            self.add("auto", CompletionItemKind::ENUM_MEMBER, 0, "worked out by the task", String::new());
        }
        use SymbolKind::{Human, Let, Param, Signal, Variable};
        [Param, Let, Signal, Variable, Human].into_iter().for_each(|kind| self.names(names, kind, 0));
        let known = BUILT_IN.iter().map(|k| k.name).filter(|n| state || !PRESENT.contains(n));
        let known: Vec<&str> = known.collect();
        self.built_in(&known, 1);
        let functions = functions();
        self.built_in(&functions, 2);
    }

    /// Events that signals and actions raise; if `triggers`, all triggers of a transition.
    fn events(&mut self, names: &Resolution, triggers: bool) {
        self.names(names, SymbolKind::Event, 0);
        let raised = [SymbolKind::RaisedEvent, SymbolKind::Outcome].into_iter().flat_map(|kind| names.visible(kind));
        for (name, id) in raised.filter(|(name, _)| names.named(SymbolKind::Event, name).is_none()) {
            let about = hover::symbol(names, id).unwrap_or_default();
            self.add(name, CompletionItemKind::EVENT, 0, SymbolKind::RaisedEvent.word(), about);
        }
        for trigger in TRIGGERS.iter().filter(|_| triggers) {
            self.add(trigger.name, CompletionItemKind::FUNCTION, 1, "", trigger.doc.to_string());
        }
    }

    fn units(&mut self) {
        for unit in UNITS {
            self.add(unit, CompletionItemKind::UNIT, 3, &hover::unit(unit).unwrap_or_default(), String::new());
        }
    }

    /// Links or joints of the URDF that a spec can name.
    fn parts(&mut self, names: &Resolution, kind: SymbolKind, used: &[String]) {
        for (name, id) in names.visible(kind).filter(|(name, _)| used.iter().all(|u| u != name)) {
            let part = names.symbol(id);
            if !["fixed", "mimic"].contains(&part.ty.as_str()) {
                self.add(name, CompletionItemKind::REFERENCE, 1, "", part.doc.concat());
            }
        }
    }

    fn joints(&mut self, names: &Resolution, used: &[String]) {
        for (group, _) in names.visible(SymbolKind::JointGroup).filter(|(name, _)| used.iter().all(|u| u != name)) {
            self.add(group, CompletionItemKind::VARIABLE, 0, SymbolKind::JointGroup.word(), String::new());
        }
        self.parts(names, SymbolKind::Joint, used);
        for (name, doc) in [("all", "every joint"), ("base", "what carries the root link")] {
            self.add(name, CompletionItemKind::VARIABLE, 2, doc, String::new());
        }
    }
}

/// Names of all functions.
fn functions() -> Vec<&'static str> {
    let trajectories = compiler::expr::TRAJECTORIES.iter().map(|t| t.name);
    compiler::expr::FUNCTIONS.iter().map(|f| f.name).chain(trajectories).collect()
}

//! Completion. A marker is inserted at the cursor and the text is parsed: the position of the marker in the tree
//! determines the candidates. The same code handles both syntaxes and incomplete texts.

use std::collections::BTreeMap;
use std::ops::Range;

use compiler::sections::{SPEC, Section};
use dsl::Syntax;
use dsl::vocabulary::UNITS;
use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionTextEdit, Documentation, MarkupContent, MarkupKind, TextEdit,
};
use stdlib_tasks::KINDS;
use stdlib_tasks::params::{ParamInfo, Presence};

use super::document::Document;
use super::hover;
use super::mentions::{Class, MARKER, Mentions, Slot, Taken};
use super::urdf::Part;
use super::vocabulary::{BUILT_IN, FAULTS, FRAME_FIELDS, MEASURED, PRESENT, TRIGGERS, VALUE_FIELDS};
use crate::catalogue::describe;
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
    let mut list = List { document, range: start..byte, colon: syntax == Syntax::Yaml, items: Vec::new() };
    let before = line.trim_end_matches([' ', '\t']);
    let unit = before.ends_with(|c: char| c.is_ascii_digit() || matches!(c, ')' | ']')) && before != line
        || before.ends_with('/');
    if unit {
        list.units();
    }
    match imagined(document, start..end, syntax) {
        Some((_, Slot::Expression { .. })) if unit => {}
        Some((mentions, slot)) => list.slot(&mentions, &slot),
        None if top_level(&text[..start], line, syntax) => {
            list.keys(&SPEC, &[]);
        }
        None => {}
    }
    Some(list.items)
}

/// Parses the text with the marker in place of the current word.
fn imagined(document: &Document, word: Range<usize>, syntax: Syntax) -> Option<(Mentions, Slot)> {
    let text = document.text.as_str();
    let read = |behind: &str| {
        let marked = [&text[..word.start], MARKER, behind, &text[word.end..]].concat();
        let mut mentions = document.imagine(&marked)?;
        let slot = mentions.slot.take()?;
        Some((mentions, slot))
    };
    if syntax == Syntax::Yaml {
        // A key is recognised only with its colon.
        return read("").or_else(|| read(":"));
    }
    let found = read("")?;
    // Without a value, a key would take the next key as its value.
    if matches!(found.1, Slot::Keys(..) | Slot::Parameters(..) | Slot::JointKey(_)) {
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

    fn slot(&mut self, mentions: &Mentions, slot: &Slot) {
        match slot {
            Slot::Keys(section, used) => self.keys(section, used),
            Slot::Parameters(infos, used) => self.parameters(infos, used),
            Slot::Named(infos, used) => {
                self.colon = true;
                self.parameters(infos, used);
            }
            Slot::Limits(of, given) => {
                self.colon = true;
                for n in of.named.iter().filter(|n| !given.iter().any(|g| g == n.name)) {
                    self.add(n.name, CompletionItemKind::PROPERTY, 0, "", n.text.to_string());
                }
                self.expression(mentions, false, false);
            }
            Slot::Words(words) => {
                for word in *words {
                    self.add(word, CompletionItemKind::ENUM_MEMBER, 0, "", String::new());
                }
            }
            Slot::Tells(all) => {
                for told in *all {
                    self.add(
                        told.name,
                        CompletionItemKind::PROPERTY,
                        0,
                        &told.dimension.to_string(),
                        told.is.to_string(),
                    );
                }
            }
            Slot::Kind => self.kinds(0),
            Slot::Member => {
                self.names(mentions, Class::Task, 0);
                self.kinds(1);
            }
            Slot::Stack => self.names(mentions, Class::Stack, 0),
            Slot::Offered(names) => {
                for (name, about) in names {
                    self.add(name, CompletionItemKind::VARIABLE, 0, about, String::new());
                }
            }
            Slot::Given(ty, left) => self.given(mentions, ty.as_deref(), left),
            Slot::Expression { auto, state } => self.expression(mentions, *auto, *state),
            Slot::Expected => {
                let measured: Vec<&str> = MEASURED.iter().map(|w| w.name).collect();
                self.built_in(&measured, 0);
                self.expression(mentions, false, true);
            }
            Slot::Condition => {
                self.built_in(compiler::expr::MOTION, 0);
                self.expression(mentions, false, true);
            }
            Slot::Captured(actuals, prefix) => {
                for actual in *actuals {
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
                    let functions = functions();
                    self.built_in(&functions, 2);
                }
            }
            Slot::FrameField => {
                for field in FRAME_FIELDS {
                    self.add(field, CompletionItemKind::FIELD, 0, "", String::new());
                }
            }
            Slot::ValueField => {
                for field in VALUE_FIELDS {
                    self.add(field, CompletionItemKind::FIELD, 0, "", String::new());
                }
            }
            Slot::Signal => {
                self.names(mentions, Class::Signal, 0);
                self.names(mentions, Class::Human, 0);
            }
            Slot::Field => self.names(mentions, Class::Field, 0),
            Slot::Human => self.names(mentions, Class::Human, 0),
            Slot::Task => self.names(mentions, Class::Task, 0),
            Slot::Machine => self.names(mentions, Class::Machine, 0),
            Slot::Events { whole } => self.events(mentions, *whole),
            Slot::Faults => {
                for fault in FAULTS {
                    self.add(fault.name, CompletionItemKind::ENUM_MEMBER, 0, "fault", fault.doc.to_string());
                }
            }
            Slot::Verbs => {
                for verb in compiler::VERBS {
                    self.add(verb.name, CompletionItemKind::FUNCTION, 0, verb.form, hover::verb(verb));
                }
            }
            Slot::Unit => self.units(),
            Slot::Link => self.links(1),
            Slot::Frame => {
                self.names(mentions, Class::Arm, 0);
                self.links(1);
            }
            Slot::Arm => self.names(mentions, Class::Arm, 0),
            Slot::Links => {
                self.names(mentions, Class::Arm, 0);
                self.slot(mentions, &Slot::Geometry);
            }
            Slot::PartOrPerson => {
                self.slot(mentions, &Slot::Geometry);
                self.names(mentions, Class::Human, 0);
            }
            Slot::Geometry => {
                for class in [Class::Point, Class::Segment, Class::Group] {
                    self.names(mentions, class, 0);
                }
                if mentions.names(Class::Arm).next().is_some() {
                    let doc = "All `points` of all arms.".to_string();
                    self.add("arms", CompletionItemKind::VARIABLE, 0, "group", doc);
                    let arms: Vec<String> = mentions.names(Class::Arm).map(|a| format!("arms.{a}")).collect();
                    for arm in arms {
                        self.add(&arm, CompletionItemKind::VARIABLE, 0, "group", String::new());
                    }
                }
                self.links(1);
            }
            Slot::Joint => self.joints(mentions, &[]),
            Slot::JointKey(used) => self.joints(mentions, used),
            Slot::Nothing => {}
        }
    }

    fn keys(&mut self, section: &'static Section, used: &[String]) {
        let syntax = if self.colon { Syntax::Yaml } else { Syntax::Native };
        for key in section.written(syntax).filter(|k| !used.iter().any(|u| u == k.name)) {
            self.add(key.name, CompletionItemKind::PROPERTY, 0, &keys::describe(&key.holds), hover::key(key));
        }
    }

    fn parameters(&mut self, infos: &[ParamInfo], used: &[String]) {
        for info in infos.iter().filter(|i| !used.iter().any(|u| u == i.name)) {
            let rank = usize::from(info.presence != Presence::Required);
            let detail = describe(&info.ty);
            self.add(info.name, CompletionItemKind::PROPERTY, rank, &detail, hover::parameter(info));
        }
    }

    /// Candidates for the next argument of a declaration with parameters.
    fn given(&mut self, mentions: &Mentions, ty: Option<&str>, left: &[Taken]) {
        match ty {
            Some("arm") => self.slot(mentions, &Slot::Arm),
            Some("frame") => self.slot(mentions, &Slot::Frame),
            Some("joints") => self.slot(mentions, &Slot::Joint),
            Some("geometry") => self.slot(mentions, &Slot::Geometry),
            Some("task") => self.slot(mentions, &Slot::Member),
            Some("name") | None => {}
            Some(_) => self.expression(mentions, false, false),
        }
        self.colon = true;
        for taken in left {
            let rank = if taken.optional { 2 } else { 1 };
            self.add(&taken.name, CompletionItemKind::PROPERTY, rank, &taken.ty, String::new());
        }
    }

    fn kinds(&mut self, rank: usize) {
        for kind in KINDS {
            self.add(kind.name, CompletionItemKind::CLASS, rank, kind.summary, hover::task_kind(kind));
        }
    }

    fn names(&mut self, mentions: &Mentions, class: Class, rank: usize) {
        let names: Vec<String> = mentions.names(class).map(str::to_string).collect();
        for name in names {
            self.add(&name, CompletionItemKind::VARIABLE, rank, class.word(), String::new());
        }
    }

    fn built_in(&mut self, names: &[&str], rank: usize) {
        for name in names {
            self.add(name, CompletionItemKind::FUNCTION, rank, "", hover::built_in(name).unwrap_or_default());
        }
    }

    fn expression(&mut self, mentions: &Mentions, auto: bool, state: bool) {
        if auto {
            self.add("auto", CompletionItemKind::ENUM_MEMBER, 0, "worked out by the task", String::new());
        }
        self.names(mentions, Class::Param, 0);
        self.names(mentions, Class::Let, 0);
        self.names(mentions, Class::Signal, 0);
        self.names(mentions, Class::Human, 0);
        let known = BUILT_IN.iter().map(|k| k.name).filter(|n| state || !PRESENT.contains(n));
        let known: Vec<&str> = known.collect();
        self.built_in(&known, 1);
        let functions = functions();
        self.built_in(&functions, 2);
    }

    /// Events that signals and actions raise; if `whole`, all triggers of a transition.
    fn events(&mut self, mentions: &Mentions, whole: bool) {
        self.names(mentions, Class::Event, 0);
        for name in mentions.raised.keys().filter(|n| mentions.names(Class::Event).all(|e| e != n.as_str())) {
            let about = hover::event(mentions, name).unwrap_or_default();
            self.add(name, CompletionItemKind::EVENT, 0, Class::Raised.word(), about);
        }
        for trigger in TRIGGERS.iter().filter(|_| whole) {
            self.add(trigger.name, CompletionItemKind::FUNCTION, 1, "", trigger.doc.to_string());
        }
    }

    fn units(&mut self) {
        for unit in UNITS {
            self.add(unit, CompletionItemKind::UNIT, 3, &hover::unit(unit).unwrap_or_default(), String::new());
        }
    }

    fn parts(&mut self, parts: &BTreeMap<String, Part>, used: &[String], kind: CompletionItemKind, rank: usize) {
        for (name, part) in parts.iter().filter(|(n, p)| p.moves && !used.contains(n)) {
            self.add(name, kind, rank, "", part.about.clone());
        }
    }

    fn links(&mut self, rank: usize) {
        if let Some(urdf) = self.document.analysis().and_then(|a| a.urdf.clone()) {
            self.parts(&urdf.links, &[], CompletionItemKind::REFERENCE, rank);
        }
    }

    fn joints(&mut self, mentions: &Mentions, used: &[String]) {
        let groups: Vec<String> = mentions.names(Class::JointGroup).map(str::to_string).collect();
        for group in groups.iter().filter(|g| !used.contains(g)) {
            self.add(group, CompletionItemKind::VARIABLE, 0, Class::JointGroup.word(), String::new());
        }
        if let Some(urdf) = self.document.analysis().and_then(|a| a.urdf.clone()) {
            self.parts(&urdf.joints, used, CompletionItemKind::REFERENCE, 1);
        }
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

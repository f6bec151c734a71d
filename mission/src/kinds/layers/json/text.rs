//! JSON parser with the position of each value; reports the position of the first syntax error.
//!
//! The values before a syntax error or a premature end are returned; lists and objects that were not closed are marked,
//! so that missing keys in them are not reported.

use super::{Fault, FaultKind, Position};

/// Maximum length of the text (bytes), nesting depth, and number of values.
pub(super) const MAX_BYTES: usize = 1 << 20;
const MAX_DEPTH: usize = 16;
const MAX_VALUES: usize = 50_000;

/// A value with the position of its begin.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub at: Position,
    pub value: Value,
    /// True if the text is truncated or invalid within the value.
    pub broken: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Null,
    Truth(bool),
    Number(f64),
    Text(String),
    List(Vec<Node>),
    /// Keys with their positions, in order.
    Object(Vec<(String, Position, Node)>),
}

impl Node {
    /// Returns the name of the value's type.
    pub fn kind(&self) -> &'static str {
        match self.value {
            Value::Null => "null",
            Value::Truth(_) => "a truth value",
            Value::Number(_) => "a number",
            Value::Text(_) => "a text",
            Value::List(_) => "a list",
            Value::Object(_) => "an object",
        }
    }
}

/// Parses a text; returns the value up to the first error, and the error if any.
pub(super) fn read(text: &str) -> (Option<Node>, Option<Fault>) {
    let mut reader =
        Reader { rest: text, at: Position { line: 1, column: 1 }, values: 0, open: Vec::new(), fault: None };
    if text.len() > MAX_BYTES {
        let what = format!("the text has {} bytes, more than {MAX_BYTES}", text.len());
        reader.stop(FaultKind::TooMuch, what, "give fewer tasks".into());
        return (None, reader.fault);
    }
    reader.space();
    if reader.rest.starts_with('`') {
        reader.wrong("the text begins with a fence", "give the JSON alone, without ``` around it");
        return (None, reader.fault);
    }
    let node = reader.value();
    if reader.fault.is_none() {
        reader.space();
        if !reader.rest.is_empty() {
            reader.wrong("there is more text after the JSON", "give one JSON object and nothing else");
        }
    }
    (node, reader.fault)
}

struct Reader<'a> {
    rest: &'a str,
    at: Position,
    values: usize,
    /// Open brackets with their positions.
    open: Vec<(char, Position)>,
    fault: Option<Fault>,
}

impl Reader<'_> {
    fn stop(&mut self, kind: FaultKind, what: String, fix: String) {
        self.fault.get_or_insert(Fault { at: self.at, path: String::new(), kind, what, fix });
    }

    /// Reports unexpected text at the current position.
    fn wrong(&mut self, what: &str, fix: &str) {
        if self.rest.is_empty() {
            let open = self
                .open
                .last()
                .map(|(bracket, at)| format!(" within the `{bracket}` of line {}, column {}", at.line, at.column));
            let what = format!("the text ends{}", open.unwrap_or_default());
            let close: String =
                self.open.iter().rev().map(|(bracket, _)| if *bracket == '{' { '}' } else { ']' }).collect();
            let fix = if close.is_empty() {
                "give a JSON object".into()
            } else {
                format!("give the whole of it, as far as the last `{close}`")
            };
            self.stop(FaultKind::Truncated, what, fix);
        } else {
            self.stop(FaultKind::Syntax, what.into(), fix.into());
        }
    }

    fn next(&mut self) -> Option<char> {
        let character = self.rest.chars().next()?;
        self.rest = &self.rest[character.len_utf8()..];
        if character == '\n' {
            self.at = Position { line: self.at.line + 1, column: 1 };
        } else {
            self.at.column += 1;
        }
        Some(character)
    }

    /// Skips this number of characters.
    fn pass(&mut self, count: usize) {
        for _ in 0..count {
            self.next();
        }
    }

    fn space(&mut self) {
        while self.rest.starts_with([' ', '\t', '\n', '\r']) {
            self.next();
        }
    }

    fn skip(&mut self, character: char) -> bool {
        self.space();
        let there = self.rest.starts_with(character);
        if there {
            self.next();
        }
        there
    }

    fn value(&mut self) -> Option<Node> {
        self.space();
        let at = self.at;
        self.values += 1;
        if self.values > MAX_VALUES || self.open.len() >= MAX_DEPTH {
            let what =
                format!("there are more than {MAX_VALUES} values, or they are nested more than {MAX_DEPTH} deep");
            self.stop(FaultKind::TooMuch, what, "give layers of tasks, and nothing else".into());
            return None;
        }
        let value = match self.rest.chars().next() {
            Some('{') => self.object(),
            Some('[') => self.list(),
            Some('"') => Value::Text(self.text()?),
            Some('-' | '0'..='9') => self.number()?,
            _ => self.word()?,
        };
        Some(Node { at, value, broken: self.fault.is_some() })
    }

    fn word(&mut self) -> Option<Value> {
        for (word, value) in [("true", Value::Truth(true)), ("false", Value::Truth(false)), ("null", Value::Null)] {
            if self.rest.starts_with(word) {
                self.pass(word.len());
                return Some(value);
            }
        }
        self.wrong("a value is expected", "put a text in double quotes, a number, a list or an object");
        None
    }

    fn number(&mut self) -> Option<Value> {
        let numeric = |c: char| matches!(c, '+' | '-' | '.' | 'e' | 'E' | '0'..='9');
        let end = self.rest.find(|c| !numeric(c)).unwrap_or(self.rest.len());
        let word = &self.rest[..end];
        let digits = word.strip_prefix('-').unwrap_or(word);
        let form = digits.starts_with(|c: char| c.is_ascii_digit())
            && !digits.ends_with('.')
            && !(digits.starts_with('0') && digits[1..].starts_with(|c: char| c.is_ascii_digit()));
        let number = word.parse::<f64>().ok().filter(|number| form && number.is_finite());
        let Some(number) = number else {
            self.wrong("this is no number", "write numbers as 12, -0.5 or 1e-3");
            return None;
        };
        self.pass(end);
        Some(Value::Number(number))
    }

    fn text(&mut self) -> Option<String> {
        self.next();
        let mut text = String::new();
        loop {
            let before = (self.rest, self.at);
            match self.next() {
                Some('"') => return Some(text),
                Some('\\') => match self.escape() {
                    Some(character) => text.push(character),
                    None => {
                        if !self.rest.is_empty() {
                            (self.rest, self.at) = before;
                        }
                        self.wrong(
                            "this is no escape of JSON",
                            "write \\n, \\\", \\\\ or \\u and four hexadecimal digits",
                        );
                        return None;
                    }
                },
                Some(character) if character >= ' ' => text.push(character),
                other => {
                    if other.is_some() {
                        (self.rest, self.at) = before;
                    }
                    self.wrong("a text in quotes does not go on over the line", "close it with a double quote");
                    return None;
                }
            }
        }
    }

    fn escape(&mut self) -> Option<char> {
        Some(match self.next()? {
            'n' => '\n',
            't' => '\t',
            'r' => '\r',
            'b' => '\u{8}',
            'f' => '\u{c}',
            same @ ('"' | '\\' | '/') => same,
            'u' => {
                let first = self.unit()?;
                let code = if (0xD800..0xDC00).contains(&first) {
                    if self.next() != Some('\\') || self.next() != Some('u') {
                        return None;
                    }
                    let second = self.unit().filter(|second| (0xDC00..0xE000).contains(second))?;
                    0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00)
                } else {
                    first
                };
                char::from_u32(code)?
            }
            _ => return None,
        })
    }

    fn unit(&mut self) -> Option<u32> {
        (0..4).try_fold(0, |code, _| Some(code * 16 + self.next()?.to_digit(16)?))
    }

    fn list(&mut self) -> Value {
        let mut list = Vec::new();
        self.open.push(('[', self.at));
        self.next();
        if !self.skip(']') {
            loop {
                list.extend(self.value());
                if self.fault.is_some() || self.skip(']') {
                    break;
                }
                if !self.skip(',') {
                    self.wrong("a comma or `]` is expected", "separate the entries of a list by commas");
                    break;
                }
            }
        }
        self.close();
        Value::List(list)
    }

    fn object(&mut self) -> Value {
        let mut entries = Vec::new();
        self.open.push(('{', self.at));
        self.next();
        if !self.skip('}') {
            loop {
                self.space();
                let at = self.at;
                if !self.rest.starts_with('"') {
                    self.wrong(
                        "a key in double quotes is expected",
                        "write \"name\": value; no comma after the last entry",
                    );
                    break;
                }
                let Some(key) = self.text() else { break };
                if !self.skip(':') {
                    self.wrong("a colon is expected", "write \"name\": value");
                    break;
                }
                entries.extend(self.value().map(|node| (key, at, node)));
                if self.fault.is_some() || self.skip('}') {
                    break;
                }
                if !self.skip(',') {
                    self.wrong("a comma or `}` is expected", "separate the entries of an object by commas");
                    break;
                }
            }
        }
        self.close();
        Value::Object(entries)
    }

    fn close(&mut self) {
        if self.fault.is_none() {
            self.open.pop();
        }
    }
}

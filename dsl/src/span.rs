//! Source locations: a source file and a range of bytes in it.

use serde::{Deserialize, Serialize};

/// Index of a source text in a [`Sources`] table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SourceId(pub u32);

/// A range of bytes in one source text; `start <= end`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Span {
    /// The text that the bytes belong to.
    pub source: SourceId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// Creates the span of the bytes `start..end` of `source`.
    pub fn new(source: SourceId, start: usize, end: usize) -> Self {
        let clamp = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
        Span { source, start: clamp(start), end: clamp(end.max(start)) }
    }

    /// Returns the smallest span that covers both (of the same source; otherwise `self`).
    pub fn to(self, other: Span) -> Span {
        if self.source != other.source {
            return self;
        }
        Span { source: self.source, start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// Returns the number of bytes.
    pub fn len(&self) -> usize {
        (self.end - self.start) as usize
    }

    /// Returns true for a position between two bytes.
    pub fn is_empty(&self) -> bool {
        self.start == self.end
    }

    /// Returns the bytes as a range of `usize`.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A value with its source location. Equality compares the value only.
#[derive(Clone, Debug)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Its location.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// Creates a value with its location.
    pub fn new(value: T, span: Span) -> Self {
        Spanned { value, span }
    }
}

impl<T: PartialEq> PartialEq for Spanned<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<T> std::ops::Deref for Spanned<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.value
    }
}

/// The texts that spans refer to.
///
/// A text may be used several times: imported by a file, or copied at each use of a declaration. Each such copy is an
/// instance with an index of its own, so that a span in it identifies the uses that led there.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    texts: Vec<SourceText>,
    instances: Vec<Instance>,
}

/// A copy of a text, created for a use.
#[derive(Clone, Debug)]
struct Instance {
    /// The text, which may be an instance itself.
    of: SourceId,
    /// Locations of its uses.
    uses: Vec<Span>,
    /// Description of the use, for a label: "imported here".
    what: &'static str,
}

/// Indices from here on are instances.
const INSTANCES: u32 = 1 << 31;

/// A text with its displayed name.
#[derive(Clone, Debug)]
pub struct SourceText {
    /// Name in diagnostics; usually the path as the user wrote it.
    pub name: String,
    /// The text.
    pub text: String,
}

impl Sources {
    /// Adds a text and returns its index.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> SourceId {
        self.texts.push(SourceText { name: name.into(), text: text.into() });
        SourceId((self.texts.len() - 1) as u32)
    }

    /// Returns the text with this index, `None` if the index is unknown.
    pub fn get(&self, id: SourceId) -> Option<&SourceText> {
        self.texts.get(self.text_of(id).0 as usize)
    }

    /// Creates a copy of a text, for a use at a location. `what` describes the use: "imported here".
    pub fn instance(&mut self, of: SourceId, used: Span, what: &'static str) -> SourceId {
        let id = INSTANCES.saturating_add(self.instances.len() as u32);
        self.instances.push(Instance { of, uses: vec![used], what });
        SourceId(id)
    }

    /// Adds a use to an instance.
    pub fn used_again(&mut self, instance: SourceId, used: Span) {
        if let Some(known) = self.known_mut(instance) {
            known.uses.push(used);
        }
    }

    fn known(&self, id: SourceId) -> Option<&Instance> {
        self.instances.get(id.0.checked_sub(INSTANCES)? as usize)
    }

    fn known_mut(&mut self, id: SourceId) -> Option<&mut Instance> {
        self.instances.get_mut(id.0.checked_sub(INSTANCES)? as usize)
    }

    /// Returns the text that an index refers to, directly or through instances. An instance is created after its
    /// original, so that the loop ends.
    pub fn text_of(&self, id: SourceId) -> SourceId {
        let mut id = id;
        while let Some(instance) = self.known(id) {
            id = instance.of;
        }
        id
    }

    /// Returns the location in the original text.
    pub fn real(&self, span: Span) -> Span {
        Span { source: self.text_of(span.source), ..span }
    }

    /// Returns the uses that led to a location, the nearest first, each with its description; at most `most`.
    pub fn uses(&self, id: SourceId, most: usize) -> Vec<(Span, &'static str)> {
        let mut out: Vec<(Span, &'static str)> = Vec::new();
        let mut open = vec![id];
        // Uses refer to earlier instances only; the bound limits their number if they multiply.
        let mut steps = 0;
        while let Some(id) = open.pop() {
            steps += 1;
            let Some(instance) = self.known(id).filter(|_| steps < 1000) else { continue };
            for used in &instance.uses {
                let place = (self.real(*used), instance.what);
                if !out.contains(&place) && out.len() < most {
                    out.push(place);
                }
            }
            open.push(instance.of);
            open.extend(instance.uses.iter().map(|u| u.source).take(most));
        }
        out
    }

    /// Returns the text of a span, empty if the span is invalid.
    pub fn snippet(&self, span: Span) -> &str {
        self.get(span.source).and_then(|s| s.text.get(span.range())).unwrap_or("")
    }

    /// Returns the line and column of a byte, both from 1; columns count characters.
    pub fn line_column(&self, source: SourceId, byte: u32) -> (usize, usize) {
        let Some(text) = self.get(source).map(|s| s.text.as_str()) else { return (1, 1) };
        let mut end = (byte as usize).min(text.len());
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &text[..end];
        let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        (line, before[start..].chars().count() + 1)
    }

    /// Returns all texts in the order they were added.
    pub fn iter(&self) -> impl Iterator<Item = (SourceId, &SourceText)> {
        self.texts.iter().enumerate().map(|(i, s)| (SourceId(i as u32), s))
    }
}

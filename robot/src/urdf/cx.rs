//! Shared context of the URDF reader: the text, the messages so far, and small readers of elements, attributes and
//! numbers.

use std::ops::Range;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::{UrdfCode, UrdfMessage};

/// The messages about one text.
pub(crate) struct Cx<'t> {
    pub text: &'t str,
    pub errors: Vec<UrdfMessage>,
    pub warnings: Vec<UrdfMessage>,
}

/// A value and its location in the text.
pub(crate) struct Spanned<T> {
    pub value: T,
    pub span: Range<usize>,
}

impl<'t> Cx<'t> {
    pub(super) fn error(&mut self, message: UrdfMessage) {
        self.errors.push(message);
    }

    pub(super) fn warn(&mut self, message: UrdfMessage) {
        self.warnings.push(message);
    }

    /// Returns the range of the opening tag of an element.
    pub(super) fn tag(&self, node: Node) -> Range<usize> {
        tag(self.text, node)
    }

    /// Returns the line of the start of `span`, from 1.
    pub(super) fn line(&self, span: &Range<usize>) -> usize {
        self.text[..span.start].matches('\n').count() + 1
    }

    /// Returns a required attribute; reports an error if it is missing or empty.
    pub(super) fn need<'a>(&mut self, node: Node<'a, '_>, name: &str) -> Option<Spanned<&'a str>> {
        match attribute(node, name) {
            Some(found) if !found.value.trim().is_empty() => Some(found),
            found => {
                let span = found.map_or_else(|| self.tag(node), |f| f.span);
                let element = node.tag_name().name();
                let text = format!("`<{element}>` has no `{name}`");
                self.error(UrdfMessage::new(UrdfCode::Missing, span, text));
                None
            }
        }
    }

    /// Reads `N` finite numbers, if the attribute exists. An invalid one is an error and returns `None`.
    pub(super) fn numbers<const N: usize>(&mut self, node: Node, name: &str) -> Option<[f64; N]> {
        let found = attribute(node, name)?;
        match parse_numbers(found.value) {
            Ok(values) => Some(values),
            Err(text) => {
                let text = format!("`{name}` {text}");
                self.error(UrdfMessage::new(UrdfCode::BadNumber, found.span, text));
                None
            }
        }
    }

    /// Reads one finite number, if the attribute exists.
    pub(super) fn number(&mut self, node: Node, name: &str) -> Option<f64> {
        self.numbers::<1>(node, name).map(|[x]| x)
    }

    /// Reads the pose in the `<origin>` of `node`; identity if there is none.
    pub(super) fn origin(&mut self, node: Node) -> Isometry3<f64> {
        let Some(origin) = child(node, "origin") else { return Isometry3::identity() };
        let xyz = self.numbers(origin, "xyz").unwrap_or([0.0; 3]);
        let [roll, pitch, yaw] = self.numbers(origin, "rpy").unwrap_or([0.0; 3]);
        let mut rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        if let Some([x, y, z, w]) = self.numbers(origin, "quat_xyzw") {
            match UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9) {
                Some(q) if q.coords.iter().all(|c| c.is_finite()) => rotation = q,
                _ => {
                    let span = attribute(origin, "quat_xyzw").map_or(origin.range(), |a| a.span);
                    let text = "the quaternion has no direction";
                    self.error(UrdfMessage::new(UrdfCode::BadNumber, span, text));
                }
            }
        }
        Isometry3::from_parts(Translation3::from(Vector3::from(xyz)), rotation)
    }
}

/// Returns the range of the opening tag of an element.
pub(crate) fn tag(text: &str, node: Node) -> Range<usize> {
    let range = node.range();
    let mut quote = None;
    for (i, byte) in text[range.clone()].bytes().enumerate() {
        match (quote, byte) {
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(q), _) if q == byte => quote = None,
            (None, b'>') => return range.start..range.start + i + 1,
            _ => {}
        }
    }
    range
}

/// Parses exactly `N` finite numbers separated by white space. The error text continues a sentence that begins with the
/// name of the attribute.
pub(crate) fn parse_numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in text.split_whitespace() {
        let value: f64 = word.parse().map_err(|_| format!("has `{word}`, which is no number"))?;
        if !value.is_finite() {
            return Err(format!("has `{word}`, which is not a finite number"));
        }
        if let Some(slot) = values.get_mut(count) {
            *slot = value;
        }
        count += 1;
    }
    if count == N {
        Ok(values)
    } else {
        let s = if N == 1 { "" } else { "s" };
        Err(format!("needs {N} number{s}, {count} found"))
    }
}

/// Returns an attribute without namespace, with the location of its value.
pub(crate) fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<Spanned<&'a str>> {
    node.attributes()
        .find(|a| a.name() == name && a.namespace().is_none())
        .map(|a| Spanned { value: a.value(), span: a.range_value() })
}

/// Returns the child elements with this name, in the namespace of their parent.
pub(crate) fn children<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    let namespace = node.tag_name().namespace();
    node.children()
        .filter(move |c| c.is_element() && c.tag_name().name() == name && c.tag_name().namespace() == namespace)
}

/// The first of [`children`].
pub(super) fn child<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

/// Formats at most eight names for a message.
pub(crate) fn list<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let mut text = names.iter().take(8).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    if names.len() > 8 {
        text.push_str(&format!(" and {} more", names.len() - 8));
    }
    text
}

//! Comments in the tree.

/// Comments that belong to a node. They never take part in equality.
#[derive(Clone, Debug, Default)]
pub struct Comments {
    /// Whole lines before the node, without their marker; an empty string is a blank line between comments.
    pub before: Vec<String>,
    /// Comment after the node on the same line, without its marker.
    pub behind: Option<String>,
}

impl PartialEq for Comments {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

//! Declarations of one form: a keyword, a name, and a block of settings. Readers, printers and expansion treat all of
//! them alike; a new one is a line of [`BlockKind`], of the grammar's `block_word`, and of the keywords.

use super::Block;
use crate::span::Spanned;

/// The kinds of [`NamedBlock`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BlockKind {
    /// `human operator { points [chest, left_wrist]  lost hold }`: a person whose points are tracked.
    Human,
    /// `safety_field nearness { of operator  points mean }`: a single number for the distance of the robot from people.
    SafetyField,
    /// `obstacle table { box [1.2, 0.8, 0.04] m  position [0.7, 0, 0.4] m }`: a body in the room.
    Obstacle,
}

impl BlockKind {
    /// All kinds, in the order in which a sorted spec declares them.
    pub const ALL: [BlockKind; 3] = [BlockKind::Human, BlockKind::SafetyField, BlockKind::Obstacle];

    /// The keyword of the native syntax.
    pub fn keyword(self) -> &'static str {
        match self {
            BlockKind::Human => "human",
            BlockKind::SafetyField => "safety_field",
            BlockKind::Obstacle => "obstacle",
        }
    }

    /// The key of YAML below which the declarations stand.
    pub fn section(self) -> &'static str {
        match self {
            BlockKind::Human => "humans",
            BlockKind::SafetyField => "safety_fields",
            BlockKind::Obstacle => "obstacles",
        }
    }

    /// The kind of a keyword.
    pub fn of_keyword(word: &str) -> Option<BlockKind> {
        BlockKind::ALL.into_iter().find(|kind| kind.keyword() == word)
    }

    /// The kind of a section of YAML.
    pub fn of_section(word: &str) -> Option<BlockKind> {
        BlockKind::ALL.into_iter().find(|kind| kind.section() == word)
    }
}

/// A declaration of a [`BlockKind`].
#[derive(Clone, Debug, PartialEq)]
pub struct NamedBlock {
    /// Its kind.
    pub kind: BlockKind,
    /// Its name.
    pub name: Spanned<String>,
    /// Its settings.
    pub body: Block,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_know_every_keyword_and_section() {
        for kind in BlockKind::ALL {
            assert!(crate::hq::KEYWORDS.contains(&kind.keyword()), "{kind:?}");
            assert!(crate::vocabulary::REPEATED.contains(&kind.section()), "{kind:?}");
            let text = format!("hierarq 1\n{} x {{ }}\n", kind.keyword());
            let (spec, _) = crate::parse(crate::SourceId(0), &text, crate::Syntax::Native);
            assert!(matches!(&spec.items[0].kind, crate::tree::ItemKind::Block(b) if b.kind == kind), "{kind:?}");
        }
    }
}

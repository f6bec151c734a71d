//! Identity of names across files: the declaration that a name refers to, and the place where the word was chosen.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::library::Source;
use super::mentions::{Class, Mentions, What};

/// A name, with the file that declares or chooses it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Origin {
    /// File.
    pub path: PathBuf,
    /// Class.
    pub class: Class,
    /// Qualified name in that file.
    pub name: String,
}

/// Declaration of an imported name.
#[derive(Clone, Debug)]
pub(super) struct Elsewhere {
    /// File with the declaration.
    pub source: Rc<Source>,
    /// Qualified name in that file.
    pub name: String,
    /// Range of the name there (bytes).
    pub place: Range<usize>,
    /// Range of the whole declaration there (bytes).
    pub whole: Range<usize>,
    /// File in which the word was chosen, with the qualified name there; `None` for a name that this import itself
    /// chose, `deck as table`.
    pub word: Option<(PathBuf, String)>,
}

/// Declaration that a word of a file refers to.
pub(super) fn declaration(path: &Path, mentions: &Mentions, what: &What) -> Option<Origin> {
    match what {
        What::Declared(class, name) => {
            let elsewhere = mentions.declared.get(&(*class, name.clone()))?.elsewhere.as_ref();
            let (path, name) = elsewhere.map_or((path, name), |e| (&e.source.path, &e.name));
            Some(Origin { path: path.to_path_buf(), class: *class, name: name.clone() })
        }
        What::Brought(class, e) => Some(Origin { path: e.source.path.clone(), class: *class, name: e.name.clone() }),
        _ => None,
    }
}

/// Place where the word was chosen. An import that renames a declaration chooses a word of its own.
pub(super) fn word(path: &Path, mentions: &Mentions, what: &What) -> Option<Origin> {
    let chosen = |class: Class, (path, name): (PathBuf, String)| Origin { path, class, name };
    match what {
        What::Declared(class, name) => {
            let own = || (path.to_path_buf(), name.clone());
            let declared = mentions.declared.get(&(*class, name.clone()))?;
            let from = declared.elsewhere.as_ref().and_then(|e| e.word.clone());
            Some(chosen(*class, from.unwrap_or_else(own)))
        }
        What::Brought(class, e) => Some(chosen(*class, e.word.clone()?)),
        _ => None,
    }
}

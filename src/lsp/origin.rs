//! What names of several files have in common: the declaration that they mean, and the place where the word was chosen.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::library::Source;
use super::mentions::{Class, Mentions, What};

/// A name by the file that gives it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Origin {
    /// The file.
    pub path: PathBuf,
    /// The class.
    pub class: Class,
    /// What it is looked up by there.
    pub name: String,
}

/// The declaration of a name that an import brings.
#[derive(Clone, Debug)]
pub(super) struct Elsewhere {
    /// The file that declares it.
    pub source: Rc<Source>,
    /// What it is looked up by there.
    pub name: String,
    /// Its name there, in bytes.
    pub place: Range<usize>,
    /// All of it there, in bytes.
    pub whole: Range<usize>,
    /// The file in which the word was chosen, and what it is looked up by there; `None` for a name that this import
    /// chose itself, `deck as table`.
    pub word: Option<(PathBuf, String)>,
}

/// The declaration that a word of a file means.
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

/// Where the word was chosen that stands for it. An import that gives another name chooses a word of its own.
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

//! What the compiler is given, and what it gives back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dsl::Spelling;
use runtime::program::{MissionProgram, Program};

use crate::diagnostics::report::Report;

/// Texts in the place of those of imported files, by canonical path: what an editor has open and has not saved.
pub type Texts = BTreeMap<PathBuf, String>;

/// What to compile.
#[derive(Clone, Debug)]
pub struct Input<'a> {
    /// How diagnostics call the text; usually the path as the user gave it.
    pub name: &'a str,
    /// The text.
    pub text: &'a str,
    /// Its spelling.
    pub spelling: Spelling,
    /// Folder that relative paths start from.
    pub folder: &'a Path,
    /// Parameters that are overridden, as `(name, value)` in the language.
    pub set: &'a [(String, String)],
    /// Where `package://` addresses are looked for, beside the usual places.
    pub package_paths: &'a [PathBuf],
}

/// The outcome: a program, missions or both where there is no error, and everything there is to say.
#[derive(Debug, Default)]
pub struct Compiled {
    /// The program of the robot; none where there is an error, or where the spec declares missions alone.
    pub program: Option<Program>,
    /// Missions, in the order declared; none where there is an error.
    pub missions: Vec<MissionProgram>,
    /// Errors and warnings.
    pub report: Report,
}

impl Compiled {
    /// What there is of a spec that cannot be compiled: the reasons.
    pub fn refused(report: Report) -> Compiled {
        Compiled { report, ..Compiled::default() }
    }

    /// True where there is something that can be run or planned.
    pub fn is_good(&self) -> bool {
        self.program.is_some() || !self.missions.is_empty()
    }
}

/// What of a spec is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Everything.
    Whole,
    /// All but its missions and their scenarios.
    Controller,
}

/// The driver, as stages that meet another spec call it.
pub(crate) type CompilePart = fn(&Input, &Texts, Part) -> Compiled;

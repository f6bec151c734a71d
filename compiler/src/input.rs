//! Input and output of the compiler.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dsl::Syntax;
use robot::{LinkMesh, Srdf};
use runtime::program::{MissionProgram, Program};

use crate::diagnostics::report::Report;
use crate::sampled::Sampled;

/// Texts that replace those of imported files, by canonical path: unsaved texts of an editor.
pub type Texts = BTreeMap<PathBuf, String>;

/// Input of a compilation.
#[derive(Clone, Debug)]
pub struct Input<'a> {
    /// Name of the text in diagnostics; usually the path as the user wrote it.
    pub name: &'a str,
    /// The text.
    pub text: &'a str,
    /// Syntax.
    pub syntax: Syntax,
    /// Base folder of relative paths.
    pub folder: &'a Path,
    /// Overridden parameters, as `(name, value)` in the language.
    pub set: &'a [(String, String)],
    /// Folders in which `package://` addresses are searched, besides the usual ones.
    pub package_paths: &'a [PathBuf],
}

/// Result of a compilation: a program, missions or both if there is no error, and the diagnostics.
#[derive(Debug, Default)]
pub struct Compiled {
    /// Program of the robot; `None` if there is an error, or if the spec declares only missions.
    pub program: Option<Program>,
    /// Missions, in source order; empty if there is an error.
    pub missions: Vec<MissionProgram>,
    /// SRDF of the robot, if the spec names one.
    pub srdf: Option<Srdf>,
    /// Meshes of the collision shapes of the robot's links.
    pub meshes: Vec<LinkMesh>,
    /// Errors and warnings.
    pub report: Report,
    /// Figures of sampled postures; `None` if none were asked for, or after an error.
    pub sampled: Option<Sampled>,
}

impl Compiled {
    /// Result for a spec that cannot be compiled: only the diagnostics.
    pub fn refused(report: Report) -> Compiled {
        Compiled { report, ..Compiled::default() }
    }

    /// True if there is something to run or plan.
    pub fn is_good(&self) -> bool {
        self.program.is_some() || !self.missions.is_empty()
    }
}

/// Part of a spec to compile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// The whole spec.
    Whole,
    /// All but missions and their scenarios.
    Controller,
    /// The whole spec, without the contents of files of bytes.
    Unread,
}

/// The driver, for stages that compile another spec.
pub(crate) type CompilePart = fn(&Input, &Texts, Part) -> Compiled;

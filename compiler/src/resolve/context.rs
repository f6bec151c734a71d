//! Completion context: the kinds of words that fit at the cursor.

use dsl::tree::{Block, Value};
use stdlib_tasks::params::ParamInfo;
use stdlib_tasks::task::{CurrentValue, TaskOutput};

use super::symbols::{Formal, SymbolKind};
use super::{Meaning, Resolver};
use crate::expr::Trajectory;
use crate::sections::{Argument, BlockSchema};

/// Word that stands for the cursor in a text, to determine the completion context.
pub const CURSOR: &str = "hqCursorHereqh";

/// A name to offer.
#[derive(Clone, Debug)]
pub struct Offered {
    /// Name, or path of a state.
    pub name: String,
    /// Short description.
    pub about: &'static str,
}

/// Completion context.
#[derive(Clone, Debug)]
pub enum CompletionContext {
    /// Keys of a section, except for these.
    Keys(&'static BlockSchema, Vec<String>),
    /// Parameters of a task type, except for these.
    Parameters(&'static [ParamInfo], Vec<String>),
    /// Parameters of a task type as named arguments, except for these.
    NamedParameters(&'static [ParamInfo], Vec<String>),
    /// An argument of a trajectory: its goal, or one of its named limits, except for these.
    Limits(&'static Trajectory, Vec<String>),
    /// Keywords, as keys or values.
    Words(&'static [&'static str]),
    /// Visible symbols of these kinds.
    Symbols(&'static [SymbolKind]),
    /// These names.
    Offered(Vec<Offered>),
    /// Outputs of a task.
    Outputs(&'static [TaskOutput]),
    /// A task type.
    TaskType,
    /// A member of a level: a task, or a task type.
    Member,
    /// An argument of a declaration with parameters: a value of this type, or one of these parameters by name.
    Argument(Option<String>, Vec<Formal>),
    /// An expression.
    Expression {
        /// True if `auto` is permitted.
        auto: bool,
        /// True if the robot's current state is permitted.
        state: bool,
        /// Arguments of the function around.
        arguments: &'static [Argument],
    },
    /// An expectation: an expression that may also use measures of a scenario.
    Expectation,
    /// A condition of a machine, which may also use measures of the motion.
    Condition,
    /// Values that `initial(..)` can capture, after this prefix.
    Captured(&'static [CurrentValue], String),
    /// A unit.
    Unit,
    /// Points, segments, groups, links; also arms and people if so.
    Geometry {
        /// True if an arm, which represents its links, is permitted.
        arms: bool,
        /// True if a person is permitted.
        people: bool,
    },
    /// Joints and their groups, except for these.
    Joint(Vec<String>),
    /// An event.
    Events {
        /// True if other triggers are permitted too, such as faults and the completion of tasks.
        triggers: bool,
    },
    /// A kind of fault.
    Faults,
    /// A verb.
    Verbs,
    /// No candidates: a new name, or a text.
    Nothing,
}

/// Keys of a block.
pub(super) fn used(block: &Block) -> Vec<String> {
    block.entries.iter().map(|e| e.key.value.clone()).collect()
}

impl Resolver<'_> {
    /// Records the completion context, if the word is the cursor. Returns true if it is.
    pub(super) fn is_cursor(&mut self, word: &str, context: impl FnOnce(&Self) -> CompletionContext) -> bool {
        let found = word == CURSOR;
        if found {
            self.out.context = Some(context(self));
        }
        found
    }

    /// As [`Self::is_cursor`], for a value that is a word.
    pub(super) fn cursor_in(&mut self, value: &Value, context: impl FnOnce(&Self) -> CompletionContext) -> bool {
        value.word().is_some_and(|word| self.is_cursor(word, context))
    }

    /// Offers words for a value that names nothing.
    pub(super) fn offer(&mut self, value: &Value, context: impl FnOnce(&Self) -> CompletionContext) {
        self.cursor_in(value, context);
    }

    /// Completion context of an expression.
    pub(super) fn expression_context(&self) -> CompletionContext {
        match &self.around {
            around if around.expected && around.of_mission => self.of_mission(),
            around if around.expected => CompletionContext::Expectation,
            around if around.condition => CompletionContext::Condition,
            around => CompletionContext::Expression { auto: false, state: around.state, arguments: around.arguments },
        }
    }

    /// Completion context with these symbols.
    pub(super) fn offering<'s>(
        &self,
        symbols: impl IntoIterator<Item = &'s super::SymbolId>,
        about: impl Fn(&super::Symbol) -> &'static str,
    ) -> CompletionContext {
        let one = |id: &super::SymbolId| {
            let symbol = self.out.symbol(*id);
            Offered { name: symbol.name.clone(), about: about(symbol) }
        };
        CompletionContext::Offered(symbols.into_iter().map(one).collect())
    }

    /// Records a built-in word.
    pub(super) fn note_built_in(&mut self, name: &dsl::Spanned<String>) {
        self.note(&name.value, name.span, Meaning::BuiltIn(name.value.clone()));
    }
}

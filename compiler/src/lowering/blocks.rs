//! Blocks of declarations, read into their structs.

use blocks::{Block as BlockOf, BlockSchema, FromBound};
use dsl::Span;
use dsl::tree::{Block, Value};

use super::Lowerer;
use crate::block_binding::{BlockBinder, Scope, TextFiles};
use crate::expr::constants::Constants;

impl Lowerer<'_> {
    /// The binder of blocks, for blocks whose values may name what is in scope.
    pub(super) fn block_binder<'b>(&'b mut self, scope: &'b Scope) -> BlockBinder<'b> {
        BlockBinder {
            constants: Constants { graph: &mut self.graph, params: &mut self.params },
            diagnostics: self.diagnostics,
            origins: &mut self.origins,
            scope,
            files: TextFiles {
                spec: self.input.name,
                folder: self.input.folder,
                sources: self.sources,
                reads_bytes: self.reads_bytes,
            },
        }
    }

    /// Reads a block that is named at a place.
    pub(super) fn read<B: BlockOf>(&mut self, block: &Block, named: Span) -> B {
        B::read(&self.block_binder(&Scope::default()).block(block, B::schema(), named))
    }

    /// Reads the value of a key that the readers of the syntaxes take, as the table of its block declares it. `None` if it
    /// is wrong, with diagnostics.
    pub(super) fn read_word<T: FromBound>(&mut self, schema: &BlockSchema, name: &str, value: &Value) -> Option<T> {
        let key = schema.keys.iter().find(|key| key.name == name)?;
        let bound = self.block_binder(&Scope::default()).value_of_key(key, value)?;
        T::from_located(&bound)
    }
}

//! Blocks of the language as tables: what `params!` is for tasks.
//!
//! [`block!`] turns one listing of keys into a documented struct, the static [`BlockSchema`] from which the compiler's
//! binding, refusals of unknown keys, the JSON schema, the editor and the page of keys derive, and the reader that fills
//! the struct from a [`BoundBlock`]. The crate knows neither texts nor trees, so that a kind of mission declares its
//! blocks in its own folder. [`Help`] and [`Snippet`] show pieces of a spec in both syntaxes.

mod bound;
mod read;
mod schema;
mod snippet;
mod table;

pub use bound::{BinaryFile, Bound, BoundBlock, BoundEntry, FileWith, Located, Origin};
pub use read::{ByName, FromBound, MemberIndex, NumberOrWord, OneOrEach, Unbound, Word};
pub use schema::{
    Argument, BinaryFormat, BlockSchema, Companion, FunctionType, Key, Members, Named, Place, Role, ValueType,
};
pub use snippet::{Help, Snippet};
pub use table::{Block, key_name, read_key, text};

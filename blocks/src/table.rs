//! The macro that declares a block.

use crate::bound::{BoundBlock, Origin};
use crate::read::FromBound;
use crate::schema::{BlockSchema, Key};

/// A struct that [`block!`](crate::block!) declares.
pub trait Block: Sized {
    /// The keys of the block.
    fn schema() -> &'static BlockSchema;

    /// Reads a bound block of this schema.
    fn read(bound: &BoundBlock) -> Self;

    /// Returns the block with nothing written in it.
    fn empty() -> Self {
        Self::read(&BoundBlock::new(Self::schema(), Origin::default()))
    }
}

/// Returns the text of a doc comment, without the space before it.
pub const fn text(doc: &'static str) -> &'static str {
    doc.trim_ascii_start()
}

/// Returns the name of a key whose field is called so: a keyword of Rust begins with `r#` there.
pub const fn key_name(field: &'static str) -> &'static str {
    match field.as_bytes() {
        [b'r', b'#', ..] => field.split_at(2).1,
        _ => field,
    }
}

/// Reads a key of a bound block.
pub fn read_key<T: FromBound>(bound: &BoundBlock, name: &str) -> T {
    const NO_KEY: Key = Key::optional("", crate::ValueType::Value, "");
    let key = bound.schema.entry(name).unwrap_or(&NO_KEY);
    bound.read(name).unwrap_or_else(|| T::stand_in(key))
}

/// Declares a block: a struct, a static [`BlockSchema`] of a name, and the reading of one from the other.
///
/// A key is a line `name: RustType = required(TYPE);`, `optional(TYPE)` or `or(TYPE, "default")` with a doc comment, which
/// is the text of the key in the language; with an example for messages behind the type, `required(TYPE, "20 s")`.
/// `elsewhere(TYPE)` and `required_elsewhere(TYPE, "example")` are keys whose values are read from the tree, by what gives them
/// a meaning: the field is `Unbound`. `same(KEY)` is a key that several blocks share. `also [..]` are keys that the readers of the syntaxes take.
#[macro_export]
macro_rules! block {
    (
        $(#[doc = $top:literal])*
        $(#[derive($($derive:path),*)])?
        $vis:vis struct $Name:ident = $SCHEMA:ident, $title:literal {
            $( $(#[doc = $doc:literal])* $field:ident : $ty:ty = $how:ident ( $($arg:expr),* ); )*
        }
        $( also [ $($also:expr),* $(,)? ] )?
    ) => {
        $(#[doc = $top])*
        #[derive(Clone, Debug $($(, $derive)*)?)]
        $vis struct $Name { $( $(#[doc = $doc])* pub $field: $ty, )* }

        $(#[doc = $top])*
        $vis static $SCHEMA: $crate::BlockSchema = $crate::BlockSchema {
            name: $title,
            keys: &[
                $( $crate::block!(@key $how, $crate::key_name(stringify!($field)), $crate::text(concat!($($doc),*)), $($arg),*), )*
                $( $($also),* )?
            ],
        };

        impl $crate::Block for $Name {
            fn schema() -> &'static $crate::BlockSchema {
                &$SCHEMA
            }

            fn read(bound: &$crate::BoundBlock) -> Self {
                $Name { $( $field: $crate::read_key(bound, $crate::key_name(stringify!($field))), )* }
            }
        }

        impl $crate::FromBound for $Name {
            fn from_bound(bound: &$crate::Bound) -> Option<Self> {
                match bound {
                    $crate::Bound::Block(block) => Some(<$Name as $crate::Block>::read(block)),
                    _ => None,
                }
            }

            fn stand_in(_: &$crate::Key) -> Self {
                <$Name as $crate::Block>::empty()
            }
        }
    };
    (@key required, $name:expr, $doc:expr, $value:expr) => { $crate::Key::required($name, $value, $doc) };
    (@key required, $name:expr, $doc:expr, $value:expr, $example:expr) => {
        $crate::Key::required($name, $value, $doc).example($example)
    };
    (@key optional, $name:expr, $doc:expr, $value:expr) => { $crate::Key::optional($name, $value, $doc) };
    (@key optional, $name:expr, $doc:expr, $value:expr, $example:expr) => {
        $crate::Key::optional($name, $value, $doc).example($example)
    };
    (@key or, $name:expr, $doc:expr, $value:expr, $default:expr) => { $crate::Key::or($name, $value, $default, $doc) };
    (@key elsewhere, $name:expr, $doc:expr, $value:expr) => {
        $crate::Key::optional($name, $value, $doc).elsewhere()
    };
    (@key required_elsewhere, $name:expr, $doc:expr, $value:expr, $example:expr) => {
        $crate::Key::required($name, $value, $doc).example($example).elsewhere()
    };
    (@key same, $name:expr, $doc:expr, $key:expr) => { $key };
}

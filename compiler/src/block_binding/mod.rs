//! Binding of blocks by their schemas: unknown, missing and misspelt keys are reported, values are converted to SI and
//! checked against their types, units and ranges, and names of members are resolved. What a block is does not matter.

mod file_values;
mod files;
mod functions;
mod origins;
mod scope;
mod values;

use dsl::tree::{Block, Value};
use dsl::{Diagnostic, Fix, Help, Severity, Span};

use blocks::{BlockSchema, Bound, BoundBlock, Key, Located};
use stdlib_tasks::params::Presence;

use crate::expr::constants::Constants;
use crate::forms::{block_of, check_keys, meant_keys};

pub(crate) use files::TextFiles;
pub(crate) use origins::Origins;
pub(crate) use scope::{PLACE, Scope};
use values::Asked;

/// Context in which blocks are bound.
pub(crate) struct BlockBinder<'a> {
    /// Constants of the spec.
    pub constants: Constants<'a>,
    /// Diagnostics.
    pub diagnostics: &'a mut Vec<Diagnostic>,
    /// Places of bound texts.
    pub origins: &'a mut Origins,
    /// Members of the mission around the block.
    pub scope: &'a Scope,
    /// Files that keys name.
    pub files: TextFiles<'a>,
}

impl BlockBinder<'_> {
    /// Binds a block that is named at a place.
    pub fn block(&mut self, block: &Block, schema: &'static BlockSchema, named: Span) -> BoundBlock {
        check_keys(block, schema, self.diagnostics);
        self.entries(block, schema, named, |_| true)
    }

    /// Binds the good blocks of a value: one, or a list of blocks.
    pub fn blocks(&mut self, value: &Value, schema: &'static BlockSchema) -> Vec<Located<Bound>> {
        let mut all = Vec::new();
        for item in value.items() {
            if let Some(block) = block_of(item, schema.name, self.diagnostics) {
                let bound = self.block(block, schema, item.span);
                if !bound.has_wrong() {
                    all.push(Located { at: self.origins.add(item.span), value: Bound::Block(bound) });
                }
            }
        }
        all
    }

    /// Binds the value of a key that the readers of the syntaxes take.
    pub fn value_of_key(&mut self, key: &Key, value: &Value) -> Option<Located<Bound>> {
        self.value(value, Asked { name: key.name, at: value.span, key }, &key.value)
    }

    /// Binds those entries of a block that are `wanted`. The caller reports other keys.
    pub fn entries(
        &mut self,
        block: &Block,
        schema: &'static BlockSchema,
        named: Span,
        wanted: impl Fn(&str) -> bool,
    ) -> BoundBlock {
        let mut bound = BoundBlock::new(schema, self.origins.add(named));
        meant_keys(block, schema).for_each(|key| bound.mark_wrong(key));
        for key in schema.keys.iter().filter(|key| key.is_entry() && wanted(key.name)) {
            let Some(entry) = block.get(key.name) else {
                if key.presence == Presence::Required && !bound.is_wrong(key.name) {
                    self.missing(key, schema, named);
                    bound.mark_wrong(key.name);
                }
                continue;
            };
            let before = self.diagnostics.len();
            let asked = Asked { name: key.name, at: entry.key.span, key };
            let value = match key.is_bound {
                true => self.value(&entry.value, asked, &key.value),
                false => Some(Located { at: self.origins.add_unbound(&entry.value), value: Bound::Unbound }),
            };
            let refused = self.diagnostics[before..].iter().any(|d| d.severity == Severity::Error);
            if refused || value.as_ref().is_some_and(|value| values::holds_wrong(&value.value)) {
                bound.mark_wrong(key.name);
            }
            let at = self.origins.add(entry.key.span);
            bound.put(key.name, at, value);
        }
        bound
    }

    fn missing(&mut self, key: &Key, schema: &BlockSchema, named: Span) {
        let d = Diagnostic::missing_keys([key.name], named, format!("{} needs `{}`", schema.name, key.name));
        let d = d.help(Help::write_for_instance(key.written()));
        // Entries are added to the block after a name; an item of a list has none.
        let is_name = |text: &str| text.chars().all(|c| c.is_alphanumeric() || c == '_');
        let fix = (!key.example.is_empty() && is_name(self.files.sources.snippet(named)))
            .then(|| Fix::entries(named, vec![(key.name.to_string(), key.example.to_string())]));
        self.diagnostics.push(fix.into_iter().fold(d, Diagnostic::fix));
    }
}

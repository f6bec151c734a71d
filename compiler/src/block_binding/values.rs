//! Values of keys, by their types.

use dsl::tree::{Entry, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use names::{list, suggest};

use blocks::{Bound, BoundBlock, BoundEntry, Key, Located, Members, Named, ValueType};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE, RATE, VELOCITY};
use stdlib_tasks::params::Quantity;

use super::BlockBinder;
use crate::expr::constants::with_units;
use crate::expr::dimension_check::one_unit;
use crate::expr::{function, unusual};
use crate::forms::{block_of, path_of, text_of};
use crate::units;

/// Returns true if a mistake was reported inside a bound value.
pub(super) fn holds_wrong(bound: &Bound) -> bool {
    match bound {
        Bound::Block(block) => block.has_wrong(),
        Bound::List(items) => items.iter().any(|item| holds_wrong(&item.value)),
        Bound::Each(entries) => entries.iter().any(|e| holds_wrong(&e.value.value)),
        _ => false,
    }
}

/// Returns a name as the subject of a sentence. A part of a value has no name of its own: `the mean`.
fn named(name: &str) -> String {
    if name.contains(' ') { name.to_string() } else { format!("`{name}`") }
}

/// The key, or the name inside its value, that a value stands behind.
#[derive(Clone, Copy)]
pub(super) struct Asked<'k> {
    /// The name.
    pub name: &'k str,
    /// Its span.
    pub at: Span,
    /// The key.
    pub key: &'k Key,
}

impl BlockBinder<'_> {
    /// Binds a value of a type. `None` if it is wrong; the diagnostics say why.
    pub(super) fn value(&mut self, value: &Value, asked: Asked, of: &ValueType) -> Option<Located<Bound>> {
        let name = asked.name;
        let bound = match of {
            ValueType::Number(q) => Bound::Number(self.number(value, name, q)?),
            ValueType::Function(of) => Bound::Function(self.function(value, asked, of)?),
            ValueType::Count(q) => Bound::Number(self.count(value, name, q)?),
            ValueType::Numbers(q) => match with_units(value) {
                Some(items) => Bound::Several(self.all(&items, |b, item| b.number(item, name, q))?),
                None => Bound::One(self.number(value, name, q)?),
            },
            ValueType::Range(q) => Bound::Range(match with_units(value) {
                Some(items) => {
                    let two = self.two(value, &items, q.dimension, asked)?;
                    self.diagnostics.extend(unusual(value, &named(name), &two, q));
                    two
                }
                None => {
                    let one = self.constant(value, q.dimension)?;
                    self.diagnostics.extend(unusual(value, &named(name), &[one], q));
                    [one; 2]
                }
            }),
            ValueType::Spread(q) => Bound::Spread(self.spread(value, name, q)?),
            ValueType::Pair(dimension) => Bound::Pair(self.pair(value, *dimension, asked)?),
            ValueType::Vector(q) => Bound::Vector(self.vector(value, name, q)?),
            ValueType::Spot => Bound::Vector(self.spot(value)?),
            ValueType::Text => Bound::Text(self.text(value, asked)?),
            ValueType::Spec => Bound::Text(self.text(value, asked)?),
            ValueType::Urdf | ValueType::Srdf => Bound::Text(match text_of(value) {
                Some(path) => path.to_string(),
                None => self.wrong_form(value, format!("`{name}` is the path of one file"), asked)?,
            }),
            ValueType::File => return self.file(value, asked),
            ValueType::FileWith(companion) => return self.file_with(value, asked, companion),
            ValueType::Binary(format) => return self.binary(value, asked, format),
            ValueType::Flag => Bound::Flag(self.flag(value, name)?),
            ValueType::Choice(words) => Bound::Word(self.word(value, name, words)?),
            ValueType::NewName => Bound::Text(self.new_name(value, asked)?),
            ValueType::Name(Named::Own(members)) => Bound::Member(self.member(value, name, members)?),
            ValueType::Name(named) => Bound::Text(self.name(value, name, *named)?),
            ValueType::List(inner) => Bound::List(self.items(value, asked, inner)),
            ValueType::Each(inner) => Bound::Each(self.each(value, asked, inner, None)?),
            ValueType::Of(Named::Own(members), inner) => Bound::Each(self.each(value, asked, inner, Some(members))?),
            ValueType::Of(_, inner) | ValueType::PerJoint(inner) => Bound::Each(self.each(value, asked, inner, None)?),
            ValueType::Block(schema) => {
                let block = block_of(value, &format!("`{name}`"), self.diagnostics)?;
                Bound::Block(self.block(block, schema, asked.at))
            }
            ValueType::Blocks(schema) => Bound::List(self.blocks(value, schema)),
            ValueType::Link => Bound::Text(self.link(value)?),
            ValueType::LinkOr(schema) => Bound::Block(match &value.kind {
                ValueKind::Block(block) => self.block(block, schema, asked.at),
                _ => {
                    let link = Located { at: self.origins.add(value.span), value: Bound::Text(self.link(value)?) };
                    let mut block = BoundBlock::new(schema, self.origins.add(asked.at));
                    block.put("link", link.at, Some(link));
                    block
                }
            }),
            ValueType::NumberOr(q, words) => self.number_or(value, name, q, words)?,
            _ => return Some(Located { at: self.origins.add_unbound(value), value: Bound::Unbound }),
        };
        Some(Located { at: self.origins.add(value.span), value: bound })
    }

    /// Binds each item, so that all mistakes are reported.
    fn all<T>(&mut self, items: &[Value], mut one: impl FnMut(&mut Self, &Value) -> Option<T>) -> Option<Vec<T>> {
        let all: Vec<Option<T>> = items.iter().map(|item| one(self, item)).collect();
        all.into_iter().collect()
    }

    /// Evaluates a constant number of a dimension.
    fn constant(&mut self, value: &Value, dimension: Dimension) -> Option<f64> {
        self.constants.scalar(value, dimension, self.diagnostics)
    }

    /// Evaluates a constant number inside its range.
    pub(super) fn number(&mut self, value: &Value, name: &str, q: &Quantity) -> Option<f64> {
        if let Some(items) = with_units(value) {
            self.not_one(value, name, &items, q);
            return None;
        }
        let x = self.constant(value, q.dimension)?;
        if q.contains(x) {
            self.diagnostics.extend(unusual(value, &named(name), &[x], q));
            return Some(x);
        }
        let in_hertz = q.dimension == RATE && self.files.sources.snippet(value.span).ends_with("Hz");
        let (unit, shown) = match in_hertz {
            true => ("Hz".to_string(), format!("{} Hz", runtime::text::number(x))),
            false => (units::written(q.dimension), units::shown(x, q.dimension)),
        };
        let range = q.describe();
        let range = if q.dimension == NONE { range } else { format!("{range} {unit}") };
        let text = format!("{} must be {range}, and this is {shown}", named(name));
        let d = Diagnostic::error("HQ0308", value.span, text);
        self.diagnostics.push(d.help(format!("write a number that is {range}")));
        None
    }

    /// Reports a list in the place of one number; of speeds the greatest one counts.
    fn not_one(&mut self, value: &Value, name: &str, items: &[Value], q: &Quantity) {
        let constants = &mut self.constants;
        let mut numbers = items.iter().filter_map(|item| constants.scalar(item, q.dimension, &mut Vec::new()));
        let (which, x) = match q.dimension {
            VELOCITY => ("the greatest one", numbers.reduce(f64::max)),
            _ => ("one of them", numbers.next()),
        };
        let text = format!("`{name}` is one number, and this list has {}", items.len());
        // The list without the unit after it.
        let list = if let ValueKind::Unit(list, _) = &value.kind { list } else { value };
        let d = Diagnostic::error("HQ0310", list.span, text);
        self.diagnostics.push(match x.filter(|x| q.contains(*x)) {
            Some(x) => d.help(Help::with(
                &format!("write {which}, {{}}"),
                [Snippet::entry(name, units::shown(x, q.dimension))],
            )),
            None => d.help("write one number without brackets"),
        });
    }

    /// A number, or one of the words of a key.
    fn number_or(&mut self, value: &Value, name: &str, q: &Quantity, words: &'static [&'static str]) -> Option<Bound> {
        let found = text_of(value);
        if let Some(word) = words.iter().find(|word| Some(**word) == found) {
            return Some(Bound::Word(word));
        }
        let before = self.diagnostics.len();
        let number = self.number(value, name, q);
        if let Some(near) = found.and_then(|word| suggest(word, words.iter().copied()))
            && let Some(unknown) = self.diagnostics.get_mut(before)
        {
            *unknown = unknown.clone().meant(near);
        }
        number.map(Bound::Number)
    }

    /// The name of a link, which is looked up on the robot.
    fn link(&mut self, value: &Value) -> Option<String> {
        if let Some(name) = text_of(value) {
            return Some(name.to_string());
        }
        if !matches!(value.kind, ValueKind::Missing) {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a link is needed here");
            self.diagnostics.push(d.help(Help::with(
                "write {}, such as {}",
                [Snippet::entry("NAME", "LINK"), Snippet::entry("elbow", "link_4")],
            )));
        }
        None
    }

    /// Evaluates a whole number.
    fn count(&mut self, value: &Value, name: &str, q: &Quantity) -> Option<f64> {
        let x = self.number(value, name, q)?;
        if x.fract() == 0.0 {
            return Some(x);
        }
        let d = Diagnostic::error("HQ0308", value.span, format!("`{name}` must be a whole number, and this is {x}"));
        self.diagnostics.push(d.help("remove the part after the point"));
        None
    }

    /// Evaluates exactly two constant numbers of a list, with or without a unit behind it.
    fn two(&mut self, value: &Value, items: &[Value], dimension: Dimension, asked: Asked) -> Option<[f64; 2]> {
        if items.len() != 2 {
            let text = format!("two numbers are needed here, and these are {}", items.len());
            let d = Diagnostic::error("HQ0310", value.span, text);
            self.diagnostics.push(d.help(Help::write_for_instance(asked.key.written())));
            return None;
        }
        let before = self.diagnostics.len();
        let numbers = self.all(items, |b, item| b.constant(item, dimension));
        one_unit(self.diagnostics, before, value, items.len());
        <[f64; 2]>::try_from(numbers?).ok()
    }

    fn pair(&mut self, value: &Value, dimension: Dimension, asked: Asked) -> Option<[f64; 2]> {
        if let Some(items) = with_units(value) {
            return self.two(value, &items, dimension, asked);
        }
        self.wrong_form(value, format!("`{}` is a point of the ground, two numbers", asked.name), asked)
    }

    /// Reports a value of another form.
    pub(super) fn wrong_form<T>(&mut self, value: &Value, text: String, asked: Asked) -> Option<T> {
        if !matches!(value.kind, ValueKind::Missing) {
            let d = Diagnostic::error("HQ0304", value.span, text);
            self.diagnostics.push(d.help(Help::write_for_instance(asked.key.written())));
        }
        None
    }

    fn spread(&mut self, value: &Value, name: &str, q: &Quantity) -> Option<[f64; 2]> {
        let ValueKind::Call(called, args) = &value.kind else { return Some([self.number(value, name, q)?, 0.0]) };
        if called.value != "normal" && function(&called.value).is_none() {
            let text = format!("there is no distribution `{}`", called.value);
            let d = Diagnostic::unknown_name(called.span, text);
            self.diagnostics.push(d.help("a duration is a time, or `normal(mean, deviation)`"));
            return None;
        }
        if called.value != "normal" {
            return Some([self.number(value, name, q)?, 0.0]);
        }
        let [mean, sigma] = args.as_slice() else {
            let text =
                format!("`normal` needs two numbers, a mean and a standard deviation, and here is {}", args.len());
            let d = Diagnostic::error("HQ0310", value.span, text);
            self.diagnostics.push(d.help("write for instance `normal(204 s, 20 s)`"));
            return None;
        };
        let mean = self.number(mean, "the mean", q);
        let sigma = self.number(sigma, "the standard deviation", &Quantity::at_least(q.dimension, 0.0));
        Some([mean?, sigma?])
    }

    fn vector(&mut self, value: &Value, name: &str, q: &Quantity) -> Option<[f64; 3]> {
        if let ValueKind::Name(place) = &value.kind
            && !self.constants.params.knows(place)
            && self.scope.has_place(place)
        {
            let d =
                Diagnostic::error("HQ0304", value.span, format!("`{place}` is a place, and a place has a position"));
            self.diagnostics.push(d.help(Help::with(
                "write the position itself, for instance {}",
                [Snippet::entry("at", "[0.4, 0, 0.1] m")],
            )));
            return None;
        }
        let x = self.constants.vector(value, q.dimension, self.diagnostics)?;
        self.diagnostics.extend(unusual(value, &named(name), &x, q));
        Some(x)
    }

    /// A position (m): that of a place, or one that is written out.
    fn spot(&mut self, value: &Value) -> Option<[f64; 3]> {
        let ValueKind::Name(name) = &value.kind else {
            return self.constants.vector(value, LENGTH, self.diagnostics);
        };
        if let Some(place) = self.scope.places.get(name) {
            return Some(*place);
        }
        if self.constants.params.knows(name) {
            return self.constants.vector(value, LENGTH, self.diagnostics);
        }
        let d = Diagnostic::undeclared("place", name, value.span);
        let names = || self.scope.places.keys().map(String::as_str);
        self.diagnostics.push(match suggest(name, names()) {
            Some(near) => d.meant(near),
            None if self.scope.places.is_empty() => d.help(Help::with(
                "declare it, {}, or write a position",
                [Snippet::declared("place", name, [Snippet::entry("at", "[0.4, 0, 0.1] m")])],
            )),
            None => d.help(format!("declared are {}; or write a position", list(names(), 12))),
        });
        None
    }

    fn text(&mut self, value: &Value, asked: Asked) -> Option<String> {
        match text_of(value) {
            Some(text) => Some(text.to_string()),
            None => self.wrong_form(value, format!("`{}` is a text", asked.name), asked),
        }
    }

    fn flag(&mut self, value: &Value, name: &str) -> Option<bool> {
        match text_of(value) {
            Some("true") => return Some(true),
            Some("false") => return Some(false),
            _ if matches!(value.kind, ValueKind::Missing) => {}
            _ => {
                let d = Diagnostic::error("HQ0304", value.span, format!("`{name}` is `true` or `false`"));
                self.diagnostics.push(d.help("write one of the two"));
            }
        }
        None
    }

    /// One of the words of a key.
    fn word(&mut self, value: &Value, name: &str, words: &'static [&'static str]) -> Option<&'static str> {
        let found = text_of(value);
        if let Some(word) = words.iter().find(|word| Some(**word) == found) {
            return Some(word);
        }
        if matches!(value.kind, ValueKind::Missing) {
            return None;
        }
        let text = format!("`{name}` is one of {}", list(words.iter().copied(), 8));
        let d = Diagnostic::error("HQ0304", value.span, text);
        self.diagnostics.push(match found.and_then(|word| suggest(word, words.iter().copied())) {
            Some(near) => d.meant(near),
            None => d.help(Help::write_for_instance(Snippet::entry(name, words.first().copied().unwrap_or_default()))),
        });
        None
    }

    /// A name that is given here.
    fn new_name(&mut self, value: &Value, asked: Asked) -> Option<String> {
        match text_of(value) {
            Some(word) => Some(word.to_string()),
            None => self.wrong_form(value, format!("`{}` are words", asked.name), asked),
        }
    }

    /// The name of something that is looked up elsewhere.
    fn name(&mut self, value: &Value, name: &str, named: Named) -> Option<String> {
        if let Some(path) = path_of(value) {
            return Some(path);
        }
        if !matches!(value.kind, ValueKind::Missing) {
            let (noun, help) = match named {
                Named::Member | Named::Person => {
                    ("member of the mission", "write it as the mission declares it".into())
                }
                Named::SignalThere(_) => ("signal", "write the name that it has in the other spec".into()),
                Named::State => ("state", "write the name of one of its states".into()),
                Named::StateThere => ("state", "write the name that it has in the other spec".into()),
                _ => (name, format!("write the name of a declared {name}")),
            };
            let d = Diagnostic::error("HQ0304", value.span, format!("`{name}` is the name of a {noun}"));
            self.diagnostics.push(d.help(help));
        }
        None
    }

    /// Index of a member that a key names.
    fn member(&mut self, value: &Value, name: &str, of: &Members) -> Option<usize> {
        if let Some(word) = text_of(value) {
            return self.member_called(word, value.span, of);
        }
        let first = match &value.kind {
            ValueKind::Missing => return None,
            ValueKind::List(items) => items.first().and_then(text_of),
            _ => None,
        };
        let noun = of.noun;
        let text = match first {
            Some(_) => format!("`{name}` is one name, not a list"),
            None => format!("`{name}` is the name of an {noun} of this mission"),
        };
        let d = Diagnostic::error("HQ0304", value.span, text);
        let names = self.scope.names(of);
        self.diagnostics.push(match first.or(names.first().copied()) {
            Some(word) => d.help(Help::write_for_instance(Snippet::entry(name, word))),
            None => d.help("leave it out"),
        });
        None
    }

    /// Index of a member of this name; reports an unknown one.
    fn member_called(&mut self, name: &str, at: Span, of: &Members) -> Option<usize> {
        let names = self.scope.names(of);
        let found = names.iter().position(|known| *known == name);
        if found.is_none() {
            let noun = of.noun;
            let d = Diagnostic::unknown_name(at, format!("there is no {noun} `{name}` of this mission"));
            self.diagnostics.push(d.help(format!("this spec declares no {noun}")).one_of(
                "declared are",
                name,
                names.iter().copied(),
            ));
        }
        found
    }

    /// Binds the good items of a list.
    fn items(&mut self, value: &Value, asked: Asked, inner: &ValueType) -> Vec<Located<Bound>> {
        let items = with_units(value).unwrap_or_else(|| value.items().to_vec());
        items.iter().filter_map(|item| self.value(item, asked, inner)).collect()
    }

    /// Binds the good values by name of a block.
    fn each(
        &mut self,
        value: &Value,
        asked: Asked,
        inner: &ValueType,
        of: Option<&Members>,
    ) -> Option<Vec<BoundEntry>> {
        let block = block_of(value, &format!("`{}`", asked.name), self.diagnostics)?;
        let mut all = Vec::new();
        for Entry { key, value, .. } in &block.entries {
            let member = of.map(|of| self.member_called(&key.value, key.span, of));
            let value = self.value(value, Asked { name: &key.value, at: key.span, key: asked.key }, inner);
            if let (Some(value), false) = (value, member == Some(None)) {
                let name = Located { at: self.origins.add(key.span), value: key.value.clone() };
                all.push(BoundEntry { name, member: member.flatten(), value });
            }
        }
        Some(all)
    }
}

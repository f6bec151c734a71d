//! Parses a line of JSON. Sizes and signs are checked later.
//!
//! Matrices are read directly into one vector, so the memory for a line is a small multiple of its length.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::{MAX_ROWS, MAX_VARIABLES, Refusal};

/// A tick as written, unchecked.
pub struct LoggedProblem {
    pub id: String,
    pub kind: Option<String>,
    pub n: u64,
    pub levels: Vec<Level>,
    pub reference: Option<List<f64>>,
    pub x: Option<List<f64>>,
    pub viol: Option<List<f64>>,
}

/// A list with at most [`MAX_ROWS`] entries.
pub struct List<T>(pub Vec<T>);

/// A level as written, unchecked.
pub struct Level(pub LevelKeys);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelKeys {
    #[serde(rename = "A")]
    pub a: Matrix,
    pub lo: List<Option<f64>>,
    pub up: List<Option<f64>>,
    pub weight: Option<List<f64>>,
    pub hard: Option<bool>,
    pub damping: Option<f64>,
}

/// Coefficients of a level as written, unchecked.
pub enum Matrix {
    /// Rows of equal length.
    Rows { count: usize, width: usize, numbers: Vec<f64> },
    /// This number of identity matrices, stacked vertically.
    Identities(u64),
}

/// Parses a line.
pub fn parse(line: &[u8]) -> Result<LoggedProblem, Refusal> {
    let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
    let Ok(text) = std::str::from_utf8(line) else {
        return Err(Refusal::new("this is not UTF-8", "save the file as UTF-8"));
    };
    serde_json::from_str(text).map_err(|e| refusal(text, &e))
}

fn refusal(text: &str, error: &serde_json::Error) -> Refusal {
    use serde_json::error::Category;
    let message = error.to_string();
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |m| m.0);
    let message = match message.strip_suffix("expected f64") {
        Some(before) => format!("{before}expected a number"),
        None => message.to_string(),
    };
    let at = error.column().max(1);
    match error.classify() {
        Category::Eof => Refusal::new("the line ends in the middle", "see whether the file was cut short"),
        Category::Data => Refusal::new(format!("column {at}: {message}"), remedy(&message)),
        Category::Syntax | Category::Io => match not_a_number(text, at) {
            Some(word) => Refusal::new(
                format!("column {at}: `{word}` is no JSON"),
                "write `null` for a bound that does not exist, and leave out ticks whose numbers are not finite",
            ),
            None if message == "number out of range" => Refusal::new(
                format!("column {at}: a number that is too large for a double"),
                "write `null` for a bound that does not exist",
            ),
            None => Refusal::new(format!("column {at}: no JSON, {message}"), "write one JSON object a line"),
        },
    }
}

/// Help for JSON of the wrong form.
fn remedy(message: &str) -> &'static str {
    let remedies = [
        ("missing field", "add the key; `hierarq solve --help` shows a line"),
        ("duplicate field", "keep one of them"),
        ("unknown field", "correct the spelling, or leave the key out"),
        ("unknown key", "correct the spelling, or give the key another name if it is meant as something else"),
        ("row ", "give every row one number for each variable"),
        ("a list has", "see whether this is the file you meant"),
        ("`A` has", "see whether this is the file you meant"),
    ];
    let found = remedies.into_iter().find(|r| message.starts_with(r.0));
    found.map_or("`hierarq solve --help` shows what a line must hold", |r| r.1)
}

/// Word for a non-finite number, if the JSON parser stopped at one.
fn not_a_number(text: &str, column: usize) -> Option<&'static str> {
    let from = column.saturating_sub(10);
    let near = text.as_bytes().get(from..text.len().min(column + 8))?;
    let holds = |word: &&str| near.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word.as_bytes()));
    ["-Infinity", "Infinity", "NaN"].into_iter().find(holds)
}

/// Stores the value of a key; an error if it has one already.
fn once<'de, A: MapAccess<'de>, T: Deserialize<'de>>(
    slot: &mut Option<T>,
    key: &'static str,
    map: &mut A,
) -> Result<(), A::Error> {
    if slot.is_some() {
        return Err(A::Error::duplicate_field(key));
    }
    *slot = Some(map.next_value()?);
    Ok(())
}

impl<'de> Deserialize<'de> for LoggedProblem {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Keys;
        impl<'de> Visitor<'de> for Keys {
            type Value = LoggedProblem;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object with `id`, `n` and `levels`")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<LoggedProblem, A::Error> {
                let (mut id, mut n, mut levels) = (None, None::<Whole>, None::<List<Level>>);
                // Optional keys may be missing or null.
                let (mut kind, mut reference, mut x, mut viol) = (None, None, None, None);
                while let Some(key) = map.next_key::<String>()? {
                    match key.as_str() {
                        "id" => once(&mut id, "id", &mut map)?,
                        "kind" => once(&mut kind, "kind", &mut map)?,
                        "n" => once(&mut n, "n", &mut map)?,
                        "levels" => once(&mut levels, "levels", &mut map)?,
                        "reference" => once(&mut reference, "reference", &mut map)?,
                        "x" => once(&mut x, "x", &mut map)?,
                        "viol" => once(&mut viol, "viol", &mut map)?,
                        other => {
                            if let Some(near) = compiler::names::suggest(other, ["kind", "reference", "viol"]) {
                                let text = format!("unknown key `{other}`, which is close to `{near}`");
                                return Err(A::Error::custom(text));
                            }
                            map.next_value::<IgnoredAny>()?;
                        }
                    }
                }
                Ok(LoggedProblem {
                    id: id.ok_or_else(|| A::Error::missing_field("id"))?,
                    kind: kind.flatten(),
                    n: n.ok_or_else(|| A::Error::missing_field("n"))?.0,
                    levels: levels.ok_or_else(|| A::Error::missing_field("levels"))?.0,
                    reference: reference.flatten(),
                    x: x.flatten(),
                    viol: viol.flatten(),
                })
            }
        }
        deserializer.deserialize_map(Keys)
    }
}

impl<'de> Deserialize<'de> for Level {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Keys;
        impl<'de> Visitor<'de> for Keys {
            type Value = Level;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a level, an object with `A`, `lo` and `up`")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Level, A::Error> {
                LevelKeys::deserialize(MapAccessDeserializer::new(map)).map(Level)
            }
        }
        deserializer.deserialize_map(Keys)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
            type Value = List<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<List<T>, A::Error> {
                let mut list = Vec::new();
                while let Some(entry) = seq.next_element()? {
                    if list.len() == MAX_ROWS {
                        return Err(A::Error::custom(format!("a list has more than {MAX_ROWS} entries")));
                    }
                    list.push(entry);
                }
                Ok(List(list))
            }
        }
        deserializer.deserialize_seq(Entries(PhantomData))
    }
}

/// A non-negative integer.
struct Whole(u64);

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Number;
        impl Visitor<'_> for Number {
            type Value = Whole;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a whole number, zero or more")
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Whole, E> {
                Ok(Whole(value))
            }
        }
        deserializer.deserialize_u64(Number)
    }
}

impl<'de> Deserialize<'de> for Matrix {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Rows;
        impl<'de> Visitor<'de> for Rows {
            type Value = Matrix;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of rows, or {\"identity\": k}")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Matrix, A::Error> {
                let (mut count, mut width, mut numbers) = (0, 0, Vec::new());
                while let Some(length) = seq.next_element_seed(Row(&mut numbers))? {
                    if count > 0 && length != width {
                        let text =
                            format!("row {count} of `A` (counted from 0) is {length} long, those above it {width}");
                        return Err(A::Error::custom(text));
                    }
                    (count, width) = (count + 1, length);
                }
                Ok(Matrix::Rows { count, width, numbers })
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Matrix, A::Error> {
                let mut identities = None::<Whole>;
                while let Some(key) = map.next_key::<String>()? {
                    if key != "identity" {
                        return Err(A::Error::unknown_field(&key, &["identity"]));
                    }
                    once(&mut identities, "identity", &mut map)?;
                }
                let count = identities.ok_or_else(|| A::Error::missing_field("identity"))?;
                Ok(Matrix::Identities(count.0))
            }
        }
        deserializer.deserialize_any(Rows)
    }
}

/// Appends a row to the numbers read before, and returns its length.
struct Row<'a>(&'a mut Vec<f64>);

impl<'de> DeserializeSeed<'de> for Row<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Row<'_> {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a row, a list of numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<usize, A::Error> {
        let before = self.0.len();
        while let Some(number) = seq.next_element::<f64>()? {
            if self.0.len() == MAX_ROWS * MAX_VARIABLES {
                return Err(A::Error::custom("`A` has more numbers than any problem that is solved"));
            }
            self.0.push(number);
        }
        Ok(self.0.len() - before)
    }
}

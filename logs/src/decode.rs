//! Reader of CDR that knows nothing but the definition that stands beside a message: numbers and texts with their paths, such as
//! `position[3]` and `transforms[2].transform.translation.x`.

use std::collections::BTreeMap;

use crate::cdr::HEADER;

/// A number or a text of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A floating-point number.
    Number(f64),
    /// A whole number or a truth value.
    Integer(i64),
    /// A text.
    Text(String),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Number(x) => write!(f, "{x}"),
            Value::Integer(x) => write!(f, "{x}"),
            Value::Text(text) => write!(f, "`{text}`"),
        }
    }
}

/// A value with its path.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// Names of fields with a point between them, and indices in brackets.
    pub path: String,
    /// The value.
    pub value: Value,
}

/// Reason why a message cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// It is not plain CDR in little endian.
    #[error("the message is not plain CDR in little endian")]
    Header,
    /// It is shorter than its definition demands.
    #[error("the message ends within `{0}`")]
    End(String),
    /// It is longer.
    #[error("{0} bytes follow after the last field")]
    Rest(usize),
    /// A type of the definition is not known.
    #[error("the definition has a type `{0}` that is not known")]
    Type(String),
}

/// A field of a definition.
#[derive(Clone, Debug)]
struct Field {
    of: String,
    array: bool,
    name: String,
}

/// A definition with its parts.
#[derive(Clone, Debug)]
pub struct Schema {
    root: Vec<Field>,
    parts: BTreeMap<String, Vec<Field>>,
}

fn fields(text: &str) -> Vec<Field> {
    let field = |line: &str| {
        let mut words = line.split_whitespace();
        let (of, name) = (words.next()?, words.next()?);
        let (of, array) = of.strip_suffix("[]").map_or((of, false), |of| (of, true));
        Some(Field { of: of.to_string(), array, name: name.to_string() })
    };
    text.lines().filter_map(field).collect()
}

impl Schema {
    /// Reads a definition in the encoding `ros2msg`.
    pub fn new(text: &str) -> Schema {
        let line = "=".repeat(80);
        let mut sections = text.split(line.as_str());
        let root = fields(sections.next().unwrap_or_default());
        let part = |section: &str| {
            let (name, rest) = section.trim_start().strip_prefix("MSG: ")?.split_once('\n')?;
            Some((name.trim().to_string(), fields(rest)))
        };
        Schema { root, parts: sections.filter_map(part).collect() }
    }

    /// Reads a message.
    ///
    /// # Errors
    /// The message is not of this definition.
    pub fn decode(&self, message: &[u8]) -> Result<Vec<Leaf>, DecodeError> {
        let body = message.strip_prefix(&HEADER).ok_or(DecodeError::Header)?;
        let mut reader = Reader { body, at: 0, leaves: Vec::new() };
        self.read_all(&self.root, "", &mut reader)?;
        match body.len() - reader.at {
            0 => Ok(reader.leaves),
            rest => Err(DecodeError::Rest(rest)),
        }
    }

    fn read_all(&self, fields: &[Field], prefix: &str, reader: &mut Reader) -> Result<(), DecodeError> {
        for field in fields {
            let path = if prefix.is_empty() { field.name.clone() } else { format!("{prefix}.{}", field.name) };
            if !field.array {
                self.read(&field.of, path, reader)?;
                continue;
            }
            let count = u32::from_le_bytes(reader.take(&path)?);
            for i in 0..count {
                // Each element has at least one byte, so that a wrong count ends here.
                self.read(&field.of, format!("{path}[{i}]"), reader)?;
            }
        }
        Ok(())
    }

    fn read(&self, of: &str, path: String, reader: &mut Reader) -> Result<(), DecodeError> {
        let value = match of {
            "float64" => Value::Number(f64::from_le_bytes(reader.take(&path)?)),
            "float32" => Value::Number(f64::from(f32::from_le_bytes(reader.take(&path)?))),
            "int32" => Value::Integer(i64::from(i32::from_le_bytes(reader.take(&path)?))),
            "uint32" => Value::Integer(i64::from(u32::from_le_bytes(reader.take(&path)?))),
            "uint8" | "byte" | "bool" => Value::Integer(i64::from(u8::from_le_bytes(reader.take(&path)?))),
            "string" => Value::Text(reader.text(&path)?),
            part => {
                let fields = self.parts.get(part).ok_or_else(|| DecodeError::Type(part.to_string()))?;
                return self.read_all(fields, &path, reader);
            }
        };
        reader.leaves.push(Leaf { path, value });
        Ok(())
    }
}

struct Reader<'m> {
    body: &'m [u8],
    at: usize,
    leaves: Vec<Leaf>,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self, path: &str) -> Result<[u8; N], DecodeError> {
        let from = self.at.next_multiple_of(N);
        let bytes = self.body.get(from..from + N).and_then(|b| b.try_into().ok());
        self.at = from + N;
        bytes.ok_or_else(|| DecodeError::End(path.to_string()))
    }

    fn text(&mut self, path: &str) -> Result<String, DecodeError> {
        let end = || DecodeError::End(path.to_string());
        let len = u32::from_le_bytes(self.take(path)?) as usize;
        let bytes = self.body.get(self.at..self.at.saturating_add(len)).ok_or_else(end)?;
        self.at += len;
        let text = bytes.strip_suffix(&[0]).ok_or_else(end)?;
        Ok(String::from_utf8_lossy(text).into_owned())
    }
}

//! Numbers in rows of equal columns, as text or as bytes: the body of a point cloud.

use nalgebra::Vector3;

/// Largest number of bytes of a row.
const MOST_STRIDE: usize = 1 << 16;

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NumberType {
    pub bytes: usize,
    pub kind: NumberKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberKind {
    Signed,
    Unsigned,
    Float,
}

/// A column: its name, type, and the number of numbers in it.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub name: String,
    pub number: NumberType,
    pub count: usize,
}

/// Form of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// The columns of x, y and z: index of the number in a row of text, and byte in one of bytes.
struct Place {
    word: usize,
    byte: usize,
    number: NumberType,
}

/// Reads the columns `x`, `y` and `z` of the first `rows` rows.
pub(super) fn points(
    columns: &[Column],
    rows: usize,
    encoding: Encoding,
    body: &[u8],
) -> Result<Vec<Vector3<f64>>, String> {
    let (mut word, mut byte) = (0usize, 0usize);
    let mut places: [Option<Place>; 3] = [None, None, None];
    for c in columns {
        if let Some(axis) = ["x", "y", "z"].iter().position(|name| *name == c.name)
            && c.count == 1
        {
            places[axis] = Some(Place { word, byte, number: c.number });
        }
        word = word.saturating_add(c.count);
        byte = byte.saturating_add(c.count.saturating_mul(c.number.bytes));
    }
    let [Some(x), Some(y), Some(z)] = places else {
        return Err("it has no columns x, y and z".into());
    };
    let places = [x, y, z];
    if byte > MOST_STRIDE {
        return Err(format!("a row of it has {byte} bytes"));
    }
    match encoding {
        Encoding::Text => text(&places, rows, body),
        _ => binary(&places, rows, byte, encoding, body),
    }
}

fn text(places: &[Place; 3], rows: usize, body: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    let text = String::from_utf8_lossy(body);
    let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty());
    // The count is the file's word, and reserves no memory.
    let mut found = Vec::new();
    for row in 1..=rows {
        let line = lines.next().ok_or_else(|| cut_off(row - 1, rows))?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut p = Vector3::zeros();
        for (x, place) in p.iter_mut().zip(places) {
            let word = words.get(place.word).ok_or_else(|| format!("point {row} of it has too few numbers"))?;
            *x = word.parse().map_err(|_| format!("`{word}` in point {row} of it is no number"))?;
        }
        found.push(p);
    }
    Ok(found)
}

fn binary(
    places: &[Place; 3],
    rows: usize,
    stride: usize,
    encoding: Encoding,
    body: &[u8],
) -> Result<Vec<Vector3<f64>>, String> {
    let whole = body.len() / stride;
    if whole < rows {
        return Err(cut_off(whole, rows));
    }
    let point = |row: &[u8]| {
        let number = |p: &Place| p.number.read(&row[p.byte..p.byte + p.number.bytes], encoding == Encoding::Big);
        let [x, y, z] = places;
        Vector3::new(number(x), number(y), number(z))
    };
    Ok(body.chunks_exact(stride).take(rows).map(point).collect())
}

fn cut_off(rows: usize, of: usize) -> String {
    format!("it is cut off: {rows} of its {of} points are there")
}

impl NumberType {
    /// A number of some bytes, at most eight; NaN for a size that no number of the kind has.
    fn read(self, bytes: &[u8], big: bool) -> f64 {
        let mut all = [0u8; 8];
        for (i, b) in bytes.iter().take(8).enumerate() {
            all[if big { bytes.len() - 1 - i } else { i }] = *b;
        }
        let bits = u64::from_le_bytes(all);
        let unused = 64 - 8 * bytes.len() as u32;
        match (self.kind, bytes.len()) {
            (NumberKind::Float, 4) => f64::from(f32::from_bits(bits as u32)),
            (NumberKind::Float, 8) => f64::from_bits(bits),
            (NumberKind::Float, _) => f64::NAN,
            (NumberKind::Unsigned, _) => bits as f64,
            (NumberKind::Signed, _) => ((bits << unused) as i64 >> unused) as f64,
        }
    }
}

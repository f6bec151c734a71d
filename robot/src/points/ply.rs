//! PLY (Stanford polygon format) 1.0: the element `vertex`, as text or binary in either order of bytes.
//!
//! Source: Greg Turk, The PLY polygon file format (1994).

use nalgebra::Vector3;

use super::table::{Column, Encoding, NumberKind, NumberType, points as rows_of};
use super::{Header, header};

pub(super) fn points(bytes: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    if !bytes.starts_with(b"ply") {
        return Err("it is no PLY file: its first line is not `ply`".into());
    }
    let Header { lines, rest } =
        header(bytes, |l| l == "end_header").ok_or("its header is cut off: there is no `end_header`")?;
    let mut encoding = None;
    let mut vertices: Option<usize> = None;
    let mut columns: Vec<Column> = Vec::new();
    let mut element = String::new();
    for line in &lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["format", "ascii", _] => encoding = Some(Encoding::Text),
            ["format", "binary_little_endian", _] => encoding = Some(Encoding::Little),
            ["format", "binary_big_endian", _] => encoding = Some(Encoding::Big),
            ["element", name, count] => {
                if *name == "vertex" {
                    vertices = Some(count.parse().map_err(|_| format!("`{count}` is no number of vertices"))?);
                } else if vertices.is_none() {
                    return Err(format!("its element `{name}` comes before its vertices, which is not read"));
                }
                element = (*name).to_string();
            }
            ["property", "list", ..] if element == "vertex" => {
                return Err("its vertices have a list, which is not read".into());
            }
            ["property", ty, name] if element == "vertex" => {
                let number = number(ty).ok_or_else(|| format!("its type `{ty}` is unknown"))?;
                columns.push(Column { name: (*name).to_string(), number, count: 1 });
            }
            _ => {}
        }
    }
    let encoding = encoding.ok_or("its header has no `format`")?;
    let vertices = vertices.ok_or("its header has no `element vertex`")?;
    rows_of(&columns, vertices, encoding, rest)
}

fn number(name: &str) -> Option<NumberType> {
    let (bytes, kind) = match name {
        "char" | "int8" => (1, NumberKind::Signed),
        "uchar" | "uint8" => (1, NumberKind::Unsigned),
        "short" | "int16" => (2, NumberKind::Signed),
        "ushort" | "uint16" => (2, NumberKind::Unsigned),
        "int" | "int32" => (4, NumberKind::Signed),
        "uint" | "uint32" => (4, NumberKind::Unsigned),
        "float" | "float32" => (4, NumberKind::Float),
        "double" | "float64" => (8, NumberKind::Float),
        _ => return None,
    };
    Some(NumberType { bytes, kind })
}

//! PCD 0.7 of the Point Cloud Library: `DATA ascii` and `DATA binary`; `binary_compressed` is refused.
//!
//! Source: <https://pointclouds.org/documentation/tutorials/pcd_file_format.html>. `VIEWPOINT` is where the sensor was, and
//! moves nothing.

use nalgebra::Vector3;

use super::table::{Column, Encoding, NumberKind, NumberType, points as rows_of};
use super::{Header, header};

pub(super) fn points(bytes: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    let Header { lines, rest } =
        header(bytes, |l| l.starts_with("DATA ")).ok_or("its header is missing or cut off: there is no `DATA` line")?;
    let of = |key: &str| lines.iter().find_map(|l| l.strip_prefix(key).filter(|r| r.starts_with(' ')));
    let words = |key: &str| of(key).map(|r| r.split_whitespace().collect::<Vec<_>>());
    let fields = words("FIELDS").ok_or("its header has no `FIELDS`")?;
    let sizes = words("SIZE").ok_or("its header has no `SIZE`")?;
    let types = words("TYPE").ok_or("its header has no `TYPE`")?;
    let ones = vec!["1"; fields.len()];
    let counts = words("COUNT").unwrap_or(ones);
    if [sizes.len(), types.len(), counts.len()] != [fields.len(); 3] {
        return Err("its header has other numbers of `FIELDS`, `SIZE`, `TYPE` and `COUNT`".into());
    }
    let whole = |text: &str| text.trim().parse::<usize>().map_err(|_| format!("`{text}` in its header is no number"));
    let mut columns = Vec::new();
    for i in 0..fields.len() {
        let kind = match types[i] {
            "I" => NumberKind::Signed,
            "U" => NumberKind::Unsigned,
            "F" => NumberKind::Float,
            other => return Err(format!("its type `{other}` is unknown")),
        };
        let number = NumberType { bytes: whole(sizes[i])?, kind };
        if ![1, 2, 4, 8].contains(&number.bytes) || (kind == NumberKind::Float && number.bytes < 4) {
            return Err(format!("its field `{}` has numbers of {} bytes", fields[i], number.bytes));
        }
        columns.push(Column { name: fields[i].to_string(), number, count: whole(counts[i])? });
    }
    let count = match (of("POINTS"), of("WIDTH"), of("HEIGHT")) {
        (Some(n), ..) => whole(n)?,
        (None, Some(w), Some(h)) => whole(w)?.checked_mul(whole(h)?).ok_or("its size is too large")?,
        _ => return Err("its header has no `POINTS`".into()),
    };
    let encoding = match of("DATA").map(str::trim) {
        Some("ascii") => Encoding::Text,
        Some("binary") => Encoding::Little,
        Some("binary_compressed") => {
            return Err("it is compressed, which is not read: write it as `binary` or `ascii`".into());
        }
        _ => return Err("its `DATA` is neither `ascii` nor `binary`".into()),
    };
    rows_of(&columns, count, encoding, rest)
}

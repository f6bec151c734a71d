//! Parquet file of a sweep: one row per run, and a description of the sweep in its metadata.
//!
//! | key of the metadata | value |
//! |---|---|
//! | `spec`, `scenario`, `command`, `program` | as in [`Head`] |
//! | `columns` | JSON: for each column its name, its SI unit if it has one, and its param, expectation or limit |
//! | `sweep` | JSON: the [`Head`] |
//! | `checksum` | of all bytes except its own: XXH3, 128 bits |
//!
//! The bytes depend on head and rows alone. The file is written to a temporary file, which then replaces the target.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use files::{Output, Target};

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::Field;
use parquet::schema::types::Type;
use serde_json::json;

use super::checksum::{self, Seal};
use super::head::{Head, VERSION};
use super::row::{Cell, Column, Kind, Row, columns};

/// Maximum number of rows in a row group.
const GROUP: usize = 100_000;

/// Any Parquet file; [`target`] checks further.
const PARQUET: files::Kind = files::Kind { name: "the file of a sweep", begins: |head| head.starts_with(b"PAR1") };

/// Checks the output path of a sweep: a new file, or the file of a sweep, intact or damaged. Input files in `sources`
/// must not be overwritten.
///
/// # Errors
/// The file must not be overwritten; the message reports the reason.
pub fn target(path: &Path, sources: &[PathBuf]) -> Result<Target, String> {
    let shown = path.display();
    let target = Target::new("--out", path, PARQUET, sources)?;
    if target.is_stream() {
        return Err(format!("cannot write {shown}: it is a device or a pipe, and no file"));
    }
    let Ok(mut file) = files::open(path) else { return Ok(target) };
    let empty = file.metadata().is_ok_and(|about| about.len() == 0);
    match checksum::check(&mut file).map_err(|e| format!("cannot read {shown}: {e}"))? {
        Seal::Foreign | Seal::Unmarked if !empty => Err(format!(
            "`{shown}` is there already and is not {} that Hierarq wrote, so it is kept; give another file, or move it away",
            PARQUET.name
        )),
        _ => Ok(target),
    }
}

/// Writes a sweep.
///
/// # Errors
/// The file cannot be written.
pub fn write(target: Target, head: &Head, rows: &[Row]) -> Result<(), String> {
    let path = target.path().to_path_buf();
    let failed = |e: &dyn std::fmt::Display| format!("cannot write {}: {e}", path.display());
    let mut output = file_of(target.begin()?, head, rows).map_err(|e| failed(&e))?;
    checksum::seal(output.file()).map_err(|e| failed(&e))?;
    output.finish()
}

fn file_of(file: Output, head: &Head, rows: &[Row]) -> Result<Output, ParquetError> {
    let columns = columns(head);
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Arc::new(Type::group_type_builder("sweep").with_fields(fields).build()?);
    let properties = WriterProperties::builder()
        .set_created_by(head.generated_by.clone())
        .set_key_value_metadata(Some(metadata(head, &columns)?))
        .build();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
    for rows in rows.chunks(GROUP) {
        let cells: Vec<Vec<Cell>> = rows.iter().map(|row| row.cells(head)).collect();
        let mut group = writer.next_row_group()?;
        for (i, column) in columns.iter().enumerate() {
            write_column(&mut group, column, cells.iter().filter_map(|row| row.get(i)))?;
        }
        group.close()?;
    }
    writer.into_inner()
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Whole => (Physical::INT64, None),
        Kind::Truth => (Physical::BOOLEAN, None),
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let repetition = if column.always { Repetition::REQUIRED } else { Repetition::OPTIONAL };
    let builder = Type::primitive_type_builder(&column.name, physical);
    Ok(Arc::new(builder.with_repetition(repetition).with_logical_type(logical).build()?))
}

fn metadata(head: &Head, columns: &[Column]) -> Result<Vec<KeyValue>, ParquetError> {
    let column = |c: &Column| json!({ "name": c.name, "unit": c.unit, "of": c.of });
    let all: Vec<_> = columns.iter().map(column).collect();
    let sweep = serde_json::to_string(head).map_err(|e| ParquetError::General(e.to_string()))?;
    let pairs = [
        ("spec", head.spec.clone()),
        ("scenario", head.scenario.clone()),
        ("command", head.command.clone()),
        ("program", head.program.clone()),
        ("columns", json!(all).to_string()),
        ("sweep", sweep),
        ("checksum", checksum::blank()),
    ];
    Ok(pairs.into_iter().map(|(key, value)| KeyValue::new(key.to_string(), value)).collect())
}

/// Writes a column; its cells have the column's type.
fn write_column<'c>(
    group: &mut SerializedRowGroupWriter<'_, Output>,
    column: &Column,
    cells: impl Iterator<Item = &'c Cell>,
) -> Result<(), ParquetError> {
    match column.kind {
        Kind::Whole => values::<Int64Type>(group, column, cells, |c| match c {
            Cell::Whole(x) => x.and_then(|x| i64::try_from(x).ok()),
            _ => None,
        }),
        Kind::Truth => values::<BoolType>(group, column, cells, |c| match c {
            Cell::Truth(x) => *x,
            _ => None,
        }),
        Kind::Number => values::<DoubleType>(group, column, cells, |c| match c {
            Cell::Number(x) => *x,
            _ => None,
        }),
        Kind::Text => values::<ByteArrayType>(group, column, cells, |c| match c {
            Cell::Text(x) => x.as_deref().map(ByteArray::from),
            _ => None,
        }),
    }
}

fn values<'c, T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Output>,
    column: &Column,
    cells: impl Iterator<Item = &'c Cell>,
    value: impl Fn(&Cell) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let all: Vec<Option<T::T>> = cells.map(value).collect();
    let levels: Vec<i16> = all.iter().map(|x| i16::from(x.is_some())).collect();
    let there: Vec<T::T> = all.into_iter().flatten().collect();
    let Some(mut writer) = group.next_column()? else { return Ok(()) };
    writer.typed::<T>().write_batch(&there, (!column.always).then_some(&levels[..]), None)?;
    writer.close()
}

/// Reads a sweep.
///
/// # Errors
/// The file cannot be read, is not one of a sweep, or is damaged.
pub fn read(path: &Path) -> Result<(Head, Vec<Row>), String> {
    let shown = path.display();
    let cannot = |e: std::io::Error| format!("cannot read {shown}: {e}");
    let mut file = files::open(path).map_err(cannot)?;
    match checksum::check(&mut file).map_err(cannot)? {
        Seal::Foreign => return Err(format!("{shown} is no Parquet file")),
        Seal::Unmarked => return Err(format!("{shown} is no file of a sweep, or of another version")),
        Seal::Broken => {
            return Err(format!("{shown} is damaged: its checksum does not fit; copy it again, or run its part again"));
        }
        Seal::Whole => {}
    }
    // The library panics on some malicious files, which can have a valid checksum.
    let read = catch_unwind(AssertUnwindSafe(|| parsed(path, file)));
    read.unwrap_or_else(|_| Err(format!("{shown} cannot be read: it is no Parquet file that a sweep wrote")))
}

fn parsed(path: &Path, file: File) -> Result<(Head, Vec<Row>), String> {
    let shown = path.display();
    let reader = SerializedFileReader::new(file).map_err(|e| format!("{shown} is no Parquet file: {e}"))?;
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let text = pairs.into_iter().flatten().find(|p| p.key == "sweep").and_then(|p| p.value.clone());
    let head = text.and_then(|t| serde_json::from_str::<Head>(&t).ok()).filter(|h| h.version == VERSION);
    let head = head.ok_or_else(|| format!("{shown} is no file of a sweep, or of another version"))?;
    let kinds: Vec<Kind> = columns(&head).iter().map(|c| c.kind).collect();
    let mut rows = Vec::new();
    for record in reader.get_row_iter(None).map_err(|e| format!("cannot read {shown}: {e}"))? {
        let fields = record.map_err(|e| format!("cannot read {shown}: {e}"))?.into_columns();
        let known = fields.len() == kinds.len();
        let cells: Option<Vec<Cell>> = fields.into_iter().zip(&kinds).map(|(f, kind)| cell(f.1, *kind)).collect();
        let row = cells.filter(|_| known).and_then(|cells| Row::of(&head, cells));
        rows.push(row.ok_or_else(|| format!("{shown} has other columns than its own head says"))?);
    }
    Ok((head, rows))
}

/// Converts a value of a column of this type; `None` for another type.
fn cell(field: Field, kind: Kind) -> Option<Cell> {
    let empty = matches!(field, Field::Null);
    match (field, kind) {
        (Field::Long(x), Kind::Whole) => u64::try_from(x).ok().map(|x| Cell::Whole(Some(x))),
        (Field::Bool(x), Kind::Truth) => Some(Cell::Truth(Some(x))),
        (Field::Double(x), Kind::Number) => Some(Cell::Number(Some(x))),
        (Field::Str(x), Kind::Text) => Some(Cell::Text(Some(x))),
        (_, kind) => empty.then_some(match kind {
            Kind::Whole => Cell::Whole(None),
            Kind::Truth => Cell::Truth(None),
            Kind::Number => Cell::Number(None),
            Kind::Text => Cell::Text(None),
        }),
    }
}

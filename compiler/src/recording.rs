//! Recorded motions of people: comma-separated files with a header `time,chest.x,chest.y,chest.z,..`, in s and m.
//!
//! Cells may be quoted ([RFC 4180](https://www.rfc-editor.org/rfc/rfc4180)). Columns may have any order, and unknown
//! columns are ignored, so that one recording serves several specs. Each mistake is reported at its place in the file.

mod lines;

use std::collections::BTreeMap;
use std::path::Path;

use dsl::{Diagnostic, SourceId, Sources, Span, Spanned};
use lines::{Cell, Lines};
use names::{list, suggest};
use runtime::program::Track;

use crate::paths::instead_of;

/// Maximum size of the file (bytes).
const MAX_BYTES: u64 = 16 << 20;
/// Maximum number of data lines.
const MAX_ROWS: usize = 100_000;
/// Maximum number of stored numbers.
const MAX_NUMBERS: usize = 1_000_000;

type Refused = Box<Diagnostic>;

/// Indices of the required columns.
struct Columns {
    time: usize,
    /// Columns of x, y and z for each point.
    points: Vec<[usize; 3]>,
}

/// Reads the tracks of some points from a file that a spec names.
///
/// # Errors
/// The file cannot be read, or is malformed; the diagnostic points into the file.
pub(crate) fn read(
    path: &Spanned<String>,
    folder: &Path,
    points: &[&str],
    sources: &mut Sources,
) -> Result<Vec<Track>, Refused> {
    let text = text_of(path, folder)?;
    let source = sources.add(path.value.clone(), text);
    let text = sources.get(source).map_or("", |s| s.text.as_str());
    parse(text, source, path, points)
}

fn text_of(path: &Spanned<String>, folder: &Path) -> Result<String, Refused> {
    let on_disk = folder.join(&path.value);
    let cannot = |why: &str| Diagnostic::error("HQ0805", path.span, format!("cannot read `{}`: {why}", path.value));
    let bytes = match files::read_up_to(&on_disk, MAX_BYTES + 1) {
        Ok(bytes) => bytes,
        Err(e) => {
            let d = cannot(files::reason(&e)).note("paths are relative to the spec");
            return Err(Box::new(instead_of(d, &path.value, &on_disk)));
        }
    };
    if bytes.len() as u64 > MAX_BYTES {
        let d = cannot(&format!("it has more than {} MB", MAX_BYTES >> 20));
        return Err(Box::new(d.help("keep the part that the scenario needs, or fewer lines for each second")));
    }
    String::from_utf8(bytes).map_err(|e| {
        let why = format!("it is not UTF-8 text: byte {} is invalid", e.utf8_error().valid_up_to());
        Box::new(cannot(&why).help("save it as comma-separated values"))
    })
}

fn parse(text: &str, source: SourceId, path: &Spanned<String>, points: &[&str]) -> Result<Vec<Track>, Refused> {
    let named = |d: Diagnostic| d.label(path.span, "named here");
    let mut lines = Lines::new(text, source);
    let mut head = Vec::new();
    let Some(whole) = lines.next(&mut head).map_err(|d| Box::new(named(*d)))? else {
        let d = Diagnostic::error("HQ0805", path.span, format!("`{}` is empty", path.value));
        return Err(Box::new(d.help(format!("write a head, {}, and lines of numbers in s and m", example(points)))));
    };
    let names: Vec<(&str, Span)> = head.iter().map(|(name, at)| (name.as_ref(), *at)).collect();
    let columns = columns(&names, whole.range(), source, points).map_err(|d| Box::new(named(*d)))?;
    let mut tracks = vec![Track::default(); points.len()];
    let mut last: Option<(f64, Span)> = None;
    let mut row = Vec::new();
    let mut count = 0;
    while let Some(whole) = lines.next(&mut row).map_err(|d| Box::new(named(*d)))? {
        if count >= MAX_ROWS || (count + 1).saturating_mul(3 * points.len()) > MAX_NUMBERS {
            let text = format!("the recording has more than {count} lines of {} points", points.len());
            let d = Diagnostic::error("HQ0805", whole, text).here("read up to here");
            return Err(Box::new(named(
                d.help("keep the part that the scenario needs, or fewer lines for each second"),
            )));
        }
        count += 1;
        if row.len() != names.len() {
            let text = format!("this line has {} numbers, and the head has {} columns", row.len(), names.len());
            let d = Diagnostic::error("HQ0805", whole, text);
            return Err(Box::new(named(d.help("write one number for each column, with commas between them"))));
        }
        let time = number(&row[columns.time]).map_err(|d| Box::new(named(*d)))?;
        let here = row[columns.time].1;
        if time < 0.0 {
            let d = Diagnostic::error("HQ0805", here, format!("a time counts from 0 s, and this is {time} s"));
            return Err(Box::new(named(d.help("let the recording begin at 0 s"))));
        }
        if let Some((before, there)) = last.filter(|(before, _)| *before >= time) {
            let text = format!("{time} s does not come after {before} s");
            let d = Diagnostic::error("HQ0805", here, text).label(there, "the line before");
            return Err(Box::new(named(d.help("sort the lines by their times, and keep one for each instant"))));
        }
        last = Some((time, here));
        for (track, [x, y, z]) in tracks.iter_mut().zip(&columns.points) {
            let one = |k: usize| number(&row[k]).map_err(|d| Box::new(named(*d)));
            track.0.push((time, [one(*x)?, one(*y)?, one(*z)?]));
        }
    }
    if last.is_none() {
        let d = Diagnostic::error("HQ0805", path.span, format!("`{}` has a head and no numbers", path.value));
        return Err(Box::new(d.help("write lines of numbers in s and m below it")));
    }
    Ok(tracks)
}

/// Example of a header for some points.
fn example(points: &[&str]) -> String {
    let point = points.first().copied().unwrap_or("chest");
    let more = if points.len() > 1 { ",.." } else { "" };
    format!("`time,{point}.x,{point}.y,{point}.z{more}`")
}

fn columns(
    names: &[(&str, Span)],
    head: std::ops::Range<usize>,
    source: SourceId,
    points: &[&str],
) -> Result<Columns, Refused> {
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for (i, (name, at)) in names.iter().enumerate().filter(|(_, n)| !n.0.is_empty()) {
        if let Some(first) = places.insert(name, i) {
            let d = Diagnostic::error("HQ0805", *at, format!("there are two columns `{name}`"));
            return Err(Box::new(d.label(names[first].1, "the first one").help("keep one of them")));
        }
    }
    let find = |wanted: &str| {
        places.get(wanted).copied().ok_or_else(|| {
            let d = Diagnostic::error(
                "HQ0805",
                Span::new(source, head.start, head.end),
                format!("there is no column `{wanted}`"),
            );
            let all = || names.iter().map(|n| n.0);
            Box::new(match suggest(wanted, all()) {
                Some(near) => d.help(format!("is `{near}` meant? the head is {}", example(points))),
                None => d.help(format!("columns are {}; the head is {}", list(all(), 12), example(points))),
            })
        })
    };
    let time = find("time")?;
    let mut all = Vec::new();
    for point in points {
        let one = |axis: &str| find(&format!("{point}.{axis}"));
        all.push([one("x")?, one("y")?, one("z")?]);
    }
    Ok(Columns { time, points: all })
}

/// Parses the number in a cell.
fn number((text, at): &Cell) -> Result<f64, Refused> {
    let text = text.trim();
    // `f64::from_str` also accepts `nan` and `inf`, which are invalid in a recording.
    let plain = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'));
    match text.parse::<f64>() {
        Ok(x) if plain && x.is_finite() => Ok(x),
        _ => {
            let shown: String = text.chars().take(24).collect();
            let what = if text.is_empty() {
                "a number is missing here".to_string()
            } else {
                format!("`{shown}` is no number")
            };
            let d = Diagnostic::error("HQ0805", *at, what);
            Err(Box::new(
                d.help("remove lines in which the person was not seen; between two lines the motion is linear"),
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(text: &str, points: &[&str]) -> Result<Vec<Track>, String> {
        let path = Spanned::new("walk.csv".to_string(), Span::default());
        parse(text, SourceId::default(), &path, points).map_err(|d| d.message)
    }

    #[test]
    fn columns_are_found_by_their_names() {
        let text = "\u{feff}hand.z, time ,hand.x,score,hand.y\r\n3,0,1,good,2\r\n\r\n-3e0,0.5,+1.5,bad,.5\r\n";
        let expected = vec![(0.0, [1.0, 2.0, 3.0]), (0.5, [1.5, 0.5, -3.0])];
        assert_eq!(parsed(text, &["hand"]), Ok(vec![Track(expected)]));
    }

    #[test]
    fn cells_may_stand_in_quotes() {
        let text = "\"time\",\"p,1\"\"\n\".x, \"p,1\"\"\n\".y ,\"p,1\"\"\n\".z\"\r\n0,1,2,3\r\n";
        // Here the suffix of each name follows its closing quote.
        assert!(parsed(text, &["p,1\"\n"]).unwrap_err().contains("after the quotes"));
        let text = "\"time\",\"p,1\"\"\n.x\", \"p,1\"\"\n.y\" ,\"p,1\"\"\n.z\"\r\n\"0\",1,\" 2 \",3\r\n";
        assert_eq!(parsed(text, &["p,1\"\n"]), Ok(vec![Track(vec![(0.0, [1.0, 2.0, 3.0])])]));
        assert!(parsed("time,p.x,p.y,p.z\n0,1,2,\"3\n", &["p"]).unwrap_err().contains("does not end"));
    }

    #[test]
    fn mistakes_are_shown_in_the_file() {
        let path = Spanned::new("walk.csv".to_string(), Span::default());
        let text = "time,a.x,a.y,a.z\n0,1,2,3\n1, 1 , nan,3\n";
        let d = parse(text, SourceId::default(), &path, &["a"]).unwrap_err();
        assert_eq!(&text[d.primary.span.range()], "nan");
    }

    proptest! {
        /// Numbers that are written with all digits are read back exactly.
        #[test]
        fn numbers_are_read_as_written(rows in prop::collection::vec(prop::array::uniform3(-1e3..1e3_f64), 1..20)) {
            let mut text = "time,p.x,p.y,p.z\n".to_string();
            for (k, x) in rows.iter().enumerate() {
                text.push_str(&format!("{},{},{},{}\n", k as f64 * 0.1, x[0], x[1], x[2]));
            }
            let track = Track(rows.iter().enumerate().map(|(k, x)| (k as f64 * 0.1, *x)).collect());
            prop_assert_eq!(parsed(&text, &["p"]), Ok(vec![track]));
        }

        /// Names that the recorders quote in a header are read back.
        #[test]
        fn names_are_read_as_they_are_quoted(name in "[a-z,\"\n\r é;.]{1,12}") {
            let name = name.trim();
            let cell = |of: &str| runtime::csv::cell(&format!("{name}.{of}")).into_owned();
            let text = format!("time,{},{},{}\n0,1,2,3\n", cell("x"), cell("y"), cell("z"));
            prop_assert_eq!(parsed(&text, &[name]), Ok(vec![Track(vec![(0.0, [1.0, 2.0, 3.0])])]));
        }

        #[test]
        fn no_text_makes_it_panic(text in "(time|p\\.x|p\\.y|p\\.z|[0-9.,\"\n é-]|nan){0,60}") {
            let _ = parsed(&text, &["p"]);
            let _ = parsed(&format!("time,p.x,p.y,p.z\n{text}"), &["p"]);
        }
    }
}

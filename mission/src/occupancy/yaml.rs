//! The YAML file of a map, as `map_server` of ROS 2 reads it.

use granit_parser::{Event, Parser};

use super::Fault;

/// Interpretation of the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Cells are free, occupied or unknown.
    Trinary,
    /// The same; pixels that are not opaque are unknown, and those between the thresholds are a probability, which is blocked.
    Scale,
    /// The value of a pixel is the occupancy in percent; above 100 it is unknown.
    Raw,
}

const MODES: [(&str, Mode); 3] = [("trinary", Mode::Trinary), ("scale", Mode::Scale), ("raw", Mode::Raw)];

/// The keys, all of which `map_server` needs but the last.
const KEYS: [&str; 7] = ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];

/// The most events of a file, nesting included.
const MOST_EVENTS: usize = 10_000;

/// The content of a map file.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFile {
    /// Path of the image, relative to the folder of the file.
    pub image: String,
    /// Width of a pixel (m), more than 0.
    pub resolution: f64,
    /// Position of the lower left corner of the image (m).
    pub origin: [f64; 2],
    /// Direction of the rows of the image (rad), counterclockwise from the x axis.
    pub yaw: f64,
    /// White is occupied; else black is.
    pub negate: bool,
    /// Occupancy above which a cell is occupied, 0 to 1.
    pub occupied_thresh: f64,
    /// Occupancy below which a cell is free, 0 to 1.
    pub free_thresh: f64,
    /// Interpretation of the pixels.
    pub mode: Mode,
}

/// A value with its line.
#[derive(Debug)]
enum Value {
    Scalar(String),
    List(Vec<String>),
    Other,
}

#[derive(Debug)]
struct Entry {
    key: String,
    line: usize,
    value: Value,
}

/// Returns the path of the image that a map file names, if it names one.
pub fn image_path(text: &str) -> Option<String> {
    let entries = entries(text).ok()?;
    entries.into_iter().find(|entry| entry.key == "image").and_then(|entry| match entry.value {
        Value::Scalar(path) if !path.is_empty() => Some(path),
        _ => None,
    })
}

impl MapFile {
    /// Reads a file.
    ///
    /// # Errors
    /// Every mistake of it.
    pub fn read(text: &str) -> Result<MapFile, Vec<Fault>> {
        let entries = entries(text).map_err(|fault| vec![fault])?;
        let mut reader = Reader { entries: &entries, faults: Vec::new() };
        let image = reader.text("image");
        let resolution = reader.number("resolution", "0.05", "more than 0", |x| x > 0.0);
        let origin = reader.origin();
        let negate = reader.negate();
        let is_share = |x: f64| (0.0..=1.0).contains(&x);
        let occupied = reader.number("occupied_thresh", "0.65", "between 0 and 1", is_share);
        let free = reader.number("free_thresh", "0.25", "between 0 and 1", is_share);
        let mode = reader.mode();
        reader.unknown_keys();
        if let (Some(occupied), Some(free)) = (occupied, free)
            && free > occupied
        {
            let text = format!(
                "`free_thresh` is {free}, above `occupied_thresh`, {occupied}: cells would be free and occupied"
            );
            reader.fault("free_thresh", text, "write a `free_thresh` that is at most `occupied_thresh`");
        }
        let found = (image, resolution, origin, negate, occupied, free, mode);
        match found {
            (
                Some(image),
                Some(resolution),
                Some([x, y, yaw]),
                Some(negate),
                Some(occupied),
                Some(free),
                Some(mode),
            ) if reader.faults.is_empty() => {
                let (occupied_thresh, free_thresh, origin) = (occupied, free, [x, y]);
                Ok(MapFile { image, resolution, origin, yaw, negate, occupied_thresh, free_thresh, mode })
            }
            _ => Err(reader.faults),
        }
    }
}

struct Reader<'e> {
    entries: &'e [Entry],
    faults: Vec<Fault>,
}

impl Reader<'_> {
    fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    fn fault(&mut self, key: &str, text: impl Into<String>, help: impl Into<String>) {
        let line = self.get(key).map(|entry| entry.line);
        self.faults.push(Fault::of_yaml(line, text, help));
    }

    fn scalar(&mut self, key: &str, example: &str) -> Option<String> {
        match self.get(key).map(|entry| &entry.value) {
            Some(Value::Scalar(text)) => return Some(text.clone()),
            Some(_) => self.fault(key, format!("`{key}` is no single value"), format!("write `{key}: {example}`")),
            None => self.fault(key, format!("it has no `{key}`"), format!("add `{key}: {example}`")),
        }
        None
    }

    fn text(&mut self, key: &str) -> Option<String> {
        let text = self.scalar(key, "lab.pgm")?;
        if text.is_empty() {
            self.fault(key, format!("`{key}` is empty"), format!("write `{key}: lab.pgm`"));
            return None;
        }
        Some(text)
    }

    fn number(&mut self, key: &str, example: &str, range: &str, good: impl Fn(f64) -> bool) -> Option<f64> {
        let text = self.scalar(key, example)?;
        let number = number(&text).filter(|x| good(*x));
        if number.is_none() {
            let text = format!("`{key}` is `{text}`, and must be a number {range}");
            self.fault(key, text, format!("write for instance `{key}: {example}`"));
        }
        number
    }

    fn origin(&mut self) -> Option<[f64; 3]> {
        const HELP: &str = "write x and y in m and yaw in rad, for instance `origin: [-10, -10, 0]`";
        let numbers = match self.get("origin").map(|entry| &entry.value) {
            Some(Value::List(items)) => items.iter().map(|item| number(item)).collect::<Option<Vec<f64>>>(),
            Some(_) => None,
            None => {
                self.fault("origin", "it has no `origin`", HELP);
                return None;
            }
        };
        let three = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        if three.is_none() {
            self.fault("origin", "`origin` must be three numbers", HELP);
        }
        three
    }

    fn negate(&mut self) -> Option<bool> {
        match self.scalar("negate", "0")?.as_str() {
            "0" | "false" | "False" => Some(false),
            "1" | "true" | "True" => Some(true),
            other => {
                let text = format!("`negate` is `{other}`, and must be 0 or 1");
                self.fault("negate", text, "write `negate: 0` if black is occupied, and `negate: 1` if white is");
                None
            }
        }
    }

    fn mode(&mut self) -> Option<Mode> {
        if self.get("mode").is_none() {
            return Some(Mode::Trinary);
        }
        let written = self.scalar("mode", "trinary")?;
        let found = MODES.iter().find(|(name, _)| *name == written).map(|(_, mode)| *mode);
        if found.is_none() {
            let near = names::suggest(&written, MODES.iter().map(|(name, _)| *name));
            let text = format!("`mode` is `{written}`, and must be `trinary`, `scale` or `raw`");
            self.fault("mode", text, format!("write `mode: {}`", near.unwrap_or("trinary")));
        }
        found
    }

    /// `map_server` ignores keys that it does not know; one that is nearly a known key was hardly meant to be ignored.
    fn unknown_keys(&mut self) {
        for entry in self.entries {
            if KEYS.contains(&entry.key.as_str()) {
                continue;
            }
            if let Some(near) = names::suggest(&entry.key, KEYS.iter().copied()) {
                let text = format!("it has no key `{}`", entry.key);
                self.faults.push(Fault::of_yaml(Some(entry.line), text, format!("write `{near}`")));
            }
        }
    }
}

/// A finite number of YAML.
fn number(text: &str) -> Option<f64> {
    text.trim_start_matches('+').parse().ok().filter(|x: &f64| x.is_finite())
}

/// The entries of the mapping that the file is.
fn entries(text: &str) -> Result<Vec<Entry>, Fault> {
    const HELP: &str = "write the file that `map_saver` of ROS writes: `image: lab.pgm`, `resolution: 0.05` ..";
    let options = granit_parser::options! { flow_nesting_limit: 8, block_nesting_limit: 8 };
    let mut entries: Vec<Entry> = Vec::new();
    let mut key: Option<(String, usize)> = None;
    let (mut depth, mut list) = (0_usize, None::<Vec<String>>);
    for (count, event) in Parser::new_from_str_with_options(text, options).enumerate() {
        let (event, at) = event.map_err(|e| {
            let line = line_of(text, e.marker().byte_offset().unwrap_or(0));
            Fault::of_yaml(Some(line), format!("it is no YAML: {}", e.info()), HELP)
        })?;
        let line = line_of(text, at.byte_range().map_or(0, |range| range.start));
        let mut add = |key: &mut Option<(String, usize)>, value: Value| {
            if let Some((key, line)) = key.take() {
                entries.push(Entry { key, line, value });
            }
        };
        if count > MOST_EVENTS {
            return Err(Fault::of_yaml(Some(line), "it is longer than a map file can be", HELP));
        }
        match event {
            Event::Scalar(value, ..) => match (depth, &mut list) {
                (2, Some(items)) => items.push(value.into_owned()),
                (1, _) if key.is_none() => key = Some((value.into_owned(), line)),
                (1, _) => add(&mut key, Value::Scalar(value.into_owned())),
                (0, _) => return Err(Fault::of_yaml(Some(line), "it is no mapping of keys to values", HELP)),
                _ => {}
            },
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                let is_list = matches!(event, Event::SequenceStart(..));
                if depth == 0 && is_list {
                    return Err(Fault::of_yaml(Some(line), "it is a list, and no mapping of keys to values", HELP));
                }
                depth += 1;
                if depth == 2 {
                    list = is_list.then(Vec::new);
                }
            }
            Event::SequenceEnd | Event::MappingEnd => {
                depth = depth.saturating_sub(1);
                if depth == 1 {
                    add(&mut key, list.take().map_or(Value::Other, Value::List));
                }
            }
            Event::Alias(..) | Event::UnresolvedAlias(..) => {
                return Err(Fault::of_yaml(Some(line), "aliases have no meaning in a map file", "write the value out"));
            }
            _ => {}
        }
    }
    for (index, entry) in entries.iter().enumerate() {
        if let Some(first) = entries[..index].iter().find(|first| first.key == entry.key) {
            let text = format!("it has `{}` twice, first in line {}", entry.key, first.line);
            return Err(Fault::of_yaml(Some(entry.line), text, "keep one of the two"));
        }
    }
    Ok(entries)
}

fn line_of(text: &str, byte: usize) -> usize {
    1 + text.as_bytes().iter().take(byte).filter(|b| **b == b'\n').count()
}

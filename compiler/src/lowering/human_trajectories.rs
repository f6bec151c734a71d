//! Motion of people in a scenario: a body that moves along waypoints, independent points, or a recorded file.

use dsl::tree::{Block, Entry};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use runtime::program::{HumanProgram, HumanScript, Program, Sending, Track};
use stdlib_tasks::dimension::LENGTH;

use super::Lowerer;
use super::world::numbers;
use crate::expr::constants::Constants;
use crate::forms::{block_of, check_keys, text_of};
use crate::recording;
use crate::sections::{HUMAN_POINT, HumanScriptBlock, LostBlock};

impl Lowerer<'_> {
    pub(super) fn human_scripts(&mut self, body: &Block, program: &Program) -> Vec<HumanScript> {
        let humans = &program.interface.humans;
        let names: Vec<&str> = humans.iter().map(|h| h.name.as_str()).collect();
        let mut all = Vec::new();
        for e in self.named_entries(body, "humans") {
            let found = self.one_of("human", &e.key.value, e.key.span, &names);
            let block = block_of(&e.value, "the script of a human", self.diagnostics);
            let (Some(human), Some(block)) = (found, block) else { continue };
            let script: HumanScriptBlock = self.read(block, e.key.span);
            let points: Vec<&str> = (humans[human].points.iter())
                .map(|&s| program.interface.signals[s].name.rsplit('.').next().unwrap_or_default())
                .collect();
            let tracks = self.tracks(block, &humans[human], &points, program);
            let sending = self.sending(&script);
            all.extend(tracks.map(|tracks| HumanScript { human, sending, tracks }));
        }
        all
    }

    /// Transmission of the readings of a human.
    fn sending(&mut self, block: &HumanScriptBlock) -> Sending {
        self.ends_after(block.from, block.to.as_ref());
        for LostBlock { from, to } in &block.lost {
            self.ends_after(*from, Some(to));
        }
        let HumanScriptBlock { from, noise, delay, drop, period, .. } = *block;
        let to = block.to.as_ref().map(|to| to.value);
        let gaps = block.lost.iter().map(|lost| (lost.from, lost.to.value)).collect();
        Sending { from, to, noise, delay, drop, period, nan: numbers(block.nan.as_ref()), gaps }
    }

    /// Lowers the path of each point.
    fn tracks(&mut self, block: &Block, of: &HumanProgram, points: &[&str], program: &Program) -> Option<Vec<Track>> {
        let said: Vec<&Entry> = ["value", "path", "points", "file"].iter().filter_map(|k| block.get(k)).collect();
        let (first, second) = (said.first().copied(), said.get(1).copied());
        if let (Some(first), Some(second)) = (first, second) {
            let text = format!("the position of `{}` is defined by `{}` already", of.name, first.key.value);
            let d = Diagnostic::error("HQ0804", second.key.span, text);
            self.push(d.label(first.key.span, "here").help("keep one of the two"));
            return None;
        }
        let Some(way) = first else {
            let text = format!("this does not define the position of `{}`", of.name);
            let help = Help::with(
                "write {} or {} with a `shape`, or {}, or {}",
                [
                    Snippet::entry("value", "[x, y, z] m"),
                    Snippet::entry("path", "[..]"),
                    Snippet::block("points", [Snippet::dots()]),
                    Snippet::entry("file", "\"walk.csv\""),
                ],
            );
            self.push(Diagnostic::missing_keys(["value", "path", "points", "file"], block.span, text).help(help));
            return None;
        };
        if let Some(shape) = block.get("shape").filter(|_| !matches!(way.key.value.as_str(), "value" | "path")) {
            let text =
                format!("a `shape` belongs to a body with a `value` or a `path`, and `{}` needs none", way.key.value);
            let d = Diagnostic::error("HQ0804", shape.key.span, text);
            self.push(d.help("leave it out"));
            return None;
        }
        match way.key.value.as_str() {
            "file" => self.recorded(way, points),
            "points" => {
                let inner = block_of(&way.value, "`points`", self.diagnostics)?;
                let entries = self.one_for_each(
                    inner,
                    points,
                    (of, way.key.span),
                    Snippet::braces([Snippet::entry("value", "[0, 0, 1] m")]),
                )?;
                let mut tracks = Vec::new();
                for e in entries {
                    let script = block_of(&e.value, "the way of a point", self.diagnostics)?;
                    check_keys(script, &HUMAN_POINT, self.diagnostics);
                    let way = match (script.get("value"), script.get("path")) {
                        (Some(way), None) | (None, Some(way)) => way,
                        (first, second) => {
                            let at = first.and(second).map_or(script.span, |path| path.key.span);
                            let d = Diagnostic::error("HQ0804", at, "a point has one `value`, or goes along a `path`");
                            self.push(d.help(Help::with(
                                "write one of the two, such as {}",
                                [Snippet::entry("value", "[0.6, 0, 1.2] m")],
                            )));
                            return None;
                        }
                    };
                    tracks.push(self.way(way, of, program)?);
                }
                Some(tracks)
            }
            _ => self.body(way, block, (of, points), program),
        }
    }

    /// Lowers a body of fixed shape that moves along a path.
    fn body(
        &mut self,
        way: &Entry,
        block: &Block,
        (of, points): (&HumanProgram, &[&str]),
        program: &Program,
    ) -> Option<Vec<Track>> {
        let Some(shape) = block.get("shape") else {
            // The position of the body is that of its only point.
            if points.len() == 1 {
                return self.way(way, of, program).map(|track| vec![track]);
            }
            let text = format!("this defines the position of `{}`, but not those of its points", of.name);
            let d = Diagnostic::missing_keys(["shape"], way.key.span, text);
            self.push(d.help(Help::with(
                "add their offsets: {}",
                [Snippet::block("shape", [Snippet::entry(points[0], "[0, 0, 1.2] m"), Snippet::dots()])],
            )));
            return None;
        };
        let inner = block_of(&shape.value, "`shape`", self.diagnostics)?;
        let entries = self.one_for_each(inner, points, (of, shape.key.span), Snippet::value("[0, 0, 1.2] m"));
        let track = self.way(way, of, program)?;
        let mut tracks = Vec::new();
        for e in entries? {
            let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
            let offset = constants.vector(&e.value, LENGTH, self.diagnostics)?;
            let moved = |(t, x): &(f64, [f64; 3])| (*t, [x[0] + offset[0], x[1] + offset[1], x[2] + offset[2]]);
            tracks.push(Track(track.0.iter().map(moved).collect()));
        }
        Some(tracks)
    }

    /// Lowers a `value` or a `path`.
    fn way(&mut self, e: &Entry, of: &HumanProgram, program: &Program) -> Option<Track> {
        if e.key.value == "value" {
            return self.vector_of(e, LENGTH).map(|x| Track(vec![(0.0, x)]));
        }
        let point = program.interface.signals.get(*of.points.first()?)?;
        let path = self.path(point, &e.value)?;
        let all: Option<Vec<(f64, [f64; 3])>> =
            path.into_iter().map(|(t, x)| Some((t, <[f64; 3]>::try_from(x).ok()?))).collect();
        all.map(Track)
    }

    /// Entries of a block, one for each point, in the order of the points.
    fn one_for_each<'b>(
        &mut self,
        block: &'b Block,
        points: &[&str],
        (of, at): (&HumanProgram, Span),
        example: Snippet,
    ) -> Option<Vec<&'b Entry>> {
        let mut good = true;
        for e in &block.entries {
            good &= self.one_of("point", &e.key.value, e.key.span, points).is_some();
        }
        let missing: Vec<&str> = points.iter().filter(|p| block.get(p).is_none()).copied().collect();
        if let Some(first) = missing.first().filter(|_| good) {
            let text = format!("`{}` is missing here: `{}` has this point too", missing.join("`, `"), of.name);
            let d = Diagnostic::missing_keys(missing.iter().copied(), at, text);
            self.push(d.help(Help::write_for_instance(Snippet::entry_of(first, example))));
            return None;
        }
        good.then(|| points.iter().filter_map(|p| block.get(p)).collect())
    }

    /// Reads a recorded file.
    fn recorded(&mut self, e: &Entry, points: &[&str]) -> Option<Vec<Track>> {
        let Some(path) = text_of(&e.value) else {
            let d = Diagnostic::error("HQ0304", e.value.span, "the path of a file, in quotes, is needed here");
            self.push(d.help(Help::write_for_instance(Snippet::entry("file", "\"walk.csv\""))));
            return None;
        };
        let path = Spanned::new(path.to_string(), e.value.span);
        match recording::read(&path, self.input.folder, points, self.sources) {
            Ok(tracks) => Some(tracks),
            Err(d) => {
                self.push(*d);
                None
            }
        }
    }
}

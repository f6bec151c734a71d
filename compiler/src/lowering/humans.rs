//! Humans: tracked points of a person. Each is a signal with a velocity and rules for the time when it is not seen.

use std::collections::BTreeMap;

use dsl::tree::{Block, Human, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};
use names::{list, suggest};
use runtime::program::{Conditioning, HumanProgram, Lost, Op, SignalProgram, Tracking, Velocity};
use stdlib_tasks::dimension::{Dimension, LENGTH, RATE, TIME, VELOCITY};

use super::Lowerer;
use super::declared::twice;
use crate::expr::constants::{self, Constants, is_word};
use crate::expr::{Axes, Frame, Kind, Typed, symbol};
use crate::forms::{check_keys, text_of};
use crate::sections::HUMAN;
use crate::units;

/// Maximum number of points of a person.
const MAX_POINTS: usize = 64;

/// Default validity of a reading (s).
const TIMEOUT: f64 = 0.2;
/// Default cutoff of an estimated velocity (Hz).
const CUTOFF: f64 = 5.0;
/// Default speed of a person who is not seen (m/s): the walking speed of ISO 13855.
const GROWTH: f64 = 1.6;

impl Lowerer<'_> {
    /// Declares a human.
    pub(super) fn human(&mut self, h: &Human) {
        let name = &h.name;
        if is_word(&name.value) {
            let d = Diagnostic::error("HQ0202", name.span, format!("`{}` is a word of the language", name.value));
            self.push(d.help("choose another name"));
            self.params.failed.insert(name.value.clone());
            return;
        }
        check_keys(&h.body, &HUMAN, self.diagnostics);
        let before = self.errors();
        let points = self.points(h);
        let links = self.links(&h.body, &points);
        let timeout = self.positive(&h.body, "timeout", TIME).unwrap_or(TIMEOUT);
        let velocity = self.velocity_of(&h.body);
        let motion =
            Tracking { velocity, max_speed: self.positive(&h.body, "max_speed", VELOCITY), lost: self.lost(&h.body) };
        if self.errors() > before || points.is_empty() {
            self.params.failed.insert(name.value.clone());
            return;
        }
        let held = matches!(motion.lost, Lost::Hold(_));
        let mut known = constants::Human { points: Vec::new(), links: links.clone(), held };
        let mut human = HumanProgram { name: name.value.clone(), points: Vec::new(), links };
        for point in points {
            let signal = SignalProgram {
                name: format!("{}.{}", name.value, point.value),
                kind: "point".to_string(),
                at: self.interface.width(),
                len: 3,
                optional: false,
                timeout: Some(timeout),
                conditioning: Conditioning::default(),
                variable: None,
                motion: Some(motion),
            };
            human.points.push(self.interface.signals.len());
            known.points.push((point.value.clone(), signal.at, signal.uncertainty_at()));
            self.point(&name.value, &point, &signal);
            self.interface.signals.push(signal);
        }
        self.interface.humans.push(human);
        self.params.humans.insert(name.value.clone(), known);
    }

    /// Declares the values of a point: position and velocity.
    fn point(&mut self, human: &str, point: &Spanned<String>, signal: &SignalProgram) {
        let (at, rate) = (signal.at + 1, signal.velocity_at());
        let moves = signal.motion.is_some_and(|m| m.velocity != Velocity::None);
        let position: Vec<usize> = (0..3)
            .map(|k| match moves {
                true => self.graph.moving_signal(at + k, rate + k),
                false => self.graph.push(Op::Signal(at + k)),
            })
            .collect();
        let velocity = (0..3).map(|k| self.graph.push(Op::Signal(rate + k))).collect();
        let typed = |dimension, nodes, axes| Typed {
            kind: Kind::Vector,
            dimension,
            nodes,
            bare: false,
            axes,
            span: point.span,
        };
        let put = |velocity: bool| Spanned::new(symbol(human, &point.value, velocity), point.span);
        self.params.put(&put(false), Some(typed(LENGTH, position, Axes::point(Frame::World))));
        self.params.put(&put(true), Some(typed(VELOCITY, velocity, Axes::direction(Frame::World))));
    }

    /// Names of the points.
    fn points(&mut self, h: &Human) -> Vec<Spanned<String>> {
        let Some(entry) = h.body.get("points") else {
            let d = Diagnostic::error("HQ0206", h.name.span, format!("`{}` has no points", h.name.value));
            self.push(d.help("name what is tracked: `points [chest, left_wrist, right_wrist]`"));
            return Vec::new();
        };
        let mut all: Vec<Spanned<String>> = Vec::new();
        let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
        for item in entry.value.items() {
            let Some(name) = text_of(item).filter(|n| is_plain(n)) else {
                if !matches!(item.kind, ValueKind::Missing) {
                    let d = Diagnostic::error("HQ0304", item.span, "a point is a name: letters, digits and `_`");
                    self.push(d.help("write for instance `points [chest, left_wrist]`"));
                }
                continue;
            };
            let point = Spanned::new(name.to_string(), item.span);
            match seen.get(name) {
                Some(first) => self.push(twice(&point, *first)),
                None => {
                    seen.insert(name, item.span);
                    all.push(point);
                }
            }
        }
        if let Some(beyond) = all.get(MAX_POINTS) {
            let text = format!("a person has more than {MAX_POINTS} points");
            let d = Diagnostic::error("HQ0308", beyond.span, text);
            self.push(d.help("name the points that tasks use"));
            all.truncate(MAX_POINTS);
        } else if all.is_empty() && matches!(&entry.value.kind, ValueKind::List(items) if items.is_empty()) {
            let d = Diagnostic::error("HQ0206", entry.value.span, format!("`{}` has no points", h.name.value));
            self.push(d.help("name what is tracked: `points [chest, left_wrist, right_wrist]`"));
        }
        all
    }

    /// Segments between points, by their indices.
    fn links(&mut self, body: &Block, points: &[Spanned<String>]) -> Vec<(usize, usize)> {
        let Some(entry) = body.get("links") else { return Vec::new() };
        let mut all = Vec::new();
        // A list of pairs; a single pair needs no outer list.
        let alone = matches!(&entry.value.kind, ValueKind::List(items) if items.iter().all(|i| text_of(i).is_some()));
        let pairs: &[Value] = if alone { std::slice::from_ref(&entry.value) } else { entry.value.items() };
        for pair in pairs {
            let ValueKind::List(ends) = &pair.kind else {
                self.bad_link(pair.span);
                continue;
            };
            let [a, b] = ends.as_slice() else {
                self.bad_link(pair.span);
                continue;
            };
            let (a, b) = (self.end(a, points), self.end(b, points));
            let (Some(a), Some(b)) = (a, b) else { continue };
            if a == b {
                let d = Diagnostic::error("HQ0304", pair.span, "a link joins two points, and this is one");
                self.push(d.help("name the point at its other end"));
            } else {
                all.push((a, b));
            }
        }
        all
    }

    fn bad_link(&mut self, at: Span) {
        let d = Diagnostic::error("HQ0304", at, "a link joins two points");
        self.push(d.help("write for instance `links [[chest, left_wrist], [chest, right_wrist]]`"));
    }

    fn end(&mut self, value: &Value, points: &[Spanned<String>]) -> Option<usize> {
        let Some(name) = text_of(value) else {
            self.bad_link(value.span);
            return None;
        };
        let found = points.iter().position(|p| p.value == name);
        if found.is_none() {
            let names = points.iter().map(|p| p.value.as_str());
            let d = Diagnostic::error("HQ0201", value.span, format!("there is no point `{name}`"));
            self.push(match suggest(name, names.clone()) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None => d.help(format!("points are {}", list(names, 12))),
            });
        }
        found
    }

    /// A positive number.
    fn positive(&mut self, body: &Block, key: &str, dimension: Dimension) -> Option<f64> {
        let entry = body.get(key)?;
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let x = constants.scalar(&entry.value, dimension, self.diagnostics)?;
        if x <= 0.0 {
            let shown = units::shown(x, dimension);
            let d =
                Diagnostic::error("HQ0308", entry.value.span, format!("`{key}` is above zero, and this is {shown}"));
            self.push(d.help("write a positive number, or leave it out"));
            return None;
        }
        Some(x)
    }

    fn choice<'w>(&mut self, body: &Block, key: &str, words: &[&'w str]) -> Option<&'w str> {
        let entry = body.get(key)?;
        let said = text_of(&entry.value).unwrap_or_default();
        let found = words.iter().find(|w| **w == said).copied();
        if found.is_none() && !matches!(entry.value.kind, ValueKind::Missing) {
            let d = Diagnostic::error(
                "HQ0304",
                entry.value.span,
                format!("`{key}` is one of {}", list(words.iter().copied(), 8)),
            );
            self.push(match suggest(said, words.iter().copied()) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None => d.help(format!("write for instance `{key} {}`", words[0])),
            });
        }
        found
    }

    /// Reports a setting that applies only to another choice.
    fn out_of_place(&mut self, body: &Block, key: &str, belongs: &str) {
        if let Some(entry) = body.get(key) {
            let d = Diagnostic::error("HQ0205", entry.key.span, format!("`{key}` belongs to `{belongs}`"));
            self.push(d.help(format!("write `{belongs}`, or leave `{key}` out")));
        }
    }

    fn velocity_of(&mut self, body: &Block) -> Velocity {
        let said = self.choice(body, "velocity", &["estimated", "measured", "none"]);
        if said.is_some_and(|s| s != "estimated") {
            self.out_of_place(body, "cutoff", "velocity estimated");
        }
        match said {
            Some("measured") => Velocity::Measured,
            Some("none") => {
                self.out_of_place(body, "max_speed", "velocity estimated");
                Velocity::None
            }
            _ => Velocity::Estimated(self.positive(body, "cutoff", RATE).unwrap_or(CUTOFF)),
        }
    }

    fn lost(&mut self, body: &Block) -> Lost {
        if self.choice(body, "lost", &["fault", "hold"]) == Some("hold") {
            return Lost::Hold(self.positive(body, "growth", VELOCITY).unwrap_or(GROWTH));
        }
        self.out_of_place(body, "growth", "lost hold");
        Lost::Fault
    }
}

/// True for a name that can follow a dot.
pub(super) fn is_plain(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

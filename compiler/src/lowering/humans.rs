//! Humans: tracked points of a person. Each is a signal with a velocity and rules for the time when it is not seen.

use std::collections::BTreeMap;

use dsl::tree::{Block, NamedBlock, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use runtime::program::{Between, Conditioning, HumanProgram, Lost, Op, SignalProgram, Tracking, Velocity};
use stdlib_tasks::dimension::{LENGTH, VELOCITY};

use super::Lowerer;
use super::declared::twice;
use crate::expr::constants::{self, is_word};
use crate::expr::{Axes, Frame, Kind, Typed, symbol};
use crate::forms::text_of;
use crate::sections::HumanBlock;

/// Maximum number of points of a person.
const MAX_POINTS: usize = 64;

impl Lowerer<'_> {
    /// Declares a human.
    pub(super) fn human(&mut self, h: &NamedBlock) {
        let name = &h.name;
        if is_word(&name.value) {
            let d = Diagnostic::error("HQ0202", name.span, format!("`{}` is a word of the language", name.value));
            self.push(d.help("choose another name"));
            self.params.failed.insert(name.value.clone());
            return;
        }
        let before = self.errors();
        let block: HumanBlock = self.read(&h.body, name.span);
        let points = self.points(h);
        let links = self.links(&h.body, &points);
        let velocity = self.velocity_of(&block, &h.body);
        let motion = Tracking {
            person: true,
            velocity,
            between: if block.between == "extrapolate" { Between::Extrapolate } else { Between::Hold },
            max_speed: block.max_speed,
            max_angular_speed: None,
            lost: self.lost(&block, &h.body),
        };
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
                timeout: Some(block.timeout),
                conditioning: Conditioning::default(),
                variable: None,
                age_of: None,
                motion: Some(motion),
            };
            human.points.push(self.interface.signals.len());
            known.points.push((point.value.clone(), signal.at, signal.uncertainty_at()));
            self.point(&name.value, &point, &signal);
            self.interface.signals.push(signal);
            self.declare_age(self.interface.signals.len() - 1, Some(&name.value));
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
    fn points(&mut self, h: &NamedBlock) -> Vec<Spanned<String>> {
        let Some(entry) = h.body.get("points") else { return Vec::new() };
        let mut all: Vec<Spanned<String>> = Vec::new();
        let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
        for item in entry.value.items() {
            let Some(name) = text_of(item).filter(|n| is_plain(n)) else {
                if !matches!(item.kind, ValueKind::Missing) {
                    let d = Diagnostic::error("HQ0304", item.span, "a point is a name: letters, digits and `_`");
                    self.push(d.help(Help::write_for_instance(Snippet::entry("points", "[chest, left_wrist]"))));
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
            let d = Diagnostic::missing_keys([], entry.value.span, format!("`{}` has no points", h.name.value));
            self.push(d.help(Help::with(
                "name the tracked points: {}",
                [Snippet::entry("points", "[chest, left_wrist, right_wrist]")],
            )));
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
        self.push(
            d.help(Help::write_for_instance(Snippet::entry("links", "[[chest, left_wrist], [chest, right_wrist]]"))),
        );
    }

    fn end(&mut self, value: &Value, points: &[Spanned<String>]) -> Option<usize> {
        let Some(name) = text_of(value) else {
            self.bad_link(value.span);
            return None;
        };
        let found = points.iter().position(|p| p.value == name);
        if found.is_none() {
            let names = points.iter().map(|p| p.value.as_str());
            let d = Diagnostic::undeclared("point", name, value.span);
            self.push(d.one_of("points are", name, names));
        }
        found
    }

    /// Reports a setting that applies only to another choice.
    pub(super) fn out_of_place(&mut self, body: &Block, key: &str, belongs: &str) {
        if let Some(entry) = body.get(key) {
            let d = Diagnostic::unknown_key("HQ0205", entry.key.span, format!("`{key}` belongs to `{belongs}`"));
            self.push(d.help(format!("write `{belongs}`, or leave `{key}` out")));
        }
    }

    fn velocity_of(&mut self, block: &HumanBlock, body: &Block) -> Velocity {
        if block.velocity != "estimated" {
            self.out_of_place(body, "cutoff", "velocity estimated");
        }
        match block.velocity {
            "measured" => Velocity::Measured,
            "none" => {
                self.out_of_place(body, "max_speed", "velocity estimated");
                self.out_of_place(body, "between", "velocity estimated");
                Velocity::None
            }
            _ => Velocity::Estimated(block.cutoff),
        }
    }

    fn lost(&mut self, block: &HumanBlock, body: &Block) -> Lost {
        if block.lost == "hold" {
            return Lost::Hold(block.growth);
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

//! Signals: their contents, and the names that expressions use for them.

use dsl::Diagnostic;
use dsl::tree::Signal;
use names::list;
use runtime::program::{Conditioning, Op, SignalProgram, Tracking};
use stdlib_tasks::dimension::{Dimension, FORCE, MOMENT, NONE};

use super::Lowerer;
use super::sensors::{Carried, Conditioned, Sensor};
use crate::expand::{TYPES, quantity};
use crate::expr::constants::is_word;
use crate::expr::{Axes, Frame, Kind, Typed, VELOCITIES, part_of_signal};
use crate::sections::SignalBlock;

/// Types of signals in addition to the quantities of parameters.
const OWN_TYPES: [&str; 3] = ["event", "flag", "wrench"];

/// Content of a signal.
pub(super) enum Carries {
    Event,
    Wrench,
    Quantity(Kind, Dimension),
}

pub(super) fn carries(ty: &str) -> Option<Carries> {
    match ty {
        "event" => Some(Carries::Event),
        "wrench" => Some(Carries::Wrench),
        "flag" => Some(Carries::Quantity(Kind::Truth, NONE)),
        _ => match quantity(ty)? {
            (kind, Some(dimension)) => Some(Carries::Quantity(kind, dimension)),
            _ => None,
        },
    }
}

/// Types that signals may have.
pub fn signal_types() -> impl Iterator<Item = &'static str> {
    let of_parameters = TYPES.iter().map(|t| t.name).filter(|t| carries(t).is_some());
    OWN_TYPES.into_iter().chain(of_parameters)
}

/// Names under which the parts of a wrench and the velocities of a point or pose are used.
pub(super) fn parts_of_signal(name: &str) -> [String; 4] {
    ["force", "moment", VELOCITIES[0], VELOCITIES[1]].map(|part| part_of_signal(name, part))
}

impl Lowerer<'_> {
    /// Declares a signal, and returns its settings that depend on the robot.
    pub(super) fn signal(&mut self, s: &Signal) -> Option<Sensor> {
        let name = &s.name;
        if is_word(&name.value) {
            let d = Diagnostic::error("HQ0202", name.span, format!("`{}` is a word of the language", name.value));
            self.push(d.help("choose another name"));
        }
        let block: SignalBlock = self.read(&s.settings, name.span);
        let Some(carries) = carries(&s.ty.value) else {
            // The parser reported an unreadable type.
            if !s.ty.value.is_empty() {
                let d = Diagnostic::unknown_name(s.ty.span, format!("no signal has the type `{}`", s.ty.value));
                self.push(
                    d.help(format!("types are {}", list(signal_types(), 30))).nearest(&s.ty.value, signal_types()),
                );
            }
            self.params.failed.insert(name.value.clone());
            return None;
        };
        let carried = match &carries {
            Carries::Event => Carried::Event,
            Carries::Wrench => Carried::Wrench,
            Carries::Quantity(Kind::Pose, _) => Carried::Pose,
            Carries::Quantity(Kind::Vector, stdlib_tasks::dimension::LENGTH) => Carried::Point,
            Carries::Quantity(Kind::Scalar | Kind::Vector, _) => Carried::Numbers,
            Carries::Quantity(..) => Carried::Other,
        };
        let Conditioned { conditioning, sensor } = self.conditioning(s, &block, carried);
        match carries {
            Carries::Event => {
                self.motion_of_signal(s, &block, carried);
                self.event(s);
            }
            Carries::Wrench => {
                self.motion_of_signal(s, &block, Carried::Wrench);
                let at = self.place(s, 6, block.timeout, conditioning, None);
                self.params.wrenches.insert(name.value.clone());
                self.vector(s, "force", at + 1, FORCE);
                self.vector(s, "moment", at + 4, MOMENT);
            }
            Carries::Quantity(kind, dimension) => {
                let motion = self.motion_of_signal(s, &block, carried);
                let at = self.place(s, kind.width(), block.timeout, conditioning, motion);
                match motion {
                    Some(_) => self.moving_quantity(name, kind, dimension, at + 1),
                    None => self.quantity(name, kind, dimension, at + 1),
                }
            }
        }
        sensor
    }

    /// Declares a name for the numbers from `at` on.
    pub(super) fn quantity(&mut self, name: &dsl::Spanned<String>, kind: Kind, dimension: Dimension, at: usize) {
        let nodes = (0..kind.width()).map(|i| self.graph.push(Op::Signal(at + i))).collect();
        self.declare_quantity(name, kind, dimension, nodes);
    }

    /// Declares a name for nodes of a kind and dimension.
    pub(super) fn declare_quantity(
        &mut self,
        name: &dsl::Spanned<String>,
        kind: Kind,
        dimension: Dimension,
        nodes: Vec<usize>,
    ) {
        let axes = match kind {
            Kind::Scalar | Kind::Truth => Axes::default(),
            Kind::Vector if dimension == stdlib_tasks::dimension::LENGTH => Axes::point(Frame::World),
            Kind::Rotation => Axes::orientation(Frame::Any, Frame::World),
            Kind::Pose => Axes { origins: Some(1.0), ..Axes::orientation(Frame::Any, Frame::World) },
            Kind::Vector => Axes::default(),
        };
        let value = Typed { kind, dimension, nodes, bare: false, axes, span: name.span };
        self.params.put(name, Some(value));
    }

    fn event(&mut self, s: &Signal) {
        if let Some(timeout) = s.settings.get("timeout") {
            let d = Diagnostic::unknown_key("HQ0205", timeout.key.span, "an event has no `timeout`");
            self.push(d.note("an event is visible only at the tick after it was raised").help("leave it out"));
        }
        if let Some(at) = s.optional {
            let d = Diagnostic::unknown_key("HQ0205", at, "an event cannot be optional");
            self.push(d.help("leave the `?` out"));
        }
        self.params.events.insert(s.name.value.clone(), s.name.span);
        self.interface.events.push(s.name.value.clone());
    }

    /// Allocates the numbers of a signal; returns the first, which stores whether the signal is present.
    fn place(
        &mut self,
        s: &Signal,
        len: usize,
        timeout: Option<f64>,
        conditioning: Conditioning,
        motion: Option<Tracking>,
    ) -> usize {
        let at = self.interface.width();
        self.params.presence.insert(s.name.value.clone(), at);
        self.interface.signals.push(SignalProgram {
            name: s.name.value.clone(),
            kind: s.ty.value.clone(),
            at,
            len,
            optional: s.optional.is_some(),
            timeout,
            motion,
            conditioning,
            variable: None,
            age_of: None,
        });
        self.declare_age(self.interface.signals.len() - 1, None);
        at
    }

    /// Declares a part of a wrench, under a name that users cannot write.
    fn vector(&mut self, s: &Signal, part: &str, at: usize, dimension: Dimension) {
        let nodes = (0..3).map(|i| self.graph.push(Op::Signal(at + i))).collect();
        let axes = Axes::direction(Frame::World);
        let value = Typed { kind: Kind::Vector, dimension, nodes, bare: false, axes, span: s.name.span };
        let name = dsl::Spanned::new(part_of_signal(&s.name.value, part), s.name.span);
        self.params.put(&name, Some(value));
    }
}

//! Sensors: conditioning of a signal before expressions use it. The axes of a wrench are those of a link, so they are
//! resolved after the robot is bound.

use dsl::tree::{Entry, Signal, Value};
use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::program::Conditioning;

use super::Lowerer;
use crate::forms::text_of;
use crate::robot_binding::{BoundRobot, unknown_link};
use crate::sections::SignalBlock;

/// Settings of a signal that depend on the robot.
#[derive(Debug)]
pub(super) struct Sensor {
    /// Index of the signal.
    signal: usize,
    /// Link in whose axes the signal is measured.
    frame: Option<Value>,
    /// Cutoff frequency (Hz), with its span.
    cutoff: Option<(f64, Span)>,
}

/// Content of a signal, as far as the conditioning depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Carried {
    Event,
    Wrench,
    /// A position.
    Point,
    /// A number or another vector.
    Numbers,
    /// A position and an orientation.
    Pose,
    /// A truth value, an orientation.
    Other,
}

/// Conditioning of a signal.
#[derive(Default)]
pub(super) struct Conditioned {
    /// The settings that are known without the robot.
    pub conditioning: Conditioning,
    /// The settings that depend on the robot.
    pub sensor: Option<Sensor>,
}

impl Lowerer<'_> {
    /// Conditioning of the signal that is declared next; settings that depend on the robot are postponed.
    pub(super) fn conditioning(&mut self, s: &Signal, block: &SignalBlock, carried: Carried) -> Conditioned {
        let mut all = Conditioned::default();
        let ty = &s.ty.value;
        let wrench = |e: &&Entry| match carried {
            Carried::Wrench => Ok((*e).clone()),
            _ => {
                let d = Diagnostic::unknown_key(
                    "HQ0205",
                    e.key.span,
                    format!("a signal of the type `{ty}` has no `{}`", e.key.value),
                );
                Err(Box::new(d.note("it belongs to the sensor of a wrench").help("leave it out")))
            }
        };
        let frame = s.settings.get("frame").as_ref().map(wrench).transpose();
        let bias = s.settings.get("bias").as_ref().map(wrench).transpose();
        let (frame, entry) = match (frame, bias) {
            (Ok(frame), Ok(bias)) => (frame, bias),
            (frame, bias) => {
                self.diagnostics.extend(frame.err().map(|d| *d));
                self.diagnostics.extend(bias.err().map(|d| *d));
                return all;
            }
        };
        if let Some(bias) = &block.bias {
            all.conditioning.bias = Some(bias.numbers());
            if let Some(e) = entry.filter(|e| e.value.block().is_some_and(|b| b.entries.is_empty())) {
                let d = Diagnostic::missing_keys(["force"], e.value.span, "this bias says nothing");
                self.push(d.help(Help::with(
                    "write {}, or leave it out",
                    [Snippet::block("bias", [Snippet::entry("force", "[0, 0, 1.2] N")])],
                )));
            }
        }
        let unfiltered = match carried {
            Carried::Event | Carried::Other => true,
            // The filter of an orientation needs its angular velocity.
            Carried::Pose => block.velocity.is_none(),
            Carried::Wrench | Carried::Point | Carried::Numbers => false,
        };
        if let Some(e) = s.settings.get("low_pass").filter(|_| unfiltered) {
            let d = Diagnostic::unknown_key(
                "HQ0205",
                e.key.span,
                format!("a signal of the type `{ty}` cannot be filtered"),
            );
            self.push(if carried == Carried::Pose {
                d.note("a pose can be filtered with its velocity").help(Help::with(
                    "write {} before it, or leave `low_pass` out",
                    [Snippet::entry("velocity", "estimated")],
                ))
            } else {
                d.note("only numbers and vectors, and poses with a velocity, can be filtered")
                    .help("leave `low_pass` out")
            });
            return all;
        }
        let cutoff = block.low_pass.as_ref().map(|cutoff| (cutoff.value, self.origins.span(cutoff.at)));
        all.conditioning.low_pass = cutoff.map(|c| c.0);
        if frame.is_some() || cutoff.is_some() {
            let signal = self.interface.signals.len();
            all.sensor = Some(Sensor { signal, frame: frame.map(|e| e.value), cutoff });
        }
        all
    }

    /// Resolves the settings of signals that depend on the robot.
    pub(super) fn sensors(&mut self, sensors: &[Sensor], robot: &BoundRobot) {
        for sensor in sensors {
            let Some(signal) = self.interface.signals.get_mut(sensor.signal) else { continue };
            if let Some(value) = &sensor.frame {
                let name = text_of(value).unwrap_or_default();
                let arm = robot.arms.iter().find(|a| a.name == name).map(|a| a.tip);
                signal.conditioning.frame = robot.model.link(name).or(arm);
                // `world` is the default, so it needs no frame.
                let told = signal.conditioning.frame.is_some() || name == "world" || robot.failed.contains(name);
                if !told {
                    let d = unknown_link(&robot.model, name, value.span, &robot.arms);
                    self.push(d);
                }
            }
            let rate = 1.0 / robot.period;
            if let Some((cutoff, at)) = sensor.cutoff.filter(|c| c.0 > 0.5 * rate) {
                let text = format!("a filter at {cutoff} Hz has almost no effect at {rate} ticks per second");
                let share = 100.0 * (1.0 - (-std::f64::consts::TAU * cutoff * robot.period).exp());
                self.push(
                    Diagnostic::warning("HQ0711", at, text)
                        .note(format!("each tick moves the value {share:.1} % of the way to the reading"))
                        .help(format!("write a cutoff well below half the rate, {} Hz, or leave it out", 0.5 * rate)),
                );
            }
        }
    }
}

//! Velocities of points and poses that the host sends: estimated between readings, or measured.

use dsl::tree::Signal;
use dsl::{Diagnostic, Help, Snippet, Spanned};
use runtime::program::{Between, Lost, Op, Tracking, Velocity};
use stdlib_tasks::dimension::{ANGULAR_VELOCITY, Dimension, VELOCITY};

use super::Lowerer;
use super::sensors::Carried;
use crate::expr::{Axes, Frame, Kind, Typed, VELOCITIES, part_of_signal};
use crate::sections::SignalBlock;

/// Keys that say something about a velocity.
const SETTINGS: [&str; 4] = ["cutoff", "max_speed", "max_angular_speed", "between"];

/// Cutoff of the filter of an estimated velocity without `cutoff`, in Hz, as for people.
const CUTOFF: f64 = 5.0;

impl Lowerer<'_> {
    /// Motion of a signal between its readings; `None` if it counts as at rest. Reports settings that do not fit.
    pub(super) fn motion_of_signal(&mut self, s: &Signal, block: &SignalBlock, carried: Carried) -> Option<Tracking> {
        let written = |key: &str| s.settings.get(key).map(|e| e.key.clone());
        let Some(key) = written(VELOCITIES[0]) else {
            if let Some(setting) = SETTINGS.into_iter().find_map(written) {
                let text = format!("`{}` needs a velocity, and this signal has none", setting.value);
                let d = Diagnostic::unknown_key("HQ0205", setting.span, text);
                self.push(d.help(Help::with(
                    "write {} before it, or leave it out",
                    [Snippet::entry(VELOCITIES[0], "estimated")],
                )));
            }
            return None;
        };
        if !matches!(carried, Carried::Point | Carried::Pose) {
            let text = format!("a signal of the type `{}` has no `{}`", s.ty.value, key.value);
            let d = Diagnostic::unknown_key("HQ0205", key.span, text);
            self.push(d.note("points and poses have a velocity").help("leave it out"));
            return None;
        }
        let measured = block.velocity.is_some_and(|how| how == "measured");
        if let Some(cutoff) = written(SETTINGS[0]).filter(|_| measured) {
            self.out_of_place(&s.settings, &cutoff.value, "velocity estimated");
        }
        if let Some(most) = written(SETTINGS[2]).filter(|_| carried == Carried::Point) {
            let d = Diagnostic::unknown_key("HQ0205", most.span, format!("a point has no `{}`", most.value));
            self.push(d.note("it belongs to a pose").help("leave it out"));
        }
        if let Some(between) = s.settings.get(SETTINGS[3]).filter(|_| block.timeout.is_none())
            && block.between.is_some_and(|between| between == "extrapolate")
        {
            let text = format!("without a `timeout`, `{}` would go on for ever", s.name.value);
            let d = Diagnostic::missing_keys(["timeout"], between.value.span, text);
            self.push(d.note("a value goes on with its velocity until it is stale, and this one never is").help(
                Help::with(
                    "write for instance {}, or leave `between` out: the value then stays at the last reading",
                    [Snippet::entry("timeout", "0.5 s")],
                ),
            ));
            return None;
        }
        Some(Tracking {
            person: false,
            velocity: match measured {
                true => Velocity::Measured,
                false => Velocity::Estimated(block.cutoff.unwrap_or(CUTOFF)),
            },
            // A value that is never stale would run away when the readings stop.
            between: match block.between.is_none_or(|between| between == "extrapolate") && block.timeout.is_some() {
                true => Between::Extrapolate,
                false => Between::Hold,
            },
            max_speed: block.max_speed,
            max_angular_speed: block.max_angular_speed,
            lost: Lost::Fault,
        })
    }

    /// Declares a name for the numbers of a tracked signal from `at` on, behind which their rates follow, and the names
    /// of its velocities.
    pub(super) fn moving_quantity(&mut self, name: &Spanned<String>, kind: Kind, dimension: Dimension, at: usize) {
        let rates = at + kind.width();
        let nodes: Vec<usize> = (0..kind.width()).map(|k| self.graph.moving_signal(at + k, rates + k)).collect();
        let velocity = (0..3).map(|k| self.graph.push(Op::Signal(rates + k))).collect();
        self.velocity(name, VELOCITIES[0], VELOCITY, velocity);
        if let Some(&[w, x, y, z]) = nodes.get(3..) {
            let angular = self.angular_velocity([w, x, y, z], rates + 3);
            self.velocity(name, VELOCITIES[1], ANGULAR_VELOCITY, angular);
        }
        self.declare_quantity(name, kind, dimension, nodes);
    }

    fn velocity(&mut self, name: &Spanned<String>, part: &str, dimension: Dimension, nodes: Vec<usize>) {
        let axes = Axes::direction(Frame::World);
        let value = Typed { kind: Kind::Vector, dimension, nodes, bare: false, axes, span: name.span };
        self.params.put(&Spanned::new(part_of_signal(&name.value, part), name.span), Some(value));
    }

    /// The vector part of `2 q' q*`: the angular velocity along the axes of the world, of a unit quaternion `w x y z`
    /// whose rates are the numbers from `rates` on.
    fn angular_velocity(&mut self, [w, x, y, z]: [usize; 4], rates: usize) -> Vec<usize> {
        let [dw, dx, dy, dz] = [0, 1, 2, 3].map(|k| self.graph.push(Op::Signal(rates + k)));
        // Each component is 2 (q'_i w - q'_w q_i + q'_k q_j - q'_j q_k) for (i, j, k) in cyclic order.
        [(dx, x, dy, y, dz, z), (dy, y, dz, z, dx, x), (dz, z, dx, x, dy, y)]
            .into_iter()
            .map(|(di, qi, dj, qj, dk, qk)| {
                let terms = [(di, w), (dw, qi), (dk, qj), (dj, qk)].map(|(a, b)| self.graph.push(Op::Mul(a, b)));
                let own = self.graph.push(Op::Sub(terms[0], terms[1]));
                let cross = self.graph.push(Op::Sub(terms[2], terms[3]));
                let half = self.graph.push(Op::Add(own, cross));
                self.graph.push(Op::Add(half, half))
            })
            .collect()
    }
}

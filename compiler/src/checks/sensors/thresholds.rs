//! Warns of thresholds of a force or a moment that no contact reaches, or that the noise of a sensor passes.

use dsl::{Diagnostic, Span};
use robot::LinkId;
use stdlib_tasks::dimension::{FORCE, MOMENT};

use super::rising;
use crate::checks::Checked;
use crate::units::shown;

/// Lever (m) at which the strongest joint gives the largest force that is considered.
const LEVER: f64 = 0.1;

/// Largest force (N) and moment (N m) for joints without a limit of effort.
const LARGEST: [f64; 2] = [5e3, 2e3];

/// Force (N) and moment (N m) below the noise of the sensors of robots.
const NOISE: [f64; 2] = [0.02, 5e-4];

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let (Some(machine), Some(places)) = (&c.program.machine, &c.places.machine) else { return };
    let mut told: Vec<Span> = Vec::new();
    for (state, transitions) in places.transitions.iter().enumerate() {
        for (i, place) in transitions.iter().enumerate() {
            let found = place.condition.map(|node| rising::comparisons(c, node)).unwrap_or_default();
            for r in found {
                let name = &c.program.interface.signals[r.signal].name;
                let (part, dimension) = if r.moment { ("moment", MOMENT) } else { ("force", FORCE) };
                let kind = usize::from(r.moment);
                let Largest { size: largest, why } = largest(c, r.signal, kind);
                let (text, note) = if r.threshold > largest {
                    (
                        format!("no contact gives a {part} of `{name}` above {}", shown(r.threshold, dimension)),
                        format!("the robot gives about {} at most{why}", shown(rounded(largest), dimension)),
                    )
                } else if r.threshold > 0.0 && r.threshold < NOISE[kind] {
                    (
                        format!("the noise of `{name}` is above {}", shown(r.threshold, dimension)),
                        "sensors of robots are accurate to some hundredths of a newton, so the condition holds at once"
                            .to_string(),
                    )
                } else {
                    continue;
                };
                if told.contains(&place.trigger) {
                    continue;
                }
                told.push(place.trigger);
                let target = machine.states[state].transitions.get(i).map_or(0, |t| t.target);
                out.push(
                    Diagnostic::warning("HQ0552", place.trigger, text)
                        .here(format!("leads to `{}`", machine.states[target].name))
                        .note(note)
                        .help("compare with the force of the contact, in N: a touch is some 5 N to 20 N"),
                );
            }
        }
    }
}

/// The largest force or moment of a contact.
struct Largest {
    size: f64,
    why: String,
}

/// Largest force or moment at the link of a sensor, from the efforts of the joints, and the reason.
fn largest(c: &Checked, signal: usize, kind: usize) -> Largest {
    let model = &c.program.robot.model;
    let frame: Option<LinkId> = c.program.interface.signals[signal].conditioning.frame;
    let efforts = model.joints.iter().enumerate().filter(|(_, j)| j.effort.is_finite() && j.effort > 0.0);
    let strongest = efforts.map(|(_, j)| j.effort).fold(0.0, f64::max);
    let complete = model.dofs.iter().filter_map(|d| d.joint).all(|j| model.joint_ref(j).effort.is_finite());
    if strongest == 0.0 || !complete {
        return Largest { size: LARGEST[kind], why: String::new() };
    }
    let at = frame.map_or(String::new(), |link| format!(" at `{}`", model.link_ref(link).name));
    let size = if kind == 0 { strongest / LEVER } else { 10.0 * strongest };
    Largest { size, why: format!("{at}: its strongest joint has {} at a lever of 10 cm", shown(strongest, MOMENT)) }
}

/// Two digits of a number.
fn rounded(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

//! Warns of sensors that are tared while they are pressed: on the entry of a state that their force leads to, or on the way
//! out because of it. The pressing force then counts as zero.

use dsl::{Diagnostic, Span};
use runtime::program::{MachineAction, MachineProgram};

use super::rising;
use crate::checks::Checked;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let (Some(machine), Some(places)) = (&c.program.machine, &c.places.machine) else { return };
    for (state, of) in machine.states.iter().enumerate() {
        for (&action, enters) in of.enter.iter().map(|a| (a, true)).chain(of.exit.iter().map(|a| (a, false))) {
            let Some(MachineAction::Tare(signal)) = machine.actions[action].own else { continue };
            let Some(trigger) = pressed(c, machine, state, enters, signal) else { continue };
            let name = &c.program.interface.signals[signal].name;
            let at = places.actions.get(action).copied().unwrap_or_default();
            if out.iter().any(|d| d.code == "HQ0558" && d.primary.span == at) {
                continue;
            }
            out.push(
                Diagnostic::warning("HQ0558", at, format!("`{name}` is tared in contact"))
                    .label(trigger, "this transition is taken because it is pressed")
                    .note(
                        "the force of the contact becomes the zero of the sensor: later forces count as smaller by it",
                    )
                    .help("tare it before the contact, while nothing is touched: on the exit of the state before"),
            );
        }
    }
}

/// A transition into a state, or out of it, that a rising force of a sensor triggers.
fn pressed(c: &Checked, machine: &MachineProgram, state: usize, enters: bool, signal: usize) -> Option<Span> {
    let places = c.places.machine.as_ref()?;
    machine.states.iter().enumerate().find_map(|(from, s)| {
        s.transitions.iter().zip(&places.transitions[from]).find_map(|(t, place)| {
            let entered = machine.leaves(t.target).iter().any(|leaf| machine.path(*leaf).any(|s| s == state))
                && !machine.path(from).any(|s| s == state);
            let left = from == state;
            let taken = if enters { entered } else { left };
            let node = place.condition.filter(|_| taken)?;
            rising::comparisons(c, node).iter().any(|r| r.signal == signal).then_some(place.trigger)
        })
    })
}

//! Looks up states by their paths.

use dsl::{Diagnostic, Span};
use runtime::program::MachineProgram;

/// Returns the index of a state by its path, or by a suffix of its path if only one state has it.
///
/// # Errors
/// No state matches, or several do.
pub(super) fn state(machine: &MachineProgram, path: &str, at: Span) -> Result<usize, Box<Diagnostic>> {
    let states = &machine.states;
    let names = || states.iter().skip(1).map(|s| s.name.as_str());
    let end = format!(".{path}");
    let of = |good: &dyn Fn(&str) -> bool| (1..states.len()).filter(|&i| good(&states[i].name)).collect::<Vec<usize>>();
    match (of(&|n| n == path).as_slice(), of(&|n| n.ends_with(&end)).as_slice()) {
        ([state], _) | ([], [state]) => Ok(*state),
        ([], [_, _, ..]) => {
            let d = Diagnostic::unknown_name(at, format!("several states are called `{path}`"));
            Err(Box::new(d.help("write the path, `OUTER.INNER`")))
        }
        _ => {
            let d = Diagnostic::undeclared("state", path, at);
            Err(Box::new(d.help("this spec has no state").one_of("there is", path, names())))
        }
    }
}

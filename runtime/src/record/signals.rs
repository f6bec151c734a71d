//! Numbers of signals and variables, with the names that recorders use: `stem.x`, `right_ft.force.z`.

use crate::program::{Interface, SignalProgram};

/// A number of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalNumber {
    /// Index of the signal in [`Interface::signals`].
    pub signal: usize,
    /// Suffix to the signal's name: `.x`, `.force.z`; empty if the signal is a single number.
    pub part: String,
    /// Its index in the table of signals.
    pub at: usize,
    /// Its unit in SI; empty for none.
    pub unit: &'static str,
}

/// Suffixes for the numbers of a signal.
fn parts(s: &SignalProgram) -> Vec<String> {
    let of = |prefix: &str, axes: &[&str]| axes.iter().map(|a| format!("{prefix}.{a}")).collect::<Vec<_>>();
    const XYZ: [&str; 3] = ["x", "y", "z"];
    const WXYZ: [&str; 4] = ["w", "x", "y", "z"];
    match s.len {
        3 => of("", &XYZ),
        4 => of("", &WXYZ),
        6 => [of(".force", &XYZ), of(".moment", &XYZ)].concat(),
        7 => [of(".position", &XYZ), of(".orientation", &WXYZ)].concat(),
        _ => vec![String::new(); s.len],
    }
}

/// The unit in SI of number `k` of a signal; empty for none.
fn unit(s: &SignalProgram, k: usize) -> &'static str {
    match (s.kind.as_str(), k) {
        ("wrench", 0..3) => "N",
        ("wrench", _) => "Nm",
        ("point" | "length", _) | ("pose", 0..3) => "m",
        ("angle", _) => "rad",
        ("duration", _) => "s",
        ("rate", _) => "1/s",
        ("speed", _) => "m/s",
        ("angular_speed", _) => "rad/s",
        ("mass", _) => "kg",
        _ => "",
    }
}

/// The numbers of all signals and variables, in the order declared.
pub fn numbers(interface: &Interface) -> Vec<SignalNumber> {
    let of = |(signal, s): (usize, &SignalProgram)| {
        let one = |(k, part): (usize, String)| SignalNumber { signal, part, at: s.at + 1 + k, unit: unit(s, k) };
        parts(s).into_iter().enumerate().map(one).collect::<Vec<_>>()
    };
    interface.signals.iter().enumerate().flat_map(of).collect()
}

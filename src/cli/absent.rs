//! Commands that need a cargo feature: in a build without it, a command is listed in the help, accepts any arguments,
//! and reports the feature.

use clap::Args;

use super::Outcome;

/// Arguments of a command that this build does not contain. They are not read.
#[derive(Args)]
pub struct Arguments {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _any: Vec<String>,
}

/// Reports that a command needs the feature of the same name.
pub fn refuse(command: &str) -> Result<Outcome, String> {
    Err(format!("this build does not contain `{command}`, which needs the feature `{command}`; {FULL}"))
}

const FULL: &str = "`cargo build --release --features full` builds all commands";

/// Returns the end of the help: the commands that this build does not contain.
pub fn listed() -> String {
    let names: Vec<String> = ABSENT.iter().map(|name| format!("`{name}`")).collect();
    match names.is_empty() {
        true => String::new(),
        false => format!("This build does not contain {}; {FULL}.", names.join(", ")),
    }
}

/// Declares each command that needs the feature of the same name, if that feature is off.
macro_rules! absent {
    ($($command:ident = $feature:literal),*) => {
        $(
            #[cfg(not(feature = $feature))]
            pub mod $command {
                pub use super::Arguments;

                pub fn run(_: &Arguments) -> Result<crate::cli::Outcome, String> {
                    super::refuse($feature)
                }
            }
        )*

        /// The commands that this build does not contain.
        const ABSENT: &[&str] = &[$(#[cfg(not(feature = $feature))] $feature),*];
    };
}

absent!(context = "context", lsp = "lsp", serve = "serve", sweep = "sweep", watch = "watch");

//! Commands that need a cargo feature: in a build without it, a command is listed in the help, accepts any arguments,
//! and reports the feature. So does an option.

use clap::Args;

/// Arguments of a command that this build does not contain. They are not read.
#[derive(Args)]
pub struct Arguments {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _any: Vec<String>,
}

/// Message that a command or an option needs a feature.
pub fn needs(wanted: &str, feature: &str) -> String {
    format!("this build does not contain `{wanted}`, which needs the feature `{feature}`; {FULL}")
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

/// Declares each command that needs a feature, if that feature is off.
macro_rules! absent {
    ($($command:ident = $feature:literal),*) => {
        $(
            #[cfg(not(feature = $feature))]
            pub mod $command {
                pub use super::Arguments;

                pub fn run(_: &Arguments) -> Result<crate::cli::Outcome, String> {
                    Err(super::needs(stringify!($command), $feature))
                }
            }
        )*

        /// The commands that this build does not contain.
        const ABSENT: &[&str] = &[$(#[cfg(not(feature = $feature))] stringify!($command)),*];
    };
}

absent!(
    context = "context",
    convert = "mcap",
    lsp = "lsp",
    replay = "mcap",
    ros = "ros",
    serve = "serve",
    sweep = "sweep",
    watch = "watch"
);

/// The log of a run in MCAP, which this build cannot write.
#[cfg(not(feature = "mcap"))]
pub mod mcap_log {
    use std::convert::Infallible;

    use files::Results;
    use runtime::program::ScenarioProgram;
    use runtime::{Controller, Program, Recorder, Tick};

    /// A log. There is none.
    pub struct McapLog(Infallible);

    /// Reports the feature.
    pub fn possible() -> Result<(), String> {
        Err(super::needs("--log mcap", "mcap"))
    }

    impl McapLog {
        pub fn begin(
            _: &Results,
            _: &Program,
            _: Option<&ScenarioProgram>,
            _: &compiler::Report,
            _: &Controller,
        ) -> Result<McapLog, String> {
            Err(super::needs("--log mcap", "mcap"))
        }

        pub fn finish(self, _: &mut Results) -> Result<(), String> {
            match self.0 {}
        }
    }

    impl Recorder for McapLog {
        fn tick(&mut self, _: &Tick) -> std::io::Result<()> {
            match self.0 {}
        }
    }
}

//! `hierarq replay LOG`

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use clap::Args;
use logs::Log;
use logs::replay::{Difference, Replayed, replay};
use serde_json::json;

use super::{Outcome, interruption, output};

/// Largest size of a log that is read (bytes).
pub const MAX_LOG: u64 = 4 << 30;

#[derive(Args)]
pub struct Arguments {
    /// A log of `hierarq run --log mcap`.
    log: PathBuf,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let shown = a.log.display();
    let bytes = files::read(&a.log, MAX_LOG).map_err(|e| format!("cannot read `{shown}`: {e}"))?;
    let log = Log::read(&bytes).map_err(|e| format!("cannot use `{shown}`: {e}"))?;
    if log.hierarq != env!("CARGO_PKG_VERSION") {
        let own = env!("CARGO_PKG_VERSION");
        output::error_line(&format!("note: hierarq {} wrote the log, and this is hierarq {own}", log.hierarq));
    }
    if log.program.run.tick_budget.is_some() {
        output::error_line("note: ticks of this run had a budget of time, and late ones differ from run to run");
    }
    let interrupted = interruption::flag();
    let result = replay(&log, &mut |_| !interrupted.load(Ordering::Relaxed));
    let result = result.map_err(|e| format!("cannot replay `{shown}`: {e}"))?;
    let complete = result.difference.is_some() || result.ticks == log.ticks;
    let text = if a.json { data(&result, complete) } else { sentence(&result, &log, complete) };
    if a.json {
        output::data(&text)
    } else {
        output::print(&text)
    }
    Ok(Outcome::of(result.difference.is_none() && complete))
}

fn data(result: &Replayed, complete: bool) -> String {
    let difference = |d: &Difference| {
        json!({
            "tick": d.tick, "time_s": d.time, "channel": d.channel, "place": d.place, "logged": d.logged, "now": d.now,
        })
    };
    let all = json!({
        "agrees": complete && result.difference.is_none(), "ticks": result.ticks, "messages": result.messages,
        "difference": result.difference.as_ref().map(difference),
    });
    format!("{all:#}\n")
}

fn sentence(result: &Replayed, log: &Log, complete: bool) -> String {
    let Replayed { ticks, messages, difference } = result;
    match difference {
        None if complete => format!("agrees: {ticks} ticks, {messages} messages, every bit\n"),
        None => format!("INTERRUPTED: {ticks} of {} ticks agree\n", log.ticks),
        Some(d) => {
            let at =
                d.tick.map_or_else(|| "before the first tick".to_string(), |t| format!("tick {t} at {} s", d.time));
            let Difference { channel, place, logged, now, .. } = d;
            format!(
                "DIFFERS: {at}, `{channel}`, {place}: {logged} in the log, {now} now\n{messages} messages before it agree\n"
            )
        }
    }
}

//! Requests to end: Ctrl-C, and on Unix SIGTERM, with which service managers, containers and build servers ask for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Lets `act` answer each request to end, on a thread of its own, instead of ending the program there and then.
///
/// # Errors
/// What to say where the system knows no such requests.
pub fn answer(act: impl Fn() + Send + Sync + 'static) -> Result<(), String> {
    let act = Arc::new(act);
    #[cfg(unix)]
    terminated(Arc::clone(&act))?;
    ctrlc::set_handler(move || act()).map_err(|e| format!("cannot wait for an interruption: {e}"))
}

/// Answers SIGTERM. SIGHUP stays as it is: `nohup` relies on it.
#[cfg(unix)]
fn terminated(act: Arc<impl Fn() + Send + Sync + 'static>) -> Result<(), String> {
    use nix::sys::signal::{SigSet, Signal};
    let failed = |e: &dyn std::fmt::Display| format!("cannot wait for SIGTERM: {e}");
    let asked = SigSet::from(Signal::SIGTERM);
    // Held back from this thread and those that it starts, it comes to the one that waits for it.
    asked.thread_block().map_err(|e| failed(&e))?;
    let wait = move || {
        while asked.wait().is_ok() {
            act();
        }
    };
    std::thread::Builder::new().name("SIGTERM".to_string()).spawn(wait).map(|_| ()).map_err(|e| failed(&e))
}

/// True from the first request on: what is under way ends there, and its files are written as ever. A second one ends the
/// program at once.
pub fn flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let shared = Arc::clone(&flag);
    // Where no request can be answered, one ends the program at once.
    let _ = answer(move || {
        if shared.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    flag
}

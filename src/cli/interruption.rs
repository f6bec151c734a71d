//! Requests to end: Ctrl-C, and on Unix SIGTERM, which service managers, containers and build servers send.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Calls `act` for each request to end, on a separate thread, instead of ending the program immediately.
///
/// # Errors
/// The reason, if the system does not support such requests.
pub fn answer(act: impl Fn() + Send + Sync + 'static) -> Result<(), String> {
    let act = Arc::new(act);
    #[cfg(unix)]
    terminated(Arc::clone(&act))?;
    ctrlc::set_handler(move || act()).map_err(|e| format!("cannot wait for an interruption: {e}"))
}

/// Handles SIGTERM. SIGHUP is not changed: `nohup` relies on it.
#[cfg(unix)]
fn terminated(act: Arc<impl Fn() + Send + Sync + 'static>) -> Result<(), String> {
    use nix::sys::signal::{SigSet, Signal};
    let failed = |e: &dyn std::fmt::Display| format!("cannot wait for SIGTERM: {e}");
    let asked = SigSet::from(Signal::SIGTERM);
    // Blocked in this thread and in those that it starts, the signal is delivered to the waiting thread.
    asked.thread_block().map_err(|e| failed(&e))?;
    let wait = move || {
        while asked.wait().is_ok() {
            act();
        }
    };
    std::thread::Builder::new().name("SIGTERM".to_string()).spawn(wait).map(|_| ()).map_err(|e| failed(&e))
}

/// Returns a flag that is true from the first request on: the current work ends there, and its files are completed as
/// usual. A second request ends the program at once.
pub fn flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let shared = Arc::clone(&flag);
    // If no handler can be installed, a request ends the program at once.
    let _ = answer(move || {
        if shared.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    flag
}

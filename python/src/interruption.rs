//! Long computations that Ctrl-C ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Time between two looks at the interpreter's signals.
const PERIOD: Duration = Duration::from_millis(50);

/// Does `work` in a thread without the interpreter, and waits for it. `work` is given a function that becomes false when the user
/// interrupts, and should then end soon.
///
/// # Errors
/// The user has interrupted: `KeyboardInterrupt`, or what a handler of signals raises.
pub(crate) fn interruptible<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> R + Send,
) -> PyResult<R> {
    let interrupted = AtomicBool::new(false);
    py.detach(|| {
        std::thread::scope(|scope| {
            let (send, receive) = channel();
            let (send, interrupted) = (send, &interrupted);
            scope.spawn(move || send.send(work(&|| !interrupted.load(Ordering::Relaxed))));
            let mut raised = None;
            loop {
                match receive.recv_timeout(PERIOD) {
                    Ok(result) => return raised.map_or(Ok(result), Err),
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("the computation has ended without a result"));
                    }
                    // Only this thread may be the main one, which alone sees signals.
                    Err(RecvTimeoutError::Timeout) if raised.is_none() => {
                        if let Err(error) = Python::attach(|py| py.check_signals()) {
                            interrupted.store(true, Ordering::Relaxed);
                            raised = Some(error);
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
            }
        })
    })
}

//! Controllers: what the host tells, the tick, and what can be read after it.

use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use runtime::Observation;
use runtime::record::columns::{error, margin};
use stdlib_tasks::task::RowKind;

use crate::program::Program;
use crate::{Result, text};

/// A program made ready, with its state between ticks.
pub struct Controller {
    controller: runtime::Controller,
    nq: usize,
    nv: usize,
    /// Names of the machine's states, by their indices.
    states: Vec<CString>,
    /// States of regions that are active beside each other, with a terminator.
    beside: Vec<u8>,
    tasks: Vec<Task>,
    /// The last fault.
    fault: Option<runtime::Fault>,
    /// True after a failure of the library, until a restart.
    failed: bool,
}

/// A task that may run.
struct Task {
    name: CString,
    /// Index in the program.
    index: usize,
    limit: bool,
}

/// Makes a controller of a program: of its run, or of the stack with this name if it is not null. Returns null if there is none, with the reason in
/// `message`, a buffer of `capacity` bytes that may be null.
///
/// # Safety
/// `program` is null or a program; `stack` is null or ends with a zero; `message` is null or has `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_controller_new(
    program: *const Program,
    stack: *const c_char,
    message: *mut c_char,
    capacity: usize,
) -> *mut Controller {
    // SAFETY: as the caller promises.
    let made = match unsafe { program.as_ref() } {
        None => Err("the program is null".to_string()),
        Some(of) => {
            // SAFETY: as the caller promises.
            let stack = (!stack.is_null()).then(|| unsafe { CStr::from_ptr(stack) }.to_string_lossy());
            let made = catch_unwind(AssertUnwindSafe(|| prepared(&of.program, stack.as_deref())));
            made.unwrap_or_else(|_| Err("the library has failed".to_string()))
        }
    };
    match made {
        Ok(controller) => Box::into_raw(Box::new(controller)),
        Err(why) => {
            // SAFETY: as the caller promises.
            unsafe { text::write(&why, message, capacity) };
            std::ptr::null_mut()
        }
    }
}

fn prepared(program: &runtime::Program, stack: Option<&str>) -> std::result::Result<Controller, String> {
    let controller = match stack {
        None => runtime::Controller::new(program),
        Some(name) => {
            let index = program.stacks.iter().position(|s| s.name == name);
            let index = index.ok_or_else(|| format!("there is no stack `{name}`"))?;
            runtime::Controller::for_stack(program, index)
        }
    };
    let mut controller = controller.map_err(|e| e.to_string())?;
    controller.called_every(None);
    let mut tasks: Vec<Task> = Vec::new();
    for member in controller.stacks().iter().flat_map(|s| s.evaluator().members()) {
        if tasks.iter().all(|t| t.index != member.program_index) {
            let limit = member.row_kind == RowKind::Inequality;
            tasks.push(Task { name: text::name(&member.name), index: member.program_index, limit });
        }
    }
    Ok(Controller {
        nq: program.robot.model.nq(),
        nv: program.robot.model.nv(),
        beside: Vec::with_capacity(controller.longest_state() + 1),
        states: controller.machine().states.iter().map(|s| text::name(&s.name)).collect(),
        controller,
        tasks,
        fault: None,
        failed: false,
    })
}

/// Frees a controller.
///
/// # Safety
/// `controller` is null, or came from `hierarq_controller_new` and was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_controller_free(controller: *mut Controller) {
    if !controller.is_null() {
        // SAFETY: the caller promises that it is a box of this library, and its only owner.
        drop(unsafe { Box::from_raw(controller) });
    }
}

/// Begins anew: the next tick is the first one.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_restart(controller: *mut Controller) {
    // SAFETY: as the caller promises.
    if let Some(c) = unsafe { controller.as_mut() } {
        c.controller.restart();
        (c.fault, c.failed) = (None, false);
    }
}

/// Tells the time between two calls of `hierarq_step`, in s. Calls may come at any rate: the motion is the same. Without this, or with a number that is
/// not positive, it is found from the calls, and the robot stands still until the second one.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_called_every(controller: *mut Controller, interval: f64) {
    // SAFETY: as the caller promises.
    if let Some(c) = unsafe { controller.as_mut() } {
        c.controller.called_every((interval > 0.0).then_some(interval));
    }
}

/// Mean rate of the calls of `hierarq_step` (Hz), faults of time left out; 0 before the second one. The spec's rate is one divided by
/// `hierarq_period`: a mean that differs by more than 5 % where one call a period is meant says that the host's loop has another rate.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_measured_rate(controller: *const Controller) -> f64 {
    // SAFETY: as the caller promises.
    unsafe { controller.as_ref() }.and_then(|c| c.controller.intervals().rate()).unwrap_or(0.0)
}

/// Tells whether the robot takes commands: its program runs, its brakes are open. While it does not, the reference stays with the robot; afterwards
/// the robot stands until `hierarq_resume`. A controller begins with a robot that does.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_enabled(controller: *mut Controller, enabled: bool) {
    // SAFETY: as the caller promises.
    if let Some(c) = unsafe { controller.as_mut() } {
        c.controller.set_enabled(enabled);
    }
}

/// Brings the robot to rest within its limits, where it stands until `hierarq_resume`. Call `hierarq_step` until `hierarq_at_rest`.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_stop(controller: *mut Controller) {
    // SAFETY: as the caller promises.
    if let Some(c) = unsafe { controller.as_mut() } {
        c.controller.stop();
    }
}

/// Lets a robot go on that was stopped, or that takes commands again: from where it is, from rest.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_resume(controller: *mut Controller) {
    // SAFETY: as the caller promises.
    if let Some(c) = unsafe { controller.as_mut() } {
        c.controller.resume();
    }
}

/// Tells that the bases are elsewhere at the next call, because they were localised anew: the reference moves with them. Without this, a reading that
/// no base can have reached is the fault `HIERARQ_RESULT_JUMP`.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_relocated(controller: *mut Controller) {
    // SAFETY: as the caller promises.
    if let Some(c) = unsafe { controller.as_mut() } {
        c.controller.relocated();
    }
}

/// True if the robot is told to stand: a host that ends may stop calling.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_at_rest(controller: *const Controller) -> bool {
    // SAFETY: as the caller promises.
    unsafe { controller.as_ref() }.is_some_and(|c| c.failed || c.controller.is_at_rest())
}

/// Sends the value of a signal, received at `time` (s): `width` numbers in SI units, a flag above 0 for true. Returns false for null pointers, another
/// width, or a signal that the host cannot set.
///
/// # Safety
/// `controller` is null or a controller; `value` is null or has `width` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_signal_set(
    controller: *mut Controller,
    signal: i32,
    value: *const f64,
    width: usize,
    time: f64,
) -> bool {
    // SAFETY: as the caller promises.
    let Some(c) = (unsafe { controller.as_mut() }) else { return false };
    let Ok(signal) = usize::try_from(signal) else { return false };
    let signals = c.controller.signals();
    let known = signals.interface().signals.get(signal).filter(|s| !s.is_variable() && s.sent() == width);
    if known.is_none() || value.is_null() {
        return false;
    }
    // SAFETY: the caller promises `width` numbers.
    signals.set(signal, unsafe { std::slice::from_raw_parts(value, width) }, time)
}

/// Says that a signal has become absent. Returns false for a null pointer and a signal that the host cannot set.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_signal_clear(controller: *mut Controller, signal: i32) -> bool {
    // SAFETY: as the caller promises.
    let Some(c) = (unsafe { controller.as_mut() }) else { return false };
    let Ok(signal) = usize::try_from(signal) else { return false };
    let signals = c.controller.signals();
    let known = signals.interface().signals.get(signal).is_some_and(|s| !s.is_variable());
    if known {
        signals.clear(signal);
    }
    known
}

/// Says that an event has occurred. Returns false for a null pointer and an event that does not exist.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_event_raise(controller: *mut Controller, event: i32) -> bool {
    // SAFETY: as the caller promises.
    let Some(c) = (unsafe { controller.as_mut() }) else { return false };
    usize::try_from(event).is_ok_and(|event| c.controller.signals().raise(event))
}

/// Executes one tick: takes the measured configuration `q` (`nq` numbers, rad or m) at `time` (s) since the start, and writes the velocity until
/// the next tick (`nv` numbers, rad/s or m/s), which is finite in any case. It neither allocates nor blocks.
///
/// # Safety
/// `controller` is null or a controller; `q` is null or has `nq` numbers, `velocity` is null or has `nv` numbers; they do not overlap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_step(
    controller: *mut Controller,
    time: f64,
    q: *const f64,
    nq: usize,
    velocity: *mut f64,
    nv: usize,
) -> Result {
    if velocity.is_null() {
        return Result::NullPointer;
    }
    // SAFETY: the caller promises `nv` numbers.
    let velocity = unsafe { std::slice::from_raw_parts_mut(velocity, nv) };
    velocity.fill(0.0);
    // SAFETY: as the caller promises.
    let Some(c) = (unsafe { controller.as_mut() }) else { return Result::NullPointer };
    if q.is_null() {
        return Result::NullPointer;
    }
    if nq != c.nq || nv != c.nv {
        return Result::WrongLength;
    }
    if c.failed {
        return Result::Internal;
    }
    // SAFETY: the caller promises `nq` numbers.
    let q = unsafe { std::slice::from_raw_parts(q, nq) };
    let stepped = catch_unwind(AssertUnwindSafe(|| {
        let command = c.controller.step(&Observation { time, q });
        velocity.copy_from_slice(command.velocity);
        let fault = command.fault;
        if c.controller.leaves().len() > 1 {
            c.beside.clear();
            c.beside.extend_from_slice(c.controller.state().as_bytes());
            c.beside.push(0);
        }
        fault
    }));
    match stepped {
        Ok(fault) => {
            c.fault = fault;
            fault.map_or(Result::Ok, |f| f.kind().into())
        }
        Err(_) => {
            c.failed = true;
            velocity.fill(0.0);
            Result::Internal
        }
    }
}

/// Writes the fault of the last tick in words into `message`, a buffer of `capacity` bytes; an empty text without a fault.
///
/// # Safety
/// `controller` is null or a controller; `message` is null or has `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_fault_text(controller: *const Controller, message: *mut c_char, capacity: usize) {
    // SAFETY: as the caller promises.
    let c = unsafe { controller.as_ref() };
    let words = c.and_then(|c| Some(c.controller.describe(c.fault.as_ref()?))).unwrap_or_default();
    // SAFETY: as the caller promises.
    unsafe { text::write(&words, message, capacity) };
}

/// Path of the active state; an empty text without a machine. The states of regions are joined, `work.left.reach | work.right.wait`; this text changes with
/// the next tick. The text is freed with the controller.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_state(controller: *const Controller) -> *const c_char {
    // SAFETY: as the caller promises.
    let c = unsafe { controller.as_ref() };
    c.map_or(std::ptr::null(), |c| match c.controller.state() {
        "" => c"".as_ptr(),
        _ if c.controller.leaves().len() > 1 && !c.beside.is_empty() => c.beside.as_ptr().cast(),
        _ => text::at(&c.states, c.controller.state_index()),
    })
}

/// True if the machine has ended.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_is_final(controller: *const Controller) -> bool {
    // SAFETY: as the caller promises.
    unsafe { controller.as_ref() }.is_some_and(|c| c.controller.is_final())
}

/// True if a fault keeps the robot still until `hierarq_restart`.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_is_halted(controller: *const Controller) -> bool {
    // SAFETY: as the caller promises.
    unsafe { controller.as_ref() }.is_some_and(|c| c.failed || c.controller.is_halted())
}

/// Copies the configuration to be reached at the next call, which a position servo is sent, into an array of `nq` numbers, which are finite in any
/// case. Returns false for null pointers and another length.
///
/// # Safety
/// `controller` is null or a controller; `q` is null or has `nq` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_position(controller: *const Controller, q: *mut f64, nq: usize) -> bool {
    // SAFETY: as the caller promises.
    unsafe { copied(controller, q, nq, runtime::Controller::position) }
}

/// Copies the reference of the hierarchy after the last decision, into an array of `nq` numbers. Returns false for null pointers and another
/// length.
///
/// # Safety
/// `controller` is null or a controller; `q` is null or has `nq` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_reference(controller: *const Controller, q: *mut f64, nq: usize) -> bool {
    // SAFETY: as the caller promises.
    unsafe { copied(controller, q, nq, runtime::Controller::reference) }
}

/// Copies a configuration of a controller.
///
/// # Safety
/// As of the functions above.
unsafe fn copied(
    controller: *const Controller,
    q: *mut f64,
    nq: usize,
    of: fn(&runtime::Controller) -> &[f64],
) -> bool {
    // SAFETY: as the caller promises.
    let Some(c) = (unsafe { controller.as_ref() }) else { return false };
    if q.is_null() || nq != c.nq {
        return false;
    }
    // SAFETY: the caller promises `nq` numbers.
    unsafe { std::slice::from_raw_parts_mut(q, nq) }.copy_from_slice(of(&c.controller));
    true
}

/// Number of the tasks of all stacks that may run.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_task_count(controller: *const Controller) -> usize {
    // SAFETY: as the caller promises.
    unsafe { controller.as_ref() }.map_or(0, |c| c.tasks.len())
}

/// Name of a task; null beyond the end. The text is freed with the controller.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_task_name(controller: *const Controller, task: usize) -> *const c_char {
    // SAFETY: as the caller promises.
    let c = unsafe { controller.as_ref() };
    c.and_then(|c| c.tasks.get(task)).map_or(std::ptr::null(), |t| t.name.as_ptr())
}

/// True for a limit, false for a target.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_task_is_limit(controller: *const Controller, task: usize) -> bool {
    // SAFETY: as the caller promises.
    unsafe { controller.as_ref() }.and_then(|c| c.tasks.get(task)).is_some_and(|t| t.limit)
}

/// The smallest margin of a limit, negative if it is passed, or the norm of a target's error, in the unit of its rows, at the last tick. NaN if the task
/// did not run.
///
/// # Safety
/// `controller` is null or a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_task_value(controller: *const Controller, task: usize) -> f64 {
    // SAFETY: as the caller promises. What was not evaluated yet is now, and nothing that a caller could tell apart changes.
    let Some(c) = (unsafe { controller.cast_mut().as_mut() }) else { return f64::NAN };
    let Some(task) = c.tasks.get(task).filter(|_| c.fault.is_none() && !c.failed) else { return f64::NAN };
    let evaluator = c.controller.measured();
    let member = evaluator.members().iter().find(|m| m.program_index == task.index);
    member.map_or(f64::NAN, |m| if task.limit { margin(evaluator, m) } else { error(evaluator, m) })
}

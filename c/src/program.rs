//! Compiled programs: loading, names, the home configuration.

use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use runtime::program::CompiledFile;

use crate::text;

/// A compiled program with the robot that it is for. Nothing changes it.
pub struct Program {
    pub(crate) program: Arc<runtime::Program>,
    name: CString,
    positions: Vec<CString>,
    velocities: Vec<CString>,
    signals: Vec<CString>,
    events: Vec<CString>,
}

/// Loads a compiled program, the text that `hierarq compile --format json` writes, of `length` bytes. Returns null if it cannot be run, with the
/// reason in `message`, a buffer of `capacity` bytes that may be null.
///
/// # Safety
/// `json` has `length` bytes, and `message` is null or has `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_program_load(
    json: *const c_char,
    length: usize,
    message: *mut c_char,
    capacity: usize,
) -> *mut Program {
    let loaded = if json.is_null() {
        Err("the text is null".to_string())
    } else {
        // SAFETY: the caller promises `length` bytes.
        let bytes = unsafe { std::slice::from_raw_parts(json.cast::<u8>(), length) };
        catch_unwind(AssertUnwindSafe(|| read(bytes))).unwrap_or_else(|_| Err("the library has failed".to_string()))
    };
    match loaded {
        Ok(program) => Box::into_raw(Box::new(program)),
        Err(why) => {
            // SAFETY: the caller promises `capacity` bytes.
            unsafe { text::write(&why, message, capacity) };
            std::ptr::null_mut()
        }
    }
}

fn read(bytes: &[u8]) -> Result<Program, String> {
    let json = std::str::from_utf8(bytes).map_err(|e| format!("it is no compiled program: {e}"))?;
    let program = CompiledFile::read(json)?.program;
    let program = program.ok_or("it has missions alone: there is no robot to step")?;
    let signals = &program.interface.signals;
    Ok(Program {
        name: text::name(&program.name),
        positions: program.robot.q_names().iter().map(|n| text::name(n)).collect(),
        velocities: program.robot.model.dofs.iter().map(|d| text::name(&d.name)).collect(),
        signals: signals.iter().map(|s| text::name(&s.name)).collect(),
        events: program.interface.events.iter().map(|e| text::name(e)).collect(),
        program: Arc::new(program),
    })
}

/// Frees a program. Controllers that were made of it go on.
///
/// # Safety
/// `program` is null, or came from `hierarq_program_load` and was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_program_free(program: *mut Program) {
    if !program.is_null() {
        // SAFETY: the caller promises that it is a box of this library, and its only owner.
        drop(unsafe { Box::from_raw(program) });
    }
}

/// The program behind a pointer.
///
/// # Safety
/// It is null, or came from `hierarq_program_load` and was not freed.
unsafe fn of<'p>(program: *const Program) -> Option<&'p Program> {
    // SAFETY: as the caller promises.
    unsafe { program.as_ref() }
}

/// Name of the spec. The text is freed with the program.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_program_name(program: *const Program) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(std::ptr::null(), |p| p.name.as_ptr())
}

/// Length of a configuration.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_nq(program: *const Program) -> usize {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(0, |p| p.positions.len())
}

/// Length of a velocity: the number of degrees of freedom.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_nv(program: *const Program) -> usize {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(0, |p| p.velocities.len())
}

/// Time between two ticks (s).
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_period(program: *const Program) -> f64 {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(f64::NAN, |p| p.program.robot.period)
}

/// Name of a number of a configuration: of a joint, or `base_x`, .. Null beyond the end.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_q_name(program: *const Program, index: usize) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(std::ptr::null(), |p| text::at(&p.positions, index))
}

/// Name of a degree of freedom. Null beyond the end.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_v_name(program: *const Program, index: usize) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(std::ptr::null(), |p| text::at(&p.velocities, index))
}

/// Copies the home configuration, rad or m, into an array of `hierarq_nq` numbers. Returns false for null pointers and another length.
///
/// # Safety
/// `program` is null or a program; `q` is null or has `nq` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_home(program: *const Program, q: *mut f64, nq: usize) -> bool {
    // SAFETY: as the caller promises.
    let Some(p) = (unsafe { of(program) }) else { return false };
    let home = &p.program.robot.home;
    if q.is_null() || nq != home.len() {
        return false;
    }
    // SAFETY: the caller promises `nq` numbers, which are as many as those of the home configuration.
    unsafe { std::slice::from_raw_parts_mut(q, nq) }.copy_from_slice(home);
    true
}

/// Number of signals, variables of the machine among them.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_signal_count(program: *const Program) -> usize {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(0, |p| p.signals.len())
}

/// Name of a signal. Null beyond the end.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_signal_name(program: *const Program, index: usize) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { of(program) }.map_or(std::ptr::null(), |p| text::at(&p.signals, index))
}

/// Number of numbers of a signal's value: 1 for a number or a flag, 3 for a point, 7 for a pose (x, y, z, then a quaternion w, x, y, z), 6 for a wrench;
/// with a measured velocity, that follows. 0 for a variable of the machine, which the host cannot set, and beyond the end.
///
/// # Safety
/// `program` is null or a program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_signal_width(program: *const Program, index: usize) -> usize {
    // SAFETY: as the caller promises.
    let signal = unsafe { of(program) }.and_then(|p| p.program.interface.signals.get(index));
    signal.filter(|s| !s.is_variable()).map_or(0, |s| s.sent())
}

/// Index of the signal with this name, or -1.
///
/// # Safety
/// `program` is null or a program; `name` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_signal_index(program: *const Program, name: *const c_char) -> i32 {
    // SAFETY: as the caller promises.
    unsafe { of(program).map_or(-1, |p| index_of(&p.signals, name)) }
}

/// Index of the event with this name, or -1.
///
/// # Safety
/// `program` is null or a program; `name` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hierarq_event_index(program: *const Program, name: *const c_char) -> i32 {
    // SAFETY: as the caller promises.
    unsafe { of(program).map_or(-1, |p| index_of(&p.events, name)) }
}

/// # Safety
/// `name` is null or ends with a zero.
unsafe fn index_of(names: &[CString], name: *const c_char) -> i32 {
    if name.is_null() {
        return -1;
    }
    // SAFETY: as the caller promises.
    let name = unsafe { CStr::from_ptr(name) };
    names.iter().position(|n| n.as_c_str() == name).and_then(|i| i32::try_from(i).ok()).unwrap_or(-1)
}

//! Texts for C: names that live as long as what they are of, and messages in a buffer of the host.

use std::ffi::{CString, c_char};

/// A name with a terminator. Names of the language contain no zero byte.
pub(crate) fn name(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

/// Pointer to a name of a list; null beyond its end.
pub(crate) fn at(names: &[CString], index: usize) -> *const c_char {
    names.get(index).map_or(std::ptr::null(), |name| name.as_ptr())
}

/// Writes a text into a buffer of the host, cut to its capacity at a character's border, with a terminator.
///
/// # Safety
/// `buffer` is null or has `capacity` bytes.
pub(crate) unsafe fn write(text: &str, buffer: *mut c_char, capacity: usize) {
    if buffer.is_null() || capacity == 0 {
        return;
    }
    let mut end = text.len().min(capacity - 1);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    // SAFETY: the caller promises `capacity` bytes, of which this writes `end + 1` at most.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr().cast(), buffer, end);
        *buffer.add(end) = 0;
    }
}

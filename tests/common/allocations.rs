//! A counting allocator, for tests that check the absence of allocations. It counts for each thread, as the threads of the
//! test harness allocate at any time, and for all together.

#![allow(unsafe_code, reason = "a global allocator cannot be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    // Constant and without a destructor: its first use does not allocate.
    static OWN: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
    OWN.set(OWN.get() + 1);
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Returns the number of allocations of this thread so far.
pub fn so_far() -> usize {
    OWN.get()
}

/// Returns the number of allocations of all threads so far. The binary must contain a single test.
#[allow(dead_code, reason = "not every binary has threads")]
pub fn of_all_threads() -> usize {
    ALLOCATIONS.load(Ordering::SeqCst)
}

/// # Panics
/// Allocations are not counted.
pub fn are_counted() {
    let before = so_far();
    drop(std::hint::black_box(Vec::<u8>::with_capacity(10)));
    assert!(so_far() > before, "the counter counts");
}

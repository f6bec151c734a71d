//! Kinematics, parameter values and task rows allocate nothing at a tick, in any example: a counting allocator proves it.
//! (The solver of the reference cascade does allocate, and says so; it is left out here.)

#![allow(unsafe_code, reason = "a global allocator cannot be written without")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use runtime::Evaluator;
use runtime::program::Times;

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// One test only: another one beside it would be counted too.
#[test]
fn a_tick_of_kinematics_and_rows_allocates_nothing() {
    let before = ALLOCATIONS.load(Ordering::SeqCst);
    drop(std::hint::black_box(Vec::<u8>::with_capacity(10)));
    assert!(ALLOCATIONS.load(Ordering::SeqCst) > before, "the counter counts");

    for name in common::EXAMPLES {
        let program = common::program(&format!("{name}.hq"));
        let (mut evaluator, mut problem) = Evaluator::new(&program, program.run.stack).expect("it can be executed");
        let mut q = program.robot.home.clone();
        let v = vec![0.1; program.robot.model.nv()];
        evaluator.enter(&q, Times::default());
        let before = ALLOCATIONS.load(Ordering::SeqCst);
        for k in 0..200 {
            let times = Times { t: 0.01 * f64::from(k), time: 0.01 * f64::from(k) };
            let result = evaluator.update(&q, times, &mut problem);
            evaluator.observe(&q, &v);
            program.robot.model.integrate(&mut q, &v, program.robot.period);
            assert!(result.is_ok());
        }
        assert_eq!(ALLOCATIONS.load(Ordering::SeqCst), before, "{name} allocates");
    }
}

//! A tick of the controller allocates nothing, from the observation to the command, in any example: a counting allocator
//! proves it, over every tick of the run. (The reference cascade does allocate, and says so; it is not the default.)

#![allow(unsafe_code, reason = "a global allocator cannot be written without")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use runtime::{Controller, Observation, SimulatedRobot};

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
fn a_tick_allocates_nothing() {
    let before = ALLOCATIONS.load(Ordering::SeqCst);
    drop(std::hint::black_box(Vec::<u8>::with_capacity(10)));
    assert!(ALLOCATIONS.load(Ordering::SeqCst) > before, "the counter counts");

    for name in common::EXAMPLES {
        let program = common::program(&format!("{name}.hq"));
        let mut controller = Controller::new(&program).expect("it can be executed");
        let mut robot = SimulatedRobot::new(&program);
        let ticks = (program.run.duration / program.robot.period).round() as usize;
        for k in 0..ticks {
            let observation = Observation { time: k as f64 * program.robot.period, q: robot.measure() };
            let before = ALLOCATIONS.load(Ordering::SeqCst);
            let command = controller.step(&observation);
            assert_eq!(ALLOCATIONS.load(Ordering::SeqCst), before, "{name} allocates at tick {k}");
            assert!(command.fault.is_none(), "{name}, tick {k}");
            let velocity = command.velocity.to_vec();
            robot.apply(&velocity);
        }
    }
}

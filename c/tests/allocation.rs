//! A tick through the functions of the header, with signals and what is read after it, allocates nothing.

#[path = "../../tests/common/allocations.rs"]
mod allocations;
#[path = "common/spec.rs"]
mod spec;

use std::ptr::{null, null_mut};

use hierarq_c::*;

// A single test: the allocations of a second one in this process would be counted too.
#[test]
fn a_tick_allocates_nothing() {
    allocations::are_counted();
    let json = spec::json();
    // SAFETY: the pointers are those of the library, the arrays have the lengths that are passed.
    unsafe {
        let program = hierarq_program_load(json.as_ptr().cast(), json.len(), null_mut(), 0);
        let controller = hierarq_controller_new(program, null(), null_mut(), 0);
        let n = hierarq_nq(program);
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        hierarq_home(program, q.as_mut_ptr(), n);
        for k in 0..2000 {
            let time = f64::from(k) * 0.001;
            let before = allocations::so_far();
            hierarq_signal_set(controller, 0, [0.45, 0.1 * time, 0.5].as_ptr(), 3, time);
            if k == 100 {
                hierarq_event_raise(controller, 0);
            }
            let result = hierarq_step(controller, time, q.as_ptr(), n, v.as_mut_ptr(), n);
            let read: f64 = (0..hierarq_task_count(controller)).map(|i| hierarq_task_value(controller, i)).sum();
            assert!(!hierarq_state(controller).is_null() && !hierarq_is_final(controller));
            assert_eq!(allocations::so_far(), before, "tick {k}");
            assert_eq!(result, Result::Ok, "tick {k}: {read}");
            q.iter_mut().zip(&v).for_each(|(q, v)| *q += 0.001 * v);
        }
        hierarq_controller_free(controller);
        hierarq_program_free(program);
    }
}

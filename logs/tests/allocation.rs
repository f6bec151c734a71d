//! A tick that is recorded allocates nothing, from the first one on: a counting allocator proves it.

#[path = "../../tests/common/allocations.rs"]
mod allocations;
#[path = "it/runs.rs"]
#[allow(dead_code, reason = "other tests use the rest of it")]
mod examples;

use hierarq_logs::{About, McapRecorder, Origin, Overflow};
use runtime::{Recorder, Tick};

struct Counted {
    log: McapRecorder<std::io::Sink>,
    ticks: usize,
    allocations: usize,
    states: Vec<usize>,
}

impl Recorder for Counted {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let before = allocations::so_far();
        self.log.record(tick)?;
        self.allocations += allocations::so_far() - before;
        self.ticks += 1;
        if !self.states.contains(&tick.state_index) {
            self.states.push(tick.state_index);
        }
        Ok(())
    }
}

#[test]
fn a_tick_allocates_nothing() {
    allocations::are_counted();
    let scenario = Some("found at second sight");
    for (name, scenario, states) in [("hello.hq", None, 1), ("both_arms.hq", None, 1), ("tested.hq", scenario, 3)] {
        for overflow in [Overflow::Wait, Overflow::Drop] {
            let (program, scenario, _) = examples::compiled(name, scenario, 8.0);
            let about = About::new(&program, scenario.as_ref(), Vec::new(), Origin::Run);
            let mut simulation = examples::simulation(&program, scenario.as_ref());
            let log = McapRecorder::new(std::io::sink(), &about, &program, simulation.controller(), overflow);
            let mut counted = Counted { log: log.expect("a thread"), ticks: 0, allocations: 0, states: Vec::new() };
            simulation.run(&mut counted, &mut || 0.0, &mut |_| true).expect("a run");
            assert!(counted.ticks > 300 && counted.states.len() >= states, "{name}: {:?}", counted.states);
            assert_eq!(counted.allocations, 0, "{name}, {overflow:?}: {} ticks", counted.ticks);
            let written = counted.log.finish().expect("a stream").written;
            assert_eq!(written.ticks as u64 + written.dropped, counted.ticks as u64);
        }
    }
}

//! A stream that is slower than the run: a simulation waits for it, and a host drops ticks, counts them, and is never kept waiting.

use std::io::Write;
use std::sync::{Arc, Mutex};

use hierarq_logs::replay::replay;
use hierarq_logs::{About, Log, McapRecorder, Origin, Overflow};

use crate::runs::{compiled, simulation};

/// A stream that stands still while somebody holds its lock, and then writes nothing if it is broken.
struct Slow {
    gate: Arc<Mutex<()>>,
    broken: bool,
    bytes: Vec<u8>,
}

impl Write for Slow {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        drop(self.gate.lock());
        if self.broken && self.bytes.len() > 400_000 {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_host_drops_ticks_and_counts_them() {
    let (program, _, _) = compiled("hello.hq", None, 40.0);
    let about = About::new(&program, None, Vec::new(), Origin::Run);
    let gate = Arc::new(Mutex::new(()));
    let mut simulation = simulation(&program, None);
    let out = Slow { gate: Arc::clone(&gate), broken: false, bytes: Vec::new() };
    let mut log = McapRecorder::new(out, &about, &program, simulation.controller(), Overflow::Drop).expect("a thread");
    // No byte is written until the run has ended: if a tick waited for the stream, this would never end.
    let held = gate.lock().expect("a lock");
    simulation.run(&mut log, &mut || 0.0, &mut |_| true).expect("a run");
    drop(held);
    let dropped = log.dropped();
    let finished = log.finish().expect("a stream that goes on");
    assert!(dropped > 0 && finished.written.dropped == dropped);
    assert_eq!(finished.written.ticks as u64 + dropped, simulation.ticks() as u64);
    let read = Log::read(&finished.out.bytes).expect("a log");
    assert_eq!((read.ticks, read.dropped), (finished.written.ticks, dropped));
    let refused = replay(&read, &mut |_| true).expect_err("ticks are missing").to_string();
    assert!(refused.contains(&format!("{dropped} of its ticks were dropped")), "{refused}");
}

#[test]
fn a_full_disk_ends_the_run_with_its_reason() {
    let (program, _, _) = compiled("safety_tasks.hq", None, 25.0);
    let about = About::new(&program, None, Vec::new(), Origin::Run);
    let mut simulation = simulation(&program, None);
    let out = Slow { gate: Arc::new(Mutex::new(())), broken: true, bytes: Vec::new() };
    let mut log = McapRecorder::new(out, &about, &program, simulation.controller(), Overflow::Wait).expect("a thread");
    let error = simulation.run(&mut log, &mut || 0.0, &mut |_| true).expect_err("the disk is full");
    let runtime::RunError::Record(error) = error else { panic!("{error}") };
    assert_eq!(error.kind(), std::io::ErrorKind::StorageFull);
}

//! Outputs of tasks belong to the tick at which the tasks ran: without such a tick there is no output, and no condition
//! stays true by an earlier one.

use runtime::{FaultKind, Recorder, Tick};

use super::host::{ARM, Host};

/// A robot that stops until a person has been far enough away for half a second.
const STOP: &str = "
human operator { points [chest] }
task separation = speed_separation(link_6) {
  from operator.chest  reaction 50 ms  deceleration 3 m/s^2  intrusion 10 cm
}
stack watched from still { add separation hard { separation } after limits }
machine monitor {
  initial protective_stop
  on fault(any) -> protective_stop
  state protective_stop { stack watched  when separation.room > 10 cm for 0.5 s -> work }
  final state work { stack watched }
}
";

const FAR: [f64; 3] = [3.0, 0.0, 0.6];
const NEAR: [f64; 3] = [0.6, 0.0, 0.6];

/// Executes one tick with the person at a position; `seen` is false if the robot's state is invalid.
fn tick(host: &mut Host, chest: Option<[f64; 3]>, seen: bool) -> (String, Option<FaultKind>, bool) {
    if let Some(chest) = chest {
        host.set("operator.chest", &chest);
    }
    let mut q = host.robot.measure().to_vec();
    if !seen {
        q[2] = f64::NAN;
    }
    let answer = host.step_at(host.time(), &q);
    let room = host.controller.signals().interface().signal("separation.room").expect("it is told");
    (answer.state, answer.fault, host.controller.signals().is_present(room))
}

fn stopped(told: bool) -> (String, Option<FaultKind>, bool) {
    ("protective_stop".to_string(), None, told)
}

/// Returns the number of ticks until the stop is left with the person far away.
fn leaves_after(host: &mut Host) -> usize {
    (0..200).take_while(|_| tick(host, Some(FAR), true).0 == "protective_stop").count()
}

#[test]
fn a_stop_is_left_when_there_has_been_room_for_long_enough() {
    let mut host = Host::new(STOP);
    // Output at the first tick, evaluated at the second, and true for 50 ticks from then on.
    assert_eq!(leaves_after(&mut host), 51);
}

#[test]
fn a_stop_is_not_left_by_what_was_told_before_the_robot_was_out_of_sight() {
    let mut host = Host::new(STOP);
    for _ in 0..40 {
        assert_eq!(tick(&mut host, Some(FAR), true), stopped(true));
    }
    for _ in 0..100 {
        let blind = ("protective_stop".to_string(), Some(FaultKind::NotFinite), false);
        assert_eq!(tick(&mut host, Some(NEAR), false), blind);
    }
    // There is no output before the first tick, and the distance is too small at the following ones.
    for _ in 0..100 {
        assert_eq!(tick(&mut host, Some(NEAR), true), stopped(true));
    }
    assert_eq!(leaves_after(&mut host), 51);
}

/// The distance was sufficient all the time, but the duration counts from zero after the fault.
#[test]
fn the_time_of_a_condition_begins_anew_after_a_fault() {
    let mut host = Host::new(STOP);
    (0..40).for_each(|_| assert_eq!(tick(&mut host, Some(FAR), true), stopped(true)));
    tick(&mut host, Some(FAR), false);
    assert_eq!(leaves_after(&mut host), 51);
}

#[test]
fn a_stop_is_not_left_by_what_was_told_before_the_person_was_out_of_sight() {
    let mut host = Host::new(STOP);
    (0..20).for_each(|_| assert_eq!(tick(&mut host, Some(FAR), true), stopped(true)));
    let mut lost = 0;
    for _ in 0..100 {
        let (state, fault, told) = tick(&mut host, None, true);
        assert_eq!(state, "protective_stop");
        assert_eq!(told, fault.is_none(), "{fault:?}");
        lost += usize::from(fault == Some(FaultKind::Stale));
    }
    assert!(lost > 50, "{lost}");
    for _ in 0..100 {
        let (state, ..) = tick(&mut host, Some(NEAR), true);
        assert_eq!(state, "protective_stop");
    }
}

/// For each tick true if there was a fault, and the outputs in the signal table.
struct Log {
    at: usize,
    ticks: Vec<(bool, f64, f64)>,
}

impl Recorder for Log {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.ticks.push((tick.fault.is_some(), tick.signals[self.at], tick.signals[self.at + 1]));
        Ok(())
    }
}

#[test]
fn a_log_shows_nothing_where_nothing_is_told() {
    let program = crate::common::program_of(&format!(
        "{ARM}{STOP}scenario s {{ machine monitor  duration 2 s
  humans {{ operator {{ value [0.9, 0, 0.6] m  lost {{ from 0.5 s  to 1.5 s }} }} }} }}"
    ));
    let scenario = &program.scenarios[0];
    let own = scenario.program(&program);
    let room = own.interface.signal("separation.room").expect("it is told");
    let mut log = Log { at: own.interface.signals[room].at, ticks: Vec::new() };
    crate::common::record(&program, scenario, &mut log);
    let faults = log.ticks.iter().filter(|t| t.0).count();
    assert!((50..150).contains(&faults), "{faults}");
    for (i, (fault, present, value)) in log.ticks.iter().enumerate() {
        assert_eq!((*present < 0.0, value.is_nan()), (*fault, *fault), "tick {i}");
    }
}

//! Runs done again from their logs: all bits agree, and the first bit that was changed is found.

use hierarq_logs::replay::replay;
use hierarq_logs::{About, Finished, Log, LogFile, McapRecorder, Messages, Origin, Overflow, csv};
use runtime::program::ScenarioProgram;
use runtime::{Program, Recorder, Tick};

use crate::runs::{recorded, simulation};

#[test]
fn the_runs_of_examples_agree_bit_for_bit() {
    for (name, scenario, seconds) in [
        ("safety_tasks.hq", None, 0.3),
        ("room.hq", Some("a pillar that was moved"), 0.4),
        ("protective_stop.hq", Some("comes near and leaves"), 6.0),
        ("free_flyer.hq", None, 0.2),
    ] {
        let run = recorded(name, scenario, seconds);
        let log = Log::read(&run.mcap).expect("a log");
        let result = replay(&log, &mut |_| true).expect("a replay");
        assert_eq!(result.difference, None, "{name}");
        assert_eq!(result.ticks, run.csv.lines().count() - 1, "{name}");
        assert!(result.messages > 3 * result.ticks, "{name}");
        assert_eq!(recorded(name, scenario, seconds).mcap, run.mcap, "{name}: the same run gives the same file");
    }
}

#[test]
fn a_log_that_was_made_of_csv_agrees_too() {
    let run = recorded("protective_stop.hq", Some("comes near and leaves"), 6.0);
    let simulation = simulation(&run.program, run.scenario.as_ref());
    let controller = simulation.controller();
    let mut messages = Messages::new(&run.program, controller);
    let about = About { origin: Origin::Csv, ..run.about.clone() };
    let mut file = LogFile::new(Vec::new(), &about, &messages).expect("memory");
    messages.begin(&mut |topic, time, message| file.write(topic, time, message)).expect("memory");
    let rows = csv::Rows::new(&run.csv, &run.program, controller, messages.signals_at()).expect("its columns");
    let mut ticks = 0;
    for row in rows {
        let row = row.expect("a row");
        messages.tick(&row, &mut |topic, time, message| file.write(topic, time, message)).expect("memory");
        ticks += 1;
    }
    let bytes = file.finish(ticks, 0).expect("memory");
    let log = Log::read(&bytes).expect("a log");
    let result = replay(&log, &mut |_| true).expect("a replay");
    assert_eq!((result.difference, result.ticks), (None, ticks));
    let mut text = Vec::new();
    csv::write(&log, &mut text).expect("memory");
    assert!(String::from_utf8(text).expect("text") == run.csv);
}

/// Records a run whose commands are changed at one tick by the last bit of one number.
struct Bent<'r> {
    log: &'r mut McapRecorder<Vec<u8>>,
    at: usize,
    dof: usize,
}

impl Recorder for Bent<'_> {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        if tick.index != self.at {
            return self.log.record(tick);
        }
        let mut v = tick.v.to_vec();
        v[self.dof] = f64::from_bits(v[self.dof].to_bits() ^ 1);
        let Tick { index, time, q, stack, state, state_index, controller, command, .. } = *tick;
        let Tick { signals, evaluator, problem, solution, fault, elapsed, .. } = *tick;
        let bent = Tick {
            index,
            time,
            q,
            v: &v,
            stack,
            state,
            state_index,
            controller,
            command,
            signals,
            evaluator,
            problem,
            solution,
            fault,
            elapsed,
        };
        self.log.record(&bent)
    }
}

#[test]
fn the_first_bit_that_differs_is_named() {
    let (program, _, _): (Program, Option<ScenarioProgram>, String) =
        crate::runs::compiled("safety_tasks.hq", None, 0.5);
    let about = About::new(&program, None, Vec::new(), Origin::Run);
    let mut simulation = simulation(&program, None);
    let mut log =
        McapRecorder::new(Vec::new(), &about, &program, simulation.controller(), Overflow::Wait).expect("memory");
    let dof = 5;
    let mut bent = Bent { log: &mut log, at: 37, dof };
    simulation.run(&mut bent, &mut || 0.0, &mut |_| true).expect("a run");
    let Finished { out, .. } = log.finish().expect("memory");
    let log = Log::read(&out).expect("a log");
    let result = replay(&log, &mut |_| true).expect("a replay");
    let found = result.difference.expect("a difference");
    let joint = &program.robot.model.dofs[dof].name;
    assert_eq!((found.tick, found.channel.as_str()), (Some(37), "/joint_states"));
    assert!(found.place.starts_with("`velocity[") && found.place.ends_with(&format!("of `{joint}`")), "{found:?}");
    assert_ne!(found.logged, found.now);
    assert_eq!(result.ticks, 37);
}

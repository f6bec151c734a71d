//! Working robots that run their controllers in scenarios of missions: compared with the controller alone, after
//! breakdowns, and with the same records for the same seed.

use crate::common;
mod files;

use common::example;
use common::played::{compiled_in, found};
use proptest::prelude::*;
use runtime::missions::{End, MissionRun, MissionSummary, WorkerRecord};
use runtime::program::{Job, MissionProgram, MissionScenarioProgram, Program, ScenarioProgram, SignalScript};
use runtime::{Recorder, Tick};
use std::path::{Path, PathBuf};

/// Serving robots, a person, and `workers`.
fn team(workers: &str) -> String {
    format!(
        "hierarq 1
mission day : schedule {{
  robot m1 {{ depot [0, 0] m  speed 0.5 m/s  proximity_speed 0.5 m/s  serve 5 s  deposit 2 s }}
  robot m2 {{ depot [0, 6] m  speed 0.5 m/s  proximity_speed 0.5 m/s  serve 5 s  deposit 2 s }}
  human h1 {{ place [6, 1] m  operations 2  duration normal(30 s, 3 s) }}
  {workers}
}}
"
    )
}

const PICKER: &str = "worker w1 { place [5, 4] m  operations 2  duration normal(36 s, 3 s)
    runs { spec \"picker.hq\"  scenario \"two boxes\"  go box_in_place  done waiting } }";

/// Compiles a scenario with this body in the folder of the examples.
fn scenario(workers: &str, body: &str) -> (MissionProgram, MissionScenarioProgram) {
    let text = format!("{}scenario s {{ mission day  {body} }}\n", team(workers));
    found(&compiled_in(&example(""), &text))
}

fn run((mission, scenario): &(MissionProgram, MissionScenarioProgram)) -> MissionRun {
    runtime::missions::run(mission, scenario, &mut runtime::missions::NullRecorder, &mut |_| true).expect("a run")
}

fn summary(workers: &str, body: &str) -> MissionSummary {
    run(&scenario(workers, body)).summary
}

/// Returns the begin and end of each operation of a worker (s); an aborted one has no end.
fn operations(summary: &MissionSummary, worker: &str) -> Vec<(f64, Option<f64>)> {
    let of = |text: &str| {
        let words = |h: &&runtime::missions::LogEntry| {
            h.what.starts_with("operation ") && h.what.ends_with(&format!("of {worker} {text}"))
        };
        summary.log.iter().filter(words).map(|h| h.at_s).collect::<Vec<_>>()
    };
    let (begins, ends) = (of("begins"), of("ends"));
    let next = |i: usize| begins.get(i + 1).copied().unwrap_or(f64::INFINITY);
    let end = |i: usize, began: f64| ends.iter().copied().find(|end| (began..=next(i)).contains(end));
    begins.iter().enumerate().map(|(i, began)| (*began, end(i, *began))).collect()
}

fn record<'s>(summary: &'s MissionSummary, worker: &str) -> &'s WorkerRecord {
    summary.workers.iter().find(|w| w.name == worker).expect("a record")
}

/// Entry times of a state of a machine (s).
struct Entries {
    state: &'static str,
    inside: bool,
    times: Vec<f64>,
}

impl Recorder for Entries {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let inside = tick.state == self.state;
        if inside && !self.inside {
            self.times.push(tick.time);
        }
        self.inside = inside;
        Ok(())
    }
}

/// Runs the controller alone, with its signal true in these intervals.
fn alone(program: &Program, world: &ScenarioProgram, go: usize, works: &[(f64, f64)], duration: f64) -> Vec<f64> {
    let script = |from: f64, to: Option<f64>, value: f64| SignalScript {
        signal: go,
        from,
        to,
        path: vec![(0.0, vec![value])],
        noise: 0.0,
        delay: 0.0,
        drop: 0.0,
        period: 0.0,
        nan: Vec::new(),
    };
    let mut scripts = Vec::new();
    for (i, (from, to)) in works.iter().enumerate() {
        scripts.push(script(*from, Some(*to), 1.0));
        scripts.push(script(*to, works.get(i + 1).map(|w| w.0), -1.0));
    }
    let mut scenario = world.clone();
    scenario.world.signals.extend(scripts);
    scenario.run.duration = duration;
    let mut entries = Entries { state: "waiting", inside: true, times: Vec::new() };
    common::record(program, &scenario, &mut entries);
    entries.times
}

#[test]
fn an_operation_takes_what_the_controller_alone_takes() {
    for seed in [1, 8] {
        let (mission, scenario) = scenario(PICKER, &format!("duration 300 s  seed {seed}"));
        let summary = run(&(mission.clone(), scenario)).summary;
        assert!(matches!(summary.end, End::Done { .. }), "{:?}", summary.end);
        let works: Vec<(f64, f64)> =
            operations(&summary, "w1").into_iter().map(|(from, to)| (from, to.expect("an end"))).collect();
        assert_eq!(works.len(), 2);
        // The second one began when a robot had come, between ticks of the controller.
        assert!(works[0].0 == 0.0 && works[1].0 > works[0].1);
        let member = mission.kind.members().iter().position(|member| member.name == "w1").expect("a worker");
        let (worker, controller) = mission.running.of(member).expect("a worker that runs");
        let Job::Operations { go, .. } = worker.job else { panic!("operations") };
        let entered = alone(&controller.program, &worker.world, go, &works, works[1].1 + 1.0);
        assert_eq!(entered.len(), works.len(), "{entered:?}");
        for (alone, (_, in_team)) in entered.iter().zip(&works) {
            assert!((alone - in_team).abs() < 1e-9, "{alone} s alone, {in_team} s in the team");
        }
        let took: Vec<f64> = works.iter().map(|(from, to)| to - from).collect();
        assert_eq!(record(&summary, "w1").operations_s, took);
    }
}

/// Creates a folder with the spec of a controller.
fn folder(name: &str, controller: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mission_workers").join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let urdf = example("robots/arm7.urdf").canonicalize().expect("a file");
    let text = format!(
        "hierarq 1
robot arm {{ urdf \"{}\"  rate 50 Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
signal go : flag
{controller}",
        urdf.display()
    );
    std::fs::write(folder.join("own.hq"), text).expect("a file");
    folder
}

/// It moves to a position and back.
const SHUTTLE: &str = "
task out = frame_position(tool) { position [0.55, 0.20, 0.50] m  gain 2 /s }
task back = frame_position(tool) { position [0.45, -0.20, 0.50] m  gain 2 /s }
task limits = joint_velocity_limits
stack outwards { level limits hard { limits }  level motion { out } }
stack backwards { level limits hard { limits }  level motion { back } }
machine shuttle {
  initial idle
  state idle { stack backwards  when go -> away }
  state away { stack outwards  on reached(out, 2 cm) -> home }
  state home { stack backwards  on reached(back, 2 cm) -> idle }
}
";

const OWN: &str = "worker w1 { place [5, 4] m  operations 3  duration normal(8 s, 1 s)
    runs { spec \"own.hq\"  go go  done idle } }";

fn own(name: &str, controller: &str, workers: &str, body: &str) -> MissionSummary {
    let text = format!("{}scenario s {{ mission day  {body} }}\n", team(workers));
    run(&found(&compiled_in(&folder(name, controller), &text))).summary
}

/// It waits at the position until it detects something there, which is rare and random.
fn uncertain() -> String {
    let looks = SHUTTLE.replace("-> home }", "-> look }  state look { stack outwards  when present(seen) -> home }");
    format!(
        "signal seen : flag?  timeout 0.1 s\n{looks}scenario seldom {{
           machine shuttle  duration 9 s  signals {{ seen {{ value true  period 0.2 s  drop 0.8 }} }} }}\n"
    )
}

#[test]
fn the_same_seed_gives_the_same_records() {
    // Every operation except for the worker's takes its planned time, so that nothing else depends on the seed.
    let workers = OWN.replace("normal(8 s, 1 s)", "8 s").replace("go go", "scenario \"seldom\"  go go");
    let of = |seed: u64| {
        let summary = own("seeds", &uncertain(), &workers, &format!("duration 200 s  seed {seed}  travel bases"));
        (serde_json::to_string(&summary).expect("data"), record(&summary, "w1").operations_s.clone())
    };
    let (first, again, other) = (of(3), of(3), of(4));
    assert_eq!(first, again);
    assert_eq!((first.1.len(), other.1.len()), (3, 3));
    assert_ne!(first.1, other.1, "other values are lost");
}

#[test]
fn workers_that_run_the_same_spec_share_it_and_not_their_worlds() {
    let own = OWN.replace("spec \"own.hq\"", "spec \"own.hq\"  scenario \"seldom\"");
    let two = format!("{own}\n{}", own.replace("w1", "w2").replace("[5, 4]", "[5, 2]"));
    let text = format!("{}scenario s {{ mission day  duration 200 s }}\n", team(&two));
    let (mission, scenario) = found(&compiled_in(&folder("shared", &uncertain()), &text));
    let running = &mission.running;
    assert_eq!((running.controllers.len(), running.workers.len()), (1, 2));
    let summary = run(&(mission, scenario)).summary;
    let of = |name: &str| record(&summary, name).operations_s.clone();
    assert!(of("w1").len() == 3 && of("w2").len() == 3 && of("w1")[0] != of("w2")[0], "{:?}", summary.workers);
}

/// Level `reach` is hard, and infeasible for the required speed.
const INFEASIBLE: &str = "
task limits = joint_velocity_limits
task stay = joint_velocity { velocity 0 rad/s }
task rush = joint_velocity { velocity if(t > 0.5 s, 50 rad/s, 0 rad/s) }
stack standing { level limits hard { limits }  level motion { stay } }
stack rushing { level limits hard { limits }  level reach hard { rush } }
machine work { initial idle  state idle { stack standing  when go -> rush }  state rush { stack rushing  after 9 s -> idle } }
";

#[test]
fn a_controller_that_faults_loses_its_worker_and_says_why() {
    let bare = own("fault", INFEASIBLE, OWN, "duration 200 s");
    let broke = record(&bare, "w1").broke_down.clone().expect("it broke down");
    assert!(broke.why.contains("`reach`"), "{}", broke.why);
    // One tick until the signal is evaluated, half a second until the velocity is required.
    assert!((0.5..0.6).contains(&broke.at_s), "{}", broke.at_s);
    let at = |text: &str| bare.log.iter().find(|h| h.what.contains(text)).map(|h| h.at_s);
    // No transition handles the fault at the next tick.
    let (fault, lost) = (at("controller of w1 has a fault").expect("told"), at("w1 is lost").expect("told"));
    assert!(lost == broke.at_s && (lost - fault - 0.02).abs() < 1e-9, "{fault} {lost}");
    // The others are served nevertheless, and no expectation covers the loss.
    assert!(matches!(bare.end, End::Done { .. }) && !bare.ok, "{:?}", bare.end);
    assert!(bare.trouble()[0].1.starts_with("w1 broke down: "), "{:?}", bare.trouble());
    let spoken = own(
        "fault",
        INFEASIBLE,
        OWN,
        "duration 200 s  expect eventually within 2 s : w1.faulted  expect eventually done
         expect always (w1.lost implies w1.faulted)  expect always w1.served < 1",
    );
    assert!(spoken.ok, "{:?} {:?}", spoken.expectations, spoken.trouble());
    // After a repair it starts again, and breaks down as before.
    let mended =
        own("fault", INFEASIBLE, OWN, "duration 200 s  happens [{ at 20 s  back w1 }]  expect eventually w1.faulted");
    let again = record(&mended, "w1").broke_down.clone().expect("again");
    assert!((20.5..20.6).contains(&again.at_s), "{}", again.at_s);
}

#[test]
fn a_fault_that_the_machine_answers_loses_nobody() {
    let answered = INFEASIBLE.replace(
        "initial idle ",
        "initial idle  on fault(any) -> rest  state rest { stack standing  after 1 s -> idle } ",
    );
    let summary = own("answered", &answered, OWN, "duration 60 s  expect never w1.lost");
    assert!(summary.ok, "{:?}", summary.trouble());
    assert!(summary.log.iter().any(|h| h.what.starts_with("the controller of w1 has a fault")));
    // A worker whose machine handles the fault by stopping for good is lost.
    let ended = INFEASIBLE.replace("initial idle ", "initial idle  on fault(any) -> out  final state out ");
    let summary = own("ended", &ended, OWN, "duration 60 s");
    let broke = record(&summary, "w1").broke_down.clone().expect("it broke down");
    assert!(broke.why.contains("come to its end in `out`"), "{}", broke.why);
}

#[test]
fn a_machine_may_end_with_its_only_operation() {
    let once = SHUTTLE.replace("-> idle }", "-> done }  final state done { stack backwards }");
    let worker = OWN.replace("operations 3", "operations 1").replace("done idle", "done done");
    let summary = own("once", &once, &worker, "duration 100 s  expect eventually done  expect never w1.lost");
    assert!(summary.ok, "{:?}", summary.trouble());
    assert_eq!(record(&summary, "w1").operations_s.len(), 1);
}

#[test]
fn a_worker_that_is_away_stands_still_and_begins_anew() {
    let body = "duration 200 s  happens [{ at 1 s  lost w1 }, { at 41 s  back w1 }]
        expect always (not w1.lost or not w1.faulted)  expect eventually done";
    let summary = own("away", SHUTTLE, OWN, body);
    assert!(summary.ok, "{:?}", summary.trouble());
    // Three completed operations, after an aborted one.
    let took = &record(&summary, "w1").operations_s;
    assert_eq!(took.len(), 3, "{took:?}");
    let end = match summary.end {
        End::Done { at_s } => at_s,
        end => panic!("{end:?}"),
    };
    // It executes no ticks while it is away or after the end.
    let ticks = record(&summary, "w1").ticks as f64;
    assert!((ticks - 50.0 * (end - 40.0)).abs() <= 2.0, "{ticks} ticks, {end} s");
}

#[test]
fn as_planned_no_controller_runs() {
    let summary = summary(
        PICKER,
        "duration 300 s  operations planned  expect eventually done  expect always day.reschedules < 1",
    );
    assert!(summary.ok && summary.workers.is_empty(), "{:?}", summary.expectations);
}

/// State of the machine in the log, in the measures, and in the summary.
#[test]
fn the_log_has_the_state_of_the_machine() {
    let body =
        "duration 300 s  step 200 ms  expect always (in(w1.waiting) or w1.working)  expect eventually in(w1.cut)";
    let (mission, scenario) = scenario(PICKER, body);
    let (run, bytes) = common::played::logged(&mission, &scenario);
    assert!(run.summary.ok, "{:?}", run.summary.expectations);
    let text = String::from_utf8(bytes).expect("a text");
    let mut rows = text.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let header = rows.next().expect("a header");
    let at = |name: &str| header.iter().position(|h| *h == name).expect("a column");
    let (state, doing) = (at("w1.state"), at("w1.doing"));
    let rows: Vec<Vec<&str>> = rows.collect();
    assert!(rows.iter().all(|r| r.len() == header.len()));
    assert!(rows.iter().all(|r| r[state] == "waiting" || r[doing] == "working"));
    assert!(rows.iter().any(|r| r[state] == "carry"));
}

/// The text of a random event.
fn event() -> impl Strategy<Value = String> {
    let at = 0..60_u32;
    prop_oneof![
        (at.clone(), -9..20_i32).prop_map(|(t, by)| format!("{{ at {t} s  late w1  by {by} s }}")),
        (at.clone(), prop::sample::select(vec!["w1", "m1", "h1"]))
            .prop_map(|(t, a)| format!("{{ at {t} s  lost {a} }}")),
        (at.clone(), prop::sample::select(vec!["w1", "m1", "h1"]))
            .prop_map(|(t, a)| format!("{{ at {t} s  back {a} }}")),
        (at.clone(), prop::sample::select(vec!["w1", "h1"])).prop_map(|(t, a)| format!("{{ at {t} s  done {a} }}")),
        (at, prop::sample::select(vec!["w1", "h1"])).prop_map(|(t, a)| format!("{{ at {t} s  begun {a} }}")),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]
    /// For any events, operations that the controller ends are those of the mission, and end at its ticks.
    #[test]
    fn random_days_keep_machine_and_mission_together(events in prop::collection::vec(event(), 0..5), seed in 0..99_u64) {
        let body = format!("duration 120 s  seed {seed}  step 500 ms  happens [{}]", events.join(", "));
        let summary = own("random", SHUTTLE, OWN, &body);
        let record = record(&summary, "w1");
        let all = operations(&summary, "w1");
        // A worker that comes back repeats an operation that was not served.
        let again = events.iter().filter(|e| e.contains("back w1")).count();
        prop_assert!(record.operations_s.len() <= 3 + again);
        prop_assert!(record.operations_s.iter().all(|took| *took > 0.0));
        // The controller's operations are among those that ended.
        let ended: Vec<f64> = all.iter().filter_map(|(from, to)| Some((*to)? - from)).collect();
        prop_assert!(record.operations_s.iter().all(|took| ended.iter().any(|e| (e - took).abs() < 1e-9)));
        if !events.iter().any(|e| e.contains("w1")) {
            let at_tick = |t: f64| (t / 0.02 - (t / 0.02).round()).abs() < 1e-6;
            prop_assert!(all.iter().all(|(_, to)| to.is_none_or(at_tick)), "{all:?}");
        }
        prop_assert!(record.ticks <= 120 * 50 + 1);
    }
}

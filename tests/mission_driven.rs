//! Robots of missions whose bases controllers of their own drive: along the planned way, round people, late and lost.

use crate::common;

use common::example;
use common::played::{compiled_in, found, numbers, table};
use mission::kind::{Detail, Event};
use runtime::expect::Verdict;
use runtime::missions::{End, MissionRun, WorkerRecord};
use runtime::program::{CompiledFile, DriveProgram, Job, TimedEvent, WorkerProgram};
use std::path::{Path, PathBuf};

/// A base with an arm that follows the target, and keeps away from a person.
const CARRIER: &str = "
param clear = 0.9 m
human visitor { points [chest]  max_speed 3 m/s }
signal drive_to : point
task go = frame_position(base_link) { position drive_to  gain 2 /s }
task apart = keep(norm([frame(base_link).position.x - visitor.chest.x, frame(base_link).position.y - visitor.chest.y, 0 m])) {
  min clear  gain 3 /s }
task still = joint_velocity { velocity { \"joint_*\" 0 rad/s } }
stack drive {
  level limits hard { joint_velocity_limits }
  level people hard { apart }
  level motion { go }
  level arm { still }
}
run { stack drive  duration 5 s }
";

/// Creates a folder with the spec of a controller.
pub fn folder(name: &str, controller: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mission_driven").join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let urdf = example("robots/arm7.urdf").canonicalize().expect("a file");
    let text = format!(
        "hierarq 1
robot carrier {{
  urdf \"{}\"
  base planar
  rate 50 Hz
  limits {{ base_x {{ velocity 0.6 m/s }}  base_y {{ velocity 0.6 m/s }}  base_yaw {{ velocity 1 rad/s }} }}
  home {{ all [0, -0.3, 0, 2, 0, 1.4, 0] rad }}
}}
{controller}",
        urdf.display()
    );
    std::fs::write(folder.join("carrier.hq"), text).expect("a file");
    folder
}

/// A room with a robot that crosses it, and with `more`.
pub fn room(runs: &str, more: &str) -> String {
    format!(
        "hierarq 1
mission day : search {{
  area [[0, 0], [10, 0], [10, 6], [0, 6]] m
  horizon 60 s
  states 500
  robot tiago {{ start [1, 3] m  speed 0.5 m/s  {runs} }}
  source door {{ at [9, 3] m  radius 0.3 m  inside {{ rate 2 /s }}  pool 10  targets [tiago] }}
  {more}
}}
"
    )
}

pub const RUNS: &str = "runs { spec \"carrier.hq\"  target drive_to }";
const ANNA: &str = "human anna { start [5, 2.5] m  speed 1 m/s }
  source plants { at [5, 2.5] m  radius 0.2 m  inside { rate 1 /s }  pool 50  targets [anna] }";

/// A run with its log.
struct Played {
    run: MissionRun,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Played {
    fn of(folder: &Path, mission: &str, body: &str) -> Played {
        let text = format!("{mission}scenario s {{ mission day  step 100 ms  {body} }}\n");
        let (mission, scenario) = found(&compiled_in(folder, &text));
        let (run, bytes) = common::played::logged(&mission, &scenario);
        let (header, rows) = table(bytes);
        Played { run, header, rows }
    }

    /// Positions in the log.
    fn way(&self, name: &str) -> Vec<[f64; 2]> {
        let of = |axis: &str| numbers(&self.header, &self.rows, &format!("{name}.{axis}"));
        of("x").into_iter().zip(of("y")).map(|(x, y)| [x, y]).collect()
    }

    fn done(&self) -> f64 {
        match self.run.summary.end {
            End::Done { at_s } => at_s,
            ref end => panic!("{end:?} {:#?}", self.run.summary.log),
        }
    }

    fn record(&self) -> &WorkerRecord {
        &self.run.summary.workers[0]
    }

    fn said(&self, text: &str) -> Option<f64> {
        self.run.summary.log.iter().find(|entry| entry.what.contains(text)).map(|entry| entry.at_s)
    }
}

fn length(way: &[[f64; 2]]) -> f64 {
    way.windows(2).map(|two| f64::hypot(two[1][0] - two[0][0], two[1][1] - two[0][1])).sum()
}

#[test]
fn alone_a_base_follows_the_planned_way_in_its_time() {
    let folder = folder("alone", &without_people());
    let driven = Played::of(&folder, &room(RUNS, ""), "duration 60 s  expect eventually done");
    let planned = Played::of(&folder, &room(RUNS, ""), "duration 60 s  operations planned");
    assert!(driven.run.summary.ok && planned.run.summary.workers.is_empty(), "{:?}", driven.run.summary.trouble());
    // Each coordinate lags by no more than the gain makes of the speed.
    let far = |(a, b): (&[f64; 2], &[f64; 2])| f64::hypot(a[0] - b[0], a[1] - b[1]);
    let off = driven.way("tiago").iter().zip(&planned.way("tiago")).map(far).fold(0.0, f64::max);
    assert!((0.01..0.3).contains(&off), "{off}");
    assert!(driven.record().drive.as_ref().is_some_and(|drive| drive.off_way_m < 0.02), "{:?}", driven.record());
    assert!((driven.done() - planned.done()).abs() < 1.0, "{} {}", driven.done(), planned.done());
    let reward = |of: &Played| of.run.summary.outcome.as_ref().expect("results")["reward"].as_f64().expect("a number");
    assert!((reward(&driven) - reward(&planned)).abs() < 1e-6, "{} {}", reward(&driven), reward(&planned));
    // It is where its base is, and has come as far.
    let travelled = driven.record().drive.as_ref().expect("a base").travelled_m;
    assert!((length(&driven.way("tiago")) - travelled).abs() < 0.02, "{travelled}");
    assert!(driven.said("is late").is_none());
}

/// Wherever she stands beside the way, and on it.
#[test]
fn no_place_of_a_person_makes_it_come_too_near() {
    let folder = folder("places", CARRIER);
    let runs = "runs { spec \"carrier.hq\"  target drive_to  people { visitor anna } }";
    for (y, passes) in [(2.0, true), (2.4, true), (2.95, false), (3.0, false), (3.4, true), (3.7, true)] {
        let room = room(runs, &ANNA.replace("2.5]", &format!("{y}]")));
        let driven = Played::of(&folder, &room, "duration 40 s  expect never tiago.faulted");
        let least = least(&driven);
        assert!(driven.run.summary.ok && least > 0.9 - 1e-3, "{y} m: {least} m, {:?}", driven.run.summary.trouble());
        let arrives = driven.way("tiago").iter().any(|at| f64::hypot(at[0] - 9.0, at[1] - 3.0) < 0.3);
        assert!(arrives == passes && driven.said("tiago is late").is_some() != passes, "{y} m");
    }
}

/// The least distance of the two in the log.
fn least(of: &Played) -> f64 {
    let far = |(a, b): (&[f64; 2], &[f64; 2])| f64::hypot(a[0] - b[0], a[1] - b[1]);
    of.way("tiago").iter().zip(&of.way("anna")).map(far).fold(f64::INFINITY, f64::min)
}

#[test]
fn it_keeps_the_distance_to_a_person_whom_the_planned_way_passes() {
    let folder = folder("person", CARRIER);
    let runs = "runs { spec \"carrier.hq\"  target drive_to  people { visitor anna } }";
    let driven = Played::of(&folder, &room(runs, ANNA), "duration 60 s  expect eventually done");
    let planned = Played::of(&folder, &room(runs, ANNA), "duration 60 s  operations planned");
    assert!(least(&planned) < 0.55, "{}", least(&planned));
    assert!((0.9 - 1e-3..0.95).contains(&least(&driven)), "{}", least(&driven));
    assert!(driven.run.summary.ok, "{:?} {:#?}", driven.run.summary.trouble(), driven.run.summary.log);
    assert!(driven.record().drive.as_ref().is_some_and(|drive| drive.off_way_m > 0.3), "{:?}", driven.record());
    let again = Played::of(&folder, &room(runs, ANNA), "duration 60 s  expect eventually done");
    assert_eq!(again.rows, driven.rows);
}

/// A robot that has to go round a wall.
const WALL: &str = "wall shelf { line [[5, 0], [5, 4.5]] m }";

#[test]
fn it_stays_in_the_corridor_of_its_way() {
    let folder = folder("corridor", &without_people());
    let driven = Played::of(&folder, &room(RUNS, WALL), "duration 60 s  expect eventually done");
    let planned = Played::of(&folder, &room(RUNS, WALL), "duration 60 s  operations planned");
    assert!(driven.run.summary.ok, "{:?}", driven.run.summary.trouble());
    // Against the way that a robot without a controller has gone, in steps of 5 cm.
    let way = planned.way("tiago");
    let near = |p: &[f64; 2]| way.iter().map(|q| f64::hypot(p[0] - q[0], p[1] - q[1])).fold(f64::INFINITY, f64::min);
    let off = driven.way("tiago").iter().map(near).fold(0.0, f64::max);
    assert!((0.03..0.2).contains(&off), "{off}");
    let told = driven.record().drive.as_ref().expect("a base").off_way_m;
    assert!((told - off).abs() < 0.05, "{told} {off}");
}

pub fn without_people() -> String {
    let line = |line: &&str| !["human", "param", "level people", "task apart"].iter().any(|word| line.contains(word));
    CARRIER.lines().filter(line).filter(|line| !line.contains("min clear")).map(|line| format!("{line}\n")).collect()
}

#[test]
fn a_base_that_is_slower_than_planned_is_late_and_arrives() {
    let slow = without_people().replace("gain 2 /s", "gain 0.4 /s");
    let folder = folder("late", &slow);
    let driven = Played::of(&folder, &room(RUNS, ""), "duration 60 s  expect eventually done");
    assert!(driven.run.summary.ok, "{:?}", driven.run.summary.trouble());
    // It follows half a metre behind its target with 0.2 m/s: 40 s in place of 16 s.
    let late = driven.said("tiago is late by").expect("late");
    assert!((late - 17.2).abs() < 0.5, "{late}");
    let arrives = driven.said("tiago is done").expect("it arrives");
    assert!((arrives - 40.0).abs() < 4.0, "{arrives}");
    assert!(driven.run.summary.results.as_ref().expect("results").reschedules > 0);
    let reward = driven.run.summary.outcome.as_ref().expect("results")["reward"].as_f64();
    assert_eq!(reward, Some(10.0));
}

#[test]
fn a_controller_that_faults_loses_its_robot_where_it_is() {
    let rush = "task rush = joint_velocity { velocity { \"joint_1\" if(t > 5 s, 50 rad/s, 0 rad/s) } }\nstack drive {";
    let faulty = without_people()
        .replace("stack drive {", rush)
        .replace("level motion", "level reach hard { rush }\n  level motion");
    let folder = folder("lost", &faulty);
    let bare = Played::of(&folder, &room(RUNS, ""), "duration 30 s  expect always day.makespan < 99 s");
    let broke = bare.record().broke_down.clone().expect("it broke down");
    assert!((5.0..5.2).contains(&broke.at_s) && broke.why.contains("`reach`"), "{broke:?}");
    assert!(!bare.run.summary.ok && bare.said("tiago is lost") == Some(broke.at_s), "{:?}", bare.run.summary.trouble());
    let last = bare.way("tiago").last().copied().expect("a position");
    assert!((last[0] - 3.3).abs() < 0.4 && (last[1] - 3.0).abs() < 1e-6, "{last:?}");
    let again = Played::of(
        &folder,
        &room(RUNS, ""),
        "duration 30 s  happens [{ at 20 s  back tiago }]  expect eventually within 6 s : tiago.faulted and tiago.lost
         expect eventually from 20 s : not tiago.lost",
    );
    let expected = &again.run.summary.expectations;
    assert!(expected.iter().all(|e| e.verdict == Verdict::Holds), "{expected:?}");
    let last = again.way("tiago").last().copied().expect("a position");
    assert!(last[0] > 5.0 && again.record().broke_down.as_ref().is_some_and(|broke| broke.at_s > 24.0), "{last:?}");
}

/// Events that move it are refused where they are written, as long as its controller runs.
#[test]
fn only_its_controller_moves_a_driven_robot() {
    let folder = folder("moved", &without_people());
    for event in ["moved", "robot_pose"] {
        let body = |operations: &str| {
            let room = room(RUNS, "human anna { start [5, 1] m  speed 1 m/s }");
            format!(
                "{room}scenario s {{ mission day  duration 60 s  {operations}
                 happens [{{ at 4 s  {event} tiago  to [2, 1] m }}]  expect eventually done }}\n"
            )
        };
        let driven = compiled_in(&folder, &body("")).report.diagnostics;
        assert!(driven.iter().any(|d| d.code == "HQ0922" && d.notes.concat().contains("its controller drives it")));
        assert_eq!(compiled_in(&folder, &body("operations planned")).report.errors(), 0, "{event}");
    }
    // In a program that was written by hand it is refused as well, before anything runs.
    let text = format!("{}scenario s {{ mission day  duration 60 s  expect eventually done }}\n", room(RUNS, ""));
    let mut mission = compiled_in(&folder, &text).missions.remove(0);
    let what =
        Event { event: "moved".into(), member: Some(0), with: [("to".into(), Detail::Point([2.0, 1.0]))].into() };
    mission.scenarios[0].happens = vec![TimedEvent { at: 4.0, what }];
    let why = mission.check().expect_err("moved");
    assert!(why.to_string().contains("its controller drives it"), "{why}");
}

/// Whatever its controller cannot work with stops the robot where it is, and the mission goes on without it.
#[test]
fn faults_inside_a_controller_lose_its_robot() {
    let scenario = "scenario \"world\" { stack drive  duration 5 s  SCRIPT }\n";
    let world = |script: &str| format!("{}{}", without_people(), scenario.replace("SCRIPT", script));
    let signals = "signals { drive_to { value [0, 0, 0] m } }";
    let late = world(&format!("{signals}  late {{ at 4 s  by 200 ms }}"));
    let root = without_people().replace("gain 2 /s", "gain 2 /s * sqrt(5 - t/(1 s))");
    let runs = |more: &str| format!("runs {{ spec \"carrier.hq\"  target drive_to  {more} }}");
    for (name, controller, runs, from, why) in [
        ("deadline", late, runs("scenario \"world\""), 4.0, "a call came"),
        ("not_finite", root, runs(""), 5.0, "finite"),
    ] {
        let folder = folder(name, &controller);
        let played = Played::of(&folder, &room(&runs, ANNA), "duration 40 s  expect eventually plants.reward > 20");
        let broke = played.record().broke_down.clone().unwrap_or_else(|| panic!("{name}: {:#?}", played.record()));
        assert!((from..from + 0.3).contains(&broke.at_s) && broke.why.contains(why), "{name}: {broke:?}");
        assert_eq!(played.said("tiago is lost"), Some(broke.at_s));
        let (way, after) = (played.way("tiago"), ((broke.at_s + 0.5) * 10.0) as usize);
        assert!(way.iter().flatten().all(|x| x.is_finite()));
        assert!(way[after..].iter().all(|at| *at == way[after]), "{name}: it stands");
        let expected = &played.run.summary.expectations;
        assert_eq!(expected[0].verdict, Verdict::Holds, "{name}: anna goes on");
    }
}

/// Looking for what is hidden, which plans anew at each find. The steps of the log change nothing but the log.
#[test]
fn finds_follow_the_base_whatever_the_steps_are() {
    let folder = folder("hidden", CARRIER);
    let sees = "sees { within 2.5 m  rate 0.5 /s }";
    let room = format!(
        "hierarq 1
mission day : search {{
  area [[0, 0], [10, 0], [10, 6], [0, 6]] m
  horizon 120 s
  window 30 s
  states 500
  robot tiago {{ start [1, 3] m  speed 0.5 m/s  {sees}
    runs {{ spec \"carrier.hq\"  target drive_to  people {{ visitor anna }} }} }}
  human anna {{ start [6, 1] m  speed 1 m/s  {sees} }}
  object token {{ count 3  worth 10  positions [[9, 5], [2, 5], [8, 1]] m }}
  wall shelf {{ line [[5, 2.5], [5, 6]] m }}
}}
"
    );
    let body = "duration 60 s  seed 6  expect eventually day.all_found  expect never tiago.faulted";
    let fine = Played::of(&folder, &room, body);
    assert!(fine.run.summary.ok && least(&fine) > 0.9 - 1e-3, "{:?}", fine.run.summary.trouble());
    assert!(fine.said("tiago has found token").is_some() && !fine.record().operations_s.is_empty());
    let text = format!("{room}scenario s {{ mission day  step 3 s  {body} }}\n");
    let (mission, scenario) = found(&compiled_in(&folder, &text));
    let coarse = common::played::logged(&mission, &scenario).0.summary;
    let summary = &fine.run.summary;
    assert_eq!((&coarse.end, &coarse.outcome, &coarse.log), (&summary.end, &summary.outcome, &summary.log));
    assert_eq!(coarse.workers[0].drive, summary.workers[0].drive);
}

/// A base that keeps to the left of its way by the direction of the way, and stands where the way ends while it does not go.
#[test]
fn direction_and_motion_are_signals() {
    let aside = without_people()
        .replace("signal drive_to", "signal way : angle\nsignal goes : flag\nsignal drive_to")
        .replace("position drive_to", "position drive_to + if(goes, 0.15 m, 0 m)*[-sin(way), cos(way), 0]");
    let folder = folder("aside", &aside);
    let runs = "runs { spec \"carrier.hq\"  target drive_to  heading way  going goes  tolerance 0.3 m }";
    let driven = Played::of(&folder, &room(runs, ""), "duration 60 s  expect eventually done");
    assert!(driven.run.summary.ok, "{:?}", driven.run.summary.trouble());
    let way = driven.way("tiago");
    assert!(way.iter().any(|[x, y]| (x - 5.0).abs() < 0.1 && (y - 3.15).abs() < 0.01), "{way:?}");
    let end = way.last().copied().expect("a position");
    assert!((end[1] - 3.0).abs() < 0.02, "{end:?}");
}

/// A modification of a file.
type Damage = fn(&mut WorkerProgram, &mut DriveProgram);

#[test]
fn a_compiled_file_keeps_driven_robots_and_refuses_damage() {
    let runs = "runs { spec \"carrier.hq\"  target drive_to  people { visitor anna } }";
    let text = format!("{}scenario s {{ mission day  duration 60 s }}\n", room(runs, ANNA));
    let missions = compiled_in(&folder("file", CARRIER), &text).missions;
    let json = CompiledFile::to_json("day", None, &missions).expect("a text");
    assert_eq!(CompiledFile::read(&json).expect("a file").missions, missions);
    let damaged: [(&str, Damage); 8] = [
        ("workers[0]", |w, _| w.member = 1),
        ("workers[0].target", |_, d| d.target = 1 - d.target),
        ("workers[0].target", |_, d| d.target = 99),
        ("workers[0].heading", |_, d| d.heading = Some(d.target)),
        ("workers[0].going", |_, d| d.going = Some(d.target)),
        ("workers[0].people", |_, d| d.people = vec![(0, 99)]),
        ("workers[0].people", |_, d| d.people = vec![(1, 1)]),
        ("workers[0]", |_, d| d.ahead = f64::NAN),
    ];
    for (place, change) in damaged {
        let mut other = missions.clone();
        let worker = &mut other[0].running.workers[0];
        let Job::Drive(mut drive) = worker.job.clone() else { panic!("it drives") };
        change(worker, &mut drive);
        worker.job = Job::Drive(drive);
        let found = other[0].check().expect_err("refused").place;
        assert!(found.contains(place), "{found}, not {place}");
    }
}

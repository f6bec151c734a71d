//! The safety planner in a running controller: the field follows the planner's prediction and stays above its
//! threshold, and no input of a person or a tracker stops the controller.

use crate::common;
#[path = "../examples/comparison.rs"]
#[allow(dead_code, reason = "the example prints what is judged here")]
mod comparison;

use proptest::prelude::*;
use runtime::program::Program;
use runtime::{Controller, Fault, Observation, Recorder, SimulatedRobot, Simulation, Tick};

/// An arm whose tool moves to and fro; `guard` are the planner's settings, `rest` follows.
fn spec(rate: u32, guard: &str, rest: &str) -> String {
    format!(
        "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate {rate} Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
human walker {{ points [chest, hand]  velocity measured }}
safety_field nearness {{ of walker }}
task reach = frame_position(tool) {{ position initial(position) + [0, 0.2, 0] m * sin(pi*t/(2 s))  gain 20 /s }}
task guard = safety_planner(reach) {{ field nearness  {guard} }}
{rest}"
    )
}

const STACK: &str = "stack work { level motion { reach }  level internal { guard } }";
const LIMITED: &str = "task velocity_limits = joint_velocity_limits
stack work { level limits hard { velocity_limits }  level motion { reach }  level internal { guard } }";

/// A person at rest far away, walking in and out again; measured.
const WALK: &str = "humans { walker { path [{ at 0 s  value [2.4, 0.4, 0] m }, { at 2 s  value [0.9, 0.4, 0] m }, { at 4 s  value [0.9, 0.4, 0] m }, { at 6 s  value [2.4, 0.4, 0] m }]
  shape { chest [0, 0, 1.0] m  hand [-0.2, 0, 0.8] m } } }";

fn told(table: &[f64], program: &Program, name: &str) -> f64 {
    let s = program.interface.signal(name).map(|s| &program.interface.signals[s]).expect(name);
    table[s.at + 1]
}

/// Outputs of a planner at one tick, with the field's rate for its law.
#[derive(Clone, Debug, PartialEq)]
struct TaskOutput {
    time: f64,
    scaling: f64,
    deviation: f64,
    slack: f64,
    withheld: f64,
    field: f64,
    rate: f64,
    clock: f64,
    stack: usize,
    q: Vec<f64>,
    v: Vec<f64>,
    command: Vec<f64>,
    fault: Option<Fault>,
}

struct All<'p>(&'p Program, Vec<TaskOutput>);

impl Recorder for All<'_> {
    fn tick(&mut self, t: &Tick) -> std::io::Result<()> {
        let table = t.controller.signal_table();
        let of = |name: &str| told(table, self.0, &format!("guard.{name}"));
        let planner = t.controller.evaluator().safety().next();
        self.1.push(TaskOutput {
            time: t.time,
            scaling: of("scaling"),
            deviation: of("deviation"),
            slack: of("slack"),
            withheld: of("withheld"),
            field: of("field"),
            rate: planner.map_or(f64::NAN, |p| p.0.plan().field_rate),
            clock: planner.map_or(f64::NAN, |p| p.0.clock()),
            stack: t.stack,
            q: t.q.to_vec(),
            v: t.v.to_vec(),
            command: t.command.to_vec(),
            fault: t.fault,
        });
        Ok(())
    }
}

fn run(text: &str) -> Vec<TaskOutput> {
    let program = common::program_of(text);
    let ran = program.scenarios[0].program(&program);
    let mut all = All(&ran, Vec::new());
    common::record(&program, &program.scenarios[0], &mut all);
    all.1
}

fn least(all: &[TaskOutput]) -> f64 {
    all.iter().map(|t| t.field).fold(f64::INFINITY, f64::min)
}

const DEVIATE: &str =
    "scaling { weight 10 }  deviate { position { speed 0.4 m/s  most 0.3 m } }  internal { gain 0.1 }";

/// The field follows the planner's prediction for any state, person and method: the error of a step is proportional to
/// the period.
fn prediction(home: &[f64], person: &[f64], method: &str, rate: u32) -> (f64, f64) {
    let text =
        spec(rate, &format!("min 0.7 m  method {method}  {}", if method == "planner" { DEVIATE } else { "" }), STACK);
    let mut program = common::program_of(&text);
    program.robot.home.copy_from_slice(home);
    let mut controller = Controller::new(&program).expect("it can be executed");
    let period = program.robot.period;
    let mut robot = SimulatedRobot::new(&program);
    let (mut before, mut worst, mut fastest): (Option<(f64, f64)>, f64, f64) = (None, 0.0, 0.0);
    for k in 0..20 {
        let time = k as f64 * period;
        for point in 0..2 {
            let p = &person[point * 6..point * 6 + 6];
            let value: Vec<f64> = (0..3).map(|i| p[i] + p[3 + i] * time).chain(p[3..].iter().copied()).collect();
            let signal = program.interface.signal(["walker.chest", "walker.hand"][point]).expect("it is tracked");
            assert!(controller.signals().set(signal, &value, time));
        }
        let command = controller.step(&Observation { time, q: robot.q() });
        assert_eq!(command.fault, None);
        let velocity = command.velocity.to_vec();
        let (planner, field) = controller.evaluator().safety().next().expect("it runs");
        if let Some((value, rate)) = before {
            worst = worst.max(((field.value() - value) / period - rate).abs());
        }
        // The part of the law that the hierarchy leaves out at a singularity is not the planner's.
        fastest = fastest.max((field.rate(controller.velocity()) - planner.plan().field_rate).abs());
        before = Some((field.value(), field.rate(controller.velocity())));
        robot.apply(&velocity);
    }
    (worst, fastest)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn the_field_does_what_the_planner_says(
        home in prop::collection::vec(-0.4..0.4f64, 7),
        person in prop::collection::vec(-1.0..1.0f64, 12),
        method in prop::sample::select(vec!["planner", "evasive", "stop"]),
    ) {
        let home: Vec<f64> = home.iter().zip([0.0, 0.4, 0.0, 1.6, 0.0, 1.14, 0.0]).map(|(d, q)| q + d).collect();
        let mut person = person;
        person[0] += 1.5;
        person[6] += 1.5;
        let (coarse, left) = prediction(&home, &person, method, 1000);
        let (fine, _) = prediction(&home, &person, method, 4000);
        prop_assert!(left < 1e-6, "the hierarchy does what the law says: {left}");
        prop_assert!(coarse < 0.05 && fine < 0.4 * coarse + 1e-6, "{coarse} {fine}");
    }
}

#[test]
fn the_field_stays_above_its_threshold() {
    let scenario = format!("scenario s {{ duration 8 s  {WALK} }}");
    let free = run(&spec(200, "min 0.1 m  internal { gain 0 }", &format!("{STACK}\n{scenario}")));
    assert!(least(&free) < 0.83, "the person comes near enough: {}", least(&free));
    assert!(free.iter().all(|t| (t.scaling - 1.0).abs() < 1e-6 && t.deviation == 0.0), "nothing gives way far above");
    let kept = run(&spec(200, &format!("min 0.85 m  {DEVIATE}"), &format!("{STACK}\n{scenario}")));
    assert!(least(&kept) > 0.85 - 2e-3, "{}", least(&kept));
    assert!(kept.iter().any(|t| t.deviation > 0.02), "the path deviates");
    assert!(kept.iter().all(|t| t.fault.is_none()));
    let last = kept.last().expect("a tick");
    assert!(last.deviation < 5e-3 && last.scaling > 0.99, "and all is well when the person has gone: {last:?}");
}

/// If only the clock can yield, the task waits; with method `stop` the clock stops completely.
#[test]
fn the_clock_waits_alone() {
    let scenario = format!("scenario s {{ duration 8 s  {WALK} }}");
    let stop = run(&spec(200, "min 0.9 m  method stop", &format!("{STACK}\n{scenario}")));
    for (a, b) in stop.iter().zip(&stop[1..]) {
        assert_eq!(a.scaling, if a.field > 0.9 { 1.0 } else { 0.0 });
        assert!((b.clock - a.clock - 0.005 * b.scaling).abs() < 1e-9);
    }
    assert!(stop.iter().any(|t| t.scaling == 0.0), "somebody is near");
    assert!(stop.iter().all(|t| t.deviation == 0.0));
}

/// A robot without a person nearby follows its task as without a planner.
#[test]
fn far_away_the_planner_changes_nothing() {
    let nobody = "duration 3 s  humans { walker { value [9, 0, 0] m  shape { chest [0, 0, 1] m  hand [0, 0, 1] m } } }";
    let settings = "min 0.5 m  internal { gain 0 }";
    let with = run(&spec(200, settings, &format!("{STACK}\nscenario s {{ {nobody} }}")));
    let plain = "stack plain { level motion { reach } }";
    let without = run(&spec(
        200,
        settings,
        &format!("{STACK}\n{plain}\nscenario s {{ stack plain  {nobody} }}\nrun {{ stack plain }}"),
    ));
    let worst = with.iter().zip(&without).flat_map(|(a, b)| a.q.iter().zip(&b.q)).map(|(a, b)| (a - b).abs());
    assert!(worst.fold(0.0, f64::max) < 1e-9);
    assert!(without.iter().all(|t| t.scaling.is_nan()), "a planner that does not run tells nothing");
}

/// The arm of [`spec`] with another task instead of `reach`, and a wrench that a scenario may exert.
fn other(task: &str, guard: &str, rest: &str) -> String {
    let text = spec(200, guard, rest);
    let from = text.find("task reach").expect("it is there");
    let to = from + text[from..].find('\n').expect("a line");
    format!("{}signal touch : wrench  timeout 1 s\ntask reach = {task}{}", &text[..from], &text[to..])
}

const BODY: &str = "mass { linear 20 kg  angular 3 kg m^2 }  damping { linear 253 N s/m  angular 27 N m s }";

/// Target of an admittance that moves fast enough for its acceleration to matter.
fn comply() -> String {
    format!(
        "admittance(tool) {{ target {{ position initial(target.position) + [0, 0.15, 0] m * sin(pi*t/(1 s)) }}  {BODY}
  stiffness {{ linear 800 N/m  angular 60 N m }}  wrench {{ force touch.force  moment touch.moment }} }}"
    )
}

fn lead() -> String {
    format!("hand_guiding(tool) {{ {BODY}  wrench {{ force touch.force  moment touch.moment }} }}")
}

/// A hand that pulls while the person is at `x`.
fn pulled(x: f64) -> String {
    format!(
        "humans {{ walker {{ value [{x}, 0.3, 0] m  shape {{ chest [0, 0, 1] m  hand [-0.2, 0, 0.8] m }} }} }}
  signals {{ touch {{ value {{ force [0, 0, 0] N  moment [0, 0, 0] N m }} }} }}
  push {{ touch [{{ from 0.5 s  to 1.5 s  force [10, 25, 0] N }}] }}"
    )
}

/// Tasks with a mass have a state. A planner evaluates them three times per tick, without an effect on the state: the
/// robot moves as without it, up to rounding.
#[test]
fn far_away_a_planner_changes_nothing_for_a_mass() {
    for task in [comply(), lead()] {
        let settings = "min 0.5 m  internal { gain 0 }";
        let with = run(&other(&task, settings, &format!("{STACK}\nscenario s {{ duration 3 s  {} }}", pulled(9.0))));
        let plain = "stack plain { level motion { reach } }\nrun { stack plain }";
        let scenario = format!("scenario s {{ stack plain  duration 3 s  {} }}", pulled(9.0));
        let without = run(&other(&task, settings, &format!("{STACK}\n{plain}\n{scenario}")));
        assert!(with.iter().all(|t| t.fault.is_none()) && with.len() == without.len(), "{task}");
        let worst = with.iter().zip(&without).flat_map(|(a, b)| a.q.iter().zip(&b.q)).map(|(a, b)| (a - b).abs());
        assert!(worst.fold(0.0, f64::max) < 1e-9, "{task}");
        let moved = with.iter().flat_map(|t| t.q.iter().zip(&with[0].q)).map(|(a, b)| (a - b).abs());
        assert!(moved.fold(0.0, f64::max) > 0.02, "it is led: {task}");
    }
}

/// While the clock is stopped, a mass moves as if its target were at rest: it does not continue with the speed of the
/// target.
#[test]
fn a_mass_whose_clock_stands_has_a_target_that_stands() {
    let scenario = format!("duration 3 s  {}", pulled(1.2));
    let stopped = run(&other(&comply(), "min 5 m  method stop", &format!("{STACK}\nscenario s {{ {scenario} }}")));
    assert!(stopped.iter().all(|t| t.scaling == 0.0 && t.fault.is_none()));
    let still = comply().replace(" + [0, 0.15, 0] m * sin(pi*t/(1 s))", "");
    let plain = "stack plain { level motion { reach } }\nrun { stack plain }";
    let rest = format!("{STACK}\n{plain}\nscenario s {{ stack plain  {scenario} }}");
    let free = run(&other(&still, "min 0.1 m", &rest));
    let worst = stopped.iter().zip(&free).flat_map(|(a, b)| a.q.iter().zip(&b.q)).map(|(a, b)| (a - b).abs());
    assert!(worst.fold(0.0, f64::max) < 1e-9);
    let moved = free.iter().flat_map(|t| t.q.iter().zip(&free[0].q)).map(|(a, b)| (a - b).abs());
    assert!(moved.fold(0.0, f64::max) > 0.02, "it gives way to the hand");
}

/// Near a person the field follows the planner's prediction for tasks with a mass too: their rows are affine in the
/// rate of the clock, and the robot yields in time or in the null space.
#[test]
fn a_mass_gives_way_to_a_person() {
    // A stack without limits of speeds needs joints without any: the reference waits for slower ones.
    let all: Vec<String> = (1..8).map(|i| format!("joint_{i} {{ velocity 100 rad/s }}")).collect();
    let limits = format!("limits {{ {} }}  home {{", all.join("  "));
    let run = |text: &str| run(&text.replacen("home {", &limits, 1));
    for (task, waits) in [(comply(), true), (lead(), false)] {
        let free = run(&other(
            &task,
            "min 0.1 m  internal { gain 0 }",
            &format!("{STACK}\nscenario s {{ duration 3 s  {} }}", pulled(0.95)),
        ));
        let threshold = least(&free) + 0.004;
        let kept = run(&other(
            &task,
            &format!("min {threshold} m  scaling {{ weight 0.1 }}"),
            &format!("{STACK}\nscenario s {{ duration 3 s  {} }}", pulled(0.95)),
        ));
        assert!(kept.iter().all(|t| t.fault.is_none()), "{task}");
        // The deficit that bounds and weights leave settles at w / k_f.
        let slack = kept.iter().map(|t| t.slack).fold(0.0, f64::max);
        assert!(least(&kept) > threshold - slack / 10.0 - 1e-3, "{task}: {} {threshold} {slack}", least(&kept));
        assert!(least(&kept) > least(&free) + 1e-3, "{task}: {} and {threshold}", least(&kept));
        assert!(kept.iter().all(|t| t.withheld < 1e-6), "the hierarchy does what the law says: {task}");
        assert_eq!(kept.iter().any(|t| t.scaling < 0.95), waits, "{task}");
        for pair in kept.windows(2) {
            let observed = (pair[1].field - pair[0].field) * 200.0;
            assert!(
                (observed - pair[0].rate).abs() < 5e-3,
                "{task}: at {} s {observed} {}",
                pair[0].time,
                pair[0].rate
            );
        }
    }
}

#[test]
fn the_same_run_gives_the_same_bits() {
    let text = spec(200, &format!("min 0.9 m  {DEVIATE}"), &format!("{STACK}\nscenario s {{ duration 3 s  {WALK} }}"));
    let bits = || run(&text).iter().map(|t| format!("{:?}", (&t.v, t.scaling, t.deviation))).collect::<Vec<_>>();
    assert_eq!(bits(), bits());
}

/// A machine that changes to another stack while the task waits, over a blend, and back: the clock starts again, and
/// the reference is continuous.
#[test]
fn stacks_change_while_the_planner_gives_way() {
    let text = spec(
        200,
        "min 0.9 m  internal { gain 0  weight 100 }  scaling { weight 0.001 }",
        &format!(
            "{STACK}
stack wait {{ level still {{ hold(tool) }} }}
machine m {{
  initial working
  state working {{ stack work  when guard.scaling < 0.5 for 0.05 s -> waiting blend 0.3 s }}
  state waiting {{ stack wait  when norm(walker.chest - frame(base_link).position) > 1.8 m -> working blend 0.3 s }}
}}
scenario s {{ duration 8 s  {WALK} }}"
        ),
    );
    let all = run(&text);
    assert!(all.iter().all(|t| t.fault.is_none()), "{:?}", all.iter().find_map(|t| t.fault));
    let changes: Vec<usize> = (1..all.len()).filter(|&k| all[k].stack != all[k - 1].stack).collect();
    assert!(changes.len() >= 2, "it waits and comes back: {changes:?}");
    for &k in &changes {
        for (a, b) in all[k - 1].v.iter().zip(&all[k].v) {
            assert!((a - b).abs() < 0.02, "no jump at {} s: {a} {b}", all[k].time);
        }
    }
    let back = changes[1];
    assert!(all[back].clock < 0.006, "the clock begins anew: {}", all[back].clock);
    assert!(all[changes[0]..back].iter().all(|t| t.scaling.is_nan()), "nothing is told meanwhile");
}

/// Reading of a tracker at a tick: position and velocity.
type Says = fn(usize) -> Option<[f64; 6]>;

/// NaN, a person who never moves, jumps across the room, is inside the robot, or is never seen.
#[test]
fn whatever_a_tracker_says_the_command_is_finite() {
    let program = common::program_of(&spec(200, &format!("min 0.9 m  {DEVIATE}"), LIMITED));
    let says: [Says; 7] = [
        |_| Some([0.9, 0.1, 0.7, 0.0, 0.0, 0.0]),
        |k| Some([if k % 2 == 0 { 0.5 } else { -3.0 }, 0.0, 0.5, 0.0, 0.0, 0.0]),
        |k| Some([if k == 20 { f64::NAN } else { 1.0 }, 0.0, 0.5, 0.0, 0.0, 0.0]),
        |_| Some([0.0, 0.0, 0.333, 0.0, 0.0, 0.0]),
        |_| Some([1e300, 0.0, 0.0, 1e300, 0.0, 0.0]),
        |k| (k < 20).then_some([1.0, 0.0, 0.5, -1.0, 0.0, 0.0]),
        |_| None,
    ];
    for (case, say) in says.into_iter().enumerate() {
        let mut controller = Controller::new(&program).expect("it can be executed");
        let mut robot = SimulatedRobot::new(&program);
        let mut faults = 0;
        for k in 0..200 {
            let time = k as f64 * 0.005;
            if let Some(value) = say(k) {
                for point in ["walker.chest", "walker.hand"] {
                    let signal = program.interface.signal(point).expect("it is tracked");
                    controller.signals().set(signal, &value, time);
                }
            }
            let command = controller.step(&Observation { time, q: robot.q() });
            assert!(command.velocity.iter().all(|v| v.is_finite()), "case {case}, tick {k}");
            faults += usize::from(command.fault.is_some());
            let velocity = command.velocity.to_vec();
            robot.apply(&velocity);
        }
        assert_eq!(faults > 0, [2, 4, 5, 6].contains(&case), "case {case}: {faults} faults");
    }
}

/// Experiments 4.A to 4.D: all expectations of their scenarios hold, and the three methods compare as described with
/// thesis Table 4.2.
#[test]
fn the_experiments_of_chapter_4_hold() {
    for name in ["safety_planner", "beside_harvest", "give_way"] {
        let program = common::program(&format!("{name}.hq"));
        for scenario in &program.scenarios {
            let result =
                hierarq::scenario_runner::run(name, &program, scenario).expect("a compiled program can be executed");
            assert!(result.ok, "{}: {:?}", scenario.name, result.expectations);
        }
    }
    let figures: Vec<[f64; 3]> = comparison::figures().expect("it is run").into_iter().map(|(_, f)| f).collect();
    let [a1, a2, a3] = figures[..] else { panic!("three methods") };
    assert!(a1[0] > a2[0] && a2[0] > a3[0], "M1, the mean field: {figures:?}");
    assert!(a2[1] > a1[1] && a1[1] > 0.005 && a3[1] < 1e-3, "M2, the mean path error: {figures:?}");
    assert!(a1[2] == 0.0 && a2[2] == 0.0 && a3[2] > 0.5, "M3, the idle time: {figures:?}");
}

/// A path of the person in 4.A that the limits of the joints make infeasible, so that the field falls: joints do not
/// oscillate between two plans, and the deficit is reported.
#[test]
fn where_there_is_no_room_joints_do_not_swing() {
    let set = [
        ("near_x", "0.6504510407"),
        ("near_y", "-0.1149074099"),
        ("near_z", "1.1514616996"),
        ("takes", "2.3413358942"),
    ];
    let unit = |name: &str| if name == "takes" { "s" } else { "m" };
    let set = set.iter().map(|(name, value)| (name.to_string(), format!("{value} {}", unit(name)))).collect();
    let settings = hierarq::project::Settings { set, ..Default::default() };
    let compiled = hierarq::project::compile(&common::example("safety_planner.hq"), &settings);
    let program = compiled.program.expect("it compiles");
    let scenario = program.scenarios.iter().find(|s| s.name.starts_with("4.A")).expect("there");
    let program = scenario.program(&program);
    let mut simulation = Simulation::in_world(&program, scenario).expect("it can be executed");
    let ticks = simulation.ticks();
    let mut summary = runtime::record::summary::SummaryRecorder::new(simulation.controller(), ticks);
    let mut short = Short { least: f64::INFINITY, slack: 0.0, untold: 0, program: &program };
    let mut all = runtime::record::All(vec![&mut summary, &mut short]);
    simulation.run(&mut all, &mut || 0.0, &mut |_| true).expect("no recorder fails");
    let of_joints = summary.summary(&program, simulation.controller(), Vec::new()).joints;
    // Without smooth plans 637 reversals of one joint.
    assert!(of_joints.values().all(|j| j.reversals <= 8 && j.jumps == 0), "{of_joints:?}");
    assert!(short.least < 0.745 && short.untold == 0, "{} {}", short.least, short.untold);
}

/// The minimum of the field, the slack of the previous tick, and the number of ticks in which it fell below its
/// threshold without slack.
struct Short<'p> {
    least: f64,
    slack: f64,
    untold: usize,
    program: &'p Program,
}

impl Recorder for Short<'_> {
    fn tick(&mut self, t: &Tick) -> std::io::Result<()> {
        let of = |name: &str| told(t.controller.signal_table(), self.program, &format!("deviating.{name}"));
        let (field, before) = (of("field"), self.least);
        self.least = before.min(field);
        self.untold += usize::from(field < 0.75 && field < before && self.slack < 1e-4);
        self.slack = of("slack");
        Ok(())
    }
}

/// Without higher levels nothing is withheld. With slow joints, the field's rate between ticks is the reported one, and
/// with the reported slack it is sufficient for the field.
#[test]
fn what_is_withheld_is_what_the_field_does_not_need() {
    let scenario = format!("run {{ duration 6 s }}\nscenario s {{ duration 6 s  {WALK} }}");
    let guard = format!("min 0.9 m  {DEVIATE}");
    let free = run(&spec(200, &guard, &format!("{STACK}\n{scenario}")));
    assert!(free.iter().all(|t| t.withheld.abs() < 1e-9), "nothing stands above");
    let slow = "task slow = joint_velocity_limits { max 0.25 rad/s }
stack work { level limits hard { slow }  level motion { reach }  level internal { guard } }";
    let all = run(&spec(200, &guard, &format!("{slow}\n{scenario}")));
    let (mut withheld, mut at_stake) = (0, 0);
    for pair in all.windows(2) {
        let given = pair[0].rate - pair[0].withheld;
        let need = -10.0 * (pair[0].field - 0.9);
        assert!(given + pair[0].slack >= need - 1e-5, "at {} s: {given} of {need}", pair[0].time);
        at_stake += usize::from(pair[0].slack < 1e-5 && given < need + 1e-3);
        // The person turns at the waypoints, up to one tick earlier or later.
        let turns = [0.0, 2.0, 4.0].iter().any(|at| (pair[0].time - at).abs() < 0.011);
        let observed = (pair[1].field - pair[0].field) * 200.0;
        // A rate beyond that of the plan is reported as not withheld.
        let exact = pair[0].withheld > 0.02;
        assert!(turns || observed > given - 5e-3, "at {} s: {observed} {given}", pair[0].time);
        assert!(turns || !exact || observed < given + 5e-3, "at {} s: {observed} {given}", pair[0].time);
        withheld += usize::from(pair[0].withheld > 0.02);
    }
    // The program contains the limits: almost nothing is withheld, although the field is at its threshold.
    assert!(withheld < 10 && at_stake > 100, "{withheld} {at_stake}");
}

/// Two planners in one stack below the same limits, with that of the lower task on the upper level: they decide in the
/// order of their tasks, and their outputs match the motion.
#[test]
fn two_planners_decide_in_the_order_of_their_tasks() {
    let text = spec(
        200,
        &format!("min 0.9 m  {DEVIATE}"),
        "task turn = joint_velocity { velocity { joint_3 0.2 rad/s } }
task other = safety_planner(turn) { field nearness  min 0.95 m }
task slow = joint_velocity_limits { max 0.15 rad/s }
stack work { level limits hard { slow }  level motion { reach }  level turn { turn }  level below { other }  level internal { guard } }",
    );
    let text = format!("{text}\nrun {{ duration 6 s }}\nscenario s {{ duration 6 s  {WALK} }}");
    let program = common::program_of(&text);
    let controller = Controller::new(&program).expect("it can be executed");
    let deviations: Vec<usize> = controller.evaluator().safety().map(|p| p.0.plan().u_alpha.len()).collect();
    assert_eq!(deviations, [1, 0], "that of `reach` is the first, and the only one that deviates");
    for pair in run(&text).windows(2) {
        assert!(pair[0].fault.is_none(), "{:?}", pair[0]);
        let turns = [0.0, 2.0, 4.0].iter().any(|at| (pair[0].time - at).abs() < 0.011);
        let (observed, given) = ((pair[1].field - pair[0].field) * 200.0, pair[0].rate - pair[0].withheld);
        // The reported withheld rate is never negative.
        assert!(turns || observed > given - 5e-3, "at {} s: {observed} {given}", pair[0].time);
    }
}

//! Blending between two stacks: hard levels hold at every tick of the blend, and the velocity is continuous.

use proptest::prelude::*;
use runtime::Controller;
use stdlib_tasks::clearance::acceleration_bound;

use super::host::{Host, in_both_syntaxes};

/// Tasks of the stacks; all have different targets.
const TASKS: &str = "
task wave = joint_position { target { joint_1 0.6 rad * sin(2*pi*t/(2 s))  joint_4 1.6 rad + 0.4 rad * sin(2*pi*t/(3 s)) }  gain 5 /s }
task reach = frame_position(tool) { position initial(position) + [0.1, 0.2, -0.1] m * sin(pi*t/(2 s))  gain 5 /s }
task up = frame_position(tool) { position [0.2, -0.3, 0.9] m  gain 2 /s }
task turn = joint_velocity { velocity { joint_1 0.8 rad/s } }
task level_tool = frame_orientation(tool) { orientation initial(orientation)  gain 5 /s }
task lead = hand_guiding(tool) {
  mass { linear 8 kg  angular 2 kg m^2 }  damping { linear 60 N s/m  angular 15 N m s }
  wrench { force [0, 6, 0] N * sin(2*pi*t/(1 s)) }
}
task floor = virtual_wall { points arms  through [[0, 0, 0], [1, 0, 0], [0, 1, 0]]  d_min 0.25 m  gain 5 /s }
task side = virtual_wall { points arms  through [[0, 0.25, 0], [1, 0.25, 0], [0, 0.25, 1]]  d_min 0.02 m  gain 5 /s }
";

/// Gain of the walls (1/s), and period of the robot (s).
const GAIN: f64 = 5.0;
const PERIOD: f64 = 0.01;

const ROBOT: &str = "robot wide from arm {
  points { hand tool  elbow link_4 }
  arms { only { tip tool  points [hand, elbow] } }
}
";

const MOTIONS: [&str; 6] = ["wave", "reach", "up", "turn", "level_tool", "lead"];

/// A stack composed of the tasks.
#[derive(Clone, Debug)]
struct Parts {
    /// Number of the locked joint.
    locked: Option<usize>,
    floor: bool,
    side: bool,
    motions: Vec<usize>,
}

fn parts() -> impl Strategy<Value = Parts> {
    let motions = prop::sample::subsequence((0..MOTIONS.len()).collect::<Vec<_>>(), 1..3).prop_shuffle();
    let locked = prop_oneof![2 => Just(None), 1 => (1..8_usize).prop_map(Some)];
    (locked, any::<bool>(), any::<bool>(), motions).prop_map(|(locked, floor, side, motions)| Parts {
        locked,
        floor,
        side,
        motions,
    })
}

impl Parts {
    fn text(&self, name: &str, limits: &str) -> String {
        let lock = self.locked.map_or(String::new(), |j| format!("lock joint_{j}  "));
        let mut out = format!(
            "stack {name} {{ {lock}level limits hard {{ joint_position_limits  joint_velocity_limits {limits} }}\n"
        );
        let walls = [(self.floor, "floor"), (self.side, "side")];
        for (_, wall) in walls.iter().filter(|w| w.0) {
            out.push_str(&format!("level {wall} hard {{ {wall} }}\n"));
        }
        for m in &self.motions {
            out.push_str(&format!("level {0} {{ {0} }}\n", MOTIONS[*m]));
        }
        out + "}\n"
    }
}

fn machine(a: &Parts, b: &Parts, blend: f64, ticks: usize) -> Host {
    limited("", a, b, blend, ticks)
}

/// As [`machine`] with one more hard limit, the same in both stacks.
fn limited(limit: &str, a: &Parts, b: &Parts, blend: f64, ticks: usize) -> Host {
    let text = format!(
        "{ROBOT}{TASKS}{}{}
         machine m {{ initial first  blend {blend} s  on fault(any) -> stopped
           state first {{ stack a  after {} ms -> second }}
           state second {{ stack b  after 10 s -> stopped }}
           final state stopped }}",
        a.text("a", limit),
        b.text("b", limit),
        10 * ticks,
    );
    Host::new(&text)
}

/// Returns the maximum violation of the stack's hard rows by the velocity of the tick.
fn broken(controller: &Controller) -> f64 {
    let v = controller.velocity();
    let hard = controller.problem().levels.iter().filter(|l| l.hard);
    hard.flat_map(|l| (0..l.rows()).map(move |i| l.slack(i, v).abs())).fold(0.0, f64::max)
}

/// Returns the margins of the walls of the running stack: wall, point, m.
fn walls(controller: &Controller) -> Vec<(String, usize, f64)> {
    let evaluator = controller.evaluator();
    let walls = evaluator.members().iter().filter(|m| ["floor", "side"].contains(&m.name.as_str()));
    let margins = |m: &runtime::Member| evaluator.margins()[m.margins.clone()].to_vec();
    walls.flat_map(|m| margins(m).into_iter().enumerate().map(|(row, h)| (m.name.clone(), row, h))).collect()
}

/// Bound on the acceleration of a point at the walls while the joints keep these velocities (m/s²).
fn acceleration(controller: &Controller, point: usize, velocity: &[f64]) -> f64 {
    let model = controller.evaluator().model();
    let link = model.link(["tool", "link_4"][point]).expect("a link of the arm");
    let speed: Vec<f64> = velocity.iter().map(|v| v.abs()).collect();
    acceleration_bound(model, None, link, 0.0, &speed)
}

fn jump(before: &[f64], after: &[f64]) -> f64 {
    before.iter().zip(after).fold(0.0, |d: f64, (a, b)| d.max((a - b).abs()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn hard_levels_hold_through_every_blend(
        (a, b) in (parts(), parts()),
        blend in 0.05..0.6_f64,
        ticks in 2..120_usize,
    ) {
        let mut host = machine(&a, &b, blend, ticks);
        let mut last = Vec::new();
        let mut switched = None;
        let mut before = Vec::new();
        for tick in 0..ticks + 70 {
            let seen = host.step();
            if seen.fault.is_some() {
                // A wall that the first stack does not have may be violated when the second one begins.
                prop_assert!(switched.is_none_or(|s| s + 1 >= tick), "{seen:?}");
                return Ok(());
            }
            if seen.state == "second" && switched.is_none() {
                switched = Some(tick);
                // The hard levels of the second stack may require another velocity than those of the first. A common
                // first motion is not blended.
                let differ = a.locked != b.locked || a.floor != b.floor || a.side != b.side || a.motions[0] != b.motions[0];
                // While a locked joint still moves, the applied rows differ from those of the problem.
                let coasts = b.locked.is_some_and(|j| last.get(j - 1).is_some_and(|v: &f64| *v != 0.0));
                if differ && !coasts && broken_by(&host, &last) < 1e-9 {
                    prop_assert!(jump(&last, host.controller.velocity()) < 1e-7, "the first tick of a blend goes on");
                }
            }
            let coasts = b.locked.is_some_and(|j| seen.state == "second" && host.controller.velocity()[j - 1] != 0.0);
            // The rows of the problem assume that a locked joint is at rest, which is true after it has stopped.
            prop_assert!(coasts || broken(&host.controller) < 1e-8, "tick {tick}: {}", broken(&host.controller));
            let now = walls(&host.controller);
            for (name, row, h) in &now {
                // The remaining margin, minus the deviation of a point from a straight line within a period.
                let from = before.iter().find(|(n, r, _)| (n, r) == (name, row)).map(|(_, _, h)| h);
                let bend = 0.5 * acceleration(&host.controller, *row, &last) * PERIOD * PERIOD;
                let least = from.map_or(f64::NEG_INFINITY, |h| (1.0 - GAIN * PERIOD) * h - bend);
                prop_assert!(*h >= least - 1e-9, "tick {tick}: `{name}` {h} after {from:?}, at least {least}");
            }
            before = now;
            let evaluator = host.controller.evaluator();
            for m in evaluator.members().iter().filter(|m| m.name.starts_with("joint")) {
                let lowest = evaluator.margins()[m.margins.clone()].iter().fold(f64::INFINITY, |a, h| a.min(*h));
                prop_assert!(lowest > -1e-8, "tick {tick}: `{}` {lowest}", m.name);
            }
            if seen.state == "second" {
                // A sum of periods has rounding errors: half a microsecond is ignored.
                let ends = tick - switched.unwrap_or(tick) >= ((blend - 5e-7) / 0.01).ceil() as usize;
                prop_assert_eq!(host.controller.is_blending(), !ends);
            }
            last = host.controller.velocity().to_vec();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    /// If both stacks have acceleration limits on a hard level, every tick of the blend satisfies them, also for joints
    /// that the second stack locks, for any duration of the blend.
    #[test]
    fn accelerations_hold_through_every_blend(
        (a, b) in (parts(), parts()),
        blend in prop_oneof![1 => Just(0.0), 4 => 0.02..0.6_f64],
        ticks in 2..120_usize,
    ) {
        // Without walls, which a slowly braking joint could not satisfy.
        let plain = |p: &Parts| Parts { floor: false, side: false, ..p.clone() };
        // The largest gain of a position limit, 10 /s, times the largest speed, 2.5 rad/s.
        let most = 25.0;
        let mut host = limited(&format!("joint_acceleration_limits {{ max {most} rad/s^2 }}"), &plain(&a), &plain(&b), blend, ticks);
        let mut last = vec![0.0; 7];
        let mut rest = 0.0;
        for tick in 0..ticks + 120 {
            let seen = host.step();
            prop_assert_eq!(seen.fault, None, "tick {} in {}", tick, seen.state);
            let v = host.controller.velocity().to_vec();
            prop_assert!(jump(&last, &v) <= most * 0.01 + 1e-8, "tick {tick}: {} rad/s^2", jump(&last, &v) / 0.01);
            let evaluator = host.controller.evaluator();
            for m in evaluator.members() {
                let lowest = evaluator.margins()[m.margins.clone()].iter().fold(f64::INFINITY, |a, h| a.min(*h));
                prop_assert!(lowest > -1e-6, "tick {tick}: `{}` {lowest}", m.name);
            }
            if let Some(j) = b.locked.filter(|_| seen.state == "second") {
                if tick == ticks {
                    rest = last[j - 1];
                }
                let (now, before) = (v[j - 1], last[j - 1]);
                prop_assert!(now * before >= 0.0 && now.abs() <= before.abs() + 1e-12, "a locked joint only slows down");
                let late = (tick - ticks) as f64 * 0.01;
                if late >= blend.max(f64::abs(rest) / most) + 0.02 {
                    prop_assert_eq!(now, 0.0, "it stands after {} s", late);
                }
            }
            last = v;
        }
    }
}

/// A joint that the second stack locks stops gradually over the blend.
#[test]
fn a_locked_joint_comes_to_rest_over_the_blend() {
    let turning = Parts { locked: None, floor: false, side: false, motions: vec![3] };
    let locking = Parts { locked: Some(1), floor: false, side: false, motions: vec![4] };
    let mut host = machine(&turning, &locking, 0.5, 50);
    host.steps(50);
    let before = host.controller.velocity()[0];
    assert!(before > 0.7);
    for tick in 0..60 {
        host.step();
        let x = (f64::from(tick) * 0.01 / 0.5).min(1.0);
        let wanted = before * (1.0 - x * x * (3.0 - 2.0 * x));
        let v = host.controller.velocity()[0];
        assert!((v - wanted).abs() < 1e-6, "tick {tick}: {v} instead of {wanted}");
    }
    assert_eq!(host.controller.velocity()[0], 0.0);
}

/// Returns the maximum violation of the tick's hard rows by a velocity.
fn broken_by(host: &Host, v: &[f64]) -> f64 {
    let hard = host.controller.problem().levels.iter().filter(|l| l.hard);
    hard.flat_map(|l| (0..l.rows()).map(move |i| l.slack(i, v).abs())).fold(0.0, f64::max)
}

/// Less restrictive acceleration limits do not shorten a blend.
#[test]
fn a_blend_takes_the_jump_out_of_a_switch() {
    let all = |motion: usize| Parts { locked: None, floor: false, side: false, motions: vec![motion] };
    let largest = |limit: &str, blend: f64| {
        let mut host = limited(limit, &all(3), &all(4), blend, 50);
        let mut last = Vec::new();
        let mut worst = 0.0_f64;
        for tick in 0..150 {
            host.step();
            let v = host.controller.velocity().to_vec();
            // It starts from rest within the limits, and reaches its speed long before the switch.
            if tick > 20 {
                worst = worst.max(jump(&last, &v));
            }
            last = v;
        }
        worst
    };
    assert!(largest("", 0.0) > 0.5, "without a blend joint 1 stops at once: {}", largest("", 0.0));
    // The maximum slope of x²(3 - 2x) is 3/2: 0.8 rad/s vanish in 0.5 s by at most 0.024 rad/s per tick.
    for limit in ["", "joint_acceleration_limits", "joint_acceleration_limits { max 5 rad/s^2 }"] {
        assert!(largest(limit, 0.5) < 0.8 * 1.5 * 0.01 / 0.5 + 2e-3, "`{limit}`: {}", largest(limit, 0.5));
    }
}

#[test]
fn levels_that_both_stacks_share_go_on_undisturbed() {
    let mut host = Host::new(
        "task here = hold(tool)
         task turn = joint_velocity { velocity { joint_1 0.5 rad/s } }
         task rest = joint_velocity { velocity 0 rad/s }
         stack a from still { add hand { here }  add elbow { turn } }
         stack b from still { add hand { here }  add elbow { rest } }
         machine m { initial first  blend 0.4 s  on fault(any) -> stopped
           state first { stack a  after 1 s -> second }
           state second { stack b  after 10 s -> stopped }
           final state stopped }",
    );
    let mut moved = 0.0_f64;
    for _ in 0..200 {
        host.step();
        moved = moved.max(host.controller.velocity().iter().fold(0.0, |a: f64, v| a.max(v.abs())));
        let (hand, v) = (&host.controller.problem().levels[1], host.controller.velocity());
        let slack = (0..hand.rows()).map(|i| hand.slack(i, v).abs()).fold(0.0, f64::max);
        assert!(slack < 1e-9, "the hand has what it asks for at every tick: {slack}");
    }
    assert!(moved > 0.05, "the elbow moves");
}

/// A damped level decides the velocity of the entered stack, not that of the blend to it: between ticks the velocity
/// changes by the change of the stack's own velocity, plus the slope of s, at most 3/2 over the blend's duration, times
/// the initial offset.
#[test]
fn a_damped_level_does_not_stop_the_way_over_to_its_stack() {
    let (blend, limits) = (0.4, "level limits hard { joint_position_limits  joint_velocity_limits }");
    let turn = "level turn { turn }";
    let stacks = [
        // The entered level is damped.
        (turn, "level hand damping 0.01 { reach }"),
        // So is a level above a common one, and a common one.
        (turn, "level hand damping 0.01 { reach }  level turn { turn }"),
        (
            "level turn damping 0.02 { turn }  level hand { reach }",
            "level turn damping 0.02 { turn }  level rest { wave }",
        ),
        // Both begin with an undamped level, and continue with damped ones.
        (
            "level turn { turn }  level tool damping 0.01 { level_tool }",
            "level turn { turn }  level hand damping 0.01 { reach }",
        ),
        ("level turn damping 0.3 { turn }", "level turn damping 0.01 { turn }"),
    ];
    for (a, b) in stacks {
        let text = format!(
            "{ROBOT}{TASKS} stack a {{ {limits} {a} }} stack b {{ {limits} {b} }}
             machine m {{ initial first  blend {blend} s  on fault(any) -> stopped
               state first {{ stack a  after 500 ms -> second }}
               state second {{ stack b  after 10 s -> stopped }}
               final state stopped }}"
        );
        for mut host in in_both_syntaxes(&text) {
            assert_eq!(host.steps(50), "first");
            let mut last = host.controller.velocity().to_vec();
            let mut own = Vec::new();
            let mut offset = 0.0;
            for tick in 0..60 {
                let seen = host.step();
                assert_eq!((seen.fault, seen.state.as_str()), (None, "second"));
                let (v, asked) = (host.controller.velocity().to_vec(), host.controller.solution().x.clone());
                let most = if tick == 0 {
                    offset = jump(&last, &asked);
                    0.0
                } else {
                    jump(&own, &asked) + 1.5 * PERIOD / blend * offset
                };
                assert!(jump(&last, &v) <= most + 1e-6, "`{b}`, tick {tick}: {} of {most} rad/s", jump(&last, &v));
                // At the end of the blend and after it, it is the velocity of the stack.
                assert!(tick < 40 || jump(&v, &asked) < 1e-12, "`{b}`, tick {tick}");
                (last, own) = (v, asked);
            }
        }
    }
}

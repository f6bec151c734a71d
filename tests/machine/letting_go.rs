//! Compliance during a blend: a hand that is pushed and released while its stack is entered moves by the law of its
//! mass and damping, and never against the push. The test integrates the law independently, one axis at a time.

use nalgebra::Vector3;
use proptest::prelude::*;
use stdlib_tasks::compliance::{Axis, Drive};

use super::host::Host;

const PERIOD: f64 = 0.01;

/// A push, and the compliant stack.
#[derive(Clone, Debug)]
struct Case {
    /// Stiffness of `admittance`; `None` for `hand_guiding`.
    stiffness: Option<f64>,
    mass: f64,
    damping: f64,
    /// Force (N), along the world's axes.
    force: Vector3<f64>,
    /// Ticks: begin and end of the push, and the entry of the state.
    push: std::ops::Range<usize>,
    entry: usize,
    blend: f64,
    /// True if the previous stack is compliant too.
    moving: bool,
    /// A further hard limit of the entered stack.
    limit: &'static str,
}

impl Case {
    fn axis(&self) -> Axis {
        Axis { mass: self.mass, damping: self.damping, stiffness: self.stiffness.unwrap_or(0.0) }
    }

    fn machine(&self) -> Host {
        let Case { mass, damping, limit, blend, .. } = self;
        let (kind, spring) = match self.stiffness {
            Some(k) => ("admittance", format!("stiffness {{ linear {k} N/m  angular 60 N m }}")),
            None => ("hand_guiding", String::new()),
        };
        let before = if self.moving { "loose" } else { "here" };
        Host::new(&format!(
            "signal ft : wrench
             task here = hold(tool)
             task loose = hand_guiding(tool) {{ mass {{ linear 10 kg  angular 3 kg m^2 }}
               damping {{ linear 120 N s/m  angular 27 N m s }}  wrench {{ force ft.force }} }}
             task give = {kind}(tool) {{ mass {{ linear {mass} kg  angular 3 kg m^2 }}
               damping {{ linear {damping} N s/m  angular 27 N m s }}  {spring}  wrench {{ force ft.force }} }}
             stack a {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level motion {{ {before} }} }}
             stack b {{ level limits hard {{ joint_position_limits  joint_velocity_limits  {limit} }}
               level motion {{ give }} }}
             machine m {{ initial first  on fault(deadline) -> second  on fault(any) -> stopped
               state first {{ stack a  after {} ms -> second blend {blend} s }}
               state second {{ stack b  after 60 s -> stopped }}
               final state stopped }}",
            10 * self.entry,
        ))
    }

    fn force_at(&self, tick: usize) -> Vector3<f64> {
        if self.push.contains(&tick) { self.force } else { Vector3::zeros() }
    }

    /// Returns the positions of the hand before each tick (m).
    fn run(&self, ticks: usize) -> Vec<Vector3<f64>> {
        let mut host = self.machine();
        (0..ticks)
            .map(|tick| {
                let f = self.force_at(tick);
                host.set("ft", &[f.x, f.y, f.z, 0.0, 0.0, 0.0]);
                let seen = host.step();
                assert_eq!(seen.fault, None, "tick {tick}");
                assert_eq!(seen.state == "second", tick >= self.entry, "tick {tick}");
                hand(&host)
            })
            .collect()
    }

    /// Returns the displacements of a body that has the velocity `v` when the state is entered, for each tick from the
    /// entry on.
    fn law(&self, mut v: Vector3<f64>, ticks: usize) -> Vec<Vector3<f64>> {
        let (axis, mut x) = (self.axis(), Vector3::<f64>::zeros());
        let mut places = vec![x];
        for tick in self.entry..ticks {
            // A blend hands the velocity over at its first tick, and the law acts from the second one on.
            if tick > self.entry {
                let force = self.force_at(tick);
                let one = |i: usize| {
                    axis.velocity(
                        PERIOD,
                        &Drive { before: v[i], velocity: 0.0, change: 0.0, error: -x[i], force: force[i] },
                    )
                };
                v = Vector3::new(one(0), one(1), one(2));
            }
            x += PERIOD * v;
            places.push(x);
        }
        places
    }
}

/// Returns the position of the tool at the tick.
fn hand(host: &Host) -> Vector3<f64> {
    let evaluator = host.controller.evaluator();
    let link = evaluator.model().link("tool").expect("a link of the arm");
    evaluator.data().pose(link).translation.vector
}

fn pushed(stiffness: Option<f64>) -> Case {
    Case {
        stiffness,
        mass: 20.0,
        damping: 253.0,
        force: Vector3::new(25.0, 0.0, 0.0),
        push: 100..120,
        entry: 105,
        blend: 0.5,
        moving: false,
        limit: "",
    }
}

/// Pushed from 1.0 s to 1.2 s, entered at 1.05 s with a blend of 0.5 s: the push ends long before the blend.
#[test]
fn a_hand_that_is_let_go_during_a_blend_comes_to_rest_by_mass_and_damping() {
    for stiffness in [None, Some(800.0)] {
        let case = pushed(stiffness);
        let ticks = 400;
        let places = case.run(ticks);
        let along: Vec<f64> = places[105..].iter().map(|p| p.x - places[105].x).collect();
        let (least, most) = along.iter().fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
        assert!(least > -1e-3, "{stiffness:?}: {} mm against the push", -1e3 * least);
        assert!(most > 5e-3, "{stiffness:?}: it gives way by {} mm", 1e3 * most);
        for (k, (x, law)) in along.iter().zip(case.law(Vector3::zeros(), ticks)).enumerate() {
            assert!((x - law.x).abs() < 2e-4, "{stiffness:?}, tick {k}: {x} and {}", law.x);
        }
        let last = (places[ticks - 1] - places[ticks - 2]).norm() / PERIOD;
        assert!(last < 1e-4, "{stiffness:?}: it rests, {last} m/s");
    }
}

/// A fault stops the robot, and also the simulated body, whatever its previous motion was.
#[test]
fn a_fault_during_the_blend_brings_the_body_to_rest() {
    let case = pushed(None);
    let mut host = case.machine();
    for tick in 0..125 {
        let f = case.force_at(tick);
        host.set("ft", &[f.x, 0.0, 0.0, 0.0, 0.0, 0.0]);
        host.step();
    }
    let fastest = |host: &Host| host.controller.velocity().iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    assert!(fastest(&host) > 1e-2 && host.controller.is_blending());
    let q = host.robot.measure().to_vec();
    let late = host.time() + 0.05;
    assert_eq!(host.step_at(late, &q).fault, Some(runtime::FaultKind::Deadline));
    for k in 1..50 {
        let q = host.robot.measure().to_vec();
        let seen = host.step_at(late + PERIOD * f64::from(k), &q);
        // The fault leads to the state in which it occurred, so the robot stands.
        assert_eq!((seen.fault, seen.state.as_str()), (Some(runtime::FaultKind::Deadline), "second"));
        assert!(fastest(&host) == 0.0, "tick {k}: {} rad/s", fastest(&host));
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let body = (1.0..30.0_f64, 0.05..0.3_f64, prop_oneof![Just(None), Just(Some(()))]);
    let push = (20..60_usize, 5..60_usize, [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0]);
    let limits = prop_oneof![
        3 => Just(""),
        1 => Just("joint_acceleration_limits { max 25 rad/s^2 }"),
        1 => Just("joint_velocity_limits { max 0.1 rad/s }"),
    ];
    (body, push, 10..90_usize, 0.02..0.8_f64, any::<bool>(), limits).prop_map(
        |((mass, delay, spring), (from, length, way), entry, blend, moving, limit)| {
            let damping = mass / delay;
            Case {
                // Critical damping: the fastest return without overshooting.
                stiffness: spring.map(|()| 0.25 * damping * damping / mass),
                mass,
                damping,
                // A steady push leads to 0.08 m/s along an axis.
                force: 0.08 * damping * Vector3::from(way),
                push: from..from + length,
                entry,
                blend,
                moving,
                limit,
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Without a force the body only slows down after the blend, and stops at the distance given by the law.
    #[test]
    fn a_blend_adds_nothing_to_what_a_push_does(case in cases()) {
        let over = case.entry + (case.blend / PERIOD).ceil() as usize + 1;
        let free = over.max(case.push.end + 1);
        let ticks = free + 150;
        let places = case.run(ticks);
        let speed: Vec<f64> = places.windows(2).map(|w| (w[1] - w[0]).norm() / PERIOD).collect();
        if case.stiffness.is_none() {
            for k in free..ticks - 2 {
                prop_assert!(speed[k + 1] <= speed[k] + 1e-6, "tick {k}: from {} to {} m/s", speed[k], speed[k + 1]);
            }
        }
        let entered = (places[case.entry] - places[case.entry - 1]) / PERIOD;
        let law = case.law(entered, ticks);
        let moved: Vec<Vector3<f64>> = places[case.entry..].iter().map(|p| p - places[case.entry]).collect();
        let way: f64 = law.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let fastest = law.windows(2).map(|w| (w[1] - w[0]).norm() / PERIOD).fold(0.0, f64::max);
        // The law continues from joint velocities: where the arm's motion is curved, they accelerate the hand by up to
        // about 3 /m times the square of its speed, and the damper needs m/d to remove that.
        let bend = 3.0 * case.mass / case.damping * fastest * way;
        for (k, (x, law)) in moved.iter().zip(&law).enumerate() {
            match case.limit {
                "" => prop_assert!((x - law).norm() < 5e-4 + bend, "tick {k}: {x} and {law}"),
                _ => prop_assert!(x.norm() < 2e-3 + 1.1 * way, "tick {k}: {x} of {way} m"),
            }
        }
        if entered.norm() < 1e-9 && case.push.end > case.entry {
            let against = moved.iter().map(|x| -x.dot(&case.force) / case.force.norm().max(1e-9)).fold(0.0, f64::max);
            prop_assert!(against < 1e-3, "{against} m against the push");
        }
    }
}

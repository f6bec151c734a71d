//! Sensors: the filter against its closed form, wrenches for any mounting of the sensor, biases, tares.

use nalgebra::Vector3;
use proptest::prelude::*;
use robot::{Data, Model};

use super::host::Host;

fn shown(host: &mut Host, signal: usize) -> Vec<f64> {
    host.controller.signals().value(signal).to_vec()
}

/// y(t) = 1 - exp(-2π f t) for a step at t = 0, for any sampling instants.
#[test]
fn a_step_goes_through_the_filter_as_through_one_of_first_order() {
    let mut host = Host::new("signal x : length?  low_pass 3 Hz\nrun { stack still }");
    let q = host.robot.measure().to_vec();
    let mut time = 0.0;
    host.set("x", &[0.0]);
    host.step_at(time, &q);
    assert_eq!(shown(&mut host, 0), [0.0]);
    host.set("x", &[1.0]);
    for (i, dt) in [0.01, 0.004, 0.018, 0.011, 0.0, 0.01].iter().cycle().take(200).enumerate() {
        time += dt;
        assert_eq!(host.step_at(time, &q).fault, None);
        let wanted = 1.0 - (-std::f64::consts::TAU * 3.0 * time).exp();
        assert!((shown(&mut host, 0)[0] - wanted).abs() < 1e-12, "tick {i}");
    }
}

/// A sine of the cutoff frequency passes with 1/√2 of its amplitude and a lag of 45°, if the rate is much higher.
#[test]
fn the_cutoff_is_where_half_of_the_power_is_left() {
    let mut host = Host::new("signal x : number?  low_pass 0.2 Hz\nrun { stack still }");
    let q = host.robot.measure().to_vec();
    let mut largest = 0.0_f64;
    for k in 0..4000 {
        let time = f64::from(k) * 0.01;
        let index = host.controller.signals().interface().signal("x").expect("a signal");
        assert!(host.controller.signals().set(index, &[(std::f64::consts::TAU * 0.2 * time).sin()], time));
        host.step_at(time, &q);
        if time > 20.0 {
            largest = largest.max(shown(&mut host, 0)[0]);
        }
    }
    assert!((largest - 0.5_f64.sqrt()).abs() < 0.01, "{largest}");
}

#[test]
fn the_filter_begins_anew_after_an_absence() {
    let mut host = Host::new("signal x : point?  timeout 25 ms  low_pass 1 Hz\nrun { stack still }");
    host.set("x", &[1.0, 2.0, 3.0]);
    host.steps(2);
    host.set("x", &[5.0, 5.0, 5.0]);
    host.steps(1);
    assert!(shown(&mut host, 0)[0] < 2.0);
    host.steps(3);
    assert!(!host.controller.signals().is_present(0));
    host.set("x", &[5.0, 5.0, 5.0]);
    host.steps(1);
    assert_eq!(shown(&mut host, 0), [5.0; 3]);
    host.set("x", &[f64::NAN, 5.0, 5.0]);
    host.steps(1);
    assert!(!host.controller.signals().is_present(0));
}

fn guided(settings: &str) -> Host {
    Host::new(&format!(
        "signal ft : wrench? {{ low_pass 15 Hz  {settings} }}
         let touched = present(ft)
         task lead = hand_guiding(tool) {{
           mass {{ linear 5 kg  angular 1 kg m^2 }}  damping {{ linear 50 N s/m  angular 5 N m s }}
           wrench {{ force if(touched, ft.force, [0, 0, 0] N)  moment if(touched, ft.moment, [0, 0, 0] Nm) }}
         }}
         stack guided {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level motion {{ lead }} }}
         run {{ stack guided }}"
    ))
}

/// Returns the reading of a sensor in a link for a wrench in the world's axes.
fn in_sensor(model: &Model, link: &str, q: &[f64], wrench: [f64; 6], bias: [f64; 6]) -> [f64; 6] {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let turn = data.pose(model.link(link).expect("a link")).rotation.to_rotation_matrix();
    let part = |at: usize| turn.transpose() * Vector3::new(wrench[at], wrench[at + 1], wrench[at + 2]);
    let (f, m) = (part(0), part(3));
    std::array::from_fn(|i| if i < 3 { f[i] } else { m[i - 3] } + bias[i])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The same hand moves the robot equally for any mounting of the sensor.
    #[test]
    fn the_mounting_of_a_sensor_changes_nothing(
        size in prop::array::uniform6(-15.0..15.0_f64),
        turn in prop::array::uniform6(-3.0..3.0_f64),
        bias in prop::array::uniform6(-4.0..4.0_f64),
        link in prop::sample::select(vec!["link_2", "link_4", "gripper", "tool"]),
    ) {
        let b: Vec<String> = bias.iter().map(|x| format!("{x:.3}")).collect();
        let bias: [f64; 6] = std::array::from_fn(|i| b[i].parse().expect("a number"));
        let settings = format!(
            "frame {link}  bias {{ force [{}, {}, {}] N  moment [{}, {}, {}] Nm }}", b[0], b[1], b[2], b[3], b[4], b[5]
        );
        let (mut plain, mut mounted) = (guided(""), guided(&settings));
        let model = plain.controller.evaluator().model().clone();
        for k in 0..60 {
            let time = f64::from(k) * 0.01;
            let wrench: [f64; 6] = std::array::from_fn(|i| size[i] * (turn[i] * time + turn[5 - i]).sin());
            plain.set("ft", &wrench);
            let q = mounted.robot.measure().to_vec();
            mounted.set("ft", &in_sensor(&model, link, &q, wrench, bias));
            prop_assert_eq!(plain.step().fault, None);
            prop_assert_eq!(mounted.step().fault, None);
            for (a, b) in plain.robot.measure().iter().zip(mounted.robot.measure()) {
                prop_assert!((a - b).abs() < 1e-9, "{a} and {b} at {time} s");
            }
        }
    }
}

/// A push of a scenario acts in the world, and the controller receives it unchanged through every sensor.
#[test]
fn a_push_comes_back_as_it_acts() {
    let text = |settings: &str| {
        format!(
            "{}signal ft : wrench {{ {settings} }}
             task lead = hand_guiding(tool) {{
               mass {{ linear 5 kg  angular 1 kg m^2 }}  damping {{ linear 50 N s/m  angular 5 N m s }}
               wrench {{ force ft.force  moment ft.moment }}
             }}
             stack guided {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level motion {{ lead }} }}
             run {{ stack guided  duration 1 s }}
             scenario pushed {{
               push {{ ft [{{ from 0.2 s  force [8, -3, 2] N  moment [0, 0.4, 0] Nm }}, {{ from 0.5 s  link tool  towards [0.4, 0.1, 0.6] m }}] }}
               expect eventually norm(ft.force) > 1 N
             }}",
            super::host::ARM
        )
    };
    let ends = ["", "frame link_6  bias { force [3, 0, -1] N  moment [0.2, 0, 0] Nm }"].map(|settings| {
        let program = crate::common::program_of(&text(settings));
        let mut simulation =
            runtime::Simulation::in_world(&program.scenarios[0].program(&program), &program.scenarios[0])
                .expect("a compiled program can be executed");
        simulation.run(&mut runtime::record::All(Vec::new()), &mut || 0.0, &mut |_| true).expect("it runs");
        simulation.controller().reference().to_vec()
    });
    let home = crate::common::program_of(&text("")).robot.home;
    assert!(ends[0].iter().zip(&home).any(|(a, b)| (a - b).abs() > 0.01), "the push moves the robot");
    for (a, b) in ends[0].iter().zip(&ends[1]) {
        assert!((a - b).abs() < 1e-9, "{ends:?}");
    }
}

/// A tare makes the present reading the bias, in the sensor's axes: from then on the reading is zero, for any motion.
#[test]
fn a_tare_takes_away_what_is_shown() {
    let mut host = Host::new(
        "signal ft : wrench?  timeout 1 s  frame tool  low_pass 30 Hz
         signal zero : event
         task turn = joint_velocity { velocity { joint_6 0.5 rad/s } }
         stack moving from still { add motion { turn } }
         machine m { initial a  blend 0.1 s  stack moving  on fault(stale) -> lost  on fault(any) -> end
           state a { on zero -> b  after 20 s -> end }
           state b { enter tare(ft)  on zero -> a  after 20 s -> end }
           state lost { on zero -> b  after 20 s -> end }
           final state end }",
    );
    host.raise("zero");
    let seen = (host.step(), host.step());
    assert_eq!(seen.0.state, "a");
    host.raise("zero");
    assert_eq!(host.step().fault, Some(runtime::FaultKind::Stale), "nothing is shown that could be taken away");
    assert_eq!(host.step().state, "lost");
    let weight = [0.4, -0.2, 3.0, 0.1, 0.0, 0.02];
    for _ in 0..100 {
        host.set("ft", &weight);
        host.step();
    }
    let before = shown(&mut host, 0);
    assert!(before.iter().zip(weight).any(|(a, b)| (a - b).abs() > 0.1), "it is shown in the world's axes: {before:?}");
    host.set("ft", &weight);
    host.raise("zero");
    assert_eq!(host.step().state, "b");
    // While the hand turns, the filter lags by the wrench's rotation within its time constant, 0.5 rad/s / (2π 30 Hz).
    assert!(shown(&mut host, 0).iter().all(|x| *x == 0.0));
    for _ in 0..100 {
        host.set("ft", &weight);
        host.step();
        assert!(shown(&mut host, 0).iter().all(|x| x.abs() < 0.012), "{:?}", shown(&mut host, 0));
    }
    let pushed: [f64; 6] = std::array::from_fn(|i| weight[i] + if i == 2 { 5.0 } else { 0.0 });
    for _ in 0..30 {
        host.set("ft", &pushed);
        host.step();
    }
    let size = shown(&mut host, 0)[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((size - 5.0).abs() < 0.03, "{size}");
    host.controller.restart();
    host.set("ft", &weight);
    host.step();
    let again = shown(&mut host, 0)[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((again - 9.2_f64.sqrt()).abs() < 1e-9, "a controller that starts again has the declared bias: {again}");
}

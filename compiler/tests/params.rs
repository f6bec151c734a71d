//! Values of params; a number printed in SI with its unit parses to the same bits.

use std::path::Path;

use dsl::Syntax;
use hierarq_compiler::{Input, ParamValue, params};
use proptest::prelude::*;

const SPEC: &str = "hierarq 1
param length = 20 cm
param gain = 5 /s
param speed = 90 deg/s
param force = 10 N
param stiffness = 300 N/m
param damping = 2 N s/m
param area = 3 m^2
param inertia = 2 kg m^2
param bare = 2
param twice = 2 * length
param there = [0, 0, 1] m
param flag = true
";

fn of(set: &[(String, String)]) -> Vec<ParamValue> {
    let (name, folder) = ("spec.hq", Path::new("."));
    params(&Input { name, text: SPEC, syntax: Syntax::Native, folder, set, package_paths: &[] })
}

fn with(name: &str, value: &str) -> Option<ParamValue> {
    of(&[(name.to_string(), value.to_string())]).into_iter().find(|p| p.name == name)
}

#[test]
fn numbers_are_in_si_and_have_the_unit_of_their_param() {
    let all = of(&[]);
    assert_eq!(all.len(), 12);
    let find = |name: &str| all.iter().find(|p| p.name == name).map(|p| (p.number, p.unit.as_str())).expect("declared");
    assert_eq!(find("length"), (Some(0.2), "m"));
    assert_eq!(find("speed"), (Some(90_f64 * (std::f64::consts::PI / 180.0)), "rad/s"));
    assert_eq!(find("twice"), (Some(0.4), "m"));
    assert_eq!(find("bare"), (Some(2.0), ""));
    assert_eq!((find("there").0, find("flag").0), (None, None));
    // A bare number takes the unit of the param; dependent params follow.
    let set = of(&[("length".to_string(), "0.5".to_string())]);
    assert_eq!((set[0].number, set[0].unit.as_str(), set[9].number), (Some(0.5), "m", Some(1.0)));
    // Params with errors have no value.
    assert_eq!((with("length", "3 s"), with("length", "]")), (None, None));
}

proptest! {
    #[test]
    fn a_number_in_si_reads_back_to_the_same_bits(x in proptest::num::f64::NORMAL | proptest::num::f64::ZERO) {
        prop_assume!(x.abs() < 1e150 && (x == 0.0 || x.abs() > 1e-150));
        for p in of(&[]).iter().filter(|p| p.number.is_some()) {
            let back = with(&p.name, &format!("{x:?}{}", p.unit)).and_then(|p| p.number);
            prop_assert_eq!(back.map(f64::to_bits), Some(x.to_bits()), "{} {:?}{}", p.name, x, p.unit);
        }
    }
}

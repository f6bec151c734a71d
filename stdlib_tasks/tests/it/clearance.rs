//! The acceleration bound against accelerations measured on random trees, and where it is reached.

use hierarq_stdlib_tasks::clearance::{acceleration_bound, loss};
use nalgebra::Vector3;
use proptest::prelude::*;
use robot::{Base, LinkId, Model, Options};

use crate::common::*;

/// A random tree with turning, sliding, fixed and mimicking joints.
pub fn tree(seed: u64, links: usize) -> String {
    let mut rng = rng(seed);
    let mut text = String::from("<robot name=\"tree\">\n<link name=\"l0\"/>\n");
    let mut leaders: Vec<(usize, bool)> = Vec::new();
    for k in 1..=links {
        // Mostly chains: they are what accelerates.
        let parent = if rng() < 0.8 { k - 1 } else { (rng() * k as f64) as usize };
        let (o, r, a) = (vector(&mut rng, 0.5), vector(&mut rng, 3.0), vector(&mut rng, 1.0));
        let sliding = rng() < 0.3;
        let kind = if rng() < 0.1 {
            "fixed"
        } else if sliding {
            "prismatic"
        } else {
            "revolute"
        };
        let leader = leaders.get((rng() * (leaders.len() + 2) as f64) as usize).filter(|l| l.1 == sliding);
        let mimic = match leader {
            Some((n, _)) if rng() < 0.4 && kind != "fixed" => {
                format!("<mimic joint=\"j{n}\" multiplier=\"{}\" offset=\"{}\"/>", 3.0 * rng() - 1.5, rng() - 0.5)
            }
            _ => String::new(),
        };
        if kind != "fixed" && mimic.is_empty() {
            leaders.push((k, sliding));
        }
        text += &format!(
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{k}\"/>\
             <origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/><axis xyz=\"{} {} {}\"/>\
             <limit lower=\"-0.6\" upper=\"0.8\" velocity=\"1\" effort=\"1\"/>{mimic}</joint>\n",
            o.x, o.y, o.z, r.x, r.y, r.z, a.x, a.y, a.z
        );
    }
    text + "</robot>"
}

/// A base, or those of two robots in one model.
pub fn any_bases() -> impl Strategy<Value = Vec<Base>> {
    let base = prop::sample::select(vec![Base::Fixed, Base::Planar, Base::Unicycle, Base::Floating]);
    prop::collection::vec(base, 1..=2)
}

/// A random tree on a base, or two trees on bases of their own.
pub fn trees(seed: u64, links: usize, bases: &[Base]) -> Model {
    let first = read(&tree(seed, links), bases[0]);
    match bases.get(1) {
        Some(base) => two(&first, &read(&tree(seed ^ 2, links), *base), &mut rng(seed ^ 3)),
        None => first,
    }
}

/// Acceleration of a point of `to` as seen from `from`, at constant velocity, by second differences.
fn measured(place: &Place, v: &[f64], from: Option<LinkId>, to: LinkId, offset: &Vector3<f64>) -> f64 {
    let h = 1e-3;
    let at = |s: f64| {
        let there = place.moved(v, s);
        let p = there.data.pose(to) * nalgebra::Point3::from(*offset);
        from.map_or(p, |f| there.data.pose(f).inverse() * p).coords
    };
    (at(h) - at(0.0) * 2.0 + at(-h)).norm() / (h * h)
}

fn check(model: &Model, seed: u64) -> Result<(), TestCaseError> {
    let mut rng = rng(seed);
    let speed: Vec<f64> = (0..model.nv()).map(|_| if rng() < 0.2 { 0.0 } else { 2.0 * rng() }).collect();
    for _ in 0..4 {
        let place = Place::new(model, &model.random_configuration(&mut rng));
        let any = |rng: &mut dyn FnMut() -> f64| LinkId((rng() * model.links.len() as f64) as u32);
        let to = any(&mut rng);
        let from = if rng() < 0.4 { None } else { Some(any(&mut rng)) };
        let offset = vector(&mut rng, 0.4);
        let bound = acceleration_bound(model, from, to, offset.norm(), &speed);
        // A base may be anywhere, and a link that turns sees it move as fast as it is far away.
        let beyond_base = from.is_some_and(|from| model.base_of(from) != model.base_of(to));
        prop_assert!(bound.is_finite() || beyond_base);
        // Corners of the box of speeds, and points inside it.
        for corner in [true, true, true, false] {
            let share = |x: f64| if corner { (x - 0.5).signum() } else { 2.0 * x - 1.0 };
            let v: Vec<f64> = speed.iter().map(|s| s * share(rng())).collect();
            let a = measured(&place, &v, from, to, &offset);
            prop_assert!(a <= bound * (1.0 + 1e-4) + 1e-7, "{a} and {bound}, from {from:?} to {to:?}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn no_point_accelerates_faster(seed in any::<u64>(), links in 1usize..9, bases in any_bases()) {
        check(&trees(seed, links, &bases), seed ^ 1)?;
    }

    #[test]
    fn nor_on_the_robots(seed in any::<u64>(), base in 0usize..4) {
        let base = [Base::Fixed, Base::Planar, Base::Unicycle, Base::Floating][base];
        check(&canopies(base), seed)?;
    }
}

#[test]
fn the_bound_is_reached_where_everything_adds_up() {
    // Three parallel axes, stretched, all turning the same way: w1² (l1+l2+l3) + ..
    let urdf = |first: &str| {
        let joint = |k: usize, x: f64| {
            format!(
                "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"{}\"><parent link=\"l{}\"/><child link=\"l{k}\"/>\
                 <origin xyz=\"{x} 0 0\"/><axis xyz=\"{}\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>",
                if k == 1 { first } else { "revolute" },
                k - 1,
                if k == 1 && first == "prismatic" { "0 1 0" } else { "0 0 1" }
            )
        };
        format!("<robot name=\"r\"><link name=\"l0\"/>{}{}{}</robot>", joint(1, 0.3), joint(2, 0.4), joint(3, 0.5))
    };
    let speed = [0.7, 1.1, 0.4];
    let offset = Vector3::new(0.2, 0.0, 0.0);
    let model = read(&urdf("revolute"), Base::Fixed);
    let place = Place::new(&model, &model.neutral());
    for (from, to, far) in
        [(None, LinkId(3), 0.2), (Some(LinkId(0)), LinkId(3), 0.2), (Some(LinkId(3)), LinkId(0), -0.2)]
    {
        let bound = acceleration_bound(&model, from, to, offset.norm(), &speed);
        let a = measured(&place, &speed, from, to, &Vector3::new(far, 0.0, 0.0));
        assert!((a / bound - 1.0).abs() < 1e-5, "{a} and {bound} from {from:?} to {to:?}");
    }
    // A planar base that drives and turns: U W + W² r.
    let model = read("<robot name=\"r\"><link name=\"l0\"/></robot>", Base::Planar);
    let place = Place::new(&model, &model.neutral());
    let bound = acceleration_bound(&model, None, LinkId(0), 0.2, &[0.3, 0.4, 1.5]);
    assert!((bound - (0.5 * 1.5 + 1.5 * 1.5 * 0.2)).abs() < 1e-12);
    let u = Vector3::new(0.3, 0.4, 0.0);
    let side = Vector3::z().cross(&u).normalize() * -0.2;
    let a = measured(&place, &[0.3, 0.4, 1.5], None, LinkId(0), &side);
    assert!((a / bound - 1.0).abs() < 1e-5, "{a} and {bound}");
}

#[test]
fn what_cannot_accelerate_has_no_bound_to_fear() {
    let model = canopies(Base::Planar);
    let speed: Vec<f64> = model.dofs.iter().map(|d| d.velocity).collect();
    let link = |n: &str| model.link(n).unwrap();
    // The base has no limits: endless as seen from the world, nothing as seen from the robot.
    assert_eq!(acceleration_bound(&model, None, link("left_tool"), 0.1, &speed), f64::INFINITY);
    assert!(acceleration_bound(&model, Some(link("base_link")), link("left_tool"), 0.1, &speed).is_finite());
    assert_eq!(acceleration_bound(&model, Some(link("left_ft")), link("left_tool"), 0.1, &speed), 0.0);
    // A point on the axis of the only joint that turns without limit.
    let mut unlimited = vec![0.0; model.nv()];
    unlimited[2] = f64::INFINITY;
    assert_eq!(acceleration_bound(&model, None, link("base_link"), 0.0, &unlimited), 0.0);
    assert_eq!(acceleration_bound(&model, None, link("base_link"), 0.1, &unlimited), f64::INFINITY);
    assert_eq!(loss(0.0, 0.01, 0.0), 0.0);
    assert_eq!(loss(1.0, 0.01, 0.0), f64::INFINITY);
    assert!((loss(2.0, 0.01, 5.0) - 0.002).abs() < 1e-15);
}

#[test]
fn strokes_and_followers_count_in_full() {
    let joint = |k: usize, kind: &str, axis: &str, mimic: &str| {
        format!(
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{}\"/><child link=\"l{k}\"/>\
             <origin xyz=\"0.3 0 0\"/><axis xyz=\"{axis}\"/><limit lower=\"-0.3\" upper=\"0.8\" velocity=\"1\" effort=\"1\"/>\
             {mimic}</joint>",
            k - 1
        )
    };
    let robot = |joints: &[String]| format!("<robot name=\"r\"><link name=\"l0\"/>{}</robot>", joints.concat());
    let turn = joint(1, "revolute", "0 0 1", "");
    // A point that turns about z, carried out along x as far as its slide goes, stretched all the way.
    let slide = joint(2, "prismatic", "1 0 0", "");
    let lead = "<mimic joint=\"j2\" multiplier=\"1.5\" offset=\"0.4\"/>";
    // A follower with room for all that its leader does.
    let follower = joint(3, "prismatic", "1 0 0", lead).replace("upper=\"0.8\"", "upper=\"1.6\"");
    let doubled = robot(&[turn.clone(), slide.clone(), follower]);
    let lock = [("j2".to_string(), 0.5)].into();
    let options = Options { lock, ..Options::default() };
    let locked = Model::from_urdf(&robot(&[turn.clone(), slide.clone()]), &options).unwrap().0;
    let faster = joint(2, "revolute", "0 0 1", "<mimic joint=\"j1\" multiplier=\"2.5\" offset=\"0\"/>");
    let x = Vector3::new(0.1, 0.0, 0.0);
    for (model, q, speed, expected) in [
        (read(&robot(&[turn.clone(), slide]), Base::Fixed), vec![0.1, 0.8], vec![0.9, 0.0], 0.81 * (0.3 + 0.8 + 0.1)),
        (read(&doubled, Base::Fixed), vec![0.1, 0.8], vec![0.9, 0.0], 0.81 * (0.3 + 0.8 + 0.3 + 1.6 + 0.1)),
        (locked, vec![0.1], vec![0.9], 0.81 * (0.3 + 0.5 + 0.1)),
        (read(&robot(&[turn, faster]), Base::Fixed), vec![0.0], vec![0.9], 0.81 * (0.3 + 3.5 * 3.5 * 0.1)),
    ] {
        let tip = LinkId(model.links.len() as u32 - 1);
        let bound = acceleration_bound(&model, None, tip, 0.1, &speed);
        let a = measured(&Place::new(&model, &q), &speed, None, tip, &x);
        assert!((bound - expected).abs() < 1e-12, "{bound} and {expected}");
        assert!((a / bound - 1.0).abs() < 1e-5, "{a} and {bound}");
    }
}

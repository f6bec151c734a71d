//! A collision task without a second side: the pairs of its one side, without neighbours and exceptions, with the rows that the
//! same pairs have as two sides.

use hierarq_stdlib_tasks::bound::{Bound, ExceptedPair, Exception, Geometry};
use robot::{LinkId, Model, contacts};

use crate::common::*;

/// All collision shapes of a robot, named after their links.
fn shapes(model: &Model) -> Vec<Geometry> {
    let mut all = Vec::new();
    for (i, link) in model.links.iter().enumerate() {
        let one = |s: &robot::PlacedShape| Geometry {
            name: link.name.clone(),
            link: LinkId(i as u32),
            origin: s.origin,
            shape: s.shape.clone(),
        };
        all.extend(link.collision.iter().map(one));
    }
    all
}

fn one_side(parts: Vec<Geometry>) -> Case {
    Case::new("self_collision")
        .with("between", Bound::Geometries(parts))
        .number("d_min", &[0.01])
        .number("gain", &[10.0])
        .number("sampled_margin", &[0.0])
}

fn names(case: &Case, model: &Model) -> Vec<String> {
    case.build(model).rows().iter().map(|row| row.name.clone()).collect()
}

#[test]
fn every_pair_that_is_no_neighbour_has_the_row_of_two_sides() {
    let mut rng = rng(5);
    for model in robots() {
        let parts = shapes(&model);
        let case = one_side(parts.clone());
        let mut task = case.build(&model);
        let pairs = contacts::pairs(&model);
        let count = |link: LinkId| model.link_ref(link).collision.len();
        assert_eq!(task.rows().len(), pairs.iter().map(|[a, b]| count(*a) * count(*b)).sum::<usize>());
        let q = &configurations(&model, 1, &mut rng)[0];
        let place = Place::new(&model, q);
        let Ok(whole) = place.write(task.as_mut(), &case, 0.0) else { continue };
        for [a, b] in pairs.into_iter().take(20) {
            let of = |link: LinkId| Bound::Geometries(parts.iter().filter(|p| p.link == link).cloned().collect());
            let sides = one_side(Vec::new()).with("between", of(a)).with("and", of(b));
            let mut two = sides.build(&model);
            let alone = place.write(two.as_mut(), &sides, 0.0).unwrap();
            let name = format!("{} to {}", model.link_ref(a).name, model.link_ref(b).name);
            let rows: Vec<usize> =
                task.rows().iter().enumerate().filter(|(_, row)| row.name == name).map(|(i, _)| i).collect();
            assert_eq!(rows.len(), alone.margins.len(), "{name}");
            for (i, row) in rows.into_iter().enumerate() {
                assert_eq!(whole.margins[row], alone.margins[i], "{name}");
                assert_eq!(whole.j.row(row), alone.j.row(i), "{name}");
                assert_eq!(whole.lower[row], alone.lower[i], "{name}");
            }
        }
    }
}

#[test]
fn excepted_pairs_have_no_row() {
    let model = arm7();
    let all = names(&one_side(shapes(&model)), &model);
    let id = |name: &str| model.link(name).unwrap();
    let pair = |a, b| ExceptedPair { links: contacts::pair(id(a), id(b)), why: Exception::Written };
    let excepted = vec![pair("gripper", "link_2"), pair("base_link", "link_3")];
    let left = names(&one_side(shapes(&model)).with("except", Bound::Pairs(excepted.clone())), &model);
    let gone: Vec<&String> = all.iter().filter(|row| !left.contains(row)).collect();
    assert!(gone.iter().all(|row| ["link_2 to gripper", "base_link to link_3"].contains(&row.as_str())), "{gone:?}");
    assert_eq!(all.len() - left.len(), 3, "link_2 has two shapes");
    // Two sides leave out the same.
    let side = |link: &str| Bound::Geometries(shapes(&model).into_iter().filter(|p| p.link == id(link)).collect());
    let sides = one_side(Vec::new()).with("between", side("gripper")).with("and", side("link_2"));
    let error = sides.with("except", Bound::Pairs(excepted)).build_for(&model, 0.01, &[1.0; 7]).err().unwrap();
    assert_eq!(error.param, "except");
}

#[test]
fn neighbours_alone_are_no_task() {
    let model = arm7();
    let two = shapes(&model).into_iter().filter(|p| ["link_3", "link_4"].contains(&p.name.as_str())).collect();
    let error = one_side(two).build_for(&model, 0.01, &[1.0; 7]).err().unwrap();
    assert_eq!(error.param, "between");
}

//! Pairs of bodies that overlap in a posture: parts that belong together, such as links that meet in a joint.

use nalgebra::Isometry3;
use robot::{Data, LinkId, Model, PlacedShape, Shape, geometry};
use stdlib_tasks::obstacle::Form;

use crate::room::Room;

/// An obstacle on a link, by its index, and a link.
pub type CarriedPair = (usize, LinkId);

fn links(model: &Model) -> impl Iterator<Item = LinkId> {
    (0..model.links.len()).map(|k| LinkId(k as u32))
}

/// True if a shape at a pose in the world overlaps a link.
fn touches(model: &Model, data: &Data, link: LinkId, shape: &Shape, pose: &Isometry3<f64>) -> bool {
    let own = |PlacedShape { origin, shape: own }: &PlacedShape| {
        geometry::closest(shape, pose, own, &(data.pose(link) * origin)).map_or(true, |c| c.distance <= 0.0)
    };
    model.link_ref(link).collision.iter().any(own)
}

/// Pairs of links that overlap, or are joined.
pub fn of_links(model: &Model, q: &[f64]) -> Vec<[LinkId; 2]> {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let joined = |a: LinkId, b: LinkId| {
        model.joints.iter().any(|j| [j.parent, j.child] == [a, b] || [j.child, j.parent] == [a, b])
    };
    let overlap = |a: LinkId, b: LinkId| {
        let shapes = &model.link_ref(a).collision;
        joined(a, b) || shapes.iter().any(|s| touches(model, &data, b, &s.shape, &(data.pose(a) * s.origin)))
    };
    links(model)
        .flat_map(|a| links(model).filter(move |b| a < *b).map(move |b| [a, b]))
        .filter(|[a, b]| overlap(*a, *b))
        .collect()
}

/// Obstacles on links, and other links that they overlap.
pub fn of_carried(model: &Model, q: &[f64], room: &Room) -> Vec<CarriedPair> {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let overlap = |k: usize, on: LinkId, pose: &Isometry3<f64>, with: LinkId| {
        let at = data.pose(on) * pose;
        let parts = &model.link_ref(with).collision;
        match &room.obstacle(k).form {
            Form::Shape(origin, shape) => touches(model, &data, with, shape, &(at * origin)),
            Form::HalfSpace(turn) => {
                let normal = at.rotation * (turn * nalgebra::Vector3::z());
                let offset = normal.dot(&at.translation.vector);
                let below = |p: &PlacedShape| {
                    geometry::closest_plane(&p.shape, &(data.pose(with) * p.origin), &normal, offset).distance <= 0.0
                };
                parts.iter().any(below)
            }
            Form::Soup(soup) => parts.iter().any(|p| {
                let pose = data.pose(with) * p.origin;
                (0..soup.len()).any(|e| soup.closest_to(e, &p.shape, &pose, &at).map_or(true, |c| c.distance <= 0.0))
            }),
        }
    };
    let with = |(k, on, pose): &(usize, LinkId, Isometry3<f64>)| {
        let (k, on, pose) = (*k, *on, *pose);
        let overlap = &overlap;
        links(model)
            .filter(move |with| *with != on && overlap(k, on, &pose, *with))
            .map(move |with| (k, with))
            .collect::<Vec<_>>()
    };
    room.on_links().iter().flat_map(with).collect()
}

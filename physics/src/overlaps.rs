//! Pairs of bodies that overlap in a posture: parts that belong together, such as links that meet in a joint.

use nalgebra::{Isometry3, Vector3};
use robot::{Data, LinkId, Model, PlacedShape, Shape, geometry};
use stdlib_tasks::obstacle::Form;

use crate::room::Room;

/// An obstacle that overlaps a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// Index of the obstacle.
    pub obstacle: usize,
    /// The link.
    pub link: LinkId,
}

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

/// Obstacles that stay where they are, in the room or on links, and links that they overlap, except for those that carry
/// them.
pub fn of_obstacles(model: &Model, q: &[f64], room: &Room) -> Vec<Overlap> {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let mut found = Vec::new();
    for standing in room.standing() {
        let at = standing.on.map_or(standing.pose, |on| data.pose(on) * standing.pose);
        let form = &room.obstacle(standing.obstacle).form;
        let others = links(model).filter(|link| standing.on != Some(*link));
        let with = others.filter(|link| meets(model, &data, *link, form, &at));
        found.extend(with.map(|link| Overlap { obstacle: standing.obstacle, link }));
    }
    found
}

/// True if the form of an obstacle at a pose in the world overlaps a link.
fn meets(model: &Model, data: &Data, link: LinkId, form: &Form, at: &Isometry3<f64>) -> bool {
    let parts = || model.link_ref(link).collision.iter().map(|p| (&p.shape, data.pose(link) * p.origin));
    match form {
        Form::Shape(origin, shape) => touches(model, data, link, shape, &(at * origin)),
        Form::HalfSpace(turn) => {
            let normal = at.rotation * (turn * Vector3::z());
            let offset = normal.dot(&at.translation.vector);
            parts().any(|(shape, pose)| geometry::closest_plane(shape, &pose, &normal, offset).distance <= 0.0)
        }
        Form::Soup(soup) => parts().any(|(shape, pose)| {
            let close = |e: usize| soup.closest_to(e, shape, &pose, at).map_or(true, |c| c.distance <= 0.0);
            (0..soup.len()).any(close)
        }),
    }
}

//! A part of the robot and an obstacle: the closest points of both, or of the part and some spots of a body of many
//! elements, and the last valid direction, which holds while the cores meet.

use nalgebra::{Point3, Vector3};
use robot::{Closest, Frontier, Search, Spot};

use crate::bound::Geometry;
use crate::closest_points::{SeparationError, overlap};
use crate::obstacle::{Form, Obstacle, PlacedObstacle};
use crate::state::State;

/// A part, an obstacle, and their last valid separation.
pub struct ObstaclePair {
    /// Index of the part.
    pub part: usize,
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Spots of a body of many elements; otherwise empty.
    spots: Vec<Option<Spot>>,
    last: Option<Last>,
}

/// Last valid separation.
#[derive(Clone, Copy)]
struct Last {
    /// From the obstacle to the part, in the world.
    normal: Vector3<f64>,
    /// Closest points, in the frames of the part's link and of the obstacle.
    on_part: Point3<f64>,
    on_obstacle: Point3<f64>,
}

/// A part and an obstacle, or an element of it, at a tick.
#[derive(Clone, Copy)]
pub struct ObstacleSeparation {
    /// Distance of the surfaces in m; negative if they overlap.
    pub distance: f64,
    /// Closest point of the part in the world, in m.
    pub on_part: Vector3<f64>,
    /// Closest point of the obstacle in the world, in m.
    pub on_obstacle: Vector3<f64>,
    /// Unit vector from the obstacle to the part.
    pub normal: Vector3<f64>,
    /// The element of the obstacle, if it has elements; `None` for the last valid separation.
    pub element: Option<usize>,
}

impl ObstacleSeparation {
    fn of(c: &Closest, element: Option<usize>) -> ObstacleSeparation {
        ObstacleSeparation { distance: c.distance, on_part: c.on_a, on_obstacle: c.on_b, normal: c.normal, element }
    }
}

/// A part and an obstacle at a tick, whose separations are computed.
pub struct Meeting<'a> {
    /// The part.
    pub part: &'a Geometry,
    /// The obstacle.
    pub obstacle: &'a Obstacle,
    /// Its place.
    pub at: &'a PlacedObstacle,
    /// Distance in m beyond which only the first spot is computed.
    pub range: f64,
}

impl ObstaclePair {
    /// A pair without a known separation, with this number of spots if the obstacle has many elements.
    pub fn new(part: usize, obstacle: usize, form: &Form, spots: usize) -> ObstaclePair {
        let spots = match form {
            Form::Soup(soup) => spots.min(soup.len()),
            Form::Shape(..) | Form::HalfSpace(_) => 0,
        };
        ObstaclePair { part, obstacle, spots: vec![None; spots], last: None }
    }

    /// Number of separations that it can have at a tick.
    pub fn count(&self) -> usize {
        self.spots.len().max(1)
    }

    /// Forgets the last separation.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Computes the separations, the nearest first; absent ones are `None`. If cores intersect, the first is the last
    /// valid one. Spots farther away than `range` (m) are absent, except the first. `found` has room for
    /// [`ObstaclePair::count`], and `frontier` for the obstacle. Allocates nothing.
    ///
    /// # Errors
    /// A pose is not finite, or the cores intersect and always did.
    pub fn find(
        &mut self,
        &Meeting { part, obstacle, at, range }: &Meeting,
        state: &State,
        found: &mut [Option<ObstacleSeparation>],
        frontier: &mut Frontier,
    ) -> Result<(), SeparationError> {
        let carrier = state.data.pose(part.link);
        let pose = carrier * part.origin;
        if !pose.translation.vector.iter().all(|x| x.is_finite()) {
            return Err(SeparationError::NotFinite);
        }
        let touching = match &obstacle.form {
            Form::Soup(soup) => {
                let search = soup.spots(&part.shape, &pose, &at.pose, range, &mut self.spots, frontier);
                let touching = search != Search::Apart;
                // The first place is that of the last separation if there is no other.
                let places = found.iter_mut().skip(usize::from(touching));
                for (place, spot) in places.zip(&self.spots) {
                    *place = spot.as_ref().map(|s| ObstacleSeparation::of(&s.closest, Some(s.element)));
                }
                touching
            }
            Form::Shape(..) | Form::HalfSpace(_) => match obstacle.closest(&part.shape, &pose, at) {
                Ok(c) => {
                    found[0] = Some(ObstacleSeparation::of(&c, None));
                    false
                }
                Err(_) => true,
            },
        };
        if touching {
            let last = self.last.ok_or(SeparationError::Overlap)?;
            let (on_part, on_obstacle) = ((carrier * last.on_part).coords, (at.pose * last.on_obstacle).coords);
            let distance = obstacle.overlap(&part.shape);
            found[0] = Some(ObstacleSeparation { distance, on_part, on_obstacle, normal: last.normal, element: None });
        } else if let Some(s) = &found[0] {
            self.last = Some(Last {
                normal: s.normal,
                on_part: carrier.inverse_transform_point(&Point3::from(s.on_part)),
                on_obstacle: at.pose.inverse_transform_point(&Point3::from(s.on_obstacle)),
            });
        }
        Ok(())
    }
}

/// Distance of a part and an obstacle, or an element of it, at a configuration beside that of the tick, in m. NaN if a pose
/// is not finite.
pub fn distance_at(
    part: &Geometry,
    obstacle: &Obstacle,
    element: Option<usize>,
    at: &PlacedObstacle,
    state: &State,
) -> f64 {
    let pose = state.data.pose(part.link) * part.origin;
    let found = match (&obstacle.form, element) {
        (Form::Soup(soup), Some(element)) => soup.closest_to(element, &part.shape, &pose, &at.pose),
        _ => obstacle.closest(&part.shape, &pose, at),
    };
    match found {
        Ok(c) => c.distance,
        Err(_) if pose.translation.vector.iter().all(|x| x.is_finite()) => obstacle.overlap(&part.shape),
        Err(_) => f64::NAN,
    }
}

impl Obstacle {
    /// Distance of a shape whose core meets that of the obstacle, in m: minus the radii around them.
    fn overlap(&self, shape: &robot::Shape) -> f64 {
        match &self.form {
            Form::Shape(_, own) => overlap(shape, own),
            Form::HalfSpace(_) => 0.0,
            Form::Soup(soup) => overlap(shape, &robot::Shape::Sphere { radius: soup.radius() }),
        }
    }
}

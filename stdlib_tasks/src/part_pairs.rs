//! Many pairs of a few parts of the robot: each part is placed once a tick, and pairs of capsules are computed several at a
//! time. The separations are those of [`Pair`](crate::closest_points::Pair), to the last bit.

use nalgebra::{Isometry3, Point3, Vector3};
use robot::geometry::{CAPSULES_AT_ONCE, Capsule, closest_capsules};
use robot::{Closest, closest};

use crate::closest_points::{Separation, SeparationError, overlap};
use crate::geometry::Geometry;
use crate::state::State;

/// Indices of two parts.
pub type Two = [usize; 2];

/// Parts, pairs of them, and the last valid separation of each pair.
#[derive(Clone, Debug)]
pub struct PartPairs {
    parts: Vec<Geometry>,
    pairs: Vec<Two>,
    /// Parts at this tick.
    placed: Vec<PlacedPart>,
    /// Poses of their links at the tick before.
    before: Vec<Isometry3<f64>>,
    /// The last valid separation of each pair, which is that of this tick if the cores are apart.
    last: Vec<Separation>,
    known: Vec<Known>,
    /// Reason why a pair has no separation at this tick.
    missing: Vec<Option<SeparationError>>,
    /// Closest points of held separations, in the frames of the two links.
    held: Vec<[Point3<f64>; 2]>,
}

/// A part at a tick.
#[derive(Clone, Copy, Debug)]
struct PlacedPart {
    link: Isometry3<f64>,
    pose: Isometry3<f64>,
    capsule: Option<Capsule>,
}

/// Time of the last valid separation of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    Never,
    /// At the last tick that was computed.
    Now,
    /// Earlier: its points moved with the links since.
    Held,
}

impl PartPairs {
    /// Pairs without a known separation. They are of different parts, and name parts that exist.
    pub fn new(parts: Vec<Geometry>, pairs: Vec<Two>) -> PartPairs {
        let nowhere = PlacedPart { link: Isometry3::identity(), pose: Isometry3::identity(), capsule: None };
        let zero = Vector3::zeros();
        let nothing = Separation { distance: 0.0, on_a: zero, on_b: zero, normal: zero };
        PartPairs {
            placed: vec![nowhere; parts.len()],
            before: vec![Isometry3::identity(); parts.len()],
            last: vec![nothing; pairs.len()],
            known: vec![Known::Never; pairs.len()],
            missing: vec![None; pairs.len()],
            held: vec![[Point3::origin(); 2]; pairs.len()],
            parts,
            pairs,
        }
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// The two parts of each pair.
    pub fn iter(&self) -> impl Iterator<Item = [&Geometry; 2]> {
        self.pairs.iter().map(|pair| pair.map(|i| &self.parts[i]))
    }

    /// The two parts of a pair.
    pub fn get(&self, pair: usize) -> Option<[&Geometry; 2]> {
        self.pairs.get(pair).map(|pair| pair.map(|i| &self.parts[i]))
    }

    /// Forgets the last separations.
    pub fn forget(&mut self) {
        self.known.fill(Known::Never);
    }

    /// Computes the closest points of all pairs. Where the cores of a pair intersect, its last valid direction and points are
    /// used. Allocates nothing.
    pub fn find(&mut self, state: &State) {
        for ((placed, before), part) in self.placed.iter_mut().zip(&mut self.before).zip(&self.parts) {
            *before = placed.link;
            let link = *state.data.pose(part.link);
            let pose = link * part.origin;
            *placed = PlacedPart { link, pose, capsule: Capsule::of(&part.shape, &pose) };
        }
        // Pairs of capsules wait until there are enough of them; the last ones are alone.
        let mut waiting = [0; CAPSULES_AT_ONCE];
        let mut count = 0;
        for i in 0..self.pairs.len() {
            if self.capsules(i).is_none() {
                self.keep(i, None);
                continue;
            }
            waiting[count] = i;
            count += 1;
            if count == CAPSULES_AT_ONCE {
                self.find_capsules(&waiting);
                count = 0;
            }
        }
        for i in &waiting[..count] {
            self.keep(*i, None);
        }
    }

    /// Separation of a pair at this tick.
    ///
    /// # Errors
    /// A pose is not finite, or the cores intersect and always did.
    pub fn separation(&self, pair: usize) -> Result<&Separation, SeparationError> {
        self.missing[pair].map_or(Ok(&self.last[pair]), Err)
    }

    fn capsules(&self, pair: usize) -> Option<[&Capsule; 2]> {
        let [a, b] = self.pairs[pair].map(|i| self.placed[i].capsule.as_ref());
        Some([a?, b?])
    }

    fn find_capsules(&mut self, pairs: &[usize; CAPSULES_AT_ONCE]) {
        let [Some(p), Some(q), Some(r), Some(s)] = pairs.map(|i| self.capsules(i)) else { return };
        let all = [p, q, r, s];
        let found = closest_capsules(&all.map(|[a, _]| a), &all.map(|[_, b]| b));
        for (i, closest) in pairs.iter().zip(found) {
            self.keep(*i, closest);
        }
    }

    /// Keeps the separation of a pair, and computes it if that is left to do.
    fn keep(&mut self, pair: usize, known: Option<Closest>) {
        let [i, j] = self.pairs[pair];
        let (a, b) = (&self.placed[i], &self.placed[j]);
        let shapes = [&self.parts[i].shape, &self.parts[j].shape];
        let last = &mut self.last[pair];
        let result = known.map_or_else(|| closest(shapes[0], &a.pose, shapes[1], &b.pose), Ok);
        if let Ok(c) = result {
            *last = Separation { distance: c.distance, on_a: c.on_a, on_b: c.on_b, normal: c.normal };
            self.known[pair] = Known::Now;
            self.missing[pair] = None;
            return;
        }
        if self.known[pair] == Known::Now {
            let on = [(i, last.on_a), (j, last.on_b)];
            self.held[pair] = on.map(|(part, p)| self.before[part].inverse_transform_point(&Point3::from(p)));
            self.known[pair] = Known::Held;
        }
        // A rotation that is NaN makes the translation NaN too.
        self.missing[pair] = if !is_finite(&a.pose) || !is_finite(&b.pose) {
            Some(SeparationError::NotFinite)
        } else if self.known[pair] == Known::Held {
            let [on_a, on_b] = self.held[pair];
            (last.on_a, last.on_b) = ((a.link * on_a).coords, (b.link * on_b).coords);
            last.distance = overlap(shapes[0], shapes[1]);
            None
        } else {
            Some(SeparationError::Overlap)
        };
    }

    /// Adds the row of the distance of a pair.
    pub fn add_row(&self, state: &State, pair: usize, separation: &Separation, row: &mut [f64]) {
        let [a, b] = self.pairs[pair].map(|i| self.parts[i].link);
        let n = &separation.normal;
        state.data.add_point(state.model, a, &separation.on_a, n, row);
        state.data.add_point(state.model, b, &separation.on_b, &-n, row);
    }

    /// Distance of a pair in m at a configuration beside that of the tick; nothing is kept of it. NaN if a pose is not finite.
    pub fn distance(&self, pair: usize, state: &State) -> f64 {
        let Some([a, b]) = self.get(pair) else { return f64::INFINITY };
        let [pose_a, pose_b] = [a, b].map(|part| state.data.pose(part.link) * part.origin);
        match closest(&a.shape, &pose_a, &b.shape, &pose_b) {
            Ok(c) => c.distance,
            Err(_) if is_finite(&pose_a) && is_finite(&pose_b) => overlap(&a.shape, &b.shape),
            Err(_) => f64::NAN,
        }
    }
}

fn is_finite(pose: &Isometry3<f64>) -> bool {
    pose.translation.vector.iter().all(|x| x.is_finite())
}

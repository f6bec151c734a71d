//! The robot in the safety field: segments between points of links.
//!
//! The segment of a link runs from its own joint to each of its children's joints, that is from the link's origin to
//! the origins of its child links. The end is fixed to the CHILD: for a turning joint that is the same point, and for a
//! sliding one the segment stretches, so that no part of the robot is missed. Children whose origin always is the
//! link's own have no segment. A link without segments is the point at its origin; if that is too little, list a tool's
//! frame as a link of its own by a fixed joint, or define segments explicitly. A link with several children is split
//! evenly between its segments, so that the field is a mean over LINKS (correction 8 of the thesis), however they
//! branch.

use nalgebra::Vector3;
use robot::{Data, JointKind, LinkId, Model};

use crate::field::error::{SafetyError, setting};

/// A point of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attached {
    /// The link.
    pub link: LinkId,
    /// The point in the link's frame \[m\].
    pub at: Vector3<f64>,
}

impl Attached {
    /// The origin of a link.
    pub fn origin(link: LinkId) -> Attached {
        Attached { link, at: Vector3::zeros() }
    }
}

/// Segment that represents a part of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSegment {
    /// Start of the segment.
    pub start: Attached,
    /// End of the segment, which may be on another link.
    pub end: Attached,
    /// Its share in the mean, positive; shares are divided by their sum.
    pub weight: f64,
}

/// Segments, with storage for their positions.
#[derive(Clone, Debug)]
pub struct Body {
    segments: Vec<LinkSegment>,
    /// Links that segments are fixed to, once each.
    links: Vec<LinkId>,
    /// Indices of both ends in `links`.
    slots: Vec<[usize; 2]>,
    /// Both ends in the world \[m\].
    ends: Vec<[Vector3<f64>; 2]>,
}

impl Body {
    /// Creates the segments of these links of `model`, each link with the same share.
    ///
    /// # Errors
    /// [`SafetyError::Body`] if there is none, one is named twice, or one does not belong to the model.
    pub fn of_links(model: &Model, links: &[LinkId]) -> Result<Body, SafetyError> {
        let mut segments = Vec::new();
        for (i, link) in links.iter().enumerate() {
            if link.index() >= model.links.len() || links[..i].contains(link) {
                return Err(SafetyError::Body);
            }
            let start = Attached::origin(*link);
            let reaches = |j: &&robot::Joint| {
                j.parent == *link && (j.kind == JointKind::Prismatic || j.origin.translation.vector.norm() > 1e-9)
            };
            let count = model.joints.iter().filter(reaches).count();
            let weight = 1.0 / count.max(1) as f64;
            if count == 0 {
                segments.push(LinkSegment { start, end: start, weight });
            }
            segments.extend(model.joints.iter().filter(reaches).map(|j| LinkSegment {
                start,
                end: Attached::origin(j.child),
                weight,
            }));
        }
        Body::of_segments(model, segments)
    }

    /// Creates a body from these segments of `model`.
    ///
    /// # Errors
    /// [`SafetyError::Body`] if there is none or a link does not belong to the model; [`SafetyError::Setting`] for a
    /// weight that is not positive; [`SafetyError::NotFinite`] for a point that is not finite.
    pub fn of_segments(model: &Model, mut segments: Vec<LinkSegment>) -> Result<Body, SafetyError> {
        if segments.is_empty() {
            return Err(SafetyError::Body);
        }
        let mut links: Vec<LinkId> = Vec::new();
        let mut slots = Vec::new();
        for s in &segments {
            setting("weight", s.weight, s.weight > 0.0 && s.weight.is_finite(), "positive and finite")?;
            let mut pair = [0; 2];
            for (slot, end) in pair.iter_mut().zip([&s.start, &s.end]) {
                if end.link.index() >= model.links.len() {
                    return Err(SafetyError::Body);
                }
                if !end.at.iter().all(|x| x.is_finite()) {
                    return Err(SafetyError::NotFinite { name: "segment" });
                }
                *slot = links.iter().position(|l| *l == end.link).unwrap_or_else(|| {
                    links.push(end.link);
                    links.len() - 1
                });
            }
            slots.push(pair);
        }
        let sum: f64 = segments.iter().map(|s| s.weight).sum();
        segments.iter_mut().for_each(|s| s.weight /= sum);
        let ends = vec![[Vector3::zeros(); 2]; segments.len()];
        Ok(Body { segments, links, slots, ends })
    }

    /// The segments; their weights add to one.
    pub fn segments(&self) -> &[LinkSegment] {
        &self.segments
    }

    /// The links that segments are fixed to, once each.
    pub fn links(&self) -> &[LinkId] {
        &self.links
    }

    /// For each segment, the indices of its ends' links in [`Body::links`].
    pub fn slots(&self) -> &[[usize; 2]] {
        &self.slots
    }

    /// Both ends of each segment in the world \[m\], as of the last [`Body::place`].
    pub fn ends(&self) -> &[[Vector3<f64>; 2]] {
        &self.ends
    }

    /// Computes the positions of the ends from the kinematics.
    pub fn place(&mut self, data: &Data) {
        for (s, ends) in self.segments.iter().zip(&mut self.ends) {
            *ends = [&s.start, &s.end].map(|e| data.position(e.link) + data.rotation(e.link) * e.at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::testing::robots;

    #[test]
    fn segments_follow_the_tree() {
        for model in robots() {
            let all: Vec<LinkId> = (0..model.links.len() as u32).map(LinkId).collect();
            let Ok(mut body) = Body::of_links(&model, &all) else { panic!("{model:?}") };
            body.place(&Data::new(&model));
            let total: f64 = body.segments().iter().map(|s| s.weight).sum();
            assert!((total - 1.0).abs() < 1e-12);
            for link in &all {
                let own: f64 = body.segments().iter().filter(|s| s.start.link == *link).map(|s| s.weight).sum();
                assert!((own * all.len() as f64 - 1.0).abs() < 1e-12, "every link has the same share");
            }
            for (s, ends) in body.segments().iter().zip(body.ends()) {
                assert!(s.end.link == s.start.link || model.parent(s.end.link) == Some(s.start.link));
                assert!(ends.iter().all(|p| p.iter().all(|x| x.is_finite())));
            }
        }
    }

    #[test]
    fn lists_that_mean_nothing_are_refused() {
        let model = &robots()[0];
        let root = model.root();
        assert_eq!(Body::of_links(model, &[]).err(), Some(SafetyError::Body));
        assert_eq!(Body::of_links(model, &[root, root]).err(), Some(SafetyError::Body));
        assert_eq!(Body::of_links(model, &[LinkId(1000)]).err(), Some(SafetyError::Body));
        let point = Attached::origin(root);
        let segment = LinkSegment { start: point, end: point, weight: 0.0 };
        assert!(matches!(Body::of_segments(model, vec![segment]), Err(SafetyError::Setting { .. })));
        let nan = Attached { link: root, at: Vector3::repeat(f64::NAN) };
        let segment = LinkSegment { start: nan, end: point, weight: 1.0 };
        assert!(matches!(Body::of_segments(model, vec![segment]), Err(SafetyError::NotFinite { .. })));
    }
}

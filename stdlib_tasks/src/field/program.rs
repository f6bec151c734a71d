//! Safety field as data: its links, its function of the distance, and the indices of people's points.

use std::sync::Arc;

use expressions::{Op, Registers};
use robot::{LinkId, Model};
use serde::{Deserialize, Serialize};

use crate::dimension::Dimension;
use crate::field::body::Body;
use crate::field::chi::{Chi, DistanceFunction};
use crate::field::error::SafetyError;
use crate::field::value::{Field, Over};

/// Safety field as data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldProgram {
    /// Its name in the spec.
    pub name: String,
    /// Links that represent the robot, each with the same share.
    pub links: Vec<LinkId>,
    /// The function of the distance.
    pub distance: DistanceProgram,
    /// Combination of the points into one number.
    pub over: Over,
    /// Indices of the numbers x, y, z of each point in the world, in m. In a program: entries of the table of values,
    /// whose rates are the velocities of the points. In a leaf of an expression: operations of the expression that come
    /// before its own.
    pub points: Vec<[usize; 3]>,
    /// Dimension of its value.
    pub dimension: Dimension,
}

/// The function of the distance as data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DistanceProgram {
    /// The distance itself.
    Identity,
    /// `min(d, reach)`, the reach in m.
    Clamped(f64),
    /// `reach (1 - exp(-d / reach))`, the reach in m.
    Saturating(f64),
    /// A user-defined function.
    Written(ExpressionDistance),
}

/// A function of the distance as operations, of which [`Op::Input`] 0 is the distance in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExpressionDistance {
    /// Operations, operands before users; at most [`expressions::MAX_OPERATIONS`].
    pub ops: Vec<Op>,
    /// Operation that computes the value.
    pub value: usize,
    /// Operation that computes the derivative.
    pub slope: usize,
}

impl DistanceFunction for ExpressionDistance {
    fn evaluate(&self, d: f64) -> (f64, f64) {
        let registers = Registers::of(&self.ops, &[d]);
        (registers.get(self.value), registers.get(self.slope))
    }
}

impl ExpressionDistance {
    fn check(&self) -> Result<(), &'static str> {
        expressions::check(&self.ops, 1, &[self.value, self.slope])
    }
}

impl DistanceProgram {
    /// The function, prepared for evaluation.
    pub fn chi(&self) -> Chi {
        match self {
            DistanceProgram::Identity => Chi::Distance,
            DistanceProgram::Clamped(reach) => Chi::Clamped { reach: *reach },
            DistanceProgram::Saturating(reach) => Chi::Saturating { reach: *reach },
            DistanceProgram::Written(written) => Chi::Given(Arc::new(written.clone())),
        }
    }
}

impl FieldProgram {
    /// Checks that the field can be created for this robot, and that its points are below `end`.
    ///
    /// # Errors
    /// Description of the first error.
    pub fn check(&self, model: &Model, end: usize) -> Result<(), &'static str> {
        if let DistanceProgram::Written(written) = &self.distance {
            written.check()?;
        }
        if self.points.is_empty() {
            return Err("a safety field has no point of a person");
        }
        if self.points.iter().flatten().any(|&at| at >= end) {
            return Err("a point of a safety field is nowhere");
        }
        self.field(model).map(drop).map_err(|e| match e {
            SafetyError::Body => "the links of a safety field are none, or repeated, or not the robot's",
            _ => "a setting of a safety field is not positive and finite",
        })
    }

    /// Creates the field with its storage.
    ///
    /// # Errors
    /// There are no links, or they are repeated or not the robot's; or a reach or sharpness is not positive.
    pub fn field(&self, model: &Model) -> Result<Field, SafetyError> {
        Field::new(model, Body::of_links(model, &self.links)?, self.distance.chi(), self.over, self.points.len())
    }

    /// Copy with renumbered points.
    pub fn renumber(&self, f: impl Fn(usize) -> usize) -> FieldProgram {
        FieldProgram { points: self.points.iter().map(|p| p.map(&f)).collect(), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use expressions::MAX_OPERATIONS;

    use super::*;
    use crate::dimension::LENGTH;
    use crate::field::HumanPoint;
    use crate::field::testing::robots;
    use nalgebra::Vector3;
    use robot::Data;

    /// `1 - exp(-d)` and its derivative.
    fn written() -> ExpressionDistance {
        let ops = vec![Op::Input(0), Op::Neg(0), Op::Exp(1), Op::Const(1.0), Op::Sub(3, 2)];
        ExpressionDistance { ops, value: 4, slope: 2 }
    }

    fn program(distance: DistanceProgram) -> FieldProgram {
        let links = (0..3).map(LinkId).collect();
        let points = vec![[0, 1, 2]];
        FieldProgram { name: "f".into(), links, distance, over: Over::Mean, points, dimension: LENGTH }
    }

    #[test]
    fn a_written_function_is_what_it_says() {
        let saturating = Chi::Saturating { reach: 1.0 };
        for d in [0.0, 0.3, 1.7, 40.0] {
            let (value, slope) = written().evaluate(d);
            let (expected, expected_slope) = saturating.evaluate(d);
            assert!((value - expected).abs() < 1e-15 && (slope - expected_slope).abs() < 1e-15);
        }
        let model = &robots()[0];
        let data = Data::new(model);
        let human = [HumanPoint::at_rest(Vector3::new(0.7, 0.2, 0.4))];
        let value = |distance| {
            let Ok(mut field) = program(distance).field(model) else { panic!("a good field") };
            assert_eq!(field.update(model, &data, &human), Ok(()));
            field.value()
        };
        let both = [DistanceProgram::Written(written()), DistanceProgram::Saturating(1.0)].map(value);
        assert!((both[0] - both[1]).abs() < 1e-14);
    }

    #[test]
    fn what_was_edited_is_refused() {
        let model = &robots()[0];
        let good = program(DistanceProgram::Written(written()));
        assert_eq!(good.check(model, 3), Ok(()));
        assert!(good.check(model, 2).is_err(), "a point beyond the end");
        assert!(FieldProgram { points: vec![], ..good.clone() }.check(model, 3).is_err());
        assert!(FieldProgram { links: vec![LinkId(1), LinkId(1)], ..good.clone() }.check(model, 3).is_err());
        assert!(program(DistanceProgram::Clamped(-1.0)).check(model, 3).is_err());
        for bad in [
            ExpressionDistance { ops: vec![Op::Neg(0)], value: 0, slope: 0 },
            ExpressionDistance { ops: vec![Op::Time], value: 0, slope: 0 },
            ExpressionDistance { ops: vec![Op::Input(1)], value: 0, slope: 0 },
            ExpressionDistance { ops: vec![Op::Input(0)], value: 0, slope: 1 },
            ExpressionDistance { ops: vec![Op::Input(0); MAX_OPERATIONS + 1], value: 0, slope: 0 },
        ] {
            assert!(program(DistanceProgram::Written(bad)).check(model, 3).is_err());
        }
    }
}

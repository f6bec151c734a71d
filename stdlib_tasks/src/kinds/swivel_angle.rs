//! Turns the elbow about the line from shoulder to wrist.
//!
//! ```text
//! a = z,  b = s - e,  c = s - w,  d = e - w                              thesis (3.35)-(3.38)
//! cos φ = (a×c)·(b×d) / (|a×c| |b×d|),   sgn φ = sgn((a×b)·c)            thesis (3.39)
//! ```
//!
//! `A = a×c` and `B = b×d = c×d` are the normals of the vertical plane through shoulder and wrist and of the plane of
//! the arm. Both are perpendicular to `c`, so that φ is the angle from A to B about `c`, and the two equations become
//! one:
//!
//! ```text
//! φ = atan2((A×B)·c, |c| A·B)         because (A×B)·c = |c|² a·B = |c|² (a×b)·c
//! ```
//!
//! φ is pi minus the dihedral angle of the points (s + a, s, w, e), whose gradient is that of Blondel and Karplus, J.
//! Comput. Chem. 17 (1996).

use nalgebra::Vector3;
use robot::LinkId;

use crate::bound::{Arm, BoundParams, Slot};
use crate::build::check;
use crate::dimension::ANGLE;
use crate::params::{Input, ParamType, Presence};
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault,
    TaskKind,
};
use quantities::usual;

crate::params! {
    /// Parameters of `swivel_angle`.
    pub struct Params {
        /// Target angle of each arm; it may move with time.
        angle: Vec<(Arm, Slot)> = ParamType::PerArm(ANGLE), Presence::Required;
        /// k: how fast the error decays.
        gain: Input<1> = ParamType::Scalar(usual::GAIN), Presence::Default("1 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "swivel_angle",
    summary: "turns the elbow about the line from shoulder to wrist",
    docs: "One equality row for each arm, `J_sw v = φ_d' + k (φ_d - φ)` in rad/s, with the error taken the short \
way round:\n\n\
```text\n\
a = z,  b = s - e,  c = s - w,  d = e - w\n\
φ = sgn(a×b · c) arccos( (a×c)·(b×d) / (|a×c| |b×d|) )\n\n\
s, e, w    3×1  m                 positions of the arm's shoulder, elbow and wrist in the world\n\
z          3×1                    vertical axis of the world\n\
φ, φ_d     rad                    swivel angle in [-pi, pi], and its target;  φ_d' its time derivative, rad/s\n\
J_sw       1×n  rad/rad or rad/m  derivative of φ with respect to the configuration\n\
v          n×1  rad/s or m/s      velocity of the n degrees of freedom\n\
k          1/s                    gain\n\
```\n\n\
φ is the angle from the vertical plane through shoulder and wrist to the plane of the arm. It is undefined if \
the wrist is vertically above or below the shoulder, or if the arm is stretched. The row is then left free, and \
`run` counts these ticks; `initial(angle.ARM)` has no value there. The sign is that of the thesis; mirrored arms \
have opposite angles.\n\n\
Source: thesis (3.35)-(3.42). The gradient is that of the dihedral angle, checked by central differences.",
    example: "task elbows = swivel_angle { angle { left 45 deg  right 45 deg }  gain 1 /s }",
    current_values: &[CurrentValue::in_world("*", CurrentValueType::Scalar(ANGLE))],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct Row {
    name: String,
    shoulder: LinkId,
    elbow: LinkId,
    wrist: LinkId,
    target: Slot,
}

struct SwivelAngle {
    rows: Vec<Row>,
    gain: Input<1>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.angle.is_empty() {
        return Err(BuildError::new("angle", "no arm is named").help("name one, or remove the task"));
    }
    let mut rows = Vec::new();
    for (arm, target) in params.angle {
        let (Some(shoulder), Some(elbow), Some(wrist)) = (arm.shoulder, arm.elbow, arm.wrist) else {
            return Err(BuildError::new("angle", format!("arm `{}` has no shoulder, elbow and wrist", arm.name))
                .help("declare them in the robot: `arms { left { shoulder .. elbow .. wrist .. tip .. } }`"));
        };
        rows.push(Row { name: arm.name, shoulder, elbow, wrist, target });
    }
    Ok(Box::new(SwivelAngle { rows, gain: params.gain }))
}

/// A swivel angle and its gradients with respect to shoulder, elbow and wrist, in rad/m.
pub struct Swivel {
    /// The angle in [-pi, pi], rad.
    pub angle: f64,
    /// Gradient with respect to the shoulder's position.
    pub by_shoulder: Vector3<f64>,
    /// Gradient with respect to the elbow's position.
    pub by_elbow: Vector3<f64>,
    /// Gradient with respect to the wrist's position.
    pub by_wrist: Vector3<f64>,
}

/// Swivel angle of three points in the world (m). `None` if it is undefined: shoulder and wrist are closer than 1e-6 m,
/// the line between them is within 1e-4 rad of the vertical, or the distance of the elbow from that line is below 1e-4
/// of its length.
pub fn swivel(s: &Vector3<f64>, e: &Vector3<f64>, w: &Vector3<f64>) -> Option<Swivel> {
    let (up, c, d) = (Vector3::z(), s - w, e - w);
    let (a, b) = (up.cross(&c), c.cross(&d));
    let length = c.norm();
    if length < 1e-6 || a.norm() < 1e-4 * length || b.norm() < 1e-4 * length * length {
        return None;
    }
    let (a2, b2) = (a.norm_squared(), b.norm_squared());
    let by_elbow = b * (length / b2);
    // The vertical moves with the shoulder: the two parts that turn A about c cancel.
    let by_shoulder = -(a * (up.dot(&c) / (a2 * length)) + b * (d.dot(&c) / (b2 * length)));
    Some(Swivel {
        angle: a.cross(&b).dot(&c).atan2(length * a.dot(&b)),
        by_shoulder,
        by_elbow,
        // Moving all three points together changes nothing.
        by_wrist: -by_shoulder - by_elbow,
    })
}

impl Task for SwivelAngle {
    fn rows(&self) -> Vec<RowInfo> {
        self.rows.iter().map(|r| RowInfo { name: r.name.clone(), dimension: ANGLE }).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        self.rows.iter().map(|r| Measure { name: r.name.clone(), dimension: ANGLE }).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [gain] = self.gain.of(state.values);
        for (i, r) in self.rows.iter().enumerate() {
            let at = |link| state.data.pose(link).translation.vector;
            let (s, e, w) = (at(r.shoulder), at(r.elbow), at(r.wrist));
            let Some(swivel) = swivel(&s, &e, &w) else {
                *rows.undefined = true;
                rows.measures[i] = f64::NAN;
                continue;
            };
            let difference = state.values[r.target.at] - swivel.angle;
            let error = difference.sin().atan2(difference.cos());
            let row = rows.row(i);
            state.data.add_point(state.model, r.shoulder, &s, &swivel.by_shoulder, row);
            state.data.add_point(state.model, r.elbow, &e, &swivel.by_elbow, row);
            state.data.add_point(state.model, r.wrist, &w, &swivel.by_wrist, row);
            rows.equal(i, state.rates[r.target.at] + gain * error);
            rows.measures[i] = error.abs();
        }
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        let Some(r) = self.rows.iter().find(|r| r.name == name.strip_prefix("angle.").unwrap_or(name)) else {
            return false;
        };
        let at = |link| state.data.pose(link).translation.vector;
        match swivel(&at(r.shoulder), &at(r.elbow), &at(r.wrist)) {
            Some(s) => out[0] = s.angle,
            None => out[0] = f64::NAN,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Thesis (3.39), literally.
    fn printed(s: Vector3<f64>, e: Vector3<f64>, w: Vector3<f64>) -> f64 {
        let (a, b, c, d) = (Vector3::z(), s - e, s - w, e - w);
        let (ac, bd) = (a.cross(&c), b.cross(&d));
        let cosine = (ac.dot(&bd) / (ac.norm() * bd.norm())).clamp(-1.0, 1.0);
        a.cross(&b).dot(&c).signum() * cosine.acos()
    }

    fn point() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn it_is_the_angle_of_the_thesis(s in point(), e in point(), w in point()) {
            if let Some(x) = swivel(&s, &e, &w) {
                let p = printed(s, e, w);
                prop_assert!((x.angle.cos() - p.cos()).abs() < 1e-6);
                prop_assume!(p.sin().abs() > 1e-3);
                prop_assert!((x.angle - p).abs() < 1e-6, "{} and {}", x.angle, p);
            }
        }

        #[test]
        fn its_gradients_are_right(s in point(), e in point(), w in point(), d in point()) {
            let Some(x) = swivel(&s, &e, &w) else { return Ok(()) };
            let (ac, bc) = (Vector3::z().cross(&(s - w)).norm(), (e - w).cross(&(s - w)).norm());
            prop_assume!(ac > 0.05 && bc > 0.05);
            let step = 1e-6;
            let slope = |f: &dyn Fn(f64) -> Option<Swivel>| {
                let d = f(step).unwrap().angle - f(-step).unwrap().angle;
                d.sin().atan2(d.cos()) / (2.0 * step)
            };
            let numeric = slope(&|h| swivel(&(s + d * h), &e, &w));
            prop_assert!((numeric - x.by_shoulder.dot(&d)).abs() < 1e-4);
            let numeric = slope(&|h| swivel(&s, &(e + d * h), &w));
            prop_assert!((numeric - x.by_elbow.dot(&d)).abs() < 1e-4);
            let numeric = slope(&|h| swivel(&s, &e, &(w + d * h)));
            prop_assert!((numeric - x.by_wrist.dot(&d)).abs() < 1e-4);
        }
    }
}

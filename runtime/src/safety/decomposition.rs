//! Contribution of each input to the rate of the safety field: thesis (4.15)-(4.21).
//!
//! The robot is assumed to follow the law of the protected task,
//!
//! ```text
//! v = J^+ (eta u_c + Psi u_a + b) + N u_n      b = K e - T de,  J^+ = J^T (J J^T + l^2 I)^-1,  N = I - J^+ J
//! ```
//!
//! so that with `g = dF/dq` and `y = (J J^T + l^2 I)^-1 J g`
//!
//! ```text
//! dF/dt = mu_1 u_c + mu_2 . u_a + mu_3 . u_n + mu_4
//! mu_1 = y . eta    mu_2 = Psi^T y    mu_3 = g - J^T y    mu_4 = y . b + (rate by the people)
//! ```
//!
//! (mu_3 has one entry for each degree of freedom, correction 9.) One Cholesky factorisation yields all of these. Since
//! `y` is the same everywhere, the sum is exactly the dF/dt of the law, damped or not.
//!
//! Damping: `l` is zero while every pivot of `J J^T`, the squared distance of a row from those before it, is at least
//! `s^2`; below, `l^2 = l_max^2 (1 - pivot / s^2)^2` (Nakamura and Hanafusa 1986, with the smallest pivot in place of
//! the manipulability), continuous in the configuration. `N` is then not a projector but
//! `I - J^T (J J^T + l^2 I)^-1 J`, whose eigenvalues lie between 0 and 1: motion that the task can no longer perform
//! becomes internal motion.

use nalgebra::Vector3;

use stdlib_tasks::field::{SafetyError, finite, setting};

/// Threshold and strength of the damping of `J J^T`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// s: distance of a row from the others below which damping begins, in the unit of a row (m or rad, per rad or m).
    pub below: f64,
    /// l_max: damping for a row that depends on others completely, in the same unit.
    pub strongest: f64,
}

impl Default for Damping {
    fn default() -> Self {
        Damping { below: 0.03, strongest: 0.03 }
    }
}

/// The protected task at a tick. All slices belong to the caller.
#[derive(Clone, Copy, Debug)]
pub struct TaskRows<'a> {
    /// J, row-major, with `stride` numbers per row, of which the first n are used.
    pub jacobian: &'a [f64],
    /// Number of numbers from one row to the next.
    pub stride: usize,
    /// eta: the rates of the nominal target along its clock, m numbers; thesis (4.6).
    pub eta: &'a [f64],
    /// K e: feedback of the task for its error from the target at this tick, m numbers.
    pub feedback: &'a [f64],
}

impl<'a> TaskRows<'a> {
    /// Row `i` of the Jacobian, n numbers.
    pub(super) fn row(&self, i: usize, n: usize) -> &'a [f64] {
        &self.jacobian[i * self.stride..i * self.stride + n]
    }
}

/// A column of Psi: a deviation input acts on three rows of the task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// The first of the three rows.
    pub row: usize,
    /// psi: rates of these rows for an input of one.
    pub along: Vector3<f64>,
}

/// The decomposition with its storage, for a task of m rows, n degrees of freedom and k inputs.
#[derive(Clone, Debug)]
pub struct Decomposition {
    damping: Damping,
    rows: usize,
    /// Lower triangle of the factor, row-major.
    factor: Vec<f64>,
    y: Vec<f64>,
    /// Contribution of the clock.
    pub mu_1: f64,
    /// Contribution of each deviation input.
    pub mu_2: Vec<f64>,
    /// Contribution of each internal velocity.
    pub mu_3: Vec<f64>,
    /// Contribution that cannot be chosen: the task's feedback, the springs, the people.
    pub mu_4: f64,
    /// l^2 of this tick; zero away from singularities.
    pub damped: f64,
}

impl Decomposition {
    /// Allocates the storage.
    ///
    /// # Errors
    /// [`SafetyError::Setting`] for a damping that is not positive.
    pub fn new(rows: usize, dofs: usize, inputs: usize, damping: Damping) -> Result<Decomposition, SafetyError> {
        for (name, value) in [("below", damping.below), ("strongest", damping.strongest)] {
            setting(name, value, value > 0.0 && value.is_finite(), "positive and finite")?;
        }
        Ok(Decomposition {
            damping,
            rows,
            factor: vec![0.0; rows * rows],
            y: vec![0.0; rows],
            mu_1: 0.0,
            mu_2: vec![0.0; inputs],
            mu_3: vec![0.0; dofs],
            mu_4: 0.0,
            damped: 0.0,
        })
    }

    /// Factorises `J J^T` and computes `y` and `mu_3` for the gradient `g` (n numbers). Never allocates.
    ///
    /// # Errors
    /// [`SafetyError::Shape`] if slices do not fit, [`SafetyError::NotFinite`].
    pub fn factorise(&mut self, task: &TaskRows, g: &[f64]) -> Result<(), SafetyError> {
        let (m, n) = (self.rows, self.mu_3.len());
        if task.eta.len() != m || task.feedback.len() != m {
            return Err(SafetyError::Shape { name: "task rows" });
        }
        let needed = if m == 0 { 0 } else { (m - 1) * task.stride + n };
        if g.len() != n || (m > 1 && task.stride < n) || task.jacobian.len() < needed {
            return Err(SafetyError::Shape { name: "task Jacobian" });
        }
        finite("field gradient", g)?;
        finite("task rates", task.eta)?;
        finite("task feedback", task.feedback)?;
        self.damped = 0.0;
        let least = self.cholesky(task, n, 0.0)?;
        let s2 = self.damping.below * self.damping.below;
        if least < s2 {
            let share = 1.0 - least.max(0.0) / s2;
            self.damped = (self.damping.strongest * share).powi(2);
            self.cholesky(task, n, self.damped)?;
        }
        for i in 0..m {
            self.y[i] = dot(task.row(i, n), g);
        }
        solve(&self.factor, &mut self.y);
        self.mu_3.copy_from_slice(g);
        for (i, y) in self.y.iter().enumerate() {
            axpy(-y, task.row(i, n), &mut self.mu_3);
        }
        finite("decomposition", &self.mu_3)
    }

    /// Computes the factor of `J J^T + damping I` and returns the smallest pivot. A pivot that is not positive, which
    /// occurs only without damping, ends the factorisation; that factor is not used.
    fn cholesky(&mut self, task: &TaskRows, n: usize, damping: f64) -> Result<f64, SafetyError> {
        let m = self.rows;
        let mut least = f64::INFINITY;
        for i in 0..m {
            for j in 0..=i {
                let (before, rest) = self.factor.split_at_mut(i * m);
                let own = &mut rest[..m];
                let other = if j < i { &before[j * m..j * m + j] } else { &[][..] };
                let product = dot(task.row(i, n), task.row(j, n));
                if j < i {
                    let sum = product - dot(&own[..j], other);
                    own[j] = sum / before[j * m + j];
                } else {
                    let pivot = product + damping - dot(&own[..i], &own[..i]);
                    if !pivot.is_finite() {
                        return Err(SafetyError::NotFinite { name: "task Jacobian" });
                    }
                    least = least.min(pivot);
                    if pivot <= 0.0 {
                        return Ok(pivot);
                    }
                    own[i] = pivot.sqrt();
                }
            }
        }
        Ok(least)
    }

    /// Gradient of the field in the task's own rows, `(J^+)^T g`; m numbers.
    pub fn task_gradient(&self) -> &[f64] {
        &self.y
    }

    /// Computes the other mu after [`Decomposition::factorise`]. `springs` is `T de`, m numbers; `human_rate` is the
    /// contribution of the people.
    ///
    /// # Errors
    /// [`SafetyError::Shape`] if a push exceeds the rows, [`SafetyError::NotFinite`].
    pub fn split(
        &mut self,
        task: &TaskRows,
        pushes: &[Push],
        springs: &[f64],
        human_rate: f64,
    ) -> Result<(), SafetyError> {
        if pushes.len() != self.mu_2.len() || springs.len() != self.rows || task.eta.len() != self.rows {
            return Err(SafetyError::Shape { name: "deviations" });
        }
        self.mu_1 = dot(&self.y, task.eta);
        self.mu_4 = dot(&self.y, task.feedback) - dot(&self.y, springs) + human_rate;
        for (mu, push) in self.mu_2.iter_mut().zip(pushes) {
            let Some(y) = self.y.get(push.row..push.row + 3) else {
                return Err(SafetyError::Shape { name: "deviations" });
            };
            *mu = dot(y, push.along.as_slice());
        }
        finite("decomposition", &[self.mu_1, self.mu_4])?;
        finite("decomposition", &self.mu_2)
    }

    /// Velocity of the law: writes `J^+ r + N u` into `v` (n numbers, which contain `u` on entry); `r` has m numbers
    /// and is overwritten. Uses the last factorisation.
    pub fn law(&self, task: &TaskRows, r: &mut [f64], v: &mut [f64]) {
        let n = self.mu_3.len();
        for (i, r) in r.iter_mut().enumerate() {
            *r -= dot(task.row(i, n), v);
        }
        solve(&self.factor, r);
        for (i, r) in r.iter().enumerate() {
            axpy(*r, task.row(i, n), v);
        }
    }
}

/// Solves `L L^T x = b` in place.
fn solve(factor: &[f64], b: &mut [f64]) {
    let m = b.len();
    for i in 0..m {
        b[i] = (b[i] - dot(&factor[i * m..i * m + i], &b[..i])) / factor[i * m + i];
    }
    for i in (0..m).rev() {
        b[i] /= factor[i * m + i];
        let x = b[i];
        axpy(-x, &factor[i * m..i * m + i], &mut b[..i]);
    }
}

/// Sum of products.
#[inline]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `y += s x`
#[inline]
pub(super) fn axpy(s: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    struct Case {
        j: DMatrix<f64>,
        flat: Vec<f64>,
        eta: Vec<f64>,
        feedback: Vec<f64>,
        g: Vec<f64>,
    }

    fn case(m: usize, n: usize, x: &[f64]) -> Case {
        let j = DMatrix::from_fn(m, n, |i, k| x[i * n + k]);
        let flat = (0..m * n).map(|i| j[(i / n, i % n)]).collect();
        let (eta, feedback) = (x[300..300 + m].to_vec(), x[330..330 + m].to_vec());
        Case { j, flat, eta, feedback, g: x[360..360 + n].to_vec() }
    }

    proptest! {
        /// The sum of the parts is dF/dt for the velocity of the law, and that velocity is the textbook's, at full
        /// rank, at rank zero, and between.
        #[test]
        fn the_parts_add_up(
            m in 3usize..13, n in 1usize..18, weak in -10.0..0.0f64,
            x in prop::collection::vec(-1.0..1.0f64, 400), u in prop::collection::vec(-1.0..1.0f64, 22),
        ) {
            let mut x = x;
            // The last row tends to the first as `weak` falls.
            for k in 0..n {
                x[(m - 1) * n + k] = x[k] + 10f64.powf(weak) * x[(m - 1) * n + k];
            }
            let c = case(m, n, &x);
            let task = TaskRows { jacobian: &c.flat, stride: n, eta: &c.eta, feedback: &c.feedback };
            let pushes = [Push { row: 0, along: Vector3::new(u[0], u[1], u[2]) }, Push { row: m - 3, along: Vector3::x() }];
            let springs = &x[380..380 + m];
            let Ok(mut parts) = Decomposition::new(m, n, 2, Damping::default()) else { panic!() };
            prop_assert_eq!(parts.factorise(&task, &c.g), Ok(()));
            prop_assert_eq!(parts.split(&task, &pushes, springs, 0.25), Ok(()));

            let (u_c, u_a, u_n) = (u[3].abs(), [u[4], u[5]], &u[4..4 + n]);
            let mut r: Vec<f64> = (0..m).map(|i| c.eta[i] * u_c + c.feedback[i] - springs[i]).collect();
            for (push, u) in pushes.iter().zip(u_a) {
                (0..3).for_each(|i| r[push.row + i] += push.along[i] * u);
            }
            let damped = &c.j * c.j.transpose() + DMatrix::identity(m, m) * parts.damped;
            let mut v = u_n.to_vec();
            let mut work = r.clone();
            parts.law(&task, &mut work, &mut v);
            let rate = dot(&c.g, &v) + 0.25;
            let sum = parts.mu_1 * u_c + dot(&parts.mu_2, &u_a) + dot(&parts.mu_3, u_n) + parts.mu_4;
            prop_assert!((rate - sum).abs() < 1e-9 * (1.0 + rate.abs() + sum.abs()), "{rate} {sum}");

            let Some(inverse) = damped.clone().try_inverse() else { return Ok(()) };
            let un = DVector::from_column_slice(u_n);
            let expected = &un + c.j.transpose() * &inverse * (DVector::from_vec(r) - &c.j * &un);
            for i in 0..n {
                prop_assert!((v[i] - expected[i]).abs() < 1e-6 * (1.0 + expected.norm()), "{} {}", v[i], expected[i]);
            }
            // Internal motion never grows, and does not move the task if nothing is damped.
            let inner = &un - c.j.transpose() * &inverse * &c.j * &un;
            prop_assert!(inner.norm() <= un.norm() * (1.0 + 1e-6));
            if parts.damped == 0.0 {
                prop_assert!((&c.j * inner).norm() < 1e-9);
            }
        }

        /// The decomposition is continuous where damping begins, and down to a row that depends on another.
        #[test]
        fn damping_has_no_jumps(x in prop::collection::vec(-1.0..1.0f64, 400)) {
            let (m, n) = (3, 6);
            let Ok(mut parts) = Decomposition::new(m, n, 0, Damping::default()) else { panic!() };
            let mut before: Option<Vec<f64>> = None;
            for step in 0..2000 {
                let mut y = x.clone();
                for k in 0..n {
                    y[2 * n + k] = x[k] + 1e-4 * f64::from(step) * x[2 * n + k];
                }
                let c = case(m, n, &y);
                let task = TaskRows { jacobian: &c.flat, stride: n, eta: &c.eta, feedback: &c.feedback };
                prop_assert_eq!(parts.factorise(&task, &c.g), Ok(()));
                if let Some(b) = &before {
                    let jump = b.iter().zip(&parts.mu_3).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    prop_assert!(jump < 0.05, "{jump} at {step}");
                }
                before = Some(parts.mu_3.clone());
            }
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let Ok(mut parts) = Decomposition::new(3, 4, 1, Damping::default()) else { panic!() };
        let (j, b) = ([0.5; 12], [0.0; 3]);
        let task = TaskRows { jacobian: &j, stride: 4, eta: &b, feedback: &b };
        assert_eq!(parts.factorise(&task, &[1.0; 4]), Ok(()), "rows that all depend are damped");
        assert!(parts.damped > 0.0);
        let push = Push { row: 1, along: Vector3::x() };
        assert!(parts.split(&task, &[push], &b, 0.0).is_err(), "rows 1..4 of 3");
        assert!(parts.factorise(&task, &[1.0; 3]).is_err());
        assert!(parts.factorise(&TaskRows { jacobian: &j[..11], ..task }, &[1.0; 4]).is_err());
        let nan = [f64::NAN; 12];
        assert!(parts.factorise(&TaskRows { jacobian: &nan, ..task }, &[1.0; 4]).is_err());
        assert!(parts.factorise(&task, &[f64::INFINITY; 4]).is_err());
        assert!(parts.factorise(&TaskRows { eta: &[0.0; 2], ..task }, &[1.0; 4]).is_err());
        assert!(Decomposition::new(3, 4, 1, Damping { below: 0.0, strongest: 1.0 }).is_err());
    }
}

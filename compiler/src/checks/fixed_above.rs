//! Targets that never move anything, because targets on levels above fix the same motion: a hand that is held above the level
//! at which it is led.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use nalgebra::{DMatrix, RowDVector};
use runtime::Member;
use solver::Problem;
use stdlib_tasks::task::RowKind;

use super::Checked;
use crate::analysis::stacks::{RANDOM, Signals};

/// Singular values below this share of the largest count as zero.
const RANK: f64 = 1e-6;

/// Share of a row that the levels above leave, up to which it counts as fixed by them.
const FIXED: f64 = 1e-5;

/// Warns of targets that the levels above fix at all configurations, once for all stacks.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for stack in 0..c.program.stacks.len() {
        // A level without any freedom was reported.
        let spans = &c.places.stacks[stack].1;
        if out.iter().any(|d| d.code == "HQ0604" && spans.contains(&d.primary.span)) {
            continue;
        }
        let Some(fixed) = fixed(c, stack) else { continue };
        for Fixed { member, above, level_above } in fixed {
            if !told.insert(member.program_index) {
                continue;
            }
            let spans = &c.places.stacks[stack].1;
            let text =
                format!("`{}` cannot move anything: `{above}`, on a level above, fixes the same motion", member.name);
            out.push(
                Diagnostic::warning("HQ0613", spans[member.level], text)
                    .label(spans[level_above], format!("`{above}` has priority"))
                    .note("a lower level uses only the motions that do not change the targets above")
                    .help("put it on a level above, or remove what fixes its motion"),
            );
        }
    }
}

/// A target that levels above fix.
struct Fixed {
    member: Member,
    /// Name of a target above that moves the same joints.
    above: String,
    level_above: usize,
}

/// Targets of a stack that the levels above fix. `None` if the rows are undefined at a configuration.
fn fixed(c: &Checked, stack: usize) -> Option<Vec<Fixed>> {
    let members = c.stacks.members(stack);
    let targets: Vec<usize> = (0..members.len()).filter(|&i| members[i].row_kind == RowKind::Equality).collect();
    let first = targets.iter().map(|&i| members[i].level).min()?;
    let mut open: Vec<usize> = targets.iter().copied().filter(|&i| members[i].level > first).collect();
    let mut last = None;
    for posture in 0..=RANDOM {
        if open.is_empty() {
            break;
        }
        let sample = c.stacks.sample(stack, Signals::Present, posture)?;
        open.retain(|&i| {
            let above: Vec<usize> = targets.iter().copied().filter(|&o| members[o].level < members[i].level).collect();
            let left = left(sample.problem(), members, &above, i);
            !sample.undefined[i] && left.is_some_and(|left| left < FIXED)
        });
        last = Some(sample);
    }
    let Some(sample) = last else { return Some(Vec::new()) };
    let result = open.into_iter().filter_map(|i| {
        let own = |m: &Member| -> BTreeSet<usize> {
            let moves = |dof: &usize| sample.rows(m).any(|row| row[*dof] != 0.0);
            (0..c.program.robot.model.nv()).filter(moves).collect()
        };
        let mine = own(&members[i]);
        let above = targets.iter().copied().filter(|&o| members[o].level < members[i].level);
        let rival = above.max_by_key(|&o| own(&members[o]).intersection(&mine).count())?;
        let member = members[i].clone();
        Some(Fixed { member, above: members[rival].name.clone(), level_above: members[rival].level })
    });
    Some(result.collect())
}

/// Share of a target's rows that the rows above leave free; `None` if its own rows are zero.
fn left(problem: &Problem, members: &[Member], above: &[usize], target: usize) -> Option<f64> {
    let own = matrix(problem, members, &[target]);
    let size = own.norm();
    if size == 0.0 || !size.is_finite() {
        return None;
    }
    let mut free = own;
    for direction in row_space(matrix(problem, members, above))? {
        let along = &free * direction.transpose();
        free -= along * direction;
    }
    Some(free.norm() / size)
}

/// Rows of some members, one below the other.
fn matrix(problem: &Problem, members: &[Member], of: &[usize]) -> DMatrix<f64> {
    let rows = |&i: &usize| members[i].rows.clone().map(move |r| (members[i].level, r));
    let rows: Vec<&[f64]> = of.iter().flat_map(rows).map(|(level, r)| problem.levels[level].row(r)).collect();
    DMatrix::from_fn(rows.len(), problem.n, |i, j| rows[i][j])
}

/// Orthonormal directions that rows span; `None` if a number is not finite.
fn row_space(rows: DMatrix<f64>) -> Option<Vec<RowDVector<f64>>> {
    if rows.is_empty() {
        return Some(Vec::new());
    }
    if rows.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let svd = rows.svd(false, true);
    let (v_t, largest) = (svd.v_t?, svd.singular_values.max());
    let spans = svd.singular_values.iter().enumerate().filter(|(_, s)| **s > RANK * largest);
    Some(spans.map(|(k, _)| v_t.row(k).into_owned()).collect())
}

/// For each level of a stack, the number of degrees of freedom that the targets above it fix at home. `None` if the rows are
/// not defined there.
pub(super) fn fixed_at_home(c: &Checked, stack: usize) -> Option<Vec<usize>> {
    fixed_by_targets_above(c.stacks.sample(stack, Signals::Absent, 0)?.problem(), c.stacks.members(stack))
}

/// For each level, the number of degrees of freedom that the targets above it fix. `None` if a row is not finite.
pub(super) fn fixed_by_targets_above(problem: &Problem, members: &[Member]) -> Option<Vec<usize>> {
    let above = |level: usize| -> Vec<usize> {
        let target = |i: &usize| members[*i].row_kind == RowKind::Equality && members[*i].level < level;
        (0..members.len()).filter(target).collect()
    };
    (0..problem.levels.len())
        .map(|level| row_space(matrix(problem, members, &above(level))).map(|space| space.len()))
        .collect()
}

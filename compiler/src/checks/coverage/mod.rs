//! Coverage: a table of the limits that each stack keeps, and errors where a `coverage` of the spec demands more.

mod atoms;
mod report;
mod table;

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use runtime::program::Program;
use stdlib_tasks::task::RowKind;

pub use table::{Firmness, Guard, Hold, JointCoverage, KeptFrom, PersonPoint, StackCoverage};

use super::Checked;
use crate::demands::{CoverageDemands, Demand, Demanded, JointQuantity};
use atoms::{Atom, atoms, held};
use report::Gap;

/// Reports the demands that are not met, that are about nothing, and that are repeated.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut tables = Tables::default();
    let mut earlier: Vec<Written> = Vec::new();
    for coverage in &c.places.coverage {
        let stacks = covered(c, coverage, &mut tables, out);
        for demand in &coverage.demands {
            if let Demanded::Limit { task, .. } = demand.of
                && !readings_limit(c.program, task)
            {
                out.push(report::no_limit(c, demand, task));
                continue;
            }
            let mut own = BTreeSet::new();
            let mut gaps: Vec<Gap> = Vec::new();
            for &stack in &stacks {
                let table = tables.of(c, stack);
                let atoms = atoms(demand, table, c.program);
                let (mut missing, mut weak) = (Vec::new(), Vec::new());
                for atom in &atoms {
                    match held(*atom, table, c.program) {
                        None => missing.push(*atom),
                        Some(hold) if !suffices(hold, demand) => weak.push((*atom, hold)),
                        Some(_) => {}
                    }
                }
                own.extend(atoms.into_iter().map(|atom| (stack, atom)));
                if missing.is_empty() && weak.is_empty() {
                    continue;
                }
                match gaps.iter_mut().find(|g| g.is_like(&missing, &weak)) {
                    Some(same) => same.stacks.push(stack),
                    None => gaps.push(Gap { stacks: vec![stack], missing, weak }),
                }
            }
            out.extend(gaps.iter().map(|gap| report::unmet(c, demand, gap, &tables)));
            if own.is_empty() && !stacks.is_empty() {
                out.push(report::vacuous(demand, coverage));
            }
            earlier.push(Written { demand, atoms: own });
        }
    }
    repetitions(&earlier, out);
}

/// True if a coverage demands limits of all joints of a stack, so that this check says what is missing.
pub(super) fn demands_of_joints(c: &Checked, stack: usize, quantity: JointQuantity) -> bool {
    let covers = |coverage: &&CoverageDemands| {
        coverage.stacks.as_ref().is_none_or(|named| named.iter().any(|of| of.stacks.contains(&stack)))
    };
    let demands = |d: &Demand| matches!(d.of, Demanded::Joints(of, None) if of == quantity);
    c.places.coverage.iter().filter(covers).any(|coverage| coverage.demands.iter().any(demands))
}

/// Coverage of stacks, computed once for each.
#[derive(Default)]
struct Tables(BTreeMap<usize, StackCoverage>);

impl Tables {
    fn of(&mut self, c: &Checked, stack: usize) -> &StackCoverage {
        self.0.entry(stack).or_insert_with(|| StackCoverage::among(c.program, &c.stacks, stack))
    }
}

/// Stacks that have to meet the demands of a coverage, each once.
fn covered(c: &Checked, coverage: &CoverageDemands, tables: &mut Tables, out: &mut Vec<Diagnostic>) -> Vec<usize> {
    let mut stacks: Vec<usize> = Vec::new();
    match &coverage.stacks {
        None => {
            stacks.extend(c.program.entered_stacks().into_iter().filter(|&s| tables.of(c, s).moves));
            if stacks.is_empty() {
                out.push(report::nothing_moves(coverage));
            }
        }
        Some(named) => {
            for of in named {
                if of.stacks.is_empty() {
                    out.push(report::no_stack(of));
                }
                stacks.extend(&of.stacks);
            }
        }
    }
    stacks.sort_unstable();
    stacks.dedup();
    stacks
}

fn suffices(hold: Hold, demand: &Demand) -> bool {
    hold.firmness == Firmness::Hard || (!demand.hard && hold.firmness == Firmness::Soft)
}

/// True for a task that limits, or that protects people.
fn readings_limit(program: &Program, task: usize) -> bool {
    let kind = stdlib_tasks::find(&program.tasks[task].kind);
    kind.is_some_and(|k| k.row_kind == RowKind::Inequality || k.person_velocity.is_some())
}

/// A demand with all that it demands.
struct Written<'d> {
    demand: &'d Demand,
    atoms: BTreeSet<(usize, Atom)>,
}

impl Written<'_> {
    /// True if another demand asks for all of this one.
    fn is_part_of(&self, other: &Written) -> bool {
        (other.demand.hard || !self.demand.hard) && self.atoms.is_subset(&other.atoms)
    }
}

/// Warns of demands that another demand contains.
fn repetitions(all: &[Written], out: &mut Vec<Diagnostic>) {
    for (i, later) in all.iter().enumerate().filter(|(_, w)| !w.atoms.is_empty()) {
        for earlier in all[..i].iter().filter(|w| !w.atoms.is_empty()) {
            if later.is_part_of(earlier) {
                out.push(report::repeated(later.demand, earlier.demand));
                break;
            }
            if earlier.is_part_of(later) {
                out.push(report::repeated(earlier.demand, later.demand));
                break;
            }
        }
    }
}

//! Searches a valuation at which some conditions hold and others do not: values are chosen one after another, and
//! formulas are evaluated as far as they are determined.

use super::{Conditions, Formula, Relation, Truth, Value};

/// Values of the conditions' variables; `None` where a value does not matter.
type Valuation = Vec<Option<Value>>;

/// Result of a search.
#[derive(Clone, Debug)]
pub(crate) enum Search {
    /// All requirements are met at some valuation.
    Found,
    /// No valuation meets them.
    Impossible,
    /// Nothing was proven with the permitted effort.
    TooLarge,
}

impl Search {
    /// True if no valuation exists.
    pub fn is_impossible(&self) -> bool {
        matches!(self, Search::Impossible)
    }
}

/// Maximum number of choices in a search.
const EFFORT: usize = 20_000;

/// Requirement: the formula holds, or does not hold (it is false, or a value is absent).
pub(crate) type Requirement<'f> = (&'f Formula, bool);

impl Conditions {
    /// Searches a valuation that meets all requirements. `restrict` can exclude values of a variable.
    pub fn search(&self, wanted: &[Requirement], restrict: impl Fn(usize, Value) -> bool) -> Search {
        let mut order = Vec::new();
        wanted.iter().for_each(|(f, _)| f.variables(&mut order));
        let related: Vec<usize> = order.iter().flat_map(|&v| self.variables[v].presences.iter().copied()).collect();
        for v in related {
            if !order.contains(&v) {
                order.push(v);
            }
        }
        let mut valuation: Valuation = vec![None; self.variables.len()];
        let mut effort = EFFORT;
        match self.choose(wanted, &order, &restrict, &mut valuation, &mut effort) {
            true => Search::Found,
            false if effort == 0 => Search::TooLarge,
            false => Search::Impossible,
        }
    }

    fn choose(
        &self,
        wanted: &[Requirement],
        order: &[usize],
        restrict: &impl Fn(usize, Value) -> bool,
        valuation: &mut Valuation,
        effort: &mut usize,
    ) -> bool {
        let mut open = false;
        for (formula, holds) in wanted {
            match formula.evaluate(valuation) {
                Some(truth) if (truth == Truth::Yes) != *holds => return false,
                Some(_) => {}
                None => open = true,
            }
        }
        let Some((&v, rest)) = order.split_first() else { return !open };
        for &value in self.variables[v].domain.iter().filter(|x| restrict(v, **x)) {
            *effort = effort.saturating_sub(1);
            if *effort == 0 {
                return false;
            }
            valuation[v] = Some(value);
            if self.is_consistent(valuation, v) && self.choose(wanted, rest, restrict, valuation, effort) {
                return true;
            }
        }
        valuation[v] = None;
        false
    }

    /// True if value `v` does not contradict the presence of the signals that it, or another value, depends on.
    fn is_consistent(&self, valuation: &Valuation, v: usize) -> bool {
        let agrees = |k: usize| {
            let (Some(value), of) = (valuation[k], &self.variables[k]) else { return true };
            let known: Vec<Option<Value>> = of.presences.iter().map(|&p| valuation[p]).collect();
            let missing = known.contains(&Some(Value::Truth(false)));
            let whole = of.total && known.iter().all(|p| *p == Some(Value::Truth(true)));
            match value {
                Value::Absent => !whole,
                _ => !missing,
            }
        };
        agrees(v) && (0..self.variables.len()).filter(|&k| self.variables[k].presences.contains(&v)).all(agrees)
    }
}

impl Formula {
    /// Its truth value, if the values that are known determine it.
    pub fn evaluate(&self, valuation: &[Option<Value>]) -> Option<Truth> {
        let of = |yes: bool| Some(if yes { Truth::Yes } else { Truth::No });
        match self {
            Formula::Constant(truth) => Some(*truth),
            Formula::Flag(v) => match valuation[*v]? {
                Value::Truth(yes) => of(yes),
                Value::Number(_) | Value::Absent => Some(Truth::Absent),
            },
            Formula::Compare(v, relation, than) => match valuation[*v]? {
                Value::Number(x) => of(match relation {
                    Relation::Less => x < *than,
                    Relation::LessEqual => x <= *than,
                    Relation::Greater => x > *than,
                    Relation::GreaterEqual => x >= *than,
                }),
                Value::Truth(_) | Value::Absent => Some(Truth::Absent),
            },
            Formula::Not(a) => a.evaluate(valuation).map(|truth| match truth {
                Truth::Yes => Truth::No,
                Truth::No => Truth::Yes,
                Truth::Absent => Truth::Absent,
            }),
            Formula::And(both) => match both[0].evaluate(valuation)? {
                Truth::Yes => both[1].evaluate(valuation),
                other => Some(other),
            },
            Formula::Or(both) => match both[0].evaluate(valuation)? {
                Truth::No => both[1].evaluate(valuation),
                other => Some(other),
            },
            Formula::If(all) => {
                let [test, yes, no] = all.as_ref();
                match test.evaluate(valuation)? {
                    Truth::Yes => yes.evaluate(valuation),
                    Truth::No => no.evaluate(valuation),
                    Truth::Absent => Some(Truth::Absent),
                }
            }
        }
    }
}

//! Searches a valuation at which some conditions hold and others do not: values are chosen one after another, and
//! formulas are evaluated as far as they are determined. Only the constants of the conditions in question divide the
//! axes, and conditions that share no value are searched apart.

use std::collections::BTreeMap;

use super::{Conditions, Formula, Key, Relation, Truth, Value};
use crate::expr::Interval;

/// Values of the conditions' variables; `None` where a value does not matter.
type Valuation = Vec<Option<Value>>;

/// Result of a search.
#[derive(Clone, Debug)]
pub(crate) enum Search {
    /// All requirements are met at some valuation: the values that matter.
    Found(Vec<(usize, Value)>),
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

/// Requirement on a valuation.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Claim<'f> {
    /// The formula holds.
    Holds(&'f Formula),
    /// The formula does not hold: it is false, or a value is absent.
    Fails(&'f Formula),
}

impl<'f> Claim<'f> {
    /// Its formula.
    fn formula(&self) -> &'f Formula {
        match self {
            Claim::Holds(formula) | Claim::Fails(formula) => formula,
        }
    }

    /// True if it is met, false if it is not; `None` if the values that are known do not determine it.
    fn evaluate(&self, valuation: &[Option<Value>]) -> Option<bool> {
        match self {
            Claim::Holds(f) => f.evaluate(valuation).map(|truth| truth == Truth::Yes),
            Claim::Fails(f) => f.evaluate(valuation).map(|truth| truth != Truth::Yes),
        }
    }
}

/// Requirements that share values, with the values in the order in which they are chosen.
#[derive(Default)]
struct Part {
    claims: Vec<usize>,
    order: Vec<usize>,
}

/// A search in one part.
struct Choice<'c, 'f> {
    conditions: &'c Conditions,
    claims: Vec<&'c Claim<'f>>,
    order: &'c [usize],
    domains: Vec<Vec<Value>>,
    valuation: &'c mut Valuation,
}

impl Conditions {
    /// Searches a valuation that meets all requirements. Values outside of `ranges` are excluded; `effort` is reduced by
    /// the number of choices.
    pub fn search_within(&self, claims: &[Claim], ranges: &BTreeMap<usize, Interval>, effort: &mut usize) -> Search {
        let mut valuation: Valuation = vec![None; self.variables.len()];
        let mut thresholds: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        claims.iter().for_each(|c| c.formula().thresholds(&mut thresholds));
        let mut permitted = EFFORT.min(*effort);
        let before = permitted;
        let mut large = false;
        for part in self.parts(claims) {
            let domain = |&v: &usize| {
                let range = ranges.get(&v).copied().unwrap_or(Interval::ALL);
                self.domain(v, thresholds.get(&v).map_or(&[][..], Vec::as_slice), range)
            };
            let mut choice = Choice {
                conditions: self,
                claims: part.claims.iter().map(|&c| &claims[c]).collect(),
                order: &part.order,
                domains: part.order.iter().map(domain).collect(),
                valuation: &mut valuation,
            };
            if !choice.choose(0, &mut permitted) {
                if permitted > 0 {
                    *effort -= before - permitted;
                    return Search::Impossible;
                }
                large = true;
                break;
            }
        }
        *effort -= before - permitted;
        if large {
            return Search::TooLarge;
        }
        Search::Found(valuation.into_iter().enumerate().filter_map(|(v, x)| Some((v, x?))).collect())
    }

    /// Searches a valuation that meets all requirements.
    pub fn search(&self, claims: &[Claim]) -> Search {
        self.search_within(claims, &BTreeMap::new(), &mut EFFORT.clone())
    }

    /// Possible values of a variable, one for each cell between the thresholds.
    fn domain(&self, v: usize, thresholds: &[f64], range: Interval) -> Vec<Value> {
        let of = &self.variables[v];
        let mut domain = match of.key {
            Key::Present(_) if !of.may_lack => return vec![Value::Truth(true)],
            Key::Present(_) => return vec![Value::Truth(true), Value::Truth(false)],
            Key::Flag(_) => vec![Value::Truth(true), Value::Truth(false)],
            Key::Number(_) => cells(thresholds, of.range, range),
        };
        if of.may_lack {
            domain.push(Value::Absent);
        }
        domain
    }

    /// Groups requirements that share values, or values whose signals are the same.
    fn parts(&self, claims: &[Claim]) -> Vec<Part> {
        // Each variable refers to one of its group, the first one to itself.
        let mut group: BTreeMap<usize, usize> = BTreeMap::new();
        fn first(group: &BTreeMap<usize, usize>, mut v: usize) -> usize {
            while let Some(&up) = group.get(&v).filter(|&&up| up != v) {
                v = up;
            }
            v
        }
        let mut lists: Vec<Vec<usize>> = Vec::with_capacity(claims.len());
        for claim in claims {
            let mut own = Vec::new();
            claim.formula().variables(&mut own);
            let mut all = Vec::new();
            for &v in &own {
                // The presences of its signals come right behind a value, so that a contradiction shows at once.
                for v in [v].into_iter().chain(self.variables[v].presences.iter().copied()) {
                    if !all.contains(&v) {
                        all.push(v);
                    }
                }
            }
            for &v in &all {
                group.entry(v).or_insert(v);
                let (a, b) = (first(&group, all[0]), first(&group, v));
                group.insert(b.max(a), a.min(b));
            }
            lists.push(all);
        }
        let mut parts: BTreeMap<Option<usize>, Part> = BTreeMap::new();
        for (c, all) in lists.into_iter().enumerate() {
            let part = parts.entry(all.first().map(|&v| first(&group, v))).or_default();
            part.claims.push(c);
            for v in all {
                if !part.order.contains(&v) {
                    part.order.push(v);
                }
            }
        }
        parts.into_values().collect()
    }
}

impl Choice<'_, '_> {
    /// Chooses the values from position `at` on. Returns false if there is no valuation, or the effort is at its end.
    fn choose(&mut self, at: usize, effort: &mut usize) -> bool {
        let mut open = false;
        for claim in &self.claims {
            match claim.evaluate(self.valuation) {
                Some(false) => return false,
                Some(true) => {}
                None => open = true,
            }
        }
        let Some(&v) = self.order.get(at) else { return !open };
        for k in 0..self.domains[at].len() {
            *effort = effort.saturating_sub(1);
            if *effort == 0 {
                break;
            }
            self.valuation[v] = Some(self.domains[at][k]);
            if self.is_consistent(at) && self.choose(at + 1, effort) {
                return true;
            }
        }
        self.valuation[v] = None;
        false
    }

    /// True if the value at a position does not contradict the presence of the signals that it, or another value,
    /// depends on.
    fn is_consistent(&self, at: usize) -> bool {
        let agrees = |k: usize| {
            let (Some(value), of) = (self.valuation[k], &self.conditions.variables[k]) else { return true };
            let known = || of.presences.iter().map(|&p| self.valuation[p]);
            let missing = known().any(|p| p == Some(Value::Truth(false)));
            match value {
                Value::Absent => !(of.total && known().all(|p| p == Some(Value::Truth(true)))),
                _ => !missing,
            }
        };
        let v = self.order[at];
        agrees(v) && self.order[..at].iter().all(|&k| !self.conditions.variables[k].presences.contains(&v) || agrees(k))
    }
}

/// A representative of each cell between thresholds that has numbers in both ranges.
fn cells(thresholds: &[f64], range: Interval, within: Interval) -> Vec<Value> {
    let mut sorted = thresholds.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let (least, most) = (range.low.max(within.low), range.high.min(within.high));
    let mut out = Vec::new();
    let mut low = f64::NEG_INFINITY;
    for high in sorted.into_iter().chain([f64::INFINITY]) {
        let (a, b) = (low.max(least), high.min(most));
        let inside = match (a.is_finite(), b.is_finite()) {
            (true, true) => a + 0.5 * (b - a),
            (true, false) => a + a.abs().max(1.0),
            (false, true) if b > 0.0 => 0.5 * b,
            (false, true) => b - b.abs().max(1.0),
            (false, false) => 0.0,
        };
        // The ends of the cell are cells of their own, those of the range are not.
        if a <= b && low < inside && inside < high {
            out.push(Value::Number(inside));
        }
        if high.is_finite() && least <= high && high <= most {
            out.push(Value::Number(high));
        }
        low = high;
    }
    out
}

impl Formula {
    /// Adds the constants with which it compares each value.
    fn thresholds(&self, out: &mut BTreeMap<usize, Vec<f64>>) {
        match self {
            Formula::Constant(_) | Formula::Flag(_) => {}
            Formula::Compare(v, _, than) => out.entry(*v).or_default().push(*than),
            Formula::Not(a) | Formula::Holds(a) => a.thresholds(out),
            Formula::And(both) | Formula::Or(both) => both.iter().for_each(|f| f.thresholds(out)),
            Formula::If(all) => all.iter().for_each(|f| f.thresholds(out)),
        }
    }

    /// Its truth value, if the values that are known determine it.
    pub fn evaluate(&self, valuation: &[Option<Value>]) -> Option<Truth> {
        match self {
            Formula::Constant(truth) => Some(*truth),
            Formula::Flag(v) => Some(valuation[*v]?.is_yes()),
            Formula::Compare(v, relation, than) => Some(valuation[*v]?.compared(*relation, *than)),
            Formula::Not(a) => a.evaluate(valuation).map(Truth::negated),
            Formula::Holds(a) => a.evaluate(valuation).map(|truth| Truth::of(truth == Truth::Yes)),
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

impl Value {
    /// Truth value of a comparison with a constant.
    pub fn compared(self, relation: Relation, than: f64) -> Truth {
        let Value::Number(x) = self else { return Truth::Absent };
        let holds = match relation {
            Relation::Less => x < than,
            Relation::LessEqual => x <= than,
            Relation::Greater => x > than,
            Relation::GreaterEqual => x >= than,
        };
        Truth::of(holds)
    }

    /// Its truth value.
    pub fn is_yes(self) -> Truth {
        match self {
            Value::Truth(yes) => Truth::of(yes),
            Value::Number(_) | Value::Absent => Truth::Absent,
        }
    }
}

impl Truth {
    /// The truth value of a fact.
    pub fn of(holds: bool) -> Truth {
        if holds { Truth::Yes } else { Truth::No }
    }

    /// The opposite; nothing remains nothing.
    pub fn negated(self) -> Truth {
        match self {
            Truth::Yes => Truth::No,
            Truth::No => Truth::Yes,
            Truth::Absent => Truth::Absent,
        }
    }
}

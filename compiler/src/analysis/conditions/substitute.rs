//! A formula in which known values are put in.

use super::{Formula, Truth, Value};

impl Formula {
    /// The formula for known values of some variables.
    pub fn given(&self, known: &impl Fn(usize) -> Option<Value>) -> Formula {
        match self {
            Formula::Constant(_) => self.clone(),
            Formula::Flag(v) => known(*v).map_or_else(|| self.clone(), |x| Formula::Constant(x.is_yes())),
            Formula::Compare(v, relation, than) => match known(*v) {
                Some(x) => Formula::Constant(x.compared(*relation, *than)),
                None => self.clone(),
            },
            Formula::Not(a) => match a.given(known) {
                Formula::Constant(truth) => Formula::Constant(truth.negated()),
                a => Formula::Not(Box::new(a)),
            },
            Formula::Holds(a) => match a.given(known) {
                Formula::Constant(truth) => Formula::Constant(Truth::of(truth == Truth::Yes)),
                a => Formula::Holds(Box::new(a)),
            },
            Formula::And(both) => match both[0].given(known) {
                Formula::Constant(Truth::Yes) => both[1].given(known),
                Formula::Constant(truth) => Formula::Constant(truth),
                a => Formula::And(Box::new([a, both[1].given(known)])),
            },
            Formula::Or(both) => match both[0].given(known) {
                Formula::Constant(Truth::No) => both[1].given(known),
                Formula::Constant(truth) => Formula::Constant(truth),
                a => Formula::Or(Box::new([a, both[1].given(known)])),
            },
            Formula::If(all) => match all[0].given(known) {
                Formula::Constant(Truth::Yes) => all[1].given(known),
                Formula::Constant(Truth::No) => all[2].given(known),
                Formula::Constant(Truth::Absent) => Formula::Constant(Truth::Absent),
                test => Formula::If(Box::new([test, all[1].given(known), all[2].given(known)])),
            },
        }
    }
}

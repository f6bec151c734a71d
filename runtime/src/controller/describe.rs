//! Text of faults.

use super::{Controller, TRACKING_LIMIT};
use crate::fault::Fault;

impl Controller {
    /// Describes a fault of the last tick in words.
    pub fn describe(&self, fault: &Fault) -> String {
        let stack = &self.stacks[self.active];
        let members = stack.evaluator.members();
        let task = |member: usize| members.get(member).map_or("?", |m| m.name.as_str());
        let row = |member: usize, row: usize| {
            let info = members.get(member).and_then(|m| m.row_info.get(row));
            format!("task `{}`, {}", task(member), info.map_or("a row", |r| r.name.as_str()))
        };
        let state = match self.state() {
            "" => String::new(),
            name => format!(" in state `{name}`"),
        };
        let level = |i: usize| stack.level_names().get(i).map_or("?", String::as_str);
        match *fault {
            Fault::Observation { index: Some(i) } => {
                format!("number {i} of the observed configuration is missing or not finite")
            }
            Fault::Observation { index: None } => "the observed time is not finite".to_string(),
            Fault::Deadline { gap } if gap < 0.0 => format!("the time went back by {} s", crate::text::number(-gap)),
            Fault::Deadline { gap } => {
                let ms = |x: f64| crate::text::number(x * 1e3);
                format!("a tick came {} ms after the one before, and {} ms are the most", ms(gap), ms(self.deadline))
            }
            Fault::Stale { signal } => {
                let name = self.signals.interface().signals.get(signal).map_or("?", |s| s.name.as_str());
                format!("there is no recent value of signal `{name}`")
            }
            Fault::Variable { signal } => {
                let name = self.signals.interface().signals.get(signal).map_or("?", |s| s.name.as_str());
                format!("variable `{name}` was to be set to something that is not finite")
            }
            Fault::NotFinite { member, row: r } => format!("{}: a number is not finite", row(member, r)),
            Fault::Value { at } => {
                let names = &stack.value_names;
                let name = names.iter().find(|n| n.at.contains(&at)).map_or("a parameter", |n| n.text.as_str());
                let value = stack.evaluator.value(at).unwrap_or(f64::NAN);
                let rate = stack.evaluator.rate(at).unwrap_or(f64::NAN);
                match (value.is_finite(), rate.is_finite()) {
                    (false, _) => format!("{name} has no finite value"),
                    (true, false) => format!("{name} changes infinitely fast"),
                    (true, true) => format!("{name} is {}, outside its range", crate::text::number(value)),
                }
            }
            Fault::Overlap { member, row: r } => {
                format!("{}: the parts overlap so deeply that no direction leads apart", row(member, r))
            }
            Fault::Gain { member } => {
                format!("the gain of task `{}` is negative, or overshoots within one period", task(member))
            }
            Fault::Crossed { member, row: r } => {
                format!("{}: its lower limit is above its upper one, or they close too fast", row(member, r))
            }
            Fault::Limit { member, row: r } => format!("{}: the limit is passed{state}", row(member, r)),
            Fault::Infeasible { level: l } => {
                let rows = stack.unmet(l);
                let list = if rows.is_empty() { String::new() } else { format!(": {}", rows.join(", ")) };
                format!("hard level `{}` cannot be met{state}{list}", level(l))
            }
            Fault::Solver { level: l } => format!("no usable answer for level `{}`", level(l)),
            Fault::Tracking { dof } => {
                let name = stack.evaluator.model().dofs.get(dof).map_or("?", |d| d.name.as_str());
                format!("`{name}` is more than {TRACKING_LIMIT} rad or m away from its reference")
            }
        }
    }
}

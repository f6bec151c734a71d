//! Text of faults: what is wrong, with names, and what the host can do.

use super::Controller;
use crate::fault::Fault;
use crate::text::number;

impl Controller {
    /// Describes a fault of the last tick in words.
    pub fn describe(&self, fault: &Fault) -> String {
        let stack = self.stacks.active();
        let members = stack.evaluator.members();
        let task = |member: usize| members.get(member).map_or("a task", |m| m.name.as_str());
        let row = |member: usize, row: usize| {
            let info = members.get(member).and_then(|m| m.row_info.get(row));
            format!("task `{}`, {}", task(member), info.map_or("a row", |r| r.name.as_str()))
        };
        let state = match self.state() {
            "" => String::new(),
            name => format!(" in state `{name}`"),
        };
        let level = |i: usize| match stack.level_names().get(i) {
            Some(name) => format!("level `{name}`"),
            None => "the choice of the least motion below all levels".to_string(),
        };
        let signal = |i: usize| self.signals.interface().signals.get(i).map_or("?", |s| s.name.as_str());
        let dof = |i: usize| self.model.dofs.get(i).map_or("?", |d| d.name.as_str());
        let unit = |i: usize| self.model.dofs.get(i).map_or("rad", |d| d.unit.select("m", "rad"));
        let ms = |x: f64| number(x * 1e3);
        match *fault {
            Fault::Observation { index: Some(i) } => match self.q_names.get(i) {
                Some(name) if name.contains("base_q") => {
                    format!(
                        "the quaternion of the base is missing, not finite, or not of length 1 (`{name}`): send a unit quaternion"
                    )
                }
                Some(name) => format!(
                    "the position of `{name}` is missing or not finite: its driver is silent, or sends no number"
                ),
                None => {
                    let most = self.q_names.len();
                    format!("the observed configuration has more than the robot's {most} numbers")
                }
            },
            Fault::Observation { index: None } => "the observed time is not finite".to_string(),
            Fault::Deadline { gap } if gap < 0.0 => {
                format!("the time went back by {} s: pass a clock that never does", number(-gap))
            }
            Fault::Deadline { gap } => format!(
                "a call came {} ms after the one before, and {} ms are the most: call more often, or declare a longer `deadline`",
                ms(gap),
                ms(self.clock.deadline())
            ),
            Fault::Stale { signal: i } => self.why_stale(i, signal(i)),
            Fault::Variable { signal: i } => {
                format!("variable `{}` was to be set to something that is not finite", signal(i))
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
                    (true, true) => format!("{name} is {}, outside its range", number(value)),
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
                let name = stack.level_names().get(l).map_or("?", String::as_str);
                format!("hard level `{name}` cannot be met{state}{list}")
            }
            Fault::Solver { level: l } => format!("no usable answer for {}", level(l)),
            Fault::Tracking { dof: i, told, moved } => format!(
                "`{}` does not follow: in the last moments it was told to move by {} {unit} and moved by {} {unit}; look whether its drive is \
                 enabled, blocked, turned round or scaled",
                dof(i),
                rounded(told),
                rounded(moved),
                unit = unit(i)
            ),
            Fault::Jump { dof: i, by } => format!(
                "`{}` cannot have moved by {} {} since its last reading: look at its encoder, or tell the controller that the robot was relocated",
                dof(i),
                rounded(by),
                unit(i)
            ),
            Fault::Beyond { member, row: r, by } => format!(
                "{}: the measured robot is {} beyond the limit{state}, which its reference keeps: it lags or sags; declare its lag, or raise `tracking_gain`",
                row(member, r),
                rounded(by)
            ),
        }
    }
}

impl Controller {
    /// Says why a signal has no value.
    fn why_stale(&self, signal: usize, name: &str) -> String {
        let timeout = self.signals.interface().signals.get(signal).and_then(|s| s.timeout);
        let received = self.signals.received(signal);
        match timeout {
            Some(timeout) if received.is_finite() => format!(
                "there is no recent value of signal `{name}`: the last one is {} ms old, and its `timeout` is {} ms",
                number(((self.clock.host() - received) * 1e3).round()),
                number(timeout * 1e3)
            ),
            _ if self.signals.was_refused(signal) => {
                format!(
                    "there is no recent value of signal `{name}`: the last one was no finite number, or no unit quaternion"
                )
            }
            _ => format!("there is no recent value of signal `{name}`"),
        }
    }
}

/// A number with three digits after the point, for people.
fn rounded(x: f64) -> String {
    number((x * 1e3).round() / 1e3)
}

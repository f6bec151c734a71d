//! Times, counts and the status of a plan as text on pages.

use crate::plan::{Plan, Status};

/// Formats seconds as `3:07` or `1:02:09`.
pub fn clock_time(seconds: f64) -> String {
    // The cast saturates: NaN and huge numbers become the nearest valid ones.
    let whole = (seconds.abs() + 1e-9) as u64;
    let sign = if seconds <= -1.0 { "-" } else { "" };
    match whole / 3600 {
        0 => format!("{sign}{}:{:02}", whole / 60, whole % 60),
        hours => format!("{sign}{hours}:{:02}:{:02}", whole / 60 % 60, whole % 60),
    }
}

/// Returns cost and status of a plan.
pub fn plan_status<A>(plan: &Plan<A>) -> String {
    match &plan.status {
        Status::Proven { .. } => format!("cost {:.3}, optimal ({})", plan.cost, plan.engine),
        Status::Gap { gap, .. } => {
            format!("cost {:.3}, at most {:.1} % above the minimum ({})", plan.cost, 100.0 * gap, plan.engine)
        }
        Status::Unbounded { .. } => format!("cost {:.3} ({})", plan.cost, plan.engine),
    }
}

/// Returns a participle with the number of repetitions: `not replanned`, `replanned once`, `replanned 3 times`.
pub(super) fn counted(participle: &str, n: usize) -> String {
    match n {
        0 => format!("not {participle}"),
        1 => format!("{participle} once"),
        n => format!("{participle} {n} times"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_as_on_a_clock() {
        let times = [0.0, 59.9, 60.0, 187.0, 3729.0, -0.5, -61.0].map(clock_time);
        assert_eq!(times, ["0:00", "0:59", "1:00", "3:07", "1:02:09", "0:00", "-1:01"]);
        assert_eq!(clock_time(f64::NAN), "0:00");
    }
}

//! Compares the tracking gain with what is known of the robot that it leads to the reference: one that a host drives, and its delays.
//!
//! Velocities that are sent without a gain leave the robot where its drives lead it. With a gain K, a correction begins to act after the lag, the dead
//! time and the period have passed. Up to `K (lag + dead time + period) = 0.25` such a loop does not overshoot; the default is the largest gain of
//! this kind, or less. The gain of a command that is held longer, up to the deadline, is `(1 - e^(-K dt))/dt`: it is at most `1/dt` at any K, so
//! that nothing is left to check there. Commands of positions are the reference, and no gain enters them.

use dsl::{Diagnostic, Span};
use runtime::program::{CommandForm, RosProgram};

use super::Checked;

/// Largest product of a gain and the time until a correction acts, without overshoot.
const STABLE: f64 = 0.25;

/// Warns of the tracking gain that the spec writes.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let written = |key: &str| c.expanded.robots.iter().find_map(|robot| Some(robot.body.get(key)?.value.span));
    let Some(at) = written("tracking_gain") else { return };
    let driven = c.program.run.ros.is_some();
    let commands = RosProgram::of(c.program).commands;
    let takes_velocities = commands.iter().any(|to| matches!(to.form, CommandForm::Velocity | CommandForm::Twist));
    if driven && !takes_velocities {
        return;
    }
    let robot = &c.program.robot;
    if robot.tracking_gain == 0.0 {
        out.extend(driven.then(|| absent(at)));
        return;
    }
    let delay = robot.lag + robot.dead_time + robot.period;
    let product = robot.tracking_gain * delay;
    if product > STABLE * (1.0 + 1e-9) {
        let declared = ["lag", "dead_time"].into_iter().filter_map(|key| Some((key, written(key)?)));
        let d = declared.fold(high(at, robot.tracking_gain, delay), |d, (key, span)| {
            d.label(span, format!("this {}", key.replace('_', " ")))
        });
        out.push(d);
    }
}

fn absent(at: Span) -> Diagnostic {
    Diagnostic::warning("HQ0509", at, "nothing leads the robot back to its reference")
        .here("no feedback")
        .note("a host drives this robot by velocities: what its drives lose is never made up for, and targets are reached by the reference alone, \
               which waits from 0.05 rad or m on for a robot that drifts away from it")
        .help("leave `tracking_gain` out: its default fits the `lag` and `dead_time` that are declared")
}

fn high(at: Span, gain: f64, delay: f64) -> Diagnostic {
    let most = rounded_down(STABLE / delay);
    let text = format!(
        "this tracking gain is too high for the time until it acts: {gain} /s times {} s is {:.3}",
        quantities::number(delay),
        gain * delay
    );
    Diagnostic::warning("HQ0510", at, text)
        .here(format!("at most {most} /s fits"))
        .note("a correction acts after the lag, the dead time and a period: up to 0.25 it does not overshoot, and from about 1 on the robot swings")
        .help("lower it, or leave it out: the default fits")
}

/// Rounds to two significant digits, towards zero.
fn rounded_down(x: f64) -> f64 {
    let digit = 10_f64.powi(x.log10().floor() as i32 - 1);
    format!("{:.3e}", (x / digit * (1.0 + 1e-9)).floor() * digit).parse().unwrap_or(x)
}

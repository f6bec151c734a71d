//! `hierarq ros SPEC`

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;
use hierarq::project;
use ros::{Ended, Remark, ServiceMapping, Settings};
use runtime::program::RosProgram;
use runtime::record::All;

use super::{Outcome, SpecOptions, interruption, output};

/// Largest domain for which the ports of DDS exist.
const MAX_DOMAIN: i64 = 232;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Domain of ROS 2 [default: the variable ROS_DOMAIN_ID, or 0].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=MAX_DOMAIN))]
    domain: Option<u16>,
    /// Implementation of ROS 2 that callers of services use, since each maps services in its own way [default: the variable
    /// RMW_IMPLEMENTATION, or rmw_fastrtps_cpp].
    #[arg(long, value_name = "NAME")]
    rmw: Option<String>,
    /// Duration of the run: `2s`, `500ms`; a number without a unit is in seconds [default: until it is interrupted].
    #[arg(long, value_name = "TIME", value_parser = super::duration, allow_hyphen_values = true)]
    duration: Option<f64>,
    /// Print the topics and services, and exit.
    #[arg(long)]
    topics: bool,
}

fn mapping(rmw: &str) -> Result<ServiceMapping, String> {
    match rmw {
        "rmw_fastrtps_cpp" | "rmw_fastrtps_dynamic_cpp" | "rmw_connextdds" => Ok(ServiceMapping::Enhanced),
        "rmw_cyclonedds_cpp" => Ok(ServiceMapping::Cyclone),
        other => Err(format!(
            "`{other}` is no implementation of ROS 2 over DDS: known are rmw_fastrtps_cpp, rmw_cyclonedds_cpp and rmw_connextdds"
        )),
    }
}

/// The domain of the environment.
fn domain() -> Result<u16, String> {
    let Ok(text) = std::env::var("ROS_DOMAIN_ID") else { return Ok(0) };
    let domain = text.trim().parse::<u16>().ok().filter(|n| i64::from(*n) <= MAX_DOMAIN);
    domain.ok_or_else(|| format!("ROS_DOMAIN_ID is `{text}`: write a number from 0 to {MAX_DOMAIN}"))
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let rmw = a.rmw.clone().or_else(|| std::env::var("RMW_IMPLEMENTATION").ok());
    let mapping = mapping(rmw.as_deref().unwrap_or("rmw_fastrtps_cpp"))?;
    let domain = a.domain.map_or_else(domain, Ok)?;
    let compiled = project::load(&a.spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, &a.spec, false);
    }
    output::show(&compiled.report);
    let Some(program) = compiled.program else { return output::refuse(&compiled.report, &a.spec, false) };
    if a.topics {
        output::print(&listed(&program));
        return Ok(Outcome::Good);
    }
    let params = project::params(&a.spec, &a.options.settings());
    let settings = Settings {
        domain,
        mapping,
        parameters: params.into_iter().filter_map(|p| Some((p.name, p.number?))).collect(),
        duration: a.duration,
    };
    let asked_to_end = interruption::flag();
    output::print(&listed(&program));
    let tell: ros::Tell = Arc::new(|remark: &Remark| output::eprint(&format!("{remark}\n")));
    let mut go_on = || !asked_to_end.load(Ordering::Relaxed);
    let ended = ros::run(&program, &settings, &mut All(Vec::new()), &mut go_on, &tell).map_err(|e| e.to_string())?;
    output::print(&digest(&ended, program.robot.period));
    Ok(Outcome::of(!ended.is_halted))
}

/// Topics and services, a line each.
fn listed(program: &runtime::Program) -> String {
    let mut out = String::new();
    let ros = RosProgram::of(program);
    let rows = ros::connections(program, &ros);
    let width = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    for row in rows {
        let _ = writeln!(out, "{:<9} {:<width$}  {:<32} {}", row.role, row.name, row.kind, row.content);
    }
    out
}

fn digest(ended: &Ended, period: f64) -> String {
    let mut out = format!(
        "{} ticks, {} of them late, by {:.2} ms at most; the longest computed {:.3} ms\n",
        ended.ticks,
        ended.late,
        1e3 * ended.latest,
        1e3 * ended.longest,
    );
    if let Some(rate) = ended.intervals.other_rate(period) {
        let _ = writeln!(out, "ticks came at {rate:.1} Hz, and the rate of the spec is {:.1} Hz", 1.0 / period);
    }
    if ended.not_shown > 0 {
        let _ = writeln!(out, "{} ticks were not shown, since the viewers were too slow", ended.not_shown);
    }
    if ended.is_halted {
        out.push_str("a fault that no transition handles keeps the robot still\n");
    }
    out
}

//! The scenario that a sweep runs, of a robot's controller or of a mission, and the columns that follow from it.

use compiler::Compiled;
use mission::kind::{Form, Member};
use runtime::Simulation;
use runtime::program::{ExpectationProgram, MissionProgram, Program, ScenarioProgram, Unit};
use runtime::record::roster::Roster;
use stdlib_tasks::task::RowKind;

use super::head::{Expectation, Limit, Measured, Subject};
use crate::scenario_runner::{self, Found};

/// The scenario of this name, or the only one of the spec.
///
/// # Errors
/// There is none of the name, or none at all, or several and no name; the message lists them.
pub fn choose<'c>(compiled: &'c Compiled, name: Option<&str>) -> Result<Found<'c>, String> {
    let all = || scenario_runner::scenarios(compiled.program.as_ref(), &compiled.missions);
    if let Some(name) = name {
        return scenario_runner::find(compiled.program.as_ref(), &compiled.missions, name);
    }
    let mut first = all();
    match (first.next(), first.next()) {
        (Some(only), None) => Ok(only),
        (None, _) => Err("the spec has no scenario: declare one, `scenario NAME { expect .. }`".to_string()),
        (Some(_), Some(_)) => {
            let names = compiler::names::list(all().map(Found::name), 12);
            Err(format!("the spec has several scenarios: choose one with `--scenario`, of {names}"))
        }
    }
}

/// Columns and metadata of a scenario.
pub struct Columns {
    /// Kind of the scenario.
    pub subject: Subject,
    /// Its own seed.
    pub seed: u64,
    /// Its program as JSON, for the hash of the head.
    pub bytes: Vec<u8>,
    /// Expectations, in source order.
    pub expectations: Vec<Expectation>,
    /// Limits of a controller.
    pub limits: Vec<Limit>,
    /// Measures of a mission.
    pub measures: Vec<Measured>,
}

impl Columns {
    /// The columns of a scenario.
    ///
    /// # Errors
    /// Its program cannot be executed, which never happens for a compiled one.
    pub fn of(found: Found<'_>) -> Result<Columns, String> {
        match found {
            Found::Controller(program, scenario) => Ok(Columns {
                subject: Subject::Controller,
                seed: scenario.run.simulator.seed,
                bytes: serde_json::to_vec(program).map_err(|e| e.to_string())?,
                expectations: expectations(&scenario.expectations, &scenario.units()),
                limits: limits(program, scenario)?,
                measures: Vec::new(),
            }),
            Found::Mission(mission, scenario) => Ok(Columns {
                subject: Subject::Mission,
                seed: scenario.seed,
                bytes: serde_json::to_vec(mission).map_err(|e| e.to_string())?,
                expectations: expectations(&scenario.expectations, &scenario.units()),
                limits: Vec::new(),
                measures: measures(mission),
            }),
        }
    }
}

fn expectations(of: &[ExpectationProgram], units: &[Unit]) -> Vec<Expectation> {
    let unit = |u: Unit| if let Unit::Quantity(d) = u { Some(d.to_string()) } else { None };
    let one = |e: &ExpectationProgram| Expectation {
        label: e.label.clone(),
        text: e.text.clone(),
        unit: unit(e.formula.unit(units)),
    };
    of.iter().map(one).collect()
}

fn limits(program: &Program, scenario: &ScenarioProgram) -> Result<Vec<Limit>, String> {
    let program = scenario.program(program);
    let simulation = Simulation::in_world(&program, scenario).map_err(|e| e.to_string())?;
    let roster = Roster::new(simulation.controller());
    let limits = roster.members.iter().filter(|m| m.row_kind == RowKind::Inequality);
    let all = limits.map(|m| {
        let mut units: Vec<String> = m.row_info.iter().map(|r| r.dimension.to_string()).collect();
        units.sort();
        units.dedup();
        Limit { task: m.name.clone(), unit: units.join(" or ") }
    });
    Ok(all.collect())
}

/// The measures of a mission and then those of each member. Those of controllers are left out: a row counts the members
/// whose controllers broke down.
pub fn measures(mission: &MissionProgram) -> Vec<Measured> {
    let (kind, members) = (mission.kind.kind(), mission.kind.members());
    let axes = if mission.kind.has_height() { 3 } else { 2 };
    let all = (kind.measures)();
    let of = |member: Option<(usize, &Member<'_>)>| -> Vec<Measured> {
        let (index, role) = (member.map(|m| m.0), member.map(|m| m.1.role));
        let title = |name: &str| member.map_or_else(|| name.to_string(), |(_, m)| format!("{}.{name}", m.name));
        let one = |title: String, name: &str, axis, unit: Option<String>| Measured {
            title,
            name: name.to_string(),
            member: index,
            axis,
            unit,
        };
        let mut measured = Vec::new();
        for m in all.iter().filter(|m| m.is_of(role)) {
            match m.form {
                Form::Number(dimension) => {
                    measured.push(one(title(m.name), m.name, 0, Some(dimension.to_string())));
                }
                Form::Truth => measured.push(one(title(m.name), m.name, 0, None)),
                Form::Point => measured.extend(["x", "y", "z"].iter().take(axes).enumerate().map(|(axis, letter)| {
                    one(format!("{}.{letter}", title(m.name)), m.name, axis, Some("m".to_string()))
                })),
                Form::OfController => {}
            }
        }
        measured
    };
    let own = of(None);
    own.into_iter().chain(members.iter().enumerate().flat_map(|member| of(Some(member)))).collect()
}

//! Plots of a report: margins, errors, joints and their limits, signals, the hierarchy.

use robot::DofUnit;
use runtime::Program;
use runtime::record::series::SeriesRecorder;
use runtime::record::signals::numbers;
use serde_json::{Value as Json, json};
use stdlib_tasks::task::RowKind;

/// Number of plotted rows, those closest to their bounds; more would be unreadable.
const MOST_ROWS: usize = 12;

/// A number for a plot: five significant digits, null if it is not finite.
fn number(x: f64) -> Option<f64> {
    if !x.is_finite() {
        return None;
    }
    format!("{x:.4e}").parse().ok()
}

fn column(rows: &[Vec<f64>], i: usize) -> Vec<Option<f64>> {
    rows.iter().map(|r| r.get(i).copied().and_then(number)).collect()
}

/// All plots, in the order of the page.
pub fn all(program: &Program, series: &SeriesRecorder) -> Vec<Json> {
    let mut plots = Vec::new();
    margins(series, &mut plots);
    errors(series, &mut plots);
    positions(program, series, &mut plots);
    velocities(program, series, &mut plots);
    accelerations(program, series, &mut plots);
    signals(program, series, &mut plots);
    hierarchy(program, series, &mut plots);
    plots
}

fn margins(series: &SeriesRecorder, plots: &mut Vec<Json>) {
    for m in series.members_of(RowKind::Inequality) {
        if m.kind.starts_with("joint_") {
            continue;
        }
        let smallest = |i: usize| series.margins.iter().map(|s| s[m.margins.start + i]).fold(f64::INFINITY, f64::min);
        let mut order: Vec<usize> = (0..m.row_info.len()).collect();
        order.sort_by(|a, b| smallest(*a).total_cmp(&smallest(*b)));
        let hidden = order.len().saturating_sub(MOST_ROWS);
        order.truncate(MOST_ROWS);
        let rest =
            if hidden > 0 { format!(" (the closest {MOST_ROWS} of {})", m.row_info.len()) } else { String::new() };
        let lines: Vec<Json> = order
            .iter()
            .map(|&i| json!({ "name": m.row_info[i].name, "y": column(&series.margins, m.margins.start + i) }))
            .collect();
        plots.push(json!({
            "id": format!("margin-{}", m.name), "group": "Safety margins", "title": format!("{}: distance left{rest}", m.name),
            "unit": m.dimension().map(|d| d.to_string()).unwrap_or_default(), "task": m.name, "series": lines,
            "limits": [{ "name": "limit", "value": 0.0, "side": "lower" }],
        }));
    }
}

fn errors(series: &SeriesRecorder, plots: &mut Vec<Json>) {
    for m in series.members_of(RowKind::Equality) {
        // One plot for each dimension, because metres and radians cannot share an axis.
        let mut dimensions: Vec<_> = m.measure_info.iter().map(|x| x.dimension).collect();
        dimensions.dedup();
        dimensions.sort();
        dimensions.dedup();
        for d in dimensions {
            let lines: Vec<Json> = (m.measure_info.iter().enumerate())
                .filter(|(_, x)| x.dimension == d)
                .map(|(i, x)| {
                    let name = if x.name.is_empty() { "error" } else { &x.name };
                    json!({ "name": name, "y": column(&series.measures, m.measures.start + i) })
                })
                .collect();
            plots.push(json!({
                "id": format!("error-{}-{d}", m.name), "group": "Task errors", "title": format!("{}: error", m.name),
                "unit": d.to_string(), "task": m.name, "series": lines, "limits": [],
            }));
        }
    }
}

/// Groups of joints with a common name up to their number, `arm_left_1` .. `arm_left_7`.
fn groups(program: &Program) -> Vec<(String, Vec<usize>)> {
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    for (i, d) in program.robot.model.dofs.iter().enumerate() {
        let stem = d.name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_');
        let name = if stem == d.name { "other joints" } else { stem };
        match groups.iter_mut().find(|g| g.0 == name) {
            Some(g) => g.1.push(i),
            None => groups.push((name.to_string(), vec![i])),
        }
    }
    // `other joints` last
    groups.sort_by_key(|g| g.0 == "other joints");
    groups
}

fn positions(program: &Program, series: &SeriesRecorder, plots: &mut Vec<Json>) {
    let dofs = &program.robot.model.dofs;
    for (name, members) in groups(program) {
        let mut lines = Vec::new();
        for i in members {
            let d = &dofs[i];
            let (Some(q), true) = (d.q_index, d.lower.is_finite() && d.upper.is_finite() && d.upper > d.lower) else {
                continue;
            };
            let half = (d.upper - d.lower) / 2.0;
            let middle = (d.upper + d.lower) / 2.0;
            let y: Vec<Option<f64>> = series.q.iter().map(|s| number((s[q] - middle) / half)).collect();
            lines.push(json!({ "name": d.name, "y": y }));
        }
        if !lines.is_empty() {
            plots.push(json!({
                "id": format!("q-{name}"), "group": "Joint positions", "title": format!("{name}, -1 and 1 are the limits"), "unit": "",
                "series": lines, "limits": [{ "name": "limit", "value": -1.0, "side": "lower" }, { "name": "limit", "value": 1.0, "side": "upper" }],
            }));
        }
    }
}

/// Speed limit of each degree of freedom during the run: the robot's own, or that of a velocity limit.
fn allowed(program: &Program) -> Vec<f64> {
    let mut speed: Vec<f64> = program.robot.model.dofs.iter().map(|d| d.velocity).collect();
    let values = &program.values.initial;
    // Largest limit among the stacks of the run.
    let mut allowed = vec![0.0_f64; speed.len()];
    let stacks = program.run_stacks();
    for &stack in &stacks {
        let mut own = speed.clone();
        let stack = &program.stacks[stack];
        let built = runtime::build_tasks(program, stack);
        for task in built.iter().flat_map(|b| &b.task) {
            for (dof, limit) in task.speed_limits(values) {
                own[dof] = own[dof].min(limit);
            }
        }
        allowed.iter_mut().zip(own).for_each(|(a, x)| *a = a.max(x));
    }
    if !stacks.is_empty() {
        speed = allowed;
    }
    speed
}

fn velocities(program: &Program, series: &SeriesRecorder, plots: &mut Vec<Json>) {
    let allowed = allowed(program);
    for (name, members) in groups(program) {
        for unit in [DofUnit::Radian, DofUnit::Metre] {
            let of_unit: Vec<usize> =
                members.iter().copied().filter(|&i| program.robot.model.dofs[i].unit == unit).collect();
            let Some(&first) = of_unit.first() else { continue };
            let lines: Vec<Json> = of_unit
                .iter()
                .map(|&i| json!({ "name": program.robot.model.dofs[i].name, "y": column(&series.command, i) }))
                .collect();
            let same = of_unit.iter().all(|&i| allowed[i] == allowed[first]) && allowed[first].is_finite();
            let limits = if same {
                json!([{ "name": "limit", "value": -allowed[first], "side": "lower" }, { "name": "limit", "value": allowed[first], "side": "upper" }])
            } else {
                json!([])
            };
            let unit = if unit == DofUnit::Radian { "rad/s" } else { "m/s" };
            plots.push(json!({
                "id": format!("v-{name}-{unit}"), "group": "Joint velocities", "title": name, "unit": unit, "series": lines, "limits": limits,
            }));
        }
    }
}

/// Limit of each degree of freedom's acceleration from the tasks of a run: the largest among the stacks, infinite if
/// one of them has none.
fn allowed_acceleration(program: &Program) -> Vec<f64> {
    let mut allowed = vec![0.0_f64; program.robot.model.nv()];
    for stack in program.run_stacks() {
        let mut own = vec![f64::INFINITY; allowed.len()];
        let built = runtime::build_tasks(program, &program.stacks[stack]);
        for (dof, limit) in built.iter().flat_map(|b| &b.task).flat_map(|task| task.acceleration_limits()) {
            own[dof] = own[dof].min(limit);
        }
        allowed.iter_mut().zip(own).for_each(|(a, x)| *a = a.max(x));
    }
    allowed
}

fn accelerations(program: &Program, series: &SeriesRecorder, plots: &mut Vec<Json>) {
    let (dofs, allowed) = (&program.robot.model.dofs, allowed_acceleration(program));
    for (name, members) in groups(program) {
        for unit in [DofUnit::Radian, DofUnit::Metre] {
            let of_unit: Vec<usize> = members.iter().copied().filter(|&i| dofs[i].unit == unit).collect();
            let Some(&first) = of_unit.first() else { continue };
            let lines: Vec<Json> = (of_unit.iter())
                .map(|&i| json!({ "name": dofs[i].name, "y": column(&series.acceleration, i) }))
                .collect();
            let limit = allowed[first];
            let same = limit.is_finite() && limit > 0.0 && of_unit.iter().all(|&i| allowed[i] == limit);
            let limits = if same { json!([{ "name": "limit", "value": limit, "side": "upper" }]) } else { json!([]) };
            let unit = if unit == DofUnit::Radian { "rad/s^2" } else { "m/s^2" };
            plots.push(json!({
                "id": format!("a-{name}-{unit}"), "group": "Joint accelerations", "title": format!("{name}, without sign"), "unit": unit,
                "series": lines, "limits": limits,
            }));
        }
    }
}

/// Adds plots for the numbers of signals, one for each signal and unit.
fn signals(program: &Program, series: &SeriesRecorder, plots: &mut Vec<Json>) {
    let all = numbers(&program.interface);
    for of_one in all.chunk_by(|a, b| a.signal == b.signal && a.unit == b.unit) {
        let Some(first) = of_one.first() else { continue };
        let name = &program.interface.signals[first.signal].name;
        let lines: Vec<Json> = of_one
            .iter()
            .map(|n| {
                let part = n.part.trim_start_matches('.');
                json!({ "name": if part.is_empty() { name } else { part }, "y": column(&series.signals, n.at) })
            })
            .collect();
        plots.push(json!({
            "id": format!("signal-{name}-{}", first.unit), "group": "Signals", "title": name, "unit": first.unit, "series": lines, "limits": [],
        }));
    }
}

fn hierarchy(program: &Program, series: &SeriesRecorder, plots: &mut Vec<Json>) {
    let several = program.run_stacks().len() > 1;
    let names: Vec<String> = (series.roster.levels.iter())
        .map(|l| match program.stacks.get(l.stack) {
            Some(stack) if several => format!("{}: {}", stack.name, l.name),
            _ => l.name.clone(),
        })
        .collect();
    let lines = |rows: &[Vec<f64>]| -> Vec<Json> {
        names.iter().enumerate().map(|(i, n)| json!({ "name": n, "y": column(rows, i) })).collect()
    };
    plots.push(json!({
        "id": "active", "group": "Hierarchy", "title": "rows at their bound, by level", "unit": "", "series": lines(&series.active), "limits": [],
    }));
    plots.push(json!({
        "id": "slack", "group": "Hierarchy", "title": "what each level had to give up (norm of its slack)", "unit": "", "series": lines(&series.violations), "limits": [],
    }));
}

//! Checks a parsed line and builds its problem: sizes, signs and order of bounds. Errors name the place as
//! `levels[0].lo`.

use solver::{LevelShape, Problem};

use super::form::{self, LevelKeys, List, Matrix};
use super::{LoggedProblem, MAX_LEVELS, MAX_NAME, MAX_ROWS, MAX_VARIABLES, Refusal};

/// Checks a tick and builds its problem.
pub fn tick(form: form::LoggedProblem) -> Result<LoggedProblem, Refusal> {
    name("id", &form.id)?;
    let kind = form.kind.unwrap_or_default();
    name("kind", &kind)?;
    if form.n == 0 || form.n > MAX_VARIABLES as u64 {
        return Err(Refusal::new(
            format!("`n` is {}", form.n),
            format!("give the number of variables, from 1 to {MAX_VARIABLES}"),
        ));
    }
    let n = form.n as usize;
    if form.levels.len() > MAX_LEVELS {
        let reason = format!("`levels` has {} entries", form.levels.len());
        return Err(Refusal::new(reason, format!("up to {MAX_LEVELS} levels are solved")));
    }
    let mut shapes = Vec::new();
    for (l, form::Level(level)) in form.levels.iter().enumerate() {
        let shape = shape(l, level, n)?;
        shapes.push(shape);
        if shapes.iter().map(|s: &LevelShape| s.rows).sum::<usize>() > MAX_ROWS {
            return Err(too_many_rows(format!("the levels up to `levels[{l}]` have more than {MAX_ROWS} rows")));
        }
    }
    let mut problem = Problem::new(n, &shapes);
    for (l, form::Level(level)) in form.levels.iter().enumerate() {
        fill(&mut problem, l, level)?;
    }
    if let Some(reference) = form.reference {
        length("reference", reference.0.len(), n, "variable")?;
        problem.reference = reference.0;
    }
    if let Some(x) = &form.x {
        length("x", x.0.len(), n, "variable")?;
    }
    if let Some(viol) = &form.viol {
        length("viol", viol.0.len(), shapes.len(), "level")?;
    }
    solver::check(&problem).map_err(|e| Refusal::new(e.to_string(), "correct the number"))?;
    Ok(LoggedProblem { id: form.id, kind, problem, x: form.x.map(|l| l.0), viol: form.viol.map(|l| l.0) })
}

fn name(key: &str, text: &str) -> Result<(), Refusal> {
    if text.chars().nth(MAX_NAME).is_some() || text.chars().any(char::is_control) {
        let help = format!("use up to {MAX_NAME} characters without ends of lines");
        return Err(Refusal::new(format!("`{key}` is too long, or has control characters"), help));
    }
    Ok(())
}

fn length(key: &str, is: usize, should: usize, what: &str) -> Result<(), Refusal> {
    if is != should {
        let count = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
        return Err(Refusal::new(
            format!("`{key}` has {} for {}", count(is, "number"), count(should, what)),
            format!("give it one number for each {what}"),
        ));
    }
    Ok(())
}

fn too_many_rows(reason: String) -> Refusal {
    Refusal::new(reason, format!("up to {MAX_ROWS} rows are solved"))
}

fn shape(l: usize, level: &LevelKeys, n: usize) -> Result<LevelShape, Refusal> {
    let rows = match &level.a {
        Matrix::Rows { count, width, .. } => {
            if *count > 0 && *width != n {
                let help = "give every row one number for each variable";
                return Err(Refusal::new(
                    format!("the rows of `levels[{l}].A` have {width} numbers, `n` is {n}"),
                    help,
                ));
            }
            *count
        }
        Matrix::Identities(k) => {
            if *k > MAX_ROWS as u64 {
                return Err(too_many_rows(format!("`levels[{l}].A` asks for {k} identities")));
            }
            *k as usize * n
        }
    };
    length(&format!("levels[{l}].lo"), level.lo.0.len(), rows, "row")?;
    length(&format!("levels[{l}].up"), level.up.0.len(), rows, "row")?;
    let damping = level.damping.unwrap_or(0.0);
    if damping < 0.0 {
        return Err(Refusal::new(format!("`levels[{l}].damping` is {damping}"), "damping is zero or more"));
    }
    Ok(LevelShape { rows, hard: level.hard.unwrap_or(false), damping })
}

fn fill(problem: &mut Problem, l: usize, form: &LevelKeys) -> Result<(), Refusal> {
    let n = problem.n;
    let level = &mut problem.levels[l];
    for i in 0..level.rows() {
        match &form.a {
            Matrix::Rows { numbers, .. } => level.row_mut(i).copy_from_slice(&numbers[i * n..(i + 1) * n]),
            Matrix::Identities(_) => level.row_mut(i)[i % n] = 1.0,
        }
        level.lower[i] = form.lo.0[i].unwrap_or(f64::NEG_INFINITY);
        level.upper[i] = form.up.0[i].unwrap_or(f64::INFINITY);
        if level.lower[i] > level.upper[i] {
            let (lo, up) = (level.lower[i], level.upper[i]);
            return Err(Refusal::new(
                format!("`levels[{l}]`, row {i} (counted from 0): `lo` {lo} is above `up` {up}"),
                "exchange them, or write the same number twice for an equality",
            ));
        }
    }
    // Rows with at most one coefficient become bounds, as in the control loop; the problem of a file never changes.
    for i in 0..level.rows() {
        if level.row(i).iter().filter(|a| **a != 0.0).count() <= 1 {
            level.fix(i..i + 1);
        }
    }
    if let Some(List(weight)) = &form.weight {
        length(&format!("levels[{l}].weight"), weight.len(), level.rows(), "row")?;
        if let Some(i) = weight.iter().position(|w| *w < 0.0) {
            let reason = format!("`levels[{l}].weight[{i}]` is {}", weight[i]);
            return Err(Refusal::new(reason, "weights are zero or more"));
        }
        level.weight.copy_from_slice(weight);
    }
    Ok(())
}

//! `hierarq context --trials N`: repeats a question, plans each answer, and prints the table of thesis 6.4.4 (Tables
//! 6.3 to 6.8): valid plans, times, relative errors (6.17) against the plans with model-generated layers only, the cost
//! J and its parts.

use std::time::Instant;

use clap::ValueEnum;
use context::endpoint::AskError;
use context::generate::{Bounds, GenerateError, Wish, tasks};
use mission::kind::generation::Generated;
use mission::plan_data::Cost;
use mission::planned::PlanOptions;

use super::super::{Outcome, output, plan};
use super::{Arguments, Decides, Kept, Talk, bounds, talk};

/// Result of a trial.
#[derive(Clone, Debug, Default, PartialEq)]
struct Trial {
    /// Cost of its plan; `None` without a usable answer.
    cost: Option<Cost>,
    /// Time of the model (s).
    model: f64,
    /// Time of the planner (s).
    planner: f64,
}

/// Results of all trials with the same decisions of the model.
#[derive(Clone, Debug, PartialEq)]
struct Case {
    decides: Decides,
    trials: Vec<Trial>,
}

/// Runs the trials of each case, and prints the table.
pub(super) fn run<'w>(
    a: &Arguments,
    mission: &str,
    count: u32,
    wish: &impl Fn(Decides) -> Wish<'w>,
) -> Result<Outcome, String> {
    for (index, decides) in a.decides.iter().enumerate() {
        if a.decides[..index].contains(decides) {
            return Err("`--decides` contains a decision twice".to_string());
        }
    }
    let mut talk = talk(a, mission)?;
    let bounds = bounds(a, 1);
    let mut cases: Vec<Case> = Vec::new();
    for decides in a.decides.iter().copied() {
        let mut case = Case { decides, trials: Vec::new() };
        for number in 1..=count {
            output::eprint(&format!("{}, trial {number} of {count}\n", word(decides)));
            match trial(&mut talk, &wish(decides), &bounds) {
                Ok(trial) => case.trials.push(trial),
                Err(error) => {
                    talk.kept.tell();
                    output::eprint(&format!("{error}: {} trials of `{}` are done\n", number - 1, word(decides)));
                    return Ok(Outcome::Failed);
                }
            }
        }
        cases.push(case);
    }
    talk.kept.tell();
    let version = wish(Decides::Layers).mission.version();
    let head = format!("mission {mission}, model {}, prompt {version}", talk.chat.model());
    output::print(&table(&head, &bounds, &cases));
    Ok(Outcome::Good)
}

/// Runs one conversation, and plans its result.
fn trial(talk: &mut Talk, wish: &Wish, bounds: &Bounds) -> Result<Trial, GenerateError> {
    let Talk { chat, kept } = talk;
    chat.begin();
    let (mut model, mut exchanges) = (0.0, 0);
    let answered = tasks(chat.as_mut(), wish, bounds, |exchange| {
        model += exchange.seconds;
        exchanges += usize::from(exchange.answered != Err(AskError::RecordingEnds));
        Kept::keep(kept, exchange, wish.mission.answer_keys())
    });
    match answered {
        Ok(generated) => {
            let begun = Instant::now();
            let given = generated.planned.is_some();
            let cost = cost(generated);
            let planner = if given { 0.0 } else { begun.elapsed().as_secs_f64() };
            Ok(Trial { cost, model, planner })
        }
        // The replayed conversation had fewer answers.
        Err(GenerateError::Refused { .. }) => Ok(Trial { model, ..Trial::default() }),
        Err(GenerateError::Server(AskError::RecordingEnds)) if exchanges > 0 => Ok(Trial { model, ..Trial::default() }),
        Err(error) => Err(error),
    }
}

/// Returns the cost of the given plan, or of a plan made for the tasks.
fn cost(generated: Generated) -> Option<Cost> {
    let planned = match generated.planned {
        Some(planned) => Ok(planned),
        None => generated.mission.plan(&PlanOptions::default()),
    };
    match planned {
        Ok(planned) => {
            output::eprint(&format!("{}\n", planned.cost_text));
            Some(planned.cost)
        }
        Err(why) => {
            output::eprint(&format!("no plan: {}\n", plan::refused(&why, generated.mission.kind())));
            None
        }
    }
}

/// Returns the word of the option for a decision.
fn word(decides: Decides) -> String {
    decides.to_possible_value().map(|value| value.get_name().to_string()).unwrap_or_default()
}

/// Returns the table with its caption.
fn table(head: &str, bounds: &Bounds, cases: &[Case]) -> String {
    let parts = parts(cases);
    let mut header = vec!["decides", "trials", "f %", "CP s", "LLM s", "eps_m", "eps_M", "J"];
    header.extend(&parts);
    let reference = cases.iter().find(|case| case.decides == Decides::Layers);
    let rows: Vec<Vec<String>> = cases.iter().map(|case| row(case, reference, &parts)).collect();
    let answers = match bounds.attempts {
        1 => "the first answer counts".to_string(),
        n => format!("up to {n} answers, each with the errors of those before"),
    };
    format!(
        "{head}; {answers}\n\n{}\n\
         f: valid plans; CP, LLM: time of planner and model; eps: least and greatest relative error of J against `layers`, trial by \
         trial;\nJ: cost; then its parts, normalised, each before its weight.\n\
         Means over valid plans ± standard deviation (n - 1).\n",
        plan::aligned(&header, &rows, 1)
    )
}

/// Returns the parts of the costs, in their order.
fn parts(cases: &[Case]) -> Vec<&'static str> {
    let first = cases.iter().flat_map(|case| &case.trials).find_map(|trial| trial.cost.as_ref());
    first.into_iter().flat_map(|cost| &cost.parts).map(|part| part.name).collect()
}

fn row(case: &Case, reference: Option<&Case>, parts: &[&str]) -> Vec<String> {
    let all = &case.trials;
    let valid: Vec<(&Trial, &Cost)> = all.iter().filter_map(|trial| Some((trial, trial.cost.as_ref()?))).collect();
    let of = |value: &dyn Fn(&Trial, &Cost) -> f64| -> Vec<f64> { valid.iter().map(|(t, c)| value(t, c)).collect() };
    let errors = match reference.filter(|reference| reference.decides != case.decides) {
        Some(reference) => errors(all, &reference.trials),
        None => Vec::new(),
    };
    let least = errors.iter().copied().reduce(f64::min);
    let most = errors.iter().copied().reduce(f64::max);
    let share = 100.0 * valid.len() as f64 / all.len().max(1) as f64;
    let short = |x: Option<f64>| x.map_or_else(|| "-".to_string(), |x| format!("{x:.2}"));
    let mut row = vec![
        word(case.decides),
        all.len().to_string(),
        format!("{share:.0}"),
        short(mean(&of(&|t, _| t.planner))),
        short(mean(&of(&|t, _| t.model))),
        short(least),
        short(most),
        spread(&of(&|_, c| c.total)),
    ];
    row.extend(parts.iter().map(|part| spread(&of(&|_, cost| value(cost, part)))));
    row
}

/// Returns a part of a cost, before its weight.
fn value(cost: &Cost, name: &str) -> f64 {
    let part = cost.parts.iter().find(|part| part.name == name);
    part.map_or(f64::NAN, |part| part.value.unwrap_or(part.cost))
}

/// Computes (6.17) for each trial in which both have a plan.
fn errors(of: &[Trial], reference: &[Trial]) -> Vec<f64> {
    let both = of.iter().zip(reference).filter_map(|(one, other)| Some((one.cost.as_ref()?, other.cost.as_ref()?)));
    let all = both.map(|(one, other)| (one.total - other.total) / other.total);
    all.filter(|error| error.is_finite()).collect()
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns mean and standard deviation; only the mean for a single value.
fn spread(values: &[f64]) -> String {
    let Some(mean) = mean(values) else { return "-".to_string() };
    if values.len() < 2 {
        return format!("{mean:.2}");
    }
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    format!("{mean:.2} ± {:.2}", (squares / (values.len() - 1) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_deviations() {
        assert_eq!(spread(&[]), "-");
        assert_eq!(spread(&[2.0]), "2.00");
        // 2, 4, 4, 4, 5, 5, 7, 9: mean 5, sum of squares 32.
        assert_eq!(spread(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]), "5.00 ± 2.14");
    }

    #[test]
    fn a_case_without_a_valid_plan_has_a_row() {
        let case = Case { decides: Decides::Everything, trials: vec![Trial::default(); 2] };
        let row = row(&case, None, &["makespan"]);
        assert_eq!(row[1..4], ["2", "0", "-"]);
        assert!(row[4..].iter().all(|cell| cell == "-"));
    }
}

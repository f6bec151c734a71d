//! Trains the synthetic person of the paper, recovers its policy, writes both, and prints Table B3 and the accuracy of
//! predictors: `cargo run --release -p hierarq-learning --example paper -- FOLDER [SEED]`.

use hierarq_learning::demonstrations::generate;
use hierarq_learning::evaluate::{Figures, accuracy, evaluate};
use hierarq_learning::grid::{Environments, Rewards};
use hierarq_learning::paper;
use hierarq_learning::policy::Policy;
use hierarq_learning::predict::{ConstantVelocity, End, GoalDirected, Learned, Limits, Observation, Predictor};
use hierarq_learning::random::stream;
use hierarq_learning::training::{Run, Settings, Stage};
use std::path::Path;
use std::time::Instant;

/// Environments of the table, and their seed, which no training uses.
const ENVIRONMENTS: usize = 1000;
const SEED: u64 = 1_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = Path::new(arguments.first().map_or(".", String::as_str));
    let seed = arguments.get(1).map_or(Ok(1), |text| text.parse())?;
    let world = paper::world();
    let mut run = Run::new(&world, Settings { seed, ..Settings::paper() })?.with_threads(2);
    let environments = run.settings().check(&world)?;
    let rewards = run.settings().rewards.clone();
    let start = Instant::now();
    let mut surrogate_shown = false;
    while !run.is_done() {
        let p = run.step(100_000)?;
        println!(
            "{:?} {:>8} {:>6.1} s  length {:.2}  collected {:.2?}  collisions {:.3}  failures {:.3}  entropy {:.3}",
            p.stage,
            p.steps,
            start.elapsed().as_secs_f64(),
            p.episodes.length,
            p.episodes.collected,
            p.episodes.collisions,
            p.episodes.failures,
            p.update.entropy,
        );
        if let Some(d) = p.discriminator.filter(|_| p.stage == Stage::Recovery) {
            println!("    discriminator: loss {:.3}, accuracy {:.3}", d.loss, d.accuracy);
        }
        if let Some(surrogate) = run.surrogate().filter(|_| !surrogate_shown) {
            surrogate_shown = true;
            show("surrogate", surrogate, &environments, &rewards, folder)?;
        }
    }
    let recovered = run.recovered().ok_or("the run has recovered nothing")?;
    show("recovered", &recovered, &environments, &rewards, folder)?;
    let surrogate = run.surrogate().ok_or("the run has no synthetic person")?;
    predictors(surrogate, recovered, &environments, &rewards)
}

/// Prints the accuracy of all predictors, for ways of the synthetic person in new environments.
fn predictors(
    surrogate: &Policy,
    recovered: Policy,
    environments: &Environments,
    rewards: &Rewards,
) -> Result<(), Box<dyn std::error::Error>> {
    let ways = generate(surrogate, environments, ENVIRONMENTS, SEED);
    let world = environments.world();
    let all: [(&str, Box<dyn Predictor>); 4] = [
        ("recovered policy", Box::new(Learned::new(recovered))),
        ("its own policy", Box::new(Learned::new(surrogate.clone()))),
        ("goal_directed", Box::new(GoalDirected::new(world.clone(), &rewards.targets)?)),
        ("constant_velocity", Box::new(ConstantVelocity::new(world.clone()))),
    ];
    println!("predictor: distance 1, 5, 10 steps ahead, targets, cut");
    for (name, predictor) in all {
        let of = accuracy(&*predictor, &ways, &[1, 5, 10], SEED)?;
        let estimates = of.distances.iter().chain([&of.targets, &of.cut]);
        let texts: Vec<String> = estimates.map(|e| format!("{:.3} ({:.3}, {:.3})", e.mean, e.low, e.high)).collect();
        println!("  {name:18} {}", texts.join("  "));
    }
    Ok(())
}

/// Writes a policy, and prints its figures and those of its predictions.
fn show(
    name: &str,
    policy: &Policy,
    environments: &Environments,
    rewards: &Rewards,
    folder: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    let file = policy.to_bytes();
    std::fs::write(folder.join(format!("{name}.safetensors")), &file)?;
    println!("{name}: {} bytes", file.len());
    table(&evaluate(policy, environments, rewards, ENVIRONMENTS, SEED));
    let predictor = Learned::new(policy.clone());
    let (mut cut, mut longest, mut sum) = (0, 0.0_f64, 0.0);
    for i in 0..ENVIRONMENTS as u64 {
        let state = environments.draw(&mut stream(SEED, "environment", &[i]));
        let start = Instant::now();
        let prediction = predictor.predict(&Observation { state, heading: None }, &Limits::default())?;
        let time = start.elapsed().as_secs_f64();
        (longest, sum) = (longest.max(time), sum + time);
        cut += i32::from(prediction.end != End::Exit);
    }
    println!("  predictions: {cut} of {ENVIRONMENTS} cut before an exit");
    println!("  with 100 samples: mean {:.2} ms, longest {:.2} ms", sum / ENVIRONMENTS as f64 * 1e3, longest * 1e3);
    Ok(())
}

fn table(figures: &Figures) {
    let rows = [
        ("length", &figures.length),
        ("collected A", &figures.collected[0]),
        ("collected B", &figures.collected[1]),
        ("collisions", &figures.collisions),
        ("return", &figures.reward),
        ("failures", &figures.failures),
    ];
    for (row, estimate) in rows {
        println!("  {row:12} {:7.3} ({:.3}, {:.3})", estimate.mean, estimate.low, estimate.high);
    }
}

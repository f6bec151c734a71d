//! Trains the synthetic person of the paper and recovers its policy, in a world like the paper's, and prints Table B3:
//! `cargo run --release -p hierarq-learning --example paper -- FOLDER [SEED [SURROGATE_STEPS RECOVERY_STEPS]]`.

use hierarq_learning::evaluate::{Figures, evaluate};
use hierarq_learning::grid::{Environments, World};
use hierarq_learning::training::{Run, Settings, Stage};
use std::path::Path;
use std::time::Instant;

/// Seven by seven cells of 1 m, the exit in the upper right corner, four obstacles of one to three cells.
fn world() -> World {
    let rows = [
        "......E", //
        ".##..#.", //
        ".....#.", //
        "..#....", //
        "..#..#.", //
        ".....#.", //
        ".......",
    ];
    let cells = |mark: u8| {
        let marked = |cell: &usize| rows[6 - cell / 7].as_bytes()[cell % 7] == mark;
        (0..49).filter(marked).collect::<Vec<_>>()
    };
    World::new(7, 7, &cells(b'#'), &cells(b'E'), 2).expect("a world")
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: u64| arguments.get(at).map_or(Ok(default), |text| text.parse::<u64>());
    let folder = Path::new(arguments.first().map_or(".", String::as_str));
    let mut settings = Settings { seed: number(1, 1)?, ..Settings::paper() };
    settings.surrogate_steps = number(2, settings.surrogate_steps)?;
    settings.recovery_steps = number(3, settings.recovery_steps)?;
    if let Ok(e) = std::env::var("ENTROPY") {
        settings.surrogate.entropy = e.parse()?;
    }
    if let Ok(e) = std::env::var("RATE") {
        settings.surrogate.rate = e.parse()?;
    }
    if let Ok(e) = std::env::var("LAMBDA") {
        settings.surrogate.lambda = e.parse()?;
    }
    if let Ok(e) = std::env::var("AENTROPY") {
        settings.airl.policy.entropy = e.parse()?;
    }
    if let Ok(e) = std::env::var("ARATE") {
        settings.airl.policy.rate = e.parse()?;
    }
    if let Ok(e) = std::env::var("DRATE") {
        settings.airl.rate = e.parse()?;
    }
    if let Ok(e) = std::env::var("UPDATES") {
        settings.airl.updates = e.parse()?;
    }
    if let Ok(e) = std::env::var("ALAMBDA") {
        settings.airl.policy.lambda = e.parse()?;
    }
    if let Ok(e) = std::env::var("MINI") {
        settings.surrogate.minibatch = e.parse()?;
        settings.airl.policy.minibatch = e.parse()?;
    }
    let world = world();
    let environments = Environments::new(&world, settings.least_targets, settings.most_targets)?;
    let rewards = settings.rewards.clone();
    let mut run = match std::env::var("SURROGATE") {
        Ok(file) => {
            let surrogate = hierarq_learning::policy::Policy::from_bytes(&std::fs::read(file)?)?;
            let d = hierarq_learning::demonstrations::generate(&surrogate, &environments, settings.demonstrations, settings.seed);
            Run::from_demonstrations(&world, settings, d)?
        }
        Err(_) => Run::new(&world, settings)?,
    }
    .with_threads(2);
    let start = Instant::now();
    let mut stage = run.progress().stage;
    while !run.is_done() {
        let p = run.step(100_000)?;
        println!(
            "{:?} {:>8} {:>6.1} s  length {:.2}  collected {:.2?}  collisions {:.3}  failures {:.3}  entropy {:.3}  clipped {:.3} {:.3?}",
            p.stage,
            p.steps,
            start.elapsed().as_secs_f64(),
            p.episodes.length,
            p.episodes.collected,
            p.episodes.collisions,
            p.episodes.failures,
            p.update.entropy,
            p.update.clipped,
            p.discriminator.map(|d| (d.loss, d.accuracy)),
        );
        if p.stage != stage {
            stage = p.stage;
            if let Some(surrogate) = run.surrogate() {
                std::fs::write(folder.join("surrogate.safetensors"), surrogate.to_bytes())?;
                print("surrogate", &evaluate(surrogate, &environments, &rewards, 1000, 99));
            }
        }
        if stage == Stage::Recovery && run.progress().steps % 500_000 < 100_000 {
            let recovered = run.recovered().ok_or("no policy")?;
            print("recovered", &evaluate(&recovered, &environments, &rewards, 1000, 99));
        }
    }
    let recovered = run.recovered().ok_or("no policy")?;
    std::fs::write(folder.join("recovered.safetensors"), recovered.to_bytes())?;
    print("recovered", &evaluate(&recovered, &environments, &rewards, 1000, 99));
    Ok(())
}

fn print(name: &str, figures: &Figures) {
    let rows = [
        ("length", &figures.length),
        ("collected A", &figures.collected[0]),
        ("collected B", &figures.collected[1]),
        ("collisions", &figures.collisions),
        ("return", &figures.reward),
        ("failures", &figures.failures),
    ];
    println!("{name}");
    for (row, estimate) in rows {
        println!("  {row:12} {:7.3} ({:.3}, {:.3})", estimate.mean, estimate.low, estimate.high);
    }
}

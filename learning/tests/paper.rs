//! The trained policies of `examples/policies/`, in the world of the paper: their figures are those of its Table B3 within the
//! differences that the paper itself has, and Algorithm 1 leads to the exit.

use hierarq_learning::evaluate::{Figures, evaluate};
use hierarq_learning::grid::{Environments, Rewards};
use hierarq_learning::paper;
use hierarq_learning::policy::{Method, Policy};
use hierarq_learning::predict::{Learned, Limits, Observation, Predictor};
use hierarq_learning::random::stream;

const SURROGATE: &[u8] = include_bytes!("../../examples/policies/surrogate.safetensors");
const RECOVERED: &[u8] = include_bytes!("../../examples/policies/recovered.safetensors");

fn environments() -> Environments {
    Environments::new(&paper::world(), 0, 4).expect("room for four targets")
}

fn figures(file: &[u8]) -> Figures {
    evaluate(&Policy::from_bytes(file).expect("a policy"), &environments(), &Rewards::paper(), 1000, 1_000_000)
}

#[test]
fn the_recovered_policy_is_as_near_to_the_surrogate_as_in_the_paper() {
    let (surrogate, recovered) = (figures(SURROGATE), figures(RECOVERED));
    let near = |what: &str, a: f64, b: f64, paper: f64| {
        assert!((a - b).abs() <= paper, "{what}: {a} and {b} differ by more than {paper}");
    };
    // Table B3: 12.7 and 12.3, 0.68 and 0.61, 1.09 and 0.81, 0.05 and -0.85.
    near("length", surrogate.length.mean, recovered.length.mean, 0.4);
    near("targets of type A", surrogate.collected[0].mean, recovered.collected[0].mean, 0.07);
    near("targets of type B", surrogate.collected[1].mean, recovered.collected[1].mean, 0.28);
    near("return", surrogate.reward.mean, recovered.reward.mean, 0.90);
}

#[test]
fn the_policies_are_those_of_the_world_and_of_their_training() {
    for (file, method) in [(SURROGATE, Method::Ppo), (RECOVERED, Method::Airl)] {
        assert!(file.len() < 200_000, "{}", file.len());
        let policy = Policy::from_bytes(file).unwrap();
        policy.check(&paper::world()).unwrap();
        assert_eq!(policy.training().method, method);
        assert_eq!(policy.to_bytes(), file);
    }
}

/// The person leaves from nearly every start. Where the most likely actions lead in a circle, the prediction says so.
#[test]
fn most_predictions_reach_the_exit() {
    for file in [SURROGATE, RECOVERED] {
        let predictor = Learned::new(Policy::from_bytes(file).unwrap());
        let limits = Limits { samples: 0, ..Limits::default() };
        let reaches = |i: &u64| {
            let state = environments().draw(&mut stream(9, "start", &[*i]));
            predictor.predict(&Observation { state, heading: None }, &limits).unwrap().reaches_exit()
        };
        let reached = (0..300).filter(reaches).count();
        assert!(reached >= 285, "{reached} of 300");
    }
}

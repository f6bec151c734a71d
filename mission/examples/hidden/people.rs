//! The figures 19 and 22 to 25 of the paper with simulated people, practised and without practice: `-- 100 people`.
//!
//! Rates of messages are those of table 1. The inclinations to roles are chosen, and inputs: results are only what follows from them.

use std::sync::Mutex;

use hierarq_mission::execution::{DiscreteEvents, Durations, Replan};
use hierarq_mission::kind::Run;
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::choose::Formulation;
use hierarq_mission::kinds::search::execution::{Role, SearchExecution, Settings};
use hierarq_mission::kinds::search::geometry::distance;
use hierarq_mission::kinds::search::habits::{Habits, Intervals, OwnGoal, Reminder, ReminderKind};
use hierarq_mission::kinds::search::problem::Problem;

use crate::{HORIZON, TIMES, mean, searched};

const ANNA: usize = 1;
/// Number of states of each planning: plans are made after every pose.
const STATES: u64 = 500;
/// Number of seeds after which the figures so far are printed.
const BLOCK: usize = 25;
/// Times at which roles are reported (s).
const ROLES: [f64; 8] = [10.0, 25.0, 50.0, 75.0, 100.0, 150.0, 200.0, 250.0];
/// The reminder of the paper's third experiment; its times are chosen.
const MULTIMODAL: Reminder = Reminder { kind: ReminderKind::Multimodal, after: 10.0, shorten: 0.8, least: 4.0 };

/// The control user of table 1, and a roboticist of Fig. 25: follows plans mostly, and never leads as the robot is led.
const PRACTISED: Habits = Habits {
    my_pose: Some(Intervals { mean: 60.0 / 15.59, share: Some(0.9095), below: 10.0 }),
    follows: 0.3,
    own_goal: OwnGoal::Greedy,
    goals_beyond: 8.0,
    my_goal: 0.9,
    robot_goal: 0.9,
    robot_goal_alone: 0.0,
    replan: 0.05,
    heeds: 0.7,
};
/// The volunteers of table 1.
const WITHOUT_PRACTICE: Habits = Habits {
    my_pose: Some(Intervals { mean: 60.0 / 6.38, share: Some(0.7294), below: 10.0 }),
    follows: 0.3,
    own_goal: OwnGoal::Nearest,
    goals_beyond: 8.0,
    my_goal: 0.55,
    robot_goal: 0.8,
    robot_goal_alone: 0.35,
    replan: 0.1,
    heeds: 0.5,
};
/// The groups: none has habits in the first one.
const GROUPS: [(&str, Option<Habits>); 3] =
    [("follows every plan", None), ("practised", Some(PRACTISED)), ("without practice", Some(WITHOUT_PRACTICE))];

#[derive(Clone, Debug, Default)]
struct Episode {
    time: f64,
    explored: [f64; 2],
    progress: [f64; TIMES.len()],
    roles: [Option<usize>; ROLES.len()],
    /// Time in each role (s).
    lasted: [f64; 4],
    poses: f64,
    times: [usize; 2],
    reminders: usize,
    messages: usize,
    /// Mean distance of the believed position from the true one (m).
    gap: f64,
}

fn episode(problem: &Problem, seed: u64) -> Episode {
    let settings = Search { problem: problem.clone() }.settings(&Run { sampled: Some(seed), ..Run::default() });
    let mut run = SearchExecution::new(problem.clone(), settings).expect("a mission without mistakes");
    let mut of = Episode::default();
    let (mut time, mut steps) = (0.0, 0.0);
    while time < HORIZON && run.problem().is_searching() {
        time += 0.5;
        run.run_until(time);
        for (_, share) in TIMES.iter().zip(&mut of.progress).filter(|(at, _)| **at >= time) {
            *share = run.explored(None);
        }
        let role = Role::ALL.iter().position(|role| *role == run.role()).unwrap_or_default();
        of.lasted[role] += 0.5;
        if let Some(k) = ROLES.iter().position(|at| (at - time).abs() < 0.25) {
            of.roles[k] = Some(role);
        }
        let view = run.agent(ANNA).expect("she takes part");
        (of.gap, steps) = (of.gap + distance(view.pose.at, view.believed.at), steps + 1.0);
    }
    of.gap /= steps;
    of.time = run.secrets().iter().map(|secret| secret.found.unwrap_or(HORIZON)).fold(0.0, f64::max);
    of.explored = [0, 1].map(|agent| run.explored(Some(agent)));
    (of.poses, of.times, of.reminders) = (run.poses(ANNA) as f64, run.times_between_poses(ANNA), run.reminders(ANNA));
    of.messages = run.messages().all();
    of
}

/// Runs jobs on two threads; planners use one each.
fn on_two<T: Send>(jobs: usize, job: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = Mutex::new(0..jobs);
    let work = || {
        let mut own = Vec::new();
        while let Some(index) = { next.lock().expect("jobs").next() } {
            own.push((index, job(index)));
        }
        own
    };
    let mut all: Vec<(usize, T)> = std::thread::scope(|scope| {
        let parts = [scope.spawn(work), scope.spawn(work)];
        parts.into_iter().flat_map(|part| part.join().expect("episodes")).collect()
    });
    all.sort_by_key(|(index, _)| *index);
    all.into_iter().map(|(_, of)| of).collect()
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

pub fn report(seeds: u64) {
    reminders(seeds as usize);
    let begun = std::time::Instant::now();
    let problems = GROUPS.map(|(_, habits)| {
        let mut problem = searched::yard();
        problem.planner.states = STATES;
        problem.reminder = habits.map(|_| MULTIMODAL);
        problem.agents[ANNA].habits = habits;
        problem
    });
    let mut all: Vec<Episode> = Vec::new();
    while all.len() < 3 * seeds as usize {
        let (done, more) = (all.len(), (3 * seeds as usize - all.len()).min(3 * BLOCK));
        all.extend(on_two(more, |job| episode(&problems[job % 3], ((done + job) / 3) as u64)));
        println!("\n{} seeds, {:.0} s", all.len() / 3, begun.elapsed().as_secs_f64());
        print(&all);
    }
}

/// Prints the figures of episodes, those of the groups in turn.
fn print(all: &[Episode]) {
    let count = all.len() / 3;
    for (group, (name, _)) in GROUPS.iter().enumerate() {
        let of = || all.iter().skip(group).step_by(3);
        let (time, error) = mean(of().map(|e| e.time));
        let mut times: Vec<f64> = of().map(|e| e.time).collect();
        times.sort_by(f64::total_cmp);
        let deviation = error * (count as f64).sqrt();
        let at = |share: f64| times[((count as f64 - 1.0) * share).round() as usize];
        let early = times.iter().filter(|time| **time < 100.0).count();
        println!(
            "{name}: {time:.1} +- {error:.1} s, deviation {deviation:.1} s, quartiles {:.1}, {:.1}, {:.1} s; under way after 100 s {}, \
             after 150 s {}, after 200 s {}",
            at(0.25),
            at(0.5),
            at(0.75),
            percent(1.0 - early as f64 / count as f64),
            percent(times.iter().filter(|time| **time >= 150.0).count() as f64 / count as f64),
            percent(times.iter().filter(|time| **time >= 200.0).count() as f64 / count as f64),
        );
        let explored = mean(of().map(|e| e.explored.iter().sum::<f64>())).0;
        let robot = mean(of().map(|e| e.explored[0] / e.explored.iter().sum::<f64>())).0;
        println!(
            "  explored {}, the robot {} of it; {:.1} messages; she is {:.2} m from where she is believed to be",
            percent(explored),
            percent(robot),
            mean(of().map(|e| e.messages as f64)).0,
            mean(of().map(|e| e.gap)).0
        );
        let [whole, prompt] = [0, 1].map(|k| of().map(|e| e.times[k]).sum::<usize>() as f64);
        println!(
            "  {:.2} poses a minute, {} of the times below 10 s; {:.1} reminders an episode",
            60.0 * of().map(|e| e.poses).sum::<f64>() / of().map(|e| e.time).sum::<f64>(),
            percent(prompt / whole.max(1.0)),
            mean(of().map(|e| e.reminders as f64)).0
        );
        let spread = |k: usize| {
            let (middle, error) = mean(of().map(|e| e.progress[k]));
            format!("{:.0} s {} (deviation {:.1})", TIMES[k], percent(middle), 100.0 * error * (count as f64).sqrt())
        };
        println!("  explored after {}", (0..TIMES.len()).map(spread).collect::<Vec<_>>().join(", "));
        let roles: Vec<String> = (0..ROLES.len())
            .map(|k| {
                let there: Vec<usize> = of().filter_map(|e| e.roles[k]).collect();
                let share =
                    |role: usize| there.iter().filter(|is| **is == role).count() as f64 / there.len().max(1) as f64;
                let shares: Vec<String> = (0..4).map(|role| format!("{:.0}", 100.0 * share(role))).collect();
                format!("{:.0} s {} of {}", ROLES[k], shares.join("/"), there.len())
            })
            .collect();
        println!("  roles (leader-follower/peer-to-peer/master-slave/leader-leader): {}", roles.join(", "));
        let whole: f64 = of().map(|e| e.time).sum();
        let lasted: Vec<String> =
            (0..4).map(|role| percent(of().map(|e| e.lasted[role]).sum::<f64>() / whole)).collect();
        println!("  of the whole time: {}", lasted.join(", "));
    }
    for group in [1, 2] {
        let (longer, error) = mean((0..count).map(|seed| all[3 * seed + group].time - all[3 * seed].time));
        println!("{} is slower than following every plan by {longer:.1} +- {error:.1} s", GROUPS[group].0);
    }
}

/// Fig. 19: share of times between poses below 8.32 s, by the time after which a reminder comes, and the probability of heeding it.
fn reminders(seeds: usize) {
    let quick = |reminder: Option<f64>, heeds: f64| {
        let mut problem = searched::light_and_panel(true);
        (problem.horizon, problem.sources[0].pool, problem.planner.stay) = (600.0, None, 300.0);
        problem.sources.truncate(1);
        // The second population: 76.82 % below 8.32 s, with the mean of the first one in proportion.
        let my_pose = Some(Intervals { mean: 0.832 * 60.0 / 6.38, share: Some(0.7682), below: 8.32 });
        let quiet =
            Habits { follows: 1.0, my_goal: 0.0, robot_goal: 0.0, robot_goal_alone: 0.0, replan: 0.0, ..PRACTISED };
        problem.agents[ANNA].habits = Some(Habits { my_pose, heeds, ..quiet });
        problem.reminder = reminder.map(|after| Reminder { after, ..MULTIMODAL });
        let counts = on_two(seeds, |seed| {
            let settings =
                Search { problem: problem.clone() }.settings(&Run { replan: Replan::None, ..Run::default() });
            let durations = Durations::Sampled { seed: seed as u64 };
            let settings = Settings { durations, formulation: Formulation::Greedy, ..settings };
            let mut run = SearchExecution::new(problem.clone(), settings).expect("a mission without mistakes");
            run.run_until(600.0);
            run.times_between_poses(ANNA)
        });
        let [all, prompt] = [0, 1].map(|k| counts.iter().map(|of| of[k]).sum::<usize>() as f64);
        format!("{} ({:.2}/min)", percent(prompt / all), all / 10.0 / seeds as f64)
    };
    println!("without reminders: {} below 8.32 s", quick(None, 0.0));
    for after in [10.0, 8.32, 6.0, 5.0] {
        let shares = [0.1, 0.2, 0.3, 0.5, 1.0].map(|heeds| format!("heeded by {heeds}: {}", quick(Some(after), heeds)));
        println!("after {after} s: {}", shares.join(", "));
    }
}

//! Simulated people of a search: times between their messages against the figures that they are given, where they go against
//! what others believe, the roles that arise, and reminders.

use hierarq_mission::execution::{DiscreteEvents, Durations, Replan};
use hierarq_mission::kind::Run;
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::belief::prior;
use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::choose::Formulation;
use hierarq_mission::kinds::search::execution::{Event, LogEntry, Role, SearchExecution, Settings};
use hierarq_mission::kinds::search::geometry::{Point, distance};
use hierarq_mission::kinds::search::ground::{Body, Ground};
use hierarq_mission::kinds::search::habits::{Habits, Intervals, OwnGoal, Reminder, ReminderKind};
use hierarq_mission::kinds::search::lookouts::lookouts;
use hierarq_mission::kinds::search::problem::{Detection, Problem};
use hierarq_mission::kinds::search::validate::validate;

use crate::searched::{agent, hidden, light_and_panel, problem, wall};

const ROBOT: usize = 0;
const ANNA: usize = 1;

/// Somebody who always follows the plan and sends nothing.
const QUIET: Habits = Habits {
    my_pose: None,
    follows: 1.0,
    own_goal: OwnGoal::Greedy,
    goals_beyond: 0.5,
    my_goal: 0.0,
    robot_goal: 0.0,
    robot_goal_alone: 0.0,
    replan: 0.0,
    heeds: 1.0,
};

fn times(mean: f64, share: f64) -> Option<Intervals> {
    Some(Intervals { mean, share: Some(share), below: 10.0 })
}

/// Somebody who does everything now and then.
fn lively() -> Habits {
    Habits {
        my_pose: times(9.4, 0.7294),
        follows: 0.4,
        my_goal: 0.5,
        robot_goal: 0.5,
        robot_goal_alone: 0.3,
        replan: 0.2,
        ..QUIET
    }
}

/// Two rooms with a door, in which something is hidden that is hard to find.
fn rooms(rate: f64, habits: Habits) -> Problem {
    let team = vec![agent("r", false, [1.0, 1.0], 0.7), agent("anna", true, [1.0, 5.0], 1.0)];
    let mut p = problem(vec![[0.0, 0.0], [12.0, 0.0], [12.0, 6.0], [0.0, 6.0]], team, Vec::new(), 400.0);
    p.walls.push(wall("low", &[[6.0, 0.0], [6.0, 2.4]]));
    p.walls.push(wall("high", &[[6.0, 3.6], [6.0, 6.0]]));
    p.agents.iter_mut().for_each(|who| who.sees = Some(Detection { within: 3.0, rate }));
    p.agents[ANNA].habits = Some(habits);
    p.objects.push(hidden("token", 2, 10.0));
    (p.planner.window, p.planner.states, p.planner.tree_nodes) = (Some(40.0), 300, 100);
    p
}

fn begun(problem: &Problem, seed: u64) -> SearchExecution {
    let settings = settings(problem, seed);
    SearchExecution::new(problem.clone(), settings).expect("an execution")
}

fn settings(problem: &Problem, seed: u64) -> Settings {
    let settings = Search { problem: problem.clone() }.settings(&Run { replan: Replan::Both, ..Run::default() });
    Settings { durations: Durations::Sampled { seed }, formulation: Formulation::Greedy, ..settings }
}

/// Times of the messages *My pose* in the log (s), with the places.
fn poses(run: &SearchExecution) -> Vec<(f64, Point)> {
    let pose = |what: &LogEntry| match what {
        LogEntry::Handled { event: Event::MyPose { to, .. } } => Some(*to),
        _ => None,
    };
    run.records().iter().filter_map(|record| Some((record.time, pose(&record.what)?))).collect()
}

/// Both users of table 1 of the paper: mean and share below 10 s over many seeds, from the log.
#[test]
fn times_between_poses_have_both_figures() {
    for (rate, share) in [(15.59, 0.9095), (6.38, 0.7294)] {
        let mut p = rooms(1e-6, Habits { my_pose: times(60.0 / rate, share), ..QUIET });
        // Long stays: the plans have few activities.
        (p.horizon, p.planner.stay, p.planner.window, p.planner.lookouts) = (1_200.0, 200.0, None, 4);
        let mut first = Vec::new();
        for seed in 0..20 {
            let settings = Settings { replan: Replan::None, ..settings(&p, seed) };
            let mut run = SearchExecution::new(p.clone(), settings).expect("an execution");
            run.advance(1_200.0);
            let sent = poses(&run);
            let own: Vec<f64> = sent.windows(2).map(|two| two[1].0 - two[0].0).collect();
            let prompt = own.iter().filter(|time| **time < 10.0).count();
            assert_eq!((run.poses(ANNA), run.times_between_poses(ANNA)), (sent.len(), [own.len(), prompt]));
            // As many of each run: those that the end cuts off are the long ones.
            assert!(own.len() >= 60, "seed {seed}: {}", own.len());
            first.extend_from_slice(&own[..60]);
        }
        let mean = |of: &dyn Fn(f64) -> f64| {
            let count = first.len() as f64;
            let mean = first.iter().map(|time| of(*time)).sum::<f64>() / count;
            let squares: f64 = first.iter().map(|time| (of(*time) - mean).powi(2)).sum();
            (mean, (squares / (count - 1.0) / count).sqrt())
        };
        let (time, error) = mean(&|time| time);
        assert!((time - 60.0 / rate).abs() < 3.0 * error && error < 0.06 * time, "{rate}: {time} +- {error}");
        let (under, error) = mean(&|time| f64::from(u8::from(time < 10.0)));
        assert!((under - share).abs() < 3.0 * error && error < 0.02, "{share}: {under} +- {error}");
    }
}

/// The same seed gives the same records, however time is cut, and another seed others.
#[test]
fn executions_of_people_do_not_depend_on_cuts() {
    for seed in 0..6 {
        let mut p = rooms(0.05, lively());
        p.reminder = Some(Reminder { kind: ReminderKind::Toast, after: 8.0, shorten: 0.8, least: 4.0 });
        p.agents[ANNA].spread = 0.1;
        let mut whole = begun(&p, seed);
        whole.advance(300.0);
        for step in [0.37, 2.0, 61.0] {
            let mut cut = begun(&p, seed);
            let mut time = 0.0;
            while time < 300.0 {
                time = f64::min(time + step, 300.0);
                cut.advance(time);
            }
            assert_eq!(whole.records(), cut.records(), "seed {seed}, steps of {step} s");
        }
        let mut other = begun(&p, seed + 100);
        other.advance(300.0);
        assert_ne!(poses(&whole), poses(&other));
    }
}

/// Each inclination leads to its role, and the decisions of nobody change another's.
#[test]
fn the_four_roles_arise() {
    let own = Habits { follows: 0.0, my_goal: 1.0, ..QUIET };
    let cases = [
        (QUIET, Role::LeaderFollower),
        (own, Role::PeerToPeer),
        (Habits { robot_goal: 1.0, ..own }, Role::MasterSlave),
        (Habits { robot_goal_alone: 1.0, ..QUIET }, Role::LeaderLeader),
    ];
    for (habits, role) in cases {
        let mut run = begun(&rooms(0.005, habits), 3);
        let mut lasted = [0; 4];
        while run.time() < 100.0 && run.problem().is_searching() {
            let to = run.time() + 0.5;
            run.advance(to);
            lasted[Role::ALL.iter().position(|of| *of == run.role()).expect("a role")] += 1;
        }
        let of = |role: Role| lasted[Role::ALL.iter().position(|of| *of == role).expect("a role")];
        assert!(of(role) > 0, "{role:?}: {lasted:?}");
        let both = of(Role::MasterSlave) > 0;
        assert_eq!(both, role == Role::MasterSlave, "{lasted:?}");
        assert!(of(Role::PeerToPeer) == 0 || habits.follows < 1.0, "{lasted:?}");
        assert!(of(Role::LeaderLeader) == 0 || matches!(role, Role::MasterSlave | Role::LeaderLeader), "{lasted:?}");
        let sent = run.messages();
        assert_eq!(sent.goals > 0, habits.follows < 1.0, "{sent:?}");
        assert_eq!(sent.robot_goals > 0, matches!(role, Role::MasterSlave | Role::LeaderLeader), "{sent:?}");
        assert_eq!((sent.poses, sent.replans), (0, 0));
    }
}

/// Whoever goes to goals of their own and says nothing is believed elsewhere, until they say where they are.
#[test]
fn an_unseen_person_is_believed_elsewhere() {
    let silent = Habits { follows: 0.0, ..QUIET };
    let gap = |p: &Problem, seed: u64| {
        let mut run = begun(p, seed);
        let (mut sum, mut count, mut found) = (0.0, 0, Vec::new());
        while run.time() < 120.0 && run.problem().is_searching() {
            let to = run.time() + 0.5;
            run.advance(to);
            let view = run.agent(ANNA).expect("she is there");
            (sum, count) = (sum + distance(view.pose.at, view.believed.at), count + 1);
        }
        // The same run up to each message: she is where she says, and is believed there.
        let mut again = begun(p, seed);
        for (time, at) in poses(&run) {
            again.advance(time);
            let view = again.agent(ANNA).expect("she is there");
            assert!(distance(view.pose.at, at) < 1e-6 && distance(view.believed.at, at) < 0.06, "{time}: {view:?}");
            found.push(time);
        }
        (sum / f64::from(count), found.len())
    };
    let mut gaps = [0.0; 3];
    for seed in 0..4 {
        let own =
            [silent, Habits { my_pose: times(20.0, 0.4), ..silent }, Habits { my_pose: times(3.0, 0.98), ..silent }];
        let found = own.map(|habits| gap(&rooms(0.005, habits), seed));
        let [never, seldom, often] = found.map(|(_, messages)| messages);
        assert!(never == 0 && 0 < seldom && seldom < often, "{never} {seldom} {often}");
        (0..3).for_each(|k| gaps[k] += found[k].0 / 4.0);
    }
    let [never, seldom, often] = gaps;
    assert!(often < 0.8 * seldom && often < 0.7 * never, "{gaps:?}");
}

/// Nobody jumps or walks through a wall: true positions are as far apart as her speed allows, whatever she decides and sends.
#[test]
fn true_positions_are_continuous() {
    for seed in 0..8 {
        let p = rooms(0.03, lively());
        let ground = Ground::new(&p, &Body { radius: 0.15, passes: Vec::new() });
        let mut run = begun(&p, seed);
        let mut at = run.agent(ANNA).expect("she is there").pose.at;
        while run.time() < 200.0 {
            let to = run.time() + 0.1;
            run.advance(to);
            let next = run.agent(ANNA).expect("she is there").pose.at;
            assert!(distance(at, next) <= 0.1 + 1e-6, "seed {seed}, {to}: {at:?} {next:?}");
            assert!(ground.clear(at, next), "seed {seed}, {to}: {at:?} {next:?}");
            at = next;
        }
    }
}

/// Every plan that follows from a message of a simulated person is one from here and now, with the tree search as well.
#[test]
fn plans_after_messages_are_valid() {
    let mut checked = 0;
    for seed in 0..4 {
        let p = rooms(0.05, lively());
        let begun = || {
            let settings = Settings { formulation: Formulation::TreeSearch, ..settings(&p, seed) };
            SearchExecution::new(p.clone(), settings).expect("an execution")
        };
        let mut run = begun();
        run.advance(90.0);
        let handled =
            |what: &LogEntry| matches!(what, LogEntry::Handled { event } if !matches!(event, Event::Strays { .. }));
        let at: Vec<f64> = run.records().iter().filter(|r| handled(&r.what)).map(|r| r.time).collect();
        let mut again = begun();
        for time in at {
            again.run_until(time);
            let violations = validate(&again.present(), again.plan());
            assert!(violations.is_empty(), "seed {seed}, {time}: {violations:?}");
            checked += 1;
        }
        assert!(again.stranded().is_none() && run.stranded().is_none());
    }
    assert!(checked > 30, "{checked}");
}

/// She knows of what she and the others have seen: by sampling.
#[test]
fn a_person_knows_what_they_have_seen() {
    let rate = 0.02;
    let mut p = rooms(rate, Habits { follows: 0.0, ..QUIET });
    p.planner.seed = 4;
    let mut run = begun(&p, 1);
    let sight = p.sight();
    let mut naive = vec![0.0; sight.len()];
    let step = 0.02;
    for k in 0..2_000 {
        run.advance((f64::from(k) + 0.5) * step);
        for who in [ROBOT, ANNA] {
            let seat = sight.seat(run.agent(who).expect("it is there").pose.at).expect("a cell");
            sight.seen(seat, 3.0).iter().for_each(|(_, cell)| naive[*cell as usize] += rate * step);
        }
    }
    run.advance(40.0);
    // Rewards are settled at steps: the last one is at 40 s.
    let known = run.known_exposure(ANNA).expect("she is simulated");
    let [sum, is]: [f64; 2] = [naive.iter().sum(), known.iter().sum()];
    assert!((sum / is - 1.0).abs() < 0.02, "{sum} {is}");
    assert!(naive.iter().zip(known).all(|(a, b)| (a - b).abs() < 0.03 * rate * 40.0), "cell by cell");
    let others: f64 = run.problem().exposure.iter().zip(known).map(|(a, b)| (a - b).abs()).sum();
    assert!(others > 0.1 * sum, "the others believe that she has looked elsewhere: {others} of {sum}");
}

/// The first goal of her own in an empty room, against every lookout.
#[test]
fn own_goals_are_worth_the_most_a_second() {
    for (choice, seed) in [(OwnGoal::Greedy, 0), (OwnGoal::Greedy, 1), (OwnGoal::Nearest, 2)] {
        let mut p = rooms(0.1, Habits { follows: 0.0, own_goal: choice, ..QUIET });
        p.walls.clear();
        p.agents[ANNA].start = [[1.0, 5.0], [5.5, 2.5], [11.0, 1.0]][seed];
        let mut run = begun(&p, 3);
        run.advance(0.0);
        let strays = run.records().iter().find_map(|record| match record.what {
            LogEntry::Handled { event: Event::Strays { to, .. } } => Some(to),
            _ => None,
        });
        let sight = p.sight();
        let mass = prior(&sight, &p.objects[0]);
        let (from, stay) = (p.agents[ANNA].start, p.planner.stay);
        let ground = Ground::new(&p, &Body::of(&p.agents[ANNA]));
        let worth = |at: &Point| {
            let cells = (0..sight.len()).filter(|cell| {
                distance(sight.middles()[*cell], sight.middles()[sight.seat(*at).expect("a cell") as usize]) <= 3.0
            });
            let seen: f64 = cells.map(|cell| mass[cell]).sum();
            let way = distance(from, *at);
            20.0 * seen * (1.0 - f64::exp(-0.1 * stay)) * (1.0 - way / 400.0)
        };
        let all: Vec<Point> =
            lookouts(&p, ANNA, &ground, None).into_iter().filter(|at| distance(from, *at) >= 0.5).collect();
        let most = all.iter().map(worth).fold(0.0, f64::max);
        let best = match choice {
            OwnGoal::Greedy => {
                let of = |at: &&Point| worth(at) / (distance(from, **at) + stay);
                all.iter().max_by(|a, b| of(a).total_cmp(&of(b)))
            }
            OwnGoal::Nearest => {
                let near = all.iter().filter(|at| worth(at) >= 0.5 * most);
                near.min_by(|a, b| distance(from, **a).total_cmp(&distance(from, **b)))
            }
        };
        assert_eq!(strays, best.copied(), "{choice:?}");
    }
}

/// Without hidden objects goals of one's own are sources; people with a page have no habits.
#[test]
fn sources_are_goals_too() {
    let mut p = light_and_panel(true);
    p.agents[ANNA].habits = Some(Habits { follows: 0.0, my_goal: 1.0, ..QUIET });
    let mut run = begun(&p, 1);
    run.advance(1.0);
    assert_eq!(run.told_goal(ANNA), Some([7.0, 5.0]), "the light");
    run.advance(30.0);
    assert!(run.rewards().pools.iter().all(|pool| *pool == 0.0), "{:?}", run.rewards());

    let p = rooms(0.05, Habits { my_pose: times(2.0, 0.99), ..lively() });
    let settings = Settings { reporting: vec![ANNA], ..settings(&p, 1) };
    let mut run = SearchExecution::new(p, settings).expect("an execution");
    run.advance(60.0);
    assert_eq!(run.messages().all(), 0);
    assert!(run.known_exposure(ANNA).is_none());
}

/// Reminders follow one another ever sooner, until a pose is sent; counters remind nobody.
#[test]
fn reminders_come_until_they_are_heeded() {
    let reminded = |habits: Habits, kind: ReminderKind| {
        let mut p = rooms(1e-6, habits);
        p.reminder = Some(Reminder { kind, after: 10.0, shorten: 0.5, least: 4.0 });
        let mut run = begun(&p, 2);
        run.advance(60.0);
        let at = run.records().iter().filter(|r| matches!(r.what, LogEntry::Reminded { agent: ANNA }));
        let at: Vec<f64> = at.map(|record| record.time).collect();
        assert_eq!((run.reminders(ANNA), run.reminders(ROBOT)), (at.len(), 0));
        (at, poses(&run).into_iter().map(|(time, _)| time).collect::<Vec<f64>>(), run.times_between_poses(ANNA))
    };
    let (at, sent, _) = reminded(Habits { heeds: 0.0, ..QUIET }, ReminderKind::Popup);
    let should = [10.0, 15.0, 19.0, 23.0, 27.0, 31.0, 35.0, 39.0, 43.0, 47.0, 51.0, 55.0, 59.0];
    assert!(at == should && sent.is_empty(), "{at:?}");
    let (at, sent, times) = reminded(QUIET, ReminderKind::Toast);
    assert_eq!(at, [10.0, 21.5, 33.0, 44.5, 56.0]);
    assert_eq!(sent, [11.5, 23.0, 34.5, 46.0, 57.5]);
    // A reminder after the threshold makes no time shorter than the threshold.
    assert_eq!(times, [4, 0]);
    let (at, sent, _) = reminded(QUIET, ReminderKind::Counters);
    assert!(at.is_empty() && sent.is_empty());
}

/// Habits of robots, contradictory times, and reminders of nobody are mistakes.
#[test]
fn impossible_habits_are_mistakes() {
    let codes = |p: &Problem| check(p).iter().map(|mistake| mistake.code).collect::<Vec<_>>();
    assert!(codes(&rooms(0.05, lively())).is_empty());
    assert_eq!(codes(&rooms(0.05, Habits { my_pose: times(3.0, 0.2), ..QUIET })), ["HQ0954"]);
    let mut p = rooms(0.05, QUIET);
    p.agents[ROBOT].habits = Some(QUIET);
    assert_eq!(codes(&p), ["HQ0955"]);
    let mut p = rooms(0.05, QUIET);
    p.reminder = Some(Reminder { kind: ReminderKind::Toast, after: 3.0, shorten: 0.8, least: 4.0 });
    assert_eq!(codes(&p), ["HQ0954"]);
    p.agents[ANNA].human = false;
    assert_eq!(codes(&p), ["HQ0955", "HQ0955", "HQ0954"]);
}

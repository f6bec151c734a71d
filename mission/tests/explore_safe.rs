//! States from which a robot can always give way: against people who hunt the robots, in random rooms.

use hierarq_mission::kind::{Detail, Event, Mission, Run};
use hierarq_mission::kinds::explore::Explore;
use hierarq_mission::kinds::explore::lattice::Ground;
use hierarq_mission::kinds::explore::motion::{Dynamics, State};
use hierarq_mission::kinds::explore::polygon::Point;
use hierarq_mission::kinds::explore::problem::{Escape, Model, Obstacle, Problem};
use proptest::prelude::*;

use crate::explored::{rectangle, world};

/// A room with walls in these cells, one robot, and a person who walks on straight unless told otherwise.
fn room(walls: &[[usize; 2]], robot: Point, person: Point) -> Problem {
    let mut problem = world();
    let middle = |cell: &[usize; 2]| [0, 1].map(|axis| cell[axis] as f64 + 0.5);
    let wall = |(index, cell): (usize, &[usize; 2])| Obstacle {
        name: format!("o{index}"),
        shape: rectangle(middle(cell), [1.0, 1.0]),
    };
    problem.obstacles = walls.iter().enumerate().map(wall).collect();
    problem.robots.truncate(1);
    problem.robots[0].start = robot;
    problem.person.start = person;
    problem.person.walks = Model::ConstantVelocity;
    problem.person.predicted = Model::ConstantVelocity;
    problem.periods = 6;
    problem.planner.escape = Escape::Required;
    problem
}

fn stands(at: Point) -> State {
    State { at, velocity: [0.0; 2] }
}

/// A corridor of the width of a cell along the left edge, closed above, with a way out to the right at 4 to 5 m.
#[test]
fn a_robot_in_a_dead_end_cannot_give_way_to_a_person_at_its_mouth() {
    let walls: Vec<[usize; 2]> = [1, 2, 3, 5, 6].map(|row| [1, row]).to_vec();
    let problem = room(&walls, [0.5, 6.5], [0.5, 4.5]);
    let ground = Ground::new(&problem).unwrap();
    let can = |at: Point, person: Point| ground.can_give_way(&problem, 0, stands(at), person);
    // The person can be at the mouth before the robot is out of it.
    assert!(!can([0.5, 6.5], [0.5, 3.5]));
    assert!(can([0.5, 4.5], [0.5, 1.5]) && can([3.5, 3.5], [0.5, 3.5]));
    // The person is farther from the mouth than the robot, which is faster.
    assert!(can([0.5, 6.5], [6.5, 0.5]));
    // Between states of the lattice.
    assert!(can([3.37, 3.81], [0.5, 3.5]) && !can([0.52, 6.47], [0.5, 3.5]));
}

/// Nothing is claimed of robots that the person outruns, and of people who do not walk a cell in each period.
#[test]
fn nothing_is_known_of_slow_robots_and_of_other_steps() {
    let mut problem = room(&[], [3.5, 3.5], [0.5, 0.5]);
    problem.person.speed = 0.7;
    let ground = Ground::new(&problem).unwrap();
    assert!(ground.can_give_way(&problem, 0, stands([0.5, 0.6]), [0.5, 0.5]));
    let mut problem = room(&[], [3.5, 3.5], [0.5, 0.5]);
    problem.robots[0].dynamics = Dynamics::Lag(0.3);
    assert!(Ground::new(&problem).is_none());
}

/// Runs a mission whose person walks to the nearest robot, again and again; the number of contacts, and of periods without a plan.
fn hunted(problem: &Problem) -> (f64, f64) {
    let mission = Explore { problem: problem.clone() };
    let mut run = mission.execute(&Run::default()).unwrap();
    for second in 1..20_u32 {
        run.advance(f64::from(second) - 0.5);
        if run.done().is_some() {
            break;
        }
        let at = run.measure("position", Some(problem.robots.len()));
        let robots = (0..problem.robots.len()).map(|robot| run.measure("position", Some(robot)));
        let far = |of: &[f64; 3]| f64::hypot(of[0] - at[0], of[1] - at[1]);
        let nearest = robots.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
        let to = Detail::Point([nearest[0], nearest[1]]);
        // Cells that no way leads to are refused.
        let _ = run.handle(&Event::of("strays", problem.robots.len()).and("to", to));
    }
    (run.measure("collisions", None)[0], run.measure("without_plan", None)[0])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, max_shrink_iters: 20, ..ProptestConfig::default() })]

    /// The plans know nothing of the hunt. A robot that begins in a safe state is never touched.
    #[test]
    fn a_person_who_hunts_a_robot_never_touches_it(
        walls in prop::collection::btree_set((0..7_usize, 0..7_usize), 0..14),
        robot in [0..7_usize, 0..7_usize],
        person in [0..7_usize, 0..7_usize],
    ) {
        let middle = |cell: [usize; 2]| cell.map(|x| x as f64 + 0.5);
        let walls: Vec<[usize; 2]> = walls.into_iter().map(|(x, y)| [x, y]).collect();
        prop_assume!(!walls.contains(&robot) && !walls.contains(&person) && !walls.contains(&[6, 6]) && person != [6, 6]);
        let problem = room(&walls, middle(robot), middle(person));
        prop_assume!(Explore { problem: problem.clone() }.check().is_ok());
        let ground = Ground::new(&problem);
        prop_assume!(ground.is_some_and(|ground| ground.can_give_way(&problem, 0, stands(middle(robot)), middle(person))));
        prop_assert_eq!(hunted(&problem).0, 0.0);
    }
}

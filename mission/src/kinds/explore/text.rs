//! An exploration as text, for people to review and for snapshots to hold.

use std::fmt::Write;

use quantities::number;

use super::mission::Explore;
use super::motion::Dynamics;
use super::polygon::{Convex, Point};
use super::problem::{Escape, Fallback, Model};

/// The text. `name` is that of the mission.
pub(super) fn text(name: &str, of: &Explore) -> String {
    let p = &of.problem;
    let mut out = format!("mission {name} : explore\n");
    let mut line = |text: String| {
        let _ = writeln!(out, "  {text}");
    };
    line(format!("area {}", corners(&p.area)));
    line(format!("exit {}", corners(&p.exit)));
    line(format!("connected within {}", corners(&p.connection)));
    line(format!("period {} s, at most {} periods, effort weighs {}", number(p.period), p.periods, number(p.effort)));
    let fallback = match p.planner.fallback {
        Fallback::Stop => "the robots stop",
        Fallback::Barrier => "the robots keep clear and connected",
    };
    line(match p.planner.escape {
        Escape::Ignored => "a robot may be cornered where the person turns against the prediction".into(),
        Escape::Preferred => "robots that stay connected keep out of states in which the person can corner them".into(),
        Escape::Required => {
            "robots keep out of states in which the person can corner them, before they stay connected".into()
        }
    });
    line(format!(
        "planned to a gap of {}, at most {} nodes; without a plan {fallback}",
        number(p.planner.gap),
        p.planner.nodes
    ));
    for robot in &p.robots {
        let dynamics = match robot.dynamics {
            Dynamics::Velocity => "its velocity is the input".into(),
            Dynamics::Acceleration => "its acceleration is the input".into(),
            Dynamics::Lag(constant) => format!("it follows a velocity with a lag of {} s", number(constant)),
        };
        let (speed, most) = (number(robot.speed), number(robot.acceleration));
        line(format!(
            "robot {} at {}, {dynamics}; at most {speed} m/s and {most} m/s^2",
            robot.name,
            point(robot.start)
        ));
    }
    let person = &p.person;
    line(format!(
        "human {} at {}, at {} m/s over cells of {} m; walks by {}, predicted by {}",
        person.name,
        point(person.start),
        number(person.speed),
        number(person.cell),
        model(&person.walks),
        model(&person.predicted)
    ));
    for target in &p.targets {
        line(format!(
            "target {} of type {} worth {}: {}",
            target.name,
            p.types[target.of],
            number(target.worth),
            corners(&target.shape)
        ));
    }
    for obstacle in &p.obstacles {
        line(format!("obstacle {}: {}", obstacle.name, corners(&obstacle.shape)));
    }
    out
}

fn point([x, y]: Point) -> String {
    format!("({}, {}) m", number(x), number(y))
}

fn corners(of: &Convex) -> String {
    let all: Vec<String> = of.corners().iter().map(|[x, y]| format!("({:.3}, {:.3})", x + 0.0, y + 0.0)).collect();
    format!("{} m", all.join(" "))
}

fn model(of: &Model) -> String {
    match of {
        Model::Policy(file) => format!("the policy {} of {} bytes", file.path, file.bytes.len()),
        Model::GoalDirected { values } if values.is_empty() => "the shortest ways to targets".into(),
        Model::GoalDirected { values } => {
            let values: Vec<String> = values.iter().map(|value| number(*value)).collect();
            format!("the shortest ways to targets with values {}", values.join(", "))
        }
        Model::ConstantVelocity => "going straight on".into(),
    }
}

//! An exploration as a [`Mission`](kind::Mission): its parts, its checks, and how it is executed.

use learning::grid::World;
use serde::{Deserialize, Serialize};

use crate::kind::course::{Drivable, GroundPose};
use crate::kind::pages::{Pages, ServeSettings};
use crate::kind::{self, Event, EventInfo, Further, Impossible, Kind, Member, Mistake, NotOf, Run};
use crate::labels::Labels;
use crate::planned::{PlanOptions, Planned, Refusal};

use super::blocks::EXPLORE;
use super::build::build;
use super::check::{Item, check};
use super::execution::{ExploreExecution, MEASURES, Settings};
use super::grid::Grid;
use super::mind::{Mind, world};
use super::pages::ExplorePages;
use super::planned::PREDICTIVE;
use super::problem::{MAX_PERIODS, Problem};
use super::{event, text};

/// Targets and obstacles take part in no event.
const A_TARGET: NotOf = NotOf { role: "target", who: "a target", why: "a target is taken, and performs nothing" };
const AN_OBSTACLE: NotOf =
    NotOf { role: "obstacle", who: "an obstacle", why: "an obstacle stands where it is, and performs nothing" };

/// An event of everybody who moves.
const fn of_all(name: &'static str) -> EventInfo {
    EventInfo { name, with: &[], not_of: &[A_TARGET, AN_OBSTACLE], not_driven: None }
}

/// An event of the person.
const fn of_person(name: &'static str, with: &'static [Further]) -> EventInfo {
    const OTHERS: &[NotOf] = &[
        A_TARGET,
        AN_OBSTACLE,
        NotOf { role: "robot", who: "a robot", why: "a robot follows the plan, which is made anew in each period" },
    ];
    EventInfo { name, with, not_of: OTHERS, not_driven: None }
}

const TO: &[Further] = &[Further { key: "to", required: Some("[2.5, 0.5] m") }];

/// The entry of the kind.
pub static KIND: Kind = Kind {
    name: "explore",
    title: "an exploration",
    doc: "Robots that predict a person among targets, and take over those that the person leaves.",
    schema: &EXPLORE,
    build: |declared, remarks| Box::new(build(declared, remarks)),
    measures: || MEASURES.iter().map(|(measure, _)| measure).collect(),
    events: &[
        of_all("lost"),
        of_all("back"),
        of_person("late", &[Further { key: "by", required: Some("5 s") }]),
        of_person("strays", TO),
        of_person("my_pose", TO),
        of_person("done", &[]),
    ],
    absent: &[
        ("travel", "robots of an exploration move by their dynamics"),
        ("failed", "a target that was not reached stays open, and the next plan knows it"),
        ("moved", "robots of an exploration move by their dynamics; of the person write `strays`"),
        ("my_goal", "the robots predict the person by a model, and ask for no goal"),
        ("robot_goal", "the plan decides where robots go"),
        ("robot_pose", "robots are seen"),
        ("free", "nobody tells goals"),
        ("seen", "the person is seen at each period, but while `lost`"),
        ("found", "an exploration has no hidden objects"),
        ("begun", "the person acts as the model says"),
        ("served", "an exploration has no services"),
        ("feedback", "feedback rates a service, and an exploration has no services"),
    ],
    formulations: || vec![PREDICTIVE],
    plan_keys: include_str!("plan.schema.json"),
    read: |value| Ok(Box::new(serde_json::from_value::<Explore>(value)?)),
};

/// An exploration to be planned and executed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Explore {
    /// The problem of the planner.
    pub problem: Problem,
}

impl Explore {
    /// The settings of a run.
    pub fn settings(&self, how: &Run) -> Settings {
        let played = how.reporting.contains(&self.problem.robots.len());
        Settings { sampled: how.sampled, replan: how.replan, played, nodes: None, driven: how.driven.clone() }
    }
}

/// Everybody who takes part: robots, the person, targets, and then obstacles.
pub(super) fn members(problem: &Problem) -> Vec<Member<'_>> {
    let robots = problem.robots.iter().map(|robot| Member { name: &robot.name, role: "robot" });
    let person = std::iter::once(Member { name: &problem.person.name, role: "human" });
    let targets = problem.targets.iter().map(|target| Member { name: &target.name, role: "target" });
    let obstacles = problem.obstacles.iter().map(|obstacle| Member { name: &obstacle.name, role: "obstacle" });
    robots.chain(person.filter(|person| !person.name.is_empty())).chain(targets).chain(obstacles).collect()
}

impl kind::Mission for Explore {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn members(&self) -> Vec<Member<'_>> {
        members(&self.problem)
    }

    fn labels(&self) -> &Labels {
        &self.problem.labels
    }

    fn map_changes(&self) -> bool {
        true
    }

    fn drivable(&self, member: usize) -> Option<Drivable> {
        let robot = self.problem.robots.get(member)?;
        Some(Drivable { start: GroundPose { at: robot.start, heading: 0.0 }, speed: robot.speed })
    }

    fn grid_world(&self, types: usize) -> Option<Result<World, String>> {
        let used = self.problem.targets.iter().map(|target| target.of + 1).max().unwrap_or(1);
        if types < used {
            return Some(Err(format!("the targets have {used} types, and the policy would know {types}")));
        }
        let grid = Grid::new(&self.problem).ok_or_else(|| "the grid has no cells, or too many".to_string());
        Some(grid.and_then(|grid| world(&grid, types)))
    }

    fn check(&self) -> Result<(), Mistake> {
        let p = &self.problem;
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let settings = positive(p.period)
            && (1..=MAX_PERIODS).contains(&p.periods)
            && p.effort.is_finite()
            && p.effort >= 0.0
            && positive(p.planner.gap)
            && positive(p.planner.time)
            && p.planner.time <= 1e6
            && p.planner.nodes >= 1
            && positive(p.person.speed)
            && positive(p.person.cell)
            && p.robots.iter().all(|robot| {
                let lag = match robot.dynamics {
                    super::motion::Dynamics::Lag(constant) => positive(constant),
                    _ => true,
                };
                lag && positive(robot.speed) && positive(robot.acceleration)
            })
            && p.targets.iter().all(|target| target.of < p.types.len() && positive(target.worth));
        Mistake::unless(settings, "the mission", "a setting is out of its range")?;
        if let Some(mistake) = check(p).into_iter().find(|mistake| mistake.is_error) {
            let place = match mistake.item {
                Item::Mission => "the mission".into(),
                Item::Robot(i) => format!("robots.{i}"),
                Item::Person => "person".into(),
                Item::Target(i) => format!("targets.{i}"),
                Item::Obstacle(i) => format!("obstacles.{i}"),
            };
            return Err(Mistake { place, why: mistake.text });
        }
        let Some(grid) = Grid::new(p) else {
            return Err(Mistake { place: "person".into(), why: "the grid has no cells".into() });
        };
        for (place, model) in [("person.walks", &p.person.walks), ("person.predicted", &p.person.predicted)] {
            Mind::new(p, &grid, model).map_err(|why| Mistake { place: place.into(), why })?;
        }
        p.labels.check_among(members(p).iter().map(|member| member.name))
    }

    fn check_run(&self, how: &Run) -> Result<(), String> {
        if how.bases || !how.replies.is_empty() {
            return Err("an exploration has no bases and no services".into());
        }
        if how.driven.iter().any(|driven| driven.member >= self.problem.robots.len()) {
            return Err("controllers drive robots alone".into());
        }
        Ok(())
    }

    fn check_event(&self, of: &Event) -> Result<(), Impossible> {
        event::typed(&self.problem, of).map(|_| ()).map_err(Impossible::from)
    }

    fn describe(&self, of: &Event) -> String {
        event::describe(&self.problem, of)
    }

    fn describe_run(&self, how: &Run) -> String {
        match how.sampled {
            Some(_) => "the actions of the person are drawn".into(),
            None => "the person acts as the model finds most likely".into(),
        }
    }

    fn text(&self, name: &str) -> String {
        text::text(name, self)
    }

    fn plan(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        self.planned(options)
    }

    fn execute(&self, how: &Run) -> Result<Box<dyn kind::Execution>, String> {
        Ok(Box::new(ExploreExecution::new(self.problem.clone(), self.settings(how))?))
    }

    fn pages(&self, of: &ServeSettings) -> Result<Box<dyn Pages>, String> {
        let settings = Settings { nodes: of.nodes, ..self.settings(&of.run()) };
        Ok(Box::new(ExplorePages::new(ExploreExecution::new(self.problem.clone(), settings)?)))
    }
}

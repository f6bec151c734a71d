//! What about a schedule can be planned and is hardly meant.

use dsl::tree::Mission;
use dsl::{Diagnostic, Span};
use mission::kinds::schedule::check::{Item, Key};
use mission::kinds::schedule::problem::{AgentKind, Problem};
use mission::numbers::Range;
use runtime::text::number;

use super::super::Lowerer;
use super::places::OfSchedule as Places;

impl Lowerer<'_> {
    /// Warns of robots and agents without anything to do, of a cost that is always zero, of speeds that are not as
    /// written, and of robots that wait behind their depots.
    pub(super) fn schedule_warnings(&mut self, m: &Mission, problem: &Problem, places: &Places) {
        for (i, who) in problem.agents.iter().enumerate().filter(|(_, who)| who.operations == 0) {
            let at = places.key(Item::Agent(i), Key::Operations).unwrap_or(m.name.span);
            let d = Diagnostic::warning("HQ0907", at, format!("no robot ever comes to `{}`", who.name));
            self.push(d.help("give it operations, or leave it out"));
        }
        let (robots, services) = (problem.robots.len(), problem.operations());
        if robots > services {
            let count = if services == 1 { "one service".to_string() } else { format!("{services} services") };
            let text = format!("{robots} robots for {count}: some never leave their depot");
            let at =
                m.members.iter().filter(|k| k.role.value == "robot").nth(services).map_or(m.name.span, |k| k.name.span);
            self.push(Diagnostic::warning("HQ0907", at, text).help("leave robots out, or add operations"));
        }
        if is_free(problem) {
            let at = places.key(Item::Mission, Key::Weights).unwrap_or(m.name.span);
            let d =
                Diagnostic::warning("HQ0908", at, "nothing costs anything, so that every plan is as good as any other");
            self.push(d.help("write a weight above zero, such as `makespan 1`"));
        }
        self.clamped(problem, places);
        self.behind(problem, places);
    }

    /// Warns of robots that wait farther from an agent than their depot is.
    fn behind(&mut self, problem: &Problem, places: &Places) {
        for (k, who) in problem.agents.iter().enumerate().filter(|(_, who)| who.operations > 0) {
            for (i, robot) in problem.robots.iter().enumerate() {
                let (far, near) = (problem.lengths(k, i).depositing, problem.approach(who, i).1);
                if near <= far {
                    continue;
                }
                let (depot, agent) = (number(far), &who.name);
                let text = format!(
                    "`{}` waits {} m from `{agent}`, and its depot is {depot} m away",
                    robot.name,
                    number(near)
                );
                let at = places.approach(k, i).or_else(|| places.key(Item::Agent(k), Key::WaitDistance));
                let at =
                    at.or_else(|| places.key(Item::Agent(k), Key::Place)).unwrap_or(places.of(Item::Agent(k), None));
                let d = Diagnostic::warning("HQ0914", at, text)
                    .note("it goes away from the agent first, and comes back to serve")
                    .help(format!("wait at most {depot} m away, or put the depot elsewhere"));
                self.push(d);
                break;
            }
        }
    }

    /// Warns of speeds near an agent that are cut to those of the robot.
    fn clamped(&mut self, problem: &Problem, places: &Places) {
        for (i, robot) in problem.robots.iter().enumerate() {
            let own = places.key(Item::Robot(i), Key::Proximity).zip(robot.proximity);
            let speed = (robot.speed, places.key(Item::Robot(i), Key::Speed));
            self.cut(own, speed);
            for (k, who) in problem.agents.iter().enumerate() {
                let asked = who.approaches.iter().find(|a| a.robot == i).and_then(|a| a.speed);
                self.cut(places.approach(k, i).zip(asked), speed);
            }
        }
    }

    fn cut(&mut self, asked: Option<(Span, Range)>, (cruise, at_cruise): (Range, Option<Span>)) {
        let Some((at, range)) = asked.filter(|(_, r)| r.low < cruise.low || r.high > cruise.high) else { return };
        let (low, high) = (range.low.max(cruise.low), range.high.min(cruise.high));
        let text =
            format!("the robot comes at {} to {} m/s, and not at all speeds of this range", number(low), number(high));
        let d = Diagnostic::warning("HQ0909", at, text)
            .note("near an agent a robot keeps to its own range of speeds too")
            .help(format!("write `[{}, {}] m/s`, or widen the speeds of the robot", number(low), number(high)));
        self.push(match at_cruise {
            Some(at) => d.label(at, "how fast the robot may go"),
            None => d,
        });
    }
}

/// True where the cost of every plan is zero.
fn is_free(problem: &Problem) -> bool {
    let weights = problem.weights;
    let has = |kind: AgentKind| problem.agents.iter().any(|a| a.kind == kind && a.operations > 0);
    let waits = (0..problem.agents.len())
        .filter(|a| problem.agents[*a].kind == AgentKind::Human)
        .any(|a| (0..problem.agents[a].operations).any(|i| problem.wait_weight(a, i) > 0.0));
    weights.energy == 0.0
        && weights.makespan == 0.0
        && !waits
        && (weights.worker_wait == 0.0 || !has(AgentKind::Worker))
}

//! Scenarios of missions: how one is executed, for how long, and what is expected of it. What happens in it stands in
//! `events.rs`.

use blocks::{Block as _, BoundBlock, Located};
use dsl::tree::{Block, Scenario};
use dsl::{Diagnostic, Help, Snippet, Span};
use mission::execution::Replan;
use mission::kind::Run;
use runtime::program::{MAX_INSTANTS, MAX_MISSION, MissionProgram, MissionScenarioProgram, step_within};
use runtime::text::number;

use super::super::Lowerer;
use super::executed::Executed;
use super::runs::Machines;
use crate::block_binding::Scope;
use crate::expand::Expanded;
use crate::forms::{text_of, unknown_key};
use crate::sections::{OF_ALL_SCENARIOS, OF_MISSIONS, SCENARIO, ScenarioBlock};

/// True for a scenario that runs a mission.
pub(crate) fn runs_mission(s: &Scenario) -> bool {
    s.body.get("mission").is_some()
}

/// True for an entry of a scenario of missions, or of one of a robot's controller.
pub(in crate::lowering) fn is_of(key: &str, of_mission: bool) -> bool {
    OF_ALL_SCENARIOS.contains(&key) || OF_MISSIONS.contains(&key) == of_mission
}

/// Reports keys of a scenario that it does not have, and says of those of the other kind of scenario why not.
pub(in crate::lowering) fn check_scenario_keys(body: &Block, of_mission: bool, diagnostics: &mut Vec<Diagnostic>) {
    let keys: Vec<&str> = SCENARIO.entries().filter(|key| is_of(key, of_mission)).collect();
    for (i, e) in body.entries.iter().enumerate() {
        let key = e.key.value.as_str();
        if keys.contains(&key) {
            continue;
        }
        if !SCENARIO.entries().any(|k| k == key) {
            diagnostics.push(unknown_key(diagnostics.len(), body, i, &keys, SCENARIO.name));
            continue;
        }
        let d = if of_mission {
            let d = Diagnostic::error("HQ0921", e.key.span, format!("a scenario of a mission has no `{key}`"))
                .note("it belongs to scenarios of a robot's controller; a mission has members in place of links and signals")
                .help("leave it out, or write it in a scenario of its own, without `mission`");
            body.get("mission").map(|m| m.key.span).map_or(d.clone(), |at| d.label(at, "this runs a mission"))
        } else {
            Diagnostic::error("HQ0921", e.key.span, format!("a scenario of a robot's controller has no `{key}`"))
                .note("it belongs to missions, and this scenario runs a single robot")
                .help(Help::with("name the mission, {}, or remove it", [Snippet::entry("mission", "NAME")]))
        };
        diagnostics.push(d);
    }
}

impl Lowerer<'_> {
    /// The scenarios of missions, each brought to its mission.
    pub(in crate::lowering) fn mission_scenarios(&mut self, expanded: &Expanded, missions: &mut [MissionProgram]) {
        for (s, texts) in expanded.scenarios.iter().filter(|(s, _)| runs_mission(s)) {
            check_scenario_keys(&s.body, true, self.diagnostics);
            let Some(index) = self.mission_of(s, expanded, missions) else { continue };
            let Some(of) = missions.get(index) else { continue };
            let planned = of.clone();
            let name = &planned.name;
            let of = Executed { name, mission: &*planned.kind, driven: &[] };
            if of.mission.waits_for_tasks() {
                let at = s.body.get("mission").map_or(s.name.span, |e| e.value.span);
                let text = format!("`{name}` has no layers yet, so that this scenario fails");
                let d = Diagnostic::warning("HQ0924", at, text);
                self.push(d.help("ask a language model for them, `hierarq context`, or write them"));
            }
            let (machines, per_second) = (Machines::of(&planned.running), planned.running.ticks(1.0));
            let driven: Vec<usize> =
                planned.running.workers.iter().filter(|w| w.drive().is_some()).map(|w| w.member).collect();
            let Some((mut scenario, at)) = self.mission_scenario(s, of, &driven) else { continue };
            let duration = s.body.get("duration").map_or(s.name.span, |e| e.value.span);
            if !self.ticks_fit(&scenario, per_second, duration) {
                continue;
            }
            self.mission_expectations((&s.expects, texts), (of, &machines), &mut scenario, at);
            if let Some(of) = missions.get_mut(index) {
                of.scenarios.push(scenario);
            }
        }
    }

    /// Reports scenarios of a spec of missions alone that do not say which of these they run.
    pub(in crate::lowering) fn nothing_runs(&mut self, expanded: &Expanded) {
        for (_, span) in &expanded.coverage {
            let d =
                Diagnostic::error("HQ0574", *span, "a coverage is about the stacks of a robot, and this spec has none");
            self.push(d.note("this spec declares missions and no robot").help("write it into the spec of a robot"));
        }
        for (s, _) in expanded.scenarios.iter().filter(|(s, _)| !runs_mission(s)) {
            let text = format!("the scenario `{}` has nothing to run", s.name.value);
            let d = Diagnostic::missing_keys(["mission"], s.name.span, text)
                .note("this spec declares missions and no robot");
            let first = expanded.missions.first().map_or("NAME", |m| &m.name.value);
            self.push(d.help(Help::with("name the mission: {}", [Snippet::entry("mission", first)])));
        }
    }

    /// The number of the mission that a scenario runs, among those that could be made.
    fn mission_of(&mut self, s: &Scenario, expanded: &Expanded, missions: &[MissionProgram]) -> Option<usize> {
        let e = s.body.get("mission")?;
        let Some(name) = text_of(&e.value) else {
            if !matches!(e.value.kind, dsl::tree::ValueKind::Missing) {
                let d = Diagnostic::error("HQ0304", e.value.span, "`mission` is the name of a mission");
                self.push(d.help("write the name of the mission as declared"));
            }
            return None;
        };
        let names = || expanded.missions.iter().map(|m| m.name.value.as_str());
        if !names().any(|n| n == name) {
            let d = Diagnostic::undeclared("mission", name, e.value.span);
            self.push(
                d.help(Help::with(
                    "this spec declares none: write {}",
                    [Snippet::each("mission NAME : KIND { .. }", "missions: { NAME: { KIND: { .. } } }")],
                ))
                .one_of("declared are", name, names()),
            );
            return None;
        }
        // One in which something is wrong was reported, and is not among these.
        missions.iter().position(|m| m.name == name)
    }

    /// A scenario without its expectations, and where its step was written. `driven` are the members that controllers can drive.
    fn mission_scenario(
        &mut self,
        s: &Scenario,
        of: Executed,
        driven: &[usize],
    ) -> Option<(MissionScenarioProgram, Span)> {
        let before = self.errors();
        let scope = Scope::default();
        let bound = self.block_binder(&scope).entries(&s.body, &SCENARIO, s.name.span, |key| is_of(key, true));
        let block = ScenarioBlock::read(&bound);
        let at = |name: &str| s.body.get(name).map_or(s.name.span, |e| e.value.span);
        let duration = self.mission_duration(&block, &bound);
        let written = s.body.get("step").is_some();
        let longest = block.step;
        let (sampled, bases) = (block.operations == "sampled", block.travel == "bases");
        let replan = match block.replan {
            "none" => Replan::None,
            "reschedule" => Replan::Reschedule,
            _ => Replan::Both,
        };
        let run = Run { bases, ..Run::default() };
        if bases
            && of.kind().absent.iter().all(|absent| absent.0 != "travel")
            && let Err(why) = of.mission.check_run(&run)
        {
            let d = Diagnostic::error("HQ0924", at("travel"), why);
            self.push(d.help(Help::with(
                "leave `distances` out of the mission, or write {}",
                [Snippet::entry("travel", "planned")],
            )));
        }
        let duration = duration?;
        let step = step_within(duration, longest);
        if written && step != longest {
            self.uneven_steps((at("step"), longest), (at("duration"), duration));
        }
        if duration / longest > f64::from(MAX_INSTANTS) {
            let text = format!("the run would be judged at more than {MAX_INSTANTS} instants");
            let d = Diagnostic::error("HQ0924", at("duration"), text);
            let d = s.body.get("step").iter().fold(d, |d, e| d.label(e.value.span, "from one instant to the next"));
            self.push(d.help("shorten the run, or write a longer `step`"));
        }
        let settled = self.errors() == before;
        // No controller runs if operations are as planned.
        let of = Executed { driven: if sampled { driven } else { &[] }, ..of };
        let happens = self.mission_events(&s.body, of, duration);
        let replies = self.replies(&s.body, of);
        self.absent_keys(&s.body, of);
        // Mistakes in events and in expectations are independent, and reported at once; those in settings are not.
        if !settled {
            return None;
        }
        let scenario = MissionScenarioProgram {
            name: s.name.value.clone(),
            duration,
            step,
            seed: block.seed as u64,
            sampled,
            bases,
            replan,
            happens,
            replies,
            measures: Vec::new(),
            predicates: Vec::new(),
            expectations: Vec::new(),
        };
        Some((scenario, at("step")))
    }

    /// The last instant would not be the end of the run.
    fn uneven_steps(&mut self, (at, step): (Span, f64), (end, duration): (Span, f64)) {
        let whole = (duration / step).ceil() * step;
        let text = format!(
            "no instant is at the end, {} s: the one before it is at {} s",
            number(duration),
            number(whole - step)
        );
        let d = Diagnostic::error("HQ0925", at, text).label(end, "how long it runs");
        let d = d.note("events after the last instant are neither evaluated nor logged");
        self.push(d.help(format!("a run of {} s ends with such a step, or leave `step` out", number(whole))));
    }

    fn mission_duration(&mut self, block: &ScenarioBlock, bound: &BoundBlock) -> Option<f64> {
        let Some(Located { at, value: duration }) = block.duration else {
            if !bound.is_wrong("duration") {
                let at = self.origins.span(bound.at);
                let d = Diagnostic::missing_keys(["duration"], at, "a scenario of a mission needs `duration`");
                let d = d.note("a mission may wait for a member that never comes back");
                self.push(d.help(Help::with(
                    "write how long it runs, for instance {}: longer than the plan",
                    [Snippet::entry("duration", "4000 s")],
                )));
            }
            return None;
        };
        if duration > MAX_MISSION {
            let text = format!("a mission runs for at most {MAX_MISSION} s, which are eleven days");
            self.push(Diagnostic::error("HQ0924", self.origins.span(at), text).help("shorten the run"));
            return None;
        }
        Some(duration)
    }
}

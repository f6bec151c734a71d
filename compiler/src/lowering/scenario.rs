//! Scenarios: the stack or machine to run, the start, and the duration.

use std::collections::BTreeMap;

use blocks::{Block as _, BoundBlock, Located};
use dsl::tree::{Block, Scenario, Value, ValueKind};
use dsl::{Diagnostic, Span};
use runtime::program::{Program, ScenarioProgram, Subject, WorldProgram};
use stdlib_tasks::dimension::Dimension;

use super::Lowerer;
use super::declared::twice;
use super::missions::scenario::{check_scenario_keys, is_of, runs_mission};
use super::shapes::shapes;
use super::world::numbers;
use crate::block_binding::Scope;
use crate::expand::Expanded;
use crate::expr::constants::{Constants, joint_dimension};
use crate::forms::block_of;
use crate::robot_binding::{BaseEntry, BoundRobot, joints};
use crate::sections::{SCENARIO, ScenarioBlock, ScenarioSimulator};
use crate::source_map::{ScenarioPlaces, SourceMap};
use crate::units;

impl Lowerer<'_> {
    /// Lowers the scenarios of a spec whose program is otherwise complete. `source_map` gets the places of each.
    pub(super) fn scenarios(
        &mut self,
        expanded: &Expanded,
        program: &Program,
        robot: &BoundRobot,
        source_map: &mut SourceMap,
    ) -> Vec<ScenarioProgram> {
        let shapes = shapes(program);
        let mut measures = Vec::new();
        let mut all: Vec<ScenarioProgram> = Vec::new();
        for (written, (s, texts)) in expanded.scenarios.iter().enumerate().filter(|(_, (s, _))| !runs_mission(s)) {
            let Some(mut scenario) = self.scenario(s, program, robot) else { continue };
            let known = (program, robot, shapes.as_slice());
            let start = s.body.get("start").map_or(s.name.span, |e| e.key.span);
            let mut places = ScenarioPlaces { start, written, nodes: Vec::new(), atoms: Vec::new() };
            self.expectations((&s.expects, texts), (&mut scenario, &mut places), known, &mut measures);
            all.push(scenario);
            source_map.scenarios.push(places);
        }
        source_map.scenario_measures = measures;
        all
    }

    /// Reports duplicate names of scenarios, including those of missions.
    pub(super) fn scenario_names(&mut self, expanded: &Expanded) {
        let mut names: BTreeMap<&str, Span> = BTreeMap::new();
        for (s, _) in &expanded.scenarios {
            match names.get(s.name.value.as_str()) {
                Some(first) => self.push(twice(&s.name, *first)),
                None => {
                    names.insert(&s.name.value, s.name.span);
                }
            }
        }
    }

    /// Lowers a scenario without its expectations.
    fn scenario(&mut self, s: &Scenario, program: &Program, robot: &BoundRobot) -> Option<ScenarioProgram> {
        check_scenario_keys(&s.body, false, self.diagnostics);
        let scope = Scope::default();
        let bound = self.block_binder(&scope).entries(&s.body, &SCENARIO, s.name.span, |key| is_of(key, false));
        let block = ScenarioBlock::read(&bound);
        let mut run = program.run.clone();
        let subject = self.subject(&block, &bound, program);
        run.simulator.seed = block.seed as u64;
        if let Some(Located { at, value }) = block.duration {
            run.duration = value;
            self.duration_fits(value, self.origins.span(at), robot);
        }
        let ScenarioSimulator { lag, noise, speed, acceleration } = block.simulator;
        run.simulator.lag = lag.unwrap_or(run.simulator.lag);
        run.simulator.noise = noise.unwrap_or(run.simulator.noise);
        run.simulator.speed = speed.or(run.simulator.speed);
        run.simulator.acceleration = acceleration.or(run.simulator.acceleration);
        self.idle_simulator(&run.simulator, &block.plant);
        run.simulator.plant = self.plant(&block.plant, Some(robot)).or(run.simulator.plant);
        self.behind_the_end(&s.body, run.duration);
        run.subject = subject?;
        Some(ScenarioProgram {
            name: s.name.value.clone(),
            start: self.start(&s.body, robot),
            world: self.world(&s.body, &block, program, robot),
            run,
            measures: Vec::new(),
            predicates: Vec::new(),
            expectations: Vec::new(),
        })
    }

    /// Warns of what the script of a scenario begins after the end of the run.
    fn behind_the_end(&mut self, body: &Block, duration: f64) {
        let mut times: Vec<&Value> = Vec::new();
        for e in &body.entries {
            match e.key.value.as_str() {
                "signals" | "humans" | "push" | "late" | "lost" => beginnings(&e.value, &mut times),
                "stop" | "resume" => times.extend(e.value.items()),
                "events" => {
                    if let ValueKind::Block(block) = &e.value.kind {
                        times.extend(block.entries.iter().flat_map(|e| e.value.items()));
                    }
                }
                _ => {}
            }
        }
        for value in times {
            let typed = Constants { graph: &mut self.graph, params: &mut self.params }.argument(value);
            let number = typed.and_then(|typed| self.graph.constant(*typed.nodes.first()?));
            if number.is_some_and(|at| at > duration) {
                let text = format!("this is after the end of the run at {} s", runtime::text::number(duration));
                let d = Diagnostic::warning("HQ0809", value.span, text);
                self.push(d.help("write an earlier time, or a longer `duration`"));
            }
        }
    }

    /// Stack or machine that runs. Returns `None` if it is invalid, with diagnostics.
    fn subject(&mut self, block: &ScenarioBlock, bound: &BoundBlock, program: &Program) -> Option<Subject> {
        let stacks: Vec<&str> = program.stacks.iter().map(|s| s.name.as_str()).collect();
        let machine = program.machine.iter().filter_map(|m| m.states.first()).map(|s| s.name.as_str());
        match (&block.stack, &block.machine) {
            (Some(_), Some(_)) => {
                let key = |name: &str| self.origins.span(bound.key_origin(name).unwrap_or(bound.at));
                let d = Diagnostic::error("HQ0207", key("machine"), "a scenario runs a stack or a machine, not both");
                let d = d.label(key("stack"), "a stack is named here").help("keep one of the two");
                self.push(d);
                None
            }
            (Some(name), None) => {
                self.one_of("stack", &name.value, self.origins.span(name.at), &stacks).map(Subject::Stack)
            }
            (None, Some(name)) => {
                let machines: Vec<&str> = machine.collect();
                self.one_of("machine", &name.value, self.origins.span(name.at), &machines).map(|_| Subject::Machine)
            }
            (None, None) if bound.is_wrong("stack") || bound.is_wrong("machine") => None,
            (None, None) => Some(program.run.subject),
        }
    }

    /// A constant number that is zero or more.
    pub(super) fn scenario_number(&mut self, value: &dsl::tree::Value, wanted: Dimension) -> Option<f64> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let x = constants.scalar(value, wanted, self.diagnostics)?;
        if x < 0.0 {
            let unit = units::written(wanted);
            let text = format!("zero or more is needed here, and this is {x} {unit}");
            self.push(Diagnostic::error("HQ0308", value.span, text.trim_end()).help("write a number from 0"));
            return None;
        }
        Some(x)
    }

    /// Start configuration of the robot.
    fn start(&mut self, body: &Block, robot: &BoundRobot) -> Vec<f64> {
        let mut q = robot.home.clone();
        let Some(start) = body.get("start") else { return q };
        if self.start_posture(&start.value, None, robot, &mut q) {
            return q;
        }
        let Some(block) = block_of(&start.value, "`start`", self.diagnostics) else { return q };
        let model = &robot.model;
        for e in &block.entries {
            if self.start_posture(&e.value, Some(&e.key.value), robot, &mut q) {
                continue;
            }
            let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
            match BaseEntry::read(model, e, &mut constants, self.diagnostics) {
                BaseEntry::Other => {}
                BaseEntry::Wrong => continue,
                BaseEntry::Coordinates { first, values } => {
                    q[first..first + values.len()].copy_from_slice(&values);
                    continue;
                }
            }
            let key = dsl::tree::Value { kind: dsl::tree::ValueKind::Text(e.key.value.clone()), span: e.key.span };
            let found = joints(std::slice::from_ref(&key), model, &robot.joint_groups, self.diagnostics);
            let Some(dofs) = found else { continue };
            let dofs: Vec<usize> = dofs.into_iter().filter(|&d| model.dofs[d].q_index.is_some()).collect();
            let values = constants.per_joint(&e.value, &dofs, model, self.diagnostics).unwrap_or_default();
            for (&dof, (x, at)) in dofs.iter().zip(values) {
                let d = &model.dofs[dof];
                let Some(i) = d.q_index else { continue };
                q[i] = x;
                if x < d.lower || x > d.upper {
                    let unit = units::written(joint_dimension(model, dof));
                    let text = format!("`{}` starts at {x} {unit}, outside its limits", d.name);
                    let d = Diagnostic::error("HQ0404", at, text)
                        .here(format!("allowed are {} to {} {unit}", d.lower, d.upper))
                        .help("move the joint inside its limits");
                    self.diagnostics.push(d);
                    break;
                }
            }
        }
        q
    }

    /// Moves the start to the posture that a value names, without the joints that the posture leaves out. False if it names none.
    fn start_posture(&mut self, value: &Value, key: Option<&str>, robot: &BoundRobot, q: &mut [f64]) -> bool {
        let Some(name) = robot.postures.named_by(value, key, &self.params) else { return false };
        let positions = match robot.postures.positions(name, key, value.span) {
            Ok(positions) => positions,
            Err(d) => {
                self.push(*d);
                return true;
            }
        };
        for position in positions {
            let dof = robot.model.dof(&position.joint);
            let found = dof.and_then(|dof| Some((dof, robot.model.dofs[dof].q_index?, position.value?)));
            let Some((dof, i, x)) = found else { continue };
            let d = &robot.model.dofs[dof];
            q[i] = x;
            if x < d.lower || x > d.upper {
                let unit = joint_dimension(&robot.model, dof);
                let text = format!("`{}` starts at {}, outside its limits", d.name, units::shown(x, unit));
                let allowed = format!("allowed are {}", units::shown_range(d.lower, d.upper, unit));
                let d = Diagnostic::error("HQ0404", value.span, text).here(allowed);
                self.push(d.help("choose another posture, or correct it in the SRDF"));
                break;
            }
        }
        true
    }

    /// Lowers the behaviour of the world.
    fn world(&mut self, body: &Block, block: &ScenarioBlock, program: &Program, robot: &BoundRobot) -> WorldProgram {
        WorldProgram {
            signals: self.signal_scripts(body, program),
            humans: self.human_scripts(body, program),
            obstacles: self.true_obstacles(body, program),
            events: self.scenario_events(&block.events, program),
            stops: numbers(block.stop.as_ref()),
            resumes: numbers(block.resume.as_ref()),
            outcomes: self.outcome_scripts(body, program),
            pushes: self.push_scripts(body, program, robot),
            late: block.late.iter().map(|late| (late.at, late.by)).collect(),
            lost: self.lost_readings(&block.lost, robot),
        }
    }
}

/// Collects the times at which parts of a script begin. A path is followed only as long as the run lasts, so its instants do not
/// count.
fn beginnings<'v>(value: &'v Value, out: &mut Vec<&'v Value>) {
    match &value.kind {
        ValueKind::List(items) => items.iter().for_each(|item| beginnings(item, out)),
        ValueKind::Block(block) => {
            for e in &block.entries {
                match e.key.value.as_str() {
                    "from" | "at" => out.push(&e.value),
                    "path" | "points" | "shape" | "value" => {}
                    _ => beginnings(&e.value, out),
                }
            }
        }
        _ => {}
    }
}

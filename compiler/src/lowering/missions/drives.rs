//! Robots of a mission whose bases are driven by controllers of their own: what a robot says with `runs`.

use blocks::{Block, BoundBlock, Located};
use dsl::{Diagnostic, Help, Snippet};
use mission::declare::DeclaredMission;
use mission::declare::driven::{DrivenBlock, PEOPLE};
use mission::kind::Mission;
use mission::kind::course::Drivable;
use names::list;
use robot::{Dof, DofUnit};
use runtime::Program;
use runtime::program::{DriveProgram, HumanScript, Job, Running, Sending, Track, WorkerProgram, around, driven_base};

use super::super::Lowerer;

/// A robot that is driven.
pub(super) struct Robot<'m> {
    pub name: &'m str,
    /// Index among the members of the mission.
    pub index: usize,
    pub drivable: Drivable,
}

/// The height (m) of the points of a person in a spec without a scenario that says where they are.
const HEIGHT: f64 = 1.0;

impl Lowerer<'_> {
    /// The controller of a driven robot.
    pub(super) fn drives(
        &mut self,
        bound: &BoundBlock,
        robot: &Robot,
        (declared, mission): (&DeclaredMission, &dyn Mission),
        into: &mut Running,
    ) {
        let block = DrivenBlock::read(bound);
        if bound.is_wrong("spec") {
            return;
        }
        let at = self.origins.span(block.spec.at);
        let Some(program) = self.controller_of(block.spec.value.as_str(), at, "a robot") else { return };
        if !self.has_base(&block, &program, robot) {
            return;
        }
        let spec = block.spec.value.as_str();
        let mut wrong = bound.has_wrong();
        let mut signal = |lowerer: &mut Self, of: Option<&Located<String>>, key: &str, ty: &str, meaning: &str| {
            let of = of.filter(|_| !bound.is_wrong(key))?;
            let found = lowerer.signal_of_way((of, key), (spec, &program), ty, meaning);
            wrong |= found.is_none();
            found
        };
        let target =
            signal(self, Some(&block.target), "target", "point", "the point of the way where the base is to go");
        let heading = signal(self, block.heading.as_ref(), "heading", "angle", "the direction of the way");
        let going = signal(self, block.going.as_ref(), "going", "flag", "true while the robot is on a way");
        let world = (!bound.is_wrong("scenario")).then(|| self.world_of(block.scenario.as_ref(), spec, &program));
        let people = self.people_there(&block, &program, mission);
        let (Some(target), Some(Some(mut world)), Some(people), false) = (target, world, people, wrong) else { return };
        let told = [Some(target), heading, going];
        world.world.signals.retain(|script| !told.contains(&Some(script.signal)));
        // The mission says where the base begins.
        let [x, y] = robot.drivable.start.at;
        world.start.iter_mut().zip([x, y, robot.drivable.start.heading]).for_each(|(q, of)| *q = of);
        for (human, _) in &people {
            let points = program.interface.humans.get(*human).map_or(0, |human| human.points.len());
            match world.world.humans.iter_mut().find(|script| script.human == *human) {
                Some(script) => script.tracks = around(&script.tracks),
                None => world.world.humans.push(HumanScript {
                    human: *human,
                    sending: Sending::default(),
                    tracks: vec![Track(vec![(0.0, [0.0, 0.0, HEIGHT])]); points],
                }),
            }
        }
        self.unseen_people(&block, &program, &world.world.humans, declared);
        let drive = DriveProgram {
            target,
            heading,
            going,
            people,
            tolerance: block.tolerance,
            lead: block.lead,
            ahead: block.ahead,
        };
        let controller = into.add(spec, program);
        into.workers.push(WorkerProgram { member: robot.index, controller, job: Job::Drive(drive), world });
    }

    /// Checks that the robot of a spec has a base that can drive the planned ways.
    fn has_base(&mut self, block: &DrivenBlock, program: &Program, robot: &Robot) -> bool {
        let (spec, at) = (block.spec.value.as_str(), self.origins.span(block.spec.at));
        let model = &program.robot.model;
        let Some(base) = driven_base(model) else {
            let is_placed = model.bases.iter().any(|base| base.kind.drives());
            let text = match is_placed {
                true => format!("the base of `{spec}` has a place of its own, or is one of several robots"),
                false => format!("the robot of `{spec}` has no base that drives on the ground"),
            };
            let d = Diagnostic::error("HQ0961", at, text)
                .note(format!("`{}` follows its way with the base of that robot", robot.name));
            self.push(match is_placed {
                true => d.help("declare one robot there, without `at`, or leave `runs` out"),
                false => d.help(Help::with(
                    "declare one there, {} or {}, or leave `runs` out",
                    [Snippet::entry("base", "unicycle"), Snippet::entry("base", "planar")],
                )),
            });
            return false;
        };
        let translates = |dof: &&Dof| dof.unit == DofUnit::Metre;
        let speeds = model.dofs[base.dofs()].iter().filter(translates).map(|dof| (dof.name.as_str(), dof.velocity));
        let slowest = speeds.min_by(|a, b| a.1.total_cmp(&b.1));
        let wanted = robot.drivable.speed;
        if let Some((name, most)) = slowest.filter(|(_, most)| *most < wanted) {
            let text = format!(
                "the base of `{spec}` drives at most {most} m/s, and `{}` is planned with {wanted} m/s",
                robot.name
            );
            let d = Diagnostic::warning("HQ0962", at, text)
                .note(format!("{most} m/s is the limit of `{name}`: the robot comes late to every place"));
            self.push(d.help(Help::with(
                "plan with that, {}, or raise the limit there",
                [Snippet::entry("speed", format!("{most} m/s"))],
            )));
        }
        true
    }

    /// A signal of a spec that the mission sets.
    fn signal_of_way(
        &mut self,
        (of, key): (&Located<String>, &str),
        (spec, program): (&str, &Program),
        ty: &str,
        meaning: &str,
    ) -> Option<usize> {
        let (name, at) = (of.value.as_str(), self.origins.span(of.at));
        let all =
            || program.interface.signals.iter().filter(|s| !s.is_variable() && !s.is_of_person() && s.sent() == s.len);
        let fitting: Vec<&str> = all().filter(|s| s.kind == ty).map(|s| s.name.as_str()).collect();
        let Some(signal) = program.interface.signals.iter().position(|s| s.name == name) else {
            let d = Diagnostic::unknown_name(at, format!("`{spec}` has no signal `{name}`"));
            let d = d.help(Help::with("declare it there: {}", [Snippet::of_type("signal", name, ty)]));
            self.push(d.one_of(&format!("signals of the type `{ty}` there are"), name, fitting));
            return None;
        };
        let s = &program.interface.signals[signal];
        if s.is_variable() || s.is_of_person() || s.sent() > s.len || s.kind != ty {
            let what = match (s.is_variable(), s.is_of_person()) {
                (true, _) => "a variable of the machine".to_string(),
                (_, true) => "a point of a person".to_string(),
                _ if s.sent() > s.len => "a signal whose velocity is measured".to_string(),
                _ => format!("a signal of the type `{}`", s.kind),
            };
            let d = Diagnostic::error("HQ0960", at, format!("`{name}` of `{spec}` is {what}"))
                .note(format!("`{key}` needs a signal of the type `{ty}`: {meaning}"));
            self.push(match fitting.is_empty() {
                true => d.help(Help::with(
                    &format!("declare a signal for it in `{spec}`: {{}}"),
                    [Snippet::of_type("signal", key, ty)],
                )),
                false => d.help(format!("signals of that type there are {}", list(fitting, 12))),
            });
            return None;
        }
        Some(signal)
    }

    /// The humans of a spec, and the members that they are; none: something is wrong with one.
    fn people_there(
        &mut self,
        block: &DrivenBlock,
        program: &Program,
        mission: &dyn Mission,
    ) -> Option<Vec<(usize, usize)>> {
        let spec = block.spec.value.as_str();
        let members = mission.members();
        let is_person = |role: &str| PEOPLE.roles.contains(&role);
        let people: Vec<usize> = (0..members.len()).filter(|i| is_person(members[*i].role)).collect();
        let mut all = Vec::new();
        let mut wrong = false;
        for entry in &block.people {
            let (name, at) = (entry.name.value.as_str(), self.origins.span(entry.name.at));
            let humans = || program.interface.humans.iter().map(|human| human.name.as_str());
            let Some(human) = humans().position(|human| human == name) else {
                let d = Diagnostic::unknown_name(at, format!("`{spec}` has no human `{name}`"));
                let d = d.help(Help::with(
                    "declare it there, {}, or leave it out here",
                    [Snippet::declared("human", name, [Snippet::entry("points", "[chest]")])],
                ));
                self.push(d.one_of("there is", name, humans()));
                wrong = true;
                continue;
            };
            all.extend(people.get(entry.value.value.0).map(|member| (human, *member)));
        }
        (!wrong).then_some(all)
    }

    /// Warns of people of a spec whom nobody of the mission is, and whom its robot does not see.
    fn unseen_people(
        &mut self,
        block: &DrivenBlock,
        program: &Program,
        scripts: &[HumanScript],
        declared: &DeclaredMission,
    ) {
        let Some(person) = declared.members.iter().find(|member| PEOPLE.roles.contains(&member.role)) else { return };
        let (spec, at) = (block.spec.value.as_str(), self.origins.span(block.spec.at));
        for (human, of) in program.interface.humans.iter().enumerate() {
            if scripts.iter().any(|script| script.human == human) {
                continue;
            }
            let text = format!("nobody of this mission is the human `{}` of `{spec}`", of.name);
            let d = Diagnostic::warning("HQ0963", at, text)
                .note("its robot sees nobody, and keeps no distance from the people here");
            let entry = Snippet::block("people", [Snippet::entry(of.name.as_str(), person.name.as_str())]);
            self.push(d.help(Help::with("say who it is, {}", [entry])));
        }
    }
}

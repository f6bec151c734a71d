//! The behaviour of a compiled spec as facts: robot, signals, tasks, stacks, the machine, scenarios, missions.

use std::hash::{DefaultHasher, Hash, Hasher};

use compiler::Compiled;
use runtime::evaluator::Evaluator;
use runtime::program::{
    ActionProgram, ExpectationProgram, MachineAction, MachineProgram, MissionProgram, Node, Op, Program,
    ScenarioProgram, StackProgram, Subject as Runs,
};
use runtime::text::number;
use serde::Serialize;
use serde_json::Value as Json;

use super::values::Values;
use super::{Fact, Subject};

/// Attribute that holds the order of others.
pub(super) const ORDER: &str = "order";

/// A short number that two equal values share, and hardly any others.
pub(super) fn digest<T: Serialize>(of: &T) -> String {
    let mut hasher = DefaultHasher::new();
    serde_json::to_string(of).unwrap_or_default().hash(&mut hasher);
    format!("{:06x}", hasher.finish() & 0xff_ffff)
}

/// The facts of a compiled spec.
pub(super) fn of(compiled: &Compiled) -> Vec<Subject> {
    let mut all = Vec::new();
    if let Some(program) = &compiled.program {
        robot(program, &mut all);
        signals(program, &mut all);
        fields(program, &mut all);
        tasks(program, &mut all);
        program.stacks.iter().for_each(|stack| self::stack(program, stack, &mut all));
        if let Some(machine) = &program.machine {
            self::machine(program, machine, &mut all);
        }
        run(program, &mut all);
        program.scenarios.iter().for_each(|scenario| self::scenario(program, scenario, &mut all));
    }
    compiled.missions.iter().for_each(|mission| self::mission(mission, &mut all));
    all
}

/// A subject under construction.
struct Facts(Subject);

impl Facts {
    fn about(name: impl Into<String>) -> Facts {
        Facts(Subject { name: name.into(), facts: Vec::new() })
    }

    fn add(&mut self, attribute: impl Into<String>, text: impl Into<String>) {
        self.0.facts.push(Fact { attribute: attribute.into(), text: text.into() });
    }

    /// Adds the parts of a value as JSON, each at its path.
    fn add_parts(&mut self, path: &str, value: &Json) {
        let join = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
        match value {
            Json::Object(map) => map.iter().for_each(|(key, value)| self.add_parts(&join(key), value)),
            Json::Array(list) if list.iter().any(|item| item.is_object() || item.is_array()) => {
                list.iter().enumerate().for_each(|(i, item)| self.add_parts(&join(&i.to_string()), item));
            }
            Json::Null => {}
            other => self.add(path, other.to_string()),
        }
    }
}

fn json<T: Serialize>(of: &T) -> Json {
    serde_json::to_value(of).unwrap_or_default()
}

fn robot(p: &Program, all: &mut Vec<Subject>) {
    let r = &p.robot;
    let mut facts = Facts::about("robot");
    facts.add("name", &r.name);
    facts.add("URDF", &r.urdf);
    facts.add("base", r.base_words());
    facts.add("control period", format!("{} s", number(r.period)));
    facts.add("deadline", format!("{} s", number(r.deadline)));
    facts.add("stop", if r.stops_at_once { "now" } else { "to rest" });
    facts.add("enabled", p.enabling_names().join(", "));
    facts.add("resume", if r.resumes_itself { "by itself" } else { "told" });
    facts.add("tracking gain", format!("{} /s", number(r.tracking_gain)));
    facts.add("lag", format!("{} s", number(r.lag)));
    facts.add("dead time", format!("{} s", number(r.dead_time)));
    // Shapes, masses and axes, with limits as far as they are not said of joints.
    facts.add("model", format!("#{}", digest(&r.model)));
    r.arms.iter().for_each(|arm| facts.add(format!("arm {}", arm.name), format!("#{}", digest(arm))));
    r.geometries.iter().for_each(|g| facts.add(g.name.clone(), format!("#{}", digest(g))));
    all.push(facts.0);
    for d in &r.model.dofs {
        let mut facts = Facts::about(format!("joint {}", d.name));
        if let Some(i) = d.q_index {
            facts.add("home", r.home.get(i).map_or_else(String::new, |x| number(*x)));
        }
        facts.add("lower limit", number(d.lower));
        facts.add("upper limit", number(d.upper));
        facts.add("speed limit", number(d.velocity));
        all.push(facts.0);
    }
}

fn signals(p: &Program, all: &mut Vec<Subject>) {
    for s in p.interface.signals.iter() {
        let word = if s.is_variable() { "variable" } else { "signal" };
        let mut facts = Facts::about(format!("{word} {}", s.name));
        facts.add("type", format!("{}{}", s.kind, if s.optional { "?" } else { "" }));
        facts.add("timeout", s.timeout.map_or_else(|| "none".to_string(), |t| format!("{} s", number(t))));
        if let Some(motion) = &s.motion {
            facts.add_parts("", &json(motion));
        }
        facts.add_parts("", &json(&s.conditioning));
        if let Some(value) = s.variable.as_ref().and_then(|v| v.value.as_ref()) {
            facts.add("value at the start", json(value).to_string());
        }
        all.push(facts.0);
    }
    for event in &p.interface.events {
        all.push(Facts::about(format!("event {event}")).0);
    }
}

fn fields(p: &Program, all: &mut Vec<Subject>) {
    for field in &p.fields {
        let mut facts = Facts::about(format!("safety field {}", field.name));
        let names: Vec<&str> = field.links.iter().map(|l| p.robot.model.link_ref(*l).name.as_str()).collect();
        facts.add("links", names.join(", "));
        facts.add("function of the distance", json(&field.distance).to_string());
        facts.add("combination", json(&field.over).to_string());
        all.push(facts.0);
    }
}

fn tasks(p: &Program, all: &mut Vec<Subject>) {
    let values = Values::new(p);
    let evaluators: Vec<_> = (0..p.stacks.len()).map(|stack| Evaluator::new(p, stack)).collect();
    for (index, task) in p.tasks.iter().enumerate() {
        let mut facts = Facts::about(format!("task {}", task.name));
        facts.add("type", &task.kind);
        for (name, bound) in &task.params {
            facts.add(name, values.bound(bound));
        }
        let members = evaluators.iter().filter_map(|e| e.as_ref().ok()).flat_map(|(e, _)| e.members());
        if let Some(member) = members.into_iter().find(|member| member.program_index == index) {
            // Rows of a limit are what it guards.
            member.row_info.iter().for_each(|row| facts.add(format!("row {}", row.name), ""));
        }
        all.push(facts.0);
    }
}

fn stack(p: &Program, stack: &StackProgram, all: &mut Vec<Subject>) {
    let mut facts = Facts::about(format!("stack {}", stack.name));
    let names: Vec<&str> = stack.levels.iter().map(|level| level.name.as_str()).collect();
    facts.add("levels", names.join(", "));
    let locked: Vec<&str> =
        stack.locked.iter().filter_map(|d| Some(p.robot.model.dofs.get(*d)?.name.as_str())).collect();
    if !locked.is_empty() {
        facts.add("locked joints", locked.join(", "));
    }
    all.push(facts.0);
    for level in &stack.levels {
        let mut facts = Facts::about(format!("level {} of stack {}", level.name, stack.name));
        facts.add("is", if level.hard { "hard" } else { "soft" });
        match (level.exact, level.damping) {
            (true, _) => facts.add("damping", "none"),
            (false, damping) if damping > 0.0 => facts.add("damping", number(damping)),
            _ => {}
        }
        for member in &level.members {
            let name = p.tasks.get(member.task).map_or("?", |task| task.name.as_str());
            facts.add(format!("task {name}"), format!("weight {}", number(member.weight)));
        }
        all.push(facts.0);
    }
}

fn machine(p: &Program, m: &MachineProgram, all: &mut Vec<Subject>) {
    let values = Values::new(p);
    let named = |index: usize| m.states.get(index).map_or("?", |state| state.name.as_str());
    for (index, state) in m.states.iter().enumerate() {
        let word = match index {
            0 => "machine",
            _ if m.region(index) == Some(index) => "region",
            _ => "state",
        };
        let mut facts = Facts::about(format!("{word} {}", state.name));
        let stack = state.stack.and_then(|stack| p.stacks.get(stack));
        facts.add("stack", stack.map_or("none of its own", |stack| stack.name.as_str()));
        if let Some(initial) = state.initial.filter(|_| state.regions.is_empty()) {
            facts.add("initial state", named(initial));
        }
        if state.is_final {
            facts.add("final", "yes");
        }
        for (moment, actions) in [("enter", &state.enter), ("do", &state.activities), ("exit", &state.exit)] {
            for action in actions.iter().filter_map(|action| m.actions.get(*action)) {
                let set = match &action.own {
                    Some(MachineAction::Set { value, .. }) => format!("#{}", digest(&values.expression(value))),
                    _ => String::new(),
                };
                facts.add(format!("{moment} {}", asked(action)), set);
            }
        }
        let mut order = Vec::new();
        for t in &state.transitions {
            let text = format!("{} -> {}", t.text, named(t.target));
            let mut how = if t.blend > 0.0 { format!("blend {} s", number(t.blend)) } else { String::new() };
            // The words of the spec may name a param whose value has changed.
            let trigger = digest(&values.trigger(&t.trigger));
            how.push_str(&format!(" #{trigger}"));
            facts.add(text.clone(), how.trim());
            order.push(text);
        }
        if order.len() > 1 {
            facts.add(ORDER, order.join(", then "));
        }
        all.push(facts.0);
    }
}

/// `capture(head_camera)`
fn asked(a: &ActionProgram) -> String {
    format!("{}({})", a.verb, a.arguments.join(", "))
}

fn run(p: &Program, all: &mut Vec<Subject>) {
    let mut facts = Facts::about("run");
    facts.add(
        "of",
        match p.run.subject {
            Runs::Stack(stack) => format!("stack {}", p.stacks.get(stack).map_or("?", |stack| stack.name.as_str())),
            Runs::Machine => "the machine".to_string(),
        },
    );
    let mut rest = json(&p.run);
    if let Json::Object(map) = &mut rest {
        map.remove("subject");
    }
    facts.add_parts("", &rest);
    all.push(facts.0);
}

fn scenario(p: &Program, s: &ScenarioProgram, all: &mut Vec<Subject>) {
    let mut facts = Facts::about(format!("scenario {}", s.name));
    facts.add("start", json(&s.start).to_string());
    facts.add_parts("", &json(&s.run));
    for (index, script) in s.world.signals.iter().enumerate() {
        let name = p.interface.signals.get(script.signal).map_or("?", |signal| signal.name.as_str());
        facts.add(format!("signal {name} {index}"), format!("#{}", digest(script)));
    }
    let mut world = json(&s.world);
    if let Json::Object(map) = &mut world {
        map.remove("signals");
    }
    facts.add_parts("", &world);
    s.expectations.iter().for_each(|e| expectation(s, e, &mut facts));
    all.push(facts.0);
}

/// An expectation, with the numbers that its words may only name: those of its predicates, and its windows.
fn expectation(s: &ScenarioProgram, e: &ExpectationProgram, facts: &mut Facts) {
    let number = |op: &Op| if let Op::Const(x) = op { Some(*x) } else { None };
    let node = |node: &Node| match node {
        Node::Predicate(k) => {
            let ops = s.predicates.get(*k).map_or(&[][..], |predicate| &predicate.value.ops);
            format!("{:?}", ops.iter().filter_map(number).collect::<Vec<f64>>())
        }
        other => format!("{other:?}"),
    };
    let nodes: Vec<String> = e.formula.nodes.iter().map(node).collect();
    let label = e.label.as_deref().unwrap_or_default();
    facts.add(format!("expect {}", e.text), format!("{label} #{}", digest(&nodes)));
}

/// A mission, by the lines of its text. A line is known by those around it.
fn mission(m: &MissionProgram, all: &mut Vec<Subject>) {
    let mut facts = Facts::about(format!("mission {}", m.name));
    let text = runtime::text::mission(m);
    let mut around: Vec<(usize, String)> = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let indent = line.len() - line.trim_start().len();
        around.retain(|(outer, _)| *outer < indent);
        let words: Vec<&str> = line.split_whitespace().collect();
        let head = words.first().copied().unwrap_or_default();
        let place: Vec<&str> = around.iter().skip(1).map(|(_, head)| head.as_str()).collect();
        let attribute = match place.is_empty() {
            true => words.join(" "),
            false => format!("{}: {}", place.join(": "), words.join(" ")),
        };
        facts.add(attribute, "");
        around.push((indent, head.to_string()));
    }
    all.push(facts.0);
}

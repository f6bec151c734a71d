//! Values of a program written out: numbers of the table of values as the expressions that compute them.

use runtime::program::{CaptureSource, Op, Program};
use runtime::text::number;
use stdlib_tasks::axis_rows::Axes;
use stdlib_tasks::bound::{Bound, ExceptedPair, Exception, Obstacle, Slot};
use stdlib_tasks::expression::{Expression, Leaf, MotionPart};

use super::facts::digest;

/// Longest expression that is written out, in characters.
const LONGEST: usize = 240;

/// Writes values of a program.
pub(super) struct Values<'p> {
    program: &'p Program,
    /// Text of each number of the table of signals.
    signals: Vec<String>,
    /// Text of each captured number.
    captured: Vec<String>,
    /// Text of each operation of the tape.
    tape: Vec<String>,
    /// Operation of the tape that computes each place of the table of values; none: it is constant.
    outputs: Vec<Option<usize>>,
}

impl<'p> Values<'p> {
    pub fn new(program: &'p Program) -> Values<'p> {
        let mut signals = vec![String::new(); program.interface.width()];
        for s in &program.interface.signals {
            let parts: &[&str] = if s.len == 3 { &["x", "y", "z"] } else { &[] };
            for (k, text) in signals.iter_mut().skip(s.at).take(s.width()).enumerate() {
                *text = match k {
                    0 => format!("present({})", s.name),
                    _ if s.len == 1 => s.name.clone(),
                    k => {
                        parts.get(k - 1).map_or_else(|| format!("{}[{k}]", s.name), |part| format!("{}.{part}", s.name))
                    }
                };
            }
        }
        let mut outputs = vec![None; program.values.initial.len()];
        for output in &program.values.tape.outputs {
            if let Some(place) = outputs.get_mut(output.at) {
                *place = Some(output.value);
            }
        }
        let mut values = Values { program, signals, captured: Vec::new(), tape: Vec::new(), outputs };
        for capture in &program.values.captures {
            let source = match &capture.source {
                CaptureSource::Task(task, name) => format!("{name} of {}", values.task(*task)),
                CaptureSource::Velocity(task, name, _) => format!("velocity of {name} of {}", values.task(*task)),
                CaptureSource::State(e) => values.expression(e),
            };
            for k in 0..capture.len {
                let part = if capture.len == 1 { String::new() } else { format!("[{k}]") };
                values.captured.push(format!("initial({source}){part}"));
            }
        }
        for op in &program.values.tape.ops {
            let text =
                operation(op, &|i| values.tape.get(i).cloned().unwrap_or_default(), &|op| values.leaf_of_tape(op));
            values.tape.push(shortened(text));
        }
        values
    }

    fn task(&self, task: usize) -> &str {
        self.program.tasks.get(task).map_or("?", |task| task.name.as_str())
    }

    /// The numbers of a slot.
    pub fn slot(&self, slot: &Slot) -> String {
        let parts: Vec<String> = (slot.at..slot.at + slot.len).map(|at| self.place(at)).collect();
        bracketed(parts)
    }

    /// A number of the table of values.
    fn place(&self, at: usize) -> String {
        match self.outputs.get(at).copied().flatten() {
            Some(value) => unwrapped(self.tape.get(value).map_or("?", String::as_str)).to_string(),
            None => self.program.values.initial.get(at).map_or_else(|| "?".to_string(), |x| number(*x)),
        }
    }

    fn leaf_of_tape(&self, op: Op) -> String {
        match op {
            Op::Signal(k) => self.signals.get(k).cloned().unwrap_or_default(),
            Op::Input(k) => self.captured.get(k).cloned().unwrap_or_default(),
            Op::Trajectory(k) => {
                let tape = &self.program.values.tape;
                let Some(t) = tape.trajectory_of(k).and_then(|t| tape.trajectories.get(t)) else { return "?".into() };
                // Its operands come before it.
                let one = |i: &usize| unwrapped(self.tape.get(*i).map_or("?", String::as_str)).to_string();
                let all = |list: &[usize]| bracketed(list.iter().map(one).collect());
                let motion = format!("{:?}", t.motion).to_lowercase();
                let of = format!("{motion}({}, within {}, from {})", all(&t.goals), all(&t.limits), all(&t.start));
                format!("{}[{}]", of, k - t.at)
            }
            Op::T => "t".into(),
            Op::Time => "time".into(),
            _ => "?".into(),
        }
    }

    /// An expression of the robot's state.
    pub fn expression(&self, e: &Expression) -> String {
        let states: Vec<String> = e.leaves.iter().flat_map(|leaf| self.leaf(e, leaf)).collect();
        let leaf = |op: Op| match op {
            Op::State(k) => states.get(k).cloned().unwrap_or_default(),
            Op::Input(k) => e.inputs.get(k).map_or_else(String::new, |at| self.place(*at)),
            _ => "?".into(),
        };
        let mut texts: Vec<String> = Vec::new();
        for op in &e.ops {
            let text = operation(op, &|i| texts.get(i).cloned().unwrap_or_default(), &leaf);
            texts.push(shortened(text));
        }
        let one = |output: &usize| unwrapped(texts.get(*output).map_or("?", String::as_str)).to_string();
        bracketed(e.outputs.iter().map(one).collect())
    }

    /// The numbers of a quantity of the robot's state.
    fn leaf(&self, e: &Expression, leaf: &Leaf) -> Vec<String> {
        let model = &self.program.robot.model;
        let link = |l| model.link_ref(l).name.as_str();
        let base = match leaf {
            Leaf::Point { link: l, offset } if offset.norm() == 0.0 => format!("frame({}).position", link(*l)),
            Leaf::Point { link: l, offset } => {
                let at: Vec<String> = offset.iter().map(|x| number(*x)).collect();
                format!("point({}, [{}])", link(*l), at.join(", "))
            }
            Leaf::Orientation(l) => format!("frame({}).orientation", link(*l)),
            Leaf::Joint(dof) => format!("joint({})", model.dofs.get(*dof).map_or("?", |d| d.name.as_str())),
            Leaf::Distance(pair) => format!("distance({}, {})", pair.0.name, pair.1.name),
            Leaf::Com => "com".into(),
            Leaf::Manipulability(of) => {
                let part = match of.part {
                    MotionPart::Whole => "",
                    MotionPart::Linear => ", linear",
                    MotionPart::Angular => ", angular",
                };
                let joints = of.dofs.iter().filter_map(|&d| model.dofs.get(d)).map(|d| d.name.as_str());
                format!("manipulability({}{part}, [{}])", link(of.link), joints.collect::<Vec<_>>().join(", "))
            }
            Leaf::Field(field) => format!("field({})", field.name),
            // Their operands are operations of the expression, which the digest holds.
            Leaf::PlaneDistance(_) | Leaf::PointDistance(_) => {
                let ops: Vec<_> = leaf.reads().iter().flatten().map(|i| e.ops.get(*i)).collect();
                format!("distance #{}", digest(&(leaf, format!("{ops:?}"))))
            }
        };
        match leaf.width() {
            1 => vec![base],
            3 => ["x", "y", "z"].map(|part| format!("{base}.{part}")).to_vec(),
            _ => ["w", "x", "y", "z"].map(|part| format!("{base}.{part}")).to_vec(),
        }
    }

    /// An obstacle: its form as a digest, its pose and its presence.
    fn obstacle(&self, o: &Obstacle) -> String {
        let on = o.link.map_or(String::new(), |l| format!(" on {}", self.program.robot.model.link_ref(l).name));
        let present = o.present.map_or(String::new(), |s| format!(" present {}", self.slot(&s)));
        let (position, orientation) = (self.slot(&o.position), self.slot(&o.orientation));
        format!("{} #{}{on} at {position} turned {orientation}{present}", o.name, digest(&o.form))
    }

    /// A pair of links that a task leaves out.
    fn excepted(&self, ExceptedPair { links, why }: &ExceptedPair) -> String {
        let all = &self.program.robot.model.links;
        let [a, b] = links.map(|link| all.get(link.index()).map_or("?", |l| l.name.as_str()));
        let why = match why {
            Exception::Written => "",
            Exception::Disabled(_) => " (SRDF)",
            Exception::Touching => " (touching)",
        };
        format!("{a} to {b}{why}")
    }

    /// A parameter of a task; none: its rows say it.
    pub fn bound(&self, bound: &Bound) -> String {
        let p = self.program;
        let joint = |dof: usize| p.robot.model.dofs.get(dof).map_or("?", |d| d.name.as_str());
        let join = |parts: Vec<String>| parts.join(", ");
        match bound {
            Bound::Value(slot) => self.slot(slot),
            Bound::Frame(name, _) => name.clone(),
            Bound::Frames(list) => join(list.iter().map(|(name, _)| name.clone()).collect()),
            Bound::Arm(arm) => arm.name.clone(),
            Bound::Geometries(list) => join(list.iter().map(|g| format!("{} #{}", g.name, digest(g))).collect()),
            Bound::Obstacles(list) => join(list.iter().map(|o| self.obstacle(o)).collect()),
            Bound::Pairs(list) => join(list.iter().map(|pair| self.excepted(pair)).collect()),
            Bound::Joints(list) => join(list.iter().map(|dof| joint(*dof).to_string()).collect()),
            Bound::PerJoint(list) => {
                join(list.iter().map(|(dof, slot)| format!("{} {}", joint(*dof), self.slot(slot))).collect())
            }
            Bound::PerArm(list) => {
                join(list.iter().map(|(arm, slot)| format!("{} {}", arm.name, self.slot(slot))).collect())
            }
            Bound::Choice(word) => word.clone(),
            Bound::Axes(chosen) => join(Axes(*chosen).names().map(str::to_string).collect()),
            Bound::Expression(e) => self.expression(e),
            Bound::Group(map) => {
                let inner: Vec<String> = map.iter().map(|(key, of)| format!("{key} {}", self.bound(of))).collect();
                format!("{{ {} }}", inner.join("  "))
            }
            Bound::Task(task) => self.task(*task).to_string(),
            Bound::Field(field) => p.fields.get(*field).map_or_else(String::new, |field| field.name.clone()),
        }
    }
}

/// A long text is shortened, with a digest of the whole. Texts of long operands are digests already, so that sharing does not
/// make them explode.
fn shortened(text: String) -> String {
    if text.chars().count() <= LONGEST {
        return text;
    }
    let start: String = text.chars().take(60).collect();
    format!("{start}.. #{}", digest(&text))
}

/// The outermost parentheses say nothing.
fn unwrapped(text: &str) -> &str {
    match text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) {
        Some(inner) if is_balanced(inner) => inner,
        _ => text,
    }
}

fn bracketed(parts: Vec<String>) -> String {
    match parts.as_slice() {
        [one] => one.clone(),
        _ => format!("[{}]", parts.join(", ")),
    }
}

/// True if no parenthesis of a text closes one that is not in it.
fn is_balanced(text: &str) -> bool {
    let mut open = 0_i64;
    text.chars().all(|c| {
        open += i64::from(c == '(') - i64::from(c == ')');
        open >= 0
    })
}

/// An operation from the texts of its operands.
fn operation(op: &Op, r: &dyn Fn(usize) -> String, leaf: &dyn Fn(Op) -> String) -> String {
    let two = |a: usize, sign: &str, b: usize| format!("({} {sign} {})", r(a), r(b));
    let call =
        |name: &str, of: &[usize]| format!("{name}({})", of.iter().map(|i| r(*i)).collect::<Vec<_>>().join(", "));
    match *op {
        Op::Const(x) => number(x),
        Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => leaf(*op),
        Op::Add(a, b) => two(a, "+", b),
        Op::Sub(a, b) => two(a, "-", b),
        Op::Mul(a, b) => two(a, "*", b),
        Op::Div(a, b) => two(a, "/", b),
        Op::Less(a, b) => two(a, "<", b),
        Op::LessEqual(a, b) => two(a, "<=", b),
        Op::Neg(a) => format!("(-{})", r(a)),
        Op::Powi(a, n) => format!("{}^{n}", r(a)),
        Op::Sin(a) => call("sin", &[a]),
        Op::Cos(a) => call("cos", &[a]),
        Op::Asin(a) => call("asin", &[a]),
        Op::Acos(a) => call("acos", &[a]),
        Op::Atan2(a, b) => call("atan2", &[a, b]),
        Op::Exp(a) => call("exp", &[a]),
        Op::Log(a) => call("log", &[a]),
        Op::Sqrt(a) => call("sqrt", &[a]),
        Op::Abs(a) => call("abs", &[a]),
        Op::Min(a, b) => call("min", &[a, b]),
        Op::Max(a, b) => call("max", &[a, b]),
        Op::Select(a, b, c) => call("if", &[a, b, c]),
    }
}

impl Values<'_> {
    /// A trigger with the numbers that its words may only name.
    pub fn trigger(&self, trigger: &runtime::program::Trigger) -> String {
        use runtime::program::Trigger;
        match trigger {
            Trigger::When { condition, hold } => format!("when {} for {}", self.expression(condition), number(*hold)),
            Trigger::After(time) => format!("after {}", number(*time)),
            Trigger::Reached(criterion) => {
                let speeds = criterion.speeds.iter().map(|s| s.most);
                let bounds: Vec<String> = criterion.tolerances.iter().copied().chain(speeds).map(number).collect();
                format!("reached {} {}", self.task(criterion.task), bounds.join(" "))
            }
            Trigger::Event(event) => {
                self.program.interface.events.get(*event).map_or_else(String::new, |event| format!("on {event}"))
            }
            Trigger::Ended(regions) => {
                let all = self.program.machine.iter().flat_map(|m| regions.iter().filter_map(|r| m.states.get(*r)));
                format!("ended {}", all.map(|s| s.name.as_str()).collect::<Vec<_>>().join(" "))
            }
            // The words of a fault name what it is of.
            Trigger::Fault(_) => "fault".to_string(),
        }
    }
}

//! Context in which a task is built, and the errors of building one.

use robot::{LinkId, Model};

use crate::bound::{Arm, Bound, BoundParams};
use crate::params::WrongForm;
use crate::slot::Slot;

/// Context in which a task is built.
pub struct Context<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Values at the time of building: constants, and moving numbers at `t = 0`.
    pub values: &'a [f64],
    /// Control period T, in s.
    pub period: f64,
    /// Largest speed of each degree of freedom that hard levels down to that of the task allow, in rad/s or m/s;
    /// infinite if none bounds it. The speed limits of the robot itself are not included: the reference, for which
    /// limits are kept, moves as the levels determine.
    pub speed: &'a [f64],
    /// Like `speed`, while joints that the stack locks come to rest: `speed` is zero for these joints, `entry_speed` is
    /// the speed that they may have when the stack is entered.
    pub entry_speed: &'a [f64],
}

impl Context<'_> {
    /// Size of the table of values.
    pub fn slot_count(&self) -> usize {
        self.values.len()
    }
}

/// Reason why a task cannot be built from well-formed parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildError {
    /// Name of the wrong parameter; empty for the task as a whole.
    pub param: String,
    /// Description of the error.
    pub message: String,
    /// Suggested correction.
    pub help: Option<String>,
}

impl BuildError {
    /// An error about a parameter.
    pub fn new(param: &str, message: impl Into<String>) -> Self {
        BuildError { param: param.to_string(), message: message.into(), help: None }
    }

    /// Adds a suggested correction.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

/// Something that a task takes for granted, and that is not so at a configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// The place, description and correction.
    pub error: BuildError,
    /// True if the rows of the task cannot be met there.
    pub certain: bool,
}

impl Doubt {
    /// A doubt about a parameter, with a suggested correction.
    pub fn new(param: &str, message: impl Into<String>, help: impl Into<String>) -> Self {
        Doubt { error: BuildError::new(param, message).help(help), certain: false }
    }
}

impl From<WrongForm> for BuildError {
    fn from(w: WrongForm) -> Self {
        let message = format!("`{}` does not have the form that this task type declares", w.param);
        BuildError { param: w.param, message, help: None }
    }
}

/// Checks that every index in the parameters is valid, so that a built task never reads outside a table.
///
/// # Errors
/// A link, a joint or an entry of the table of values does not exist, or a shape has no sound size and placement.
pub fn check(params: &BoundParams, ctx: &Context) -> Result<(), BuildError> {
    for (name, bound) in params {
        check_one(bound, ctx).map_err(|message| BuildError::new(name, message))?;
    }
    Ok(())
}

fn check_one(bound: &Bound, ctx: &Context) -> Result<(), &'static str> {
    let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
    let link = |l: &LinkId| ensure(l.index() < ctx.model.links.len(), "a frame does not exist");
    let dof = |d: &usize| ensure(*d < ctx.model.nv() && *d < ctx.speed.len(), "a joint does not exist");
    let slot = |s: &Slot| {
        let inside = s.at.checked_add(s.len).is_some_and(|end| end <= ctx.slot_count());
        ensure(inside, "a number has no place in the table of values")
    };
    let one = |s: &Slot| ensure(s.len == 1, "a single number is needed").and_then(|()| slot(s));
    let arm = |a: &Arm| {
        [Some(&a.tip), a.shoulder.as_ref(), a.elbow.as_ref(), a.wrist.as_ref()].into_iter().flatten().try_for_each(link)
    };
    match bound {
        Bound::Value(s) => slot(s),
        Bound::Frame(_, l) => link(l),
        Bound::Frames(list) => list.iter().try_for_each(|(_, l)| link(l)),
        Bound::Arm(a) => arm(a),
        Bound::Geometries(list) => list.iter().try_for_each(|g| g.check(ctx.model)),
        Bound::Obstacles(list) => list.iter().try_for_each(|o| {
            o.check(ctx.model)?;
            o.slots().collect::<Vec<_>>().iter().try_for_each(slot)
        }),
        Bound::Pairs(list) => list.iter().flat_map(|pair| &pair.links).try_for_each(link),
        Bound::Joints(list) => list.iter().try_for_each(dof),
        Bound::PerJoint(list) => list.iter().try_for_each(|(d, s)| dof(d).and_then(|()| one(s))),
        Bound::PerArm(list) => list.iter().try_for_each(|(a, s)| arm(a).and_then(|()| one(s))),
        Bound::Axes(chosen) => ensure(chosen.contains(&true), "no axis is chosen"),
        // Only the program can check these.
        Bound::Choice(_) | Bound::Task(_) | Bound::Field(_) => Ok(()),
        Bound::Expression(e) => e.check(ctx.model, ctx.slot_count()),
        Bound::Group(group) => group.values().try_for_each(|b| check_one(b, ctx)),
    }
}

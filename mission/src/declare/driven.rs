//! The block of a robot whose mobile base a controller of its own drives along the planned way.

use blocks::{ByName, Located, MemberIndex, Members, Named, ValueType, block};
use quantities::Quantity;
use quantities::dimension::{LENGTH, TIME};

/// The key of a member that runs a controller.
pub const RUNS_KEY: &str = "runs";

/// People of a mission, in the order written.
pub static PEOPLE: Members = Members { noun: "person", roles: &["human"] };

/// A length above zero.
const SOME_LENGTH: ValueType = ValueType::Number(Quantity::above(LENGTH, 0.0));

block! {
    /// The controller that drives the base of a robot.
    pub struct DrivenBlock = DRIVEN, "what a driven robot runs" {
        /// The spec of its controller, `"carrier.hq"`, whose robot has a `planar` or `unicycle` base.
        spec: Located<String> = required(ValueType::Spec, "\"carrier.hq\"");
        /// A signal of that spec, a point: the point of the planned way where the base is to go now; its height is 0. While the
        /// robot is on no way, the place where it stands.
        target: Located<String> = required(ValueType::Name(Named::SignalThere("point")), "drive_to");
        /// A signal of that spec, an angle: the direction of the way at that point.
        heading: Option<Located<String>> = optional(ValueType::Name(Named::SignalThere("angle")), "way_heading");
        /// A signal of that spec, a flag: true while the robot is on a way.
        going: Option<Located<String>> = optional(ValueType::Name(Named::SignalThere("flag")), "on_the_way");
        /// People of that spec, and the people of the mission that they are. Their true positions are what its sensors show.
        people: Vec<ByName<MemberIndex>> = optional(
            ValueType::Of(Named::HumanThere, &ValueType::Name(Named::Own(&PEOPLE))), "{ visitor anna }");
        /// A scenario of that spec that defines the environment of the robot: its joints at the start, its simulator, the shape of
        /// people and how they are tracked, signals other than those above, outcomes of actions. Its expectations and its
        /// duration are ignored, and so is where its base and its people begin. Default: no events, and every action ends
        /// immediately.
        scenario: Option<Located<String>> = optional(ValueType::Text);
        /// Distance from the end of a way within which the base has arrived.
        tolerance: f64 = or(SOME_LENGTH, "0.2 m");
        /// Time by which the target is ahead of the point where the plan has the robot. A base that follows the target with
        /// `gain k` keeps up with the plan if it is `1/k`.
        lead: f64 = or(ValueType::Number(Quantity::at_least(TIME, 0.0)), "0.5 s");
        /// Greatest distance, along the way, of the target from the base. A base that has stopped goes on from there.
        ahead: f64 = or(SOME_LENGTH, "0.5 m");
    }
}

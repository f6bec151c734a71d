//! Services: one for each event that others may raise, and those that restart the controller, stop the robot, and let it go on.

use ros2_client::{Node, Server, ServiceMapping};
use runtime::program::{Program, RosProgram};

use crate::RosError;
use crate::messages::{TriggerRequest, TriggerResponse};
use crate::names::{absolute, part, resolved, trigger};
use crate::quality;

/// A service of the type `std_srvs/Trigger`.
pub struct Trigger {
    /// Content of its calls.
    pub call: Call,
    server: Server<TriggerRequest, TriggerResponse>,
}

/// Content of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// The event with this index occurs.
    Raise(usize),
    /// The controller begins anew.
    Restart,
    /// The robot comes to rest.
    Stop,
    /// A robot that stands goes on.
    Resume,
    /// Bases are about to be localised anew.
    Relocated,
}

/// An event that others raise.
pub struct Event<'p> {
    /// Its index.
    pub index: usize,
    /// Its name.
    pub name: &'p str,
}

/// Events that others raise: those that the machine raises itself need no service.
pub fn raised_by_others(program: &Program) -> impl Iterator<Item = Event<'_>> {
    let actions = program.machine.iter().flat_map(|m| &m.actions);
    let emitted: Vec<usize> = actions.filter_map(|a| a.event).collect();
    let events = program.interface.events.iter().enumerate();
    events.filter(move |(i, _)| !emitted.contains(i)).map(|(index, name)| Event { index, name })
}

/// A service of the node itself, which no spec declares.
pub struct OwnService {
    /// Name below the node.
    pub name: &'static str,
    /// Effect of a call.
    pub call: Call,
    /// The same in words.
    pub content: &'static str,
}

/// Services of the node itself. Events are often called `stop` and `resume`: the services of the motion have a place of their own.
const OWN: [OwnService; 4] = [
    OwnService { name: "restart", call: Call::Restart, content: "begins anew after a fault" },
    OwnService { name: "motion/stop", call: Call::Stop, content: "brings the robot to rest" },
    OwnService { name: "motion/resume", call: Call::Resume, content: "lets a robot go on that stands" },
    OwnService { name: "motion/relocated", call: Call::Relocated, content: "the base is about to be localised anew" },
];

/// The services of the node itself: without a base that moves, nothing is localised.
pub fn own(program: &Program) -> impl Iterator<Item = OwnService> {
    let moves = !program.robot.model.bases.is_empty();
    OWN.into_iter().filter(move |service| moves || service.call != Call::Relocated)
}

/// Offers the services of a program.
///
/// # Errors
/// The client library refuses one.
pub fn offer(
    node: &mut Node,
    ros: &RosProgram,
    program: &Program,
    mapping: ServiceMapping,
) -> Result<Vec<Trigger>, RosError> {
    let events = raised_by_others(program);
    let own = own(program).map(|service| (service.name.to_string(), service.call));
    let mut offered = Vec::new();
    for (name, call) in events.map(|e| (part(e.name), Call::Raise(e.index))).chain(own) {
        let name = resolved(ros, &format!("~/{name}"));
        let (requests, responses) = (quality::service(), quality::service());
        let server = node.create_server(mapping, &absolute(&name)?, &trigger(), requests, responses)?;
        offered.push(Trigger { call, server });
    }
    Ok(offered)
}

impl Trigger {
    /// Answers the calls that have arrived; `act` says whether it was done, or why not.
    pub fn serve(&self, mut act: impl FnMut(Call) -> Result<(), String>) {
        while let Ok(Some((id, _))) = self.server.receive_request() {
            let done = act(self.call);
            let success = done.is_ok();
            let response = TriggerResponse { success, message: done.err().unwrap_or_default() };
            // A caller that has gone needs no answer.
            let _ = self.server.send_response(id, response);
        }
    }
}

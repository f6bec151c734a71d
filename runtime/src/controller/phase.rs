//! What the controller does with the robot: it runs the stack of a state, brings the robot to rest, or keeps it there.

use crate::fault::Fault;
use crate::program::Times;

/// Phase of a controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    /// The machine has not been started.
    Unstarted,
    /// The stack of the machine's state moves the robot.
    Running,
    /// The robot comes to rest.
    Stopping(Stop),
    /// The robot is at rest.
    Standing(Why),
}

/// Reason for which the robot comes to rest, and stays there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Why {
    /// The state of the machine has no stack.
    NoStack,
    /// The stack of the state needs a signal, by its index, whose first value may still come.
    Awaiting(usize),
    /// A fault at this tick, which the machine will answer.
    Raised(Fault),
    /// A fault that occurred in the state to which its transition leads, until the machine leaves that state.
    InTarget(Fault),
    /// A fault that nothing answers, until a restart.
    Halted(Fault),
    /// The host has asked for it, until it resumes.
    Told,
    /// The robot takes no commands: until it does, and the host resumes.
    Disabled,
}

/// Motion to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    /// The reason.
    pub why: Why,
    /// Clocks of the stack when the motion began: its targets stay where they were then.
    pub times: Times,
    /// Motion time at which it began (s).
    pub begun: f64,
    /// Duration in which the velocity should fade (s); 0 to come to rest as fast as the limits allow.
    pub fade: f64,
}

impl Phase {
    /// The reason for which the robot is at rest, or comes to rest.
    pub fn why(&self) -> Option<Why> {
        match self {
            Phase::Unstarted | Phase::Running => None,
            Phase::Stopping(stop) => Some(stop.why),
            Phase::Standing(why) => Some(*why),
        }
    }

    /// The fault that keeps the robot at rest until a restart.
    pub fn halted(&self) -> Option<Fault> {
        if let Some(Why::Halted(fault)) = self.why() { Some(fault) } else { None }
    }
}

impl Why {
    /// The fault, if it is one.
    pub fn fault(&self) -> Option<Fault> {
        match self {
            Why::Raised(fault) | Why::InTarget(fault) | Why::Halted(fault) => Some(*fault),
            _ => None,
        }
    }

    /// Returns true if the robot is led back to its set point on the way to rest, and at rest.
    pub fn leads_back(&self) -> bool {
        matches!(self, Why::NoStack | Why::Awaiting(_))
    }

    /// Returns true if the robot stays at rest whatever the machine does, which then stands still too.
    pub fn holds_machine(&self) -> bool {
        matches!(self, Why::Halted(_) | Why::Told | Why::Disabled)
    }
}

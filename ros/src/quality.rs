//! Qualities of service. A reader that asks for the best effort fits every writer, and a reliable writer every reader.

use ros2_client::QosProfile;
use ros2_client::qos::{Durability, History, Reliability, WhenFull};

/// Messages of a topic that are read in one tick: a topic that others flood keeps nothing else waiting.
pub const MOST: usize = 64;
/// Messages kept for a reader that is slow.
const SENSORS: usize = 16;
/// Messages that publishers have kept, for a reader that is slow.
const KEPT: usize = 128;
/// Requests and outcomes kept for a reader that is slow.
const EVENTS: usize = 32;

/// Sensors: the newest values count.
pub fn sensor() -> QosProfile {
    QosProfile::subscription_default().history(History::KeepLast { depth: SENSORS })
}

/// Commands: the newest one counts, and the writer never waits.
pub fn command() -> QosProfile {
    QosProfile::publisher_default()
        .reliability(Reliability::Reliable { when_full: WhenFull::Fail })
        .history(History::KeepLast { depth: 1 })
}

/// Requests: none is lost, and the writer never waits.
pub fn request() -> QosProfile {
    command().history(History::KeepLast { depth: EVENTS })
}

/// Pictures: the newest values count.
pub fn view() -> QosProfile {
    command()
}

/// Values that change rarely: those who come later receive the last one.
pub fn latched() -> QosProfile {
    command().durability(Durability::TransientLocal)
}

/// Fixed transforms and latched signals: each publisher keeps its own for those who come later. No message of another publisher is read.
pub fn kept() -> QosProfile {
    QosProfile::subscription_default()
        .reliability(Reliability::Reliable { when_full: WhenFull::Fail })
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: KEPT })
}

/// Services.
pub fn service() -> QosProfile {
    QosProfile::publisher_default().history(History::KeepLast { depth: 10 })
}

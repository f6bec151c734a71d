//! Others on the same topics: a thread looks for those whose messages have another type, or that keep none for those who come later where
//! the node reads kept ones, which the middleware keeps apart without a word.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use ros2_client::Context;
use ros2_client::dds::rustdds::qos::policy::Durability;

use crate::RosError;
use crate::names::from_dds;
use crate::remark::{Remark, Tell};

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(250);
/// Looks from one question to the next.
const EVERY: usize = 4;

/// Topic of a node.
pub struct Used {
    /// Type of its messages.
    pub kind: String,
    /// True if only latched messages are read from it; `None` where that makes no difference.
    pub latched: Option<bool>,
}

/// Looks after the topics of a node.
pub struct Neighbours {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Neighbours {
    /// Begins to look: `topics` are by their resolved names.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn watch(context: Context, topics: BTreeMap<String, Used>, tell: Tell) -> Result<Neighbours, RosError> {
        let ended = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&ended);
        let look = move || {
            let mut told: BTreeSet<Remark> = BTreeSet::new();
            for count in 0.. {
                if flag.load(Ordering::Relaxed) {
                    return;
                }
                if count % EVERY == EVERY - 1 {
                    for Use { topic, kind, keeps } in uses(&context) {
                        let Some(own) = topics.get(&topic) else { continue };
                        let remark = match (own.latched, keeps) {
                            _ if own.kind != kind => Remark::OtherType { topic, found: kind, needed: own.kind.clone() },
                            (Some(true), Some(false)) => Remark::NotLatched { topic },
                            (Some(false), Some(true)) => Remark::Latched { topic },
                            _ => continue,
                        };
                        if told.insert(remark.clone()) {
                            tell(&remark);
                        }
                    }
                }
                std::thread::sleep(LOOK);
            }
        };
        let thread = std::thread::Builder::new().name("neighbours".to_string()).spawn(look)?;
        Ok(Neighbours { ended, thread: Some(thread) })
    }
}

impl Drop for Neighbours {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Use of a topic by another participant.
struct Use {
    topic: String,
    kind: String,
    /// True if messages are kept for those who come later; `None` of a reader.
    keeps: Option<bool>,
}

fn uses(context: &Context) -> Vec<Use> {
    let participant = context.domain_participant();
    // Topics of ROS have a prefix; services have others.
    let used = |name: &str, kind: &str, keeps| {
        Some(Use { topic: name.strip_prefix("rt")?.to_string(), kind: from_dds(kind), keeps })
    };
    let writers = participant.discovered_writers().into_iter().filter_map(|w| {
        let data = w.publication_topic_data;
        let keeps = data.durability.is_some_and(|durability| durability != Durability::Volatile);
        used(&data.topic_name, &data.type_name, Some(keeps))
    });
    let readers = participant.discovered_readers().into_iter().filter_map(|r| {
        let data = r.subscription_topic_data;
        used(data.topic_name(), data.type_name(), None)
    });
    writers.chain(readers).collect()
}

//! Others on the same topics: a thread looks for those whose messages have another type, which the middleware keeps apart without a
//! word.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use ros2_client::Context;

use crate::RosError;
use crate::names::from_dds;
use crate::remark::{Remark, Tell};

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(250);
/// Looks from one question to the next.
const EVERY: usize = 4;

/// Looks after the topics of a node.
pub struct Neighbours {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Neighbours {
    /// Begins to look: `topics` are resolved names, each with the type of its messages.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn watch(context: Context, topics: BTreeMap<String, String>, tell: Tell) -> Result<Neighbours, RosError> {
        let ended = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&ended);
        let look = move || {
            let mut told: BTreeMap<String, String> = BTreeMap::new();
            for count in 0.. {
                if flag.load(Ordering::Relaxed) {
                    return;
                }
                if count % EVERY == EVERY - 1 {
                    for Use { topic, kind } in uses(&context) {
                        let other = topics.get(&topic).filter(|own| **own != kind);
                        if let Some(needed) = other
                            && told.insert(topic.clone(), kind.clone()).as_ref() != Some(&kind)
                        {
                            tell(&Remark::OtherType { topic, found: kind, needed: needed.clone() });
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
}

fn uses(context: &Context) -> Vec<Use> {
    let participant = context.domain_participant();
    let writers = participant.discovered_writers().into_iter();
    let writers = writers.map(|w| (w.publication_topic_data.topic_name, w.publication_topic_data.type_name));
    let readers = participant.discovered_readers().into_iter();
    let readers = readers
        .map(|r| (r.subscription_topic_data.topic_name().clone(), r.subscription_topic_data.type_name().clone()));
    let topic = |(name, kind): (String, String)| {
        // Topics of ROS have a prefix; services have others.
        let topic = name.strip_prefix("rt")?.to_string();
        Some(Use { topic, kind: from_dds(&kind) })
    };
    writers.chain(readers).filter_map(topic).collect()
}

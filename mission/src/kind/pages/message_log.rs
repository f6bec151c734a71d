//! Recent messages of a page: a limited number, in which a message may replace earlier ones of its topic.

use std::collections::VecDeque;

use super::{Message, PersonMessage};

/// A list of messages, the latest first.
#[derive(Clone, Debug)]
pub(super) struct MessageLog {
    list: VecDeque<(Option<&'static str>, Message)>,
    capacity: usize,
}

impl MessageLog {
    /// Creates an empty list with this capacity.
    pub fn new(capacity: usize) -> MessageLog {
        MessageLog { list: VecDeque::new(), capacity }
    }

    /// Adds a message.
    pub fn add(&mut self, time: f64, PersonMessage { text, topic }: PersonMessage) {
        self.list.retain(|(other, _)| topic.is_none() || *other != topic);
        self.list.push_front((topic, Message { at: time, text }));
        self.list.truncate(self.capacity);
    }

    /// Returns the messages, the latest first.
    pub fn messages(&self) -> Vec<Message> {
        self.list.iter().map(|(_, message)| message.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_replaces_earlier_ones_of_its_topic() {
        let mut log = MessageLog::new(3);
        let mut add = |topic: Option<&'static str>, text: &str| {
            log.add(0.0, PersonMessage { text: text.into(), topic });
            log.messages().iter().map(|message| message.text.clone()).collect::<Vec<_>>().join(" ")
        };
        add(None, "begun");
        add(Some("late"), "late-1");
        assert_eq!(add(Some("late"), "late-2"), "late-2 begun");
        add(None, "ended");
        assert_eq!(add(None, "over"), "over ended late-2");
    }
}

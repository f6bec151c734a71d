//! Recent messages: a limited number, and only the last one of a kind that outdates earlier ones.

use std::collections::VecDeque;
use std::mem::{Discriminant, discriminant};

use crate::view::Message;

/// Messages about happenings of this type.
#[derive(Clone, Debug)]
pub struct Messages<T> {
    list: VecDeque<(Discriminant<T>, Message)>,
    most: usize,
}

impl<T> Messages<T> {
    /// Creates an empty list with this maximum length.
    pub fn new(most: usize) -> Messages<T> {
        Messages { list: VecDeque::new(), most }
    }

    /// Adds a message. If it `outdates` earlier messages of its kind, these are removed.
    pub fn add(&mut self, what: &T, outdates: bool, message: Message) {
        let kind = discriminant(what);
        if outdates {
            self.list.retain(|(other, _)| *other != kind);
        }
        self.list.push_front((kind, message));
        self.list.truncate(self.most);
    }

    /// Returns the messages, the latest first.
    pub fn shown(&self) -> Vec<Message> {
        self.list.iter().map(|(_, message)| message.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_news_give_way() {
        let mut messages = Messages::new(3);
        let mut add = |what: Result<u8, u8>, outdates: bool, text: &str| {
            messages.add(&what, outdates, Message { at: 0.0, text: text.into() });
            messages.shown().iter().map(|message| message.text.clone()).collect::<Vec<_>>().join(" ")
        };
        add(Err(0), false, "begun");
        add(Ok(1), true, "late-1");
        assert_eq!(add(Ok(2), true, "late-2"), "late-2 begun");
        add(Err(0), false, "ended");
        assert_eq!(add(Err(0), false, "over"), "over ended late-2");
    }
}

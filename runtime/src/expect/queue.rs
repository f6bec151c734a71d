//! Queue that maintains the product of all its elements, in constant time on average and without allocation: two
//! stacks, one of which stores the products (Tangwongsan, Hirzel, Schneider, *In-order sliding-window aggregation in
//! worst-case constant time*, 2021, section 2).
//!
//! The elements are stretches of ticks. Their product is all that a sliding `until` needs.

use super::value::Interval;

/// Consecutive ticks, summarized for `until`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stretch {
    /// The goal holds at one of the ticks, and the hold at all ticks before it.
    pub goal: Interval,
    /// The hold is true at all ticks.
    pub hold: Interval,
}

impl Stretch {
    /// Empty stretch.
    pub const NONE: Stretch = Stretch { goal: Interval::FALSE, hold: Interval::TRUE };

    /// Concatenation of this stretch and the next one.
    pub fn then(self, next: Stretch) -> Stretch {
        Stretch { goal: self.goal.or(self.hold.and(next.goal)), hold: self.hold.and(next.hold) }
    }
}

/// Queue of stretches.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    /// Older elements, the oldest on top, each with the product of it and all below it.
    old: Vec<(Stretch, Stretch)>,
    /// Newer elements, the newest on top.
    new: Vec<Stretch>,
    /// Product of the newer elements.
    product_of_new: Stretch,
}

impl Queue {
    /// Creates a queue with room for `capacity` elements; it must never hold more.
    pub fn with_capacity(capacity: usize) -> Queue {
        let (old, new) = (Vec::with_capacity(capacity), Vec::with_capacity(capacity));
        Queue { old, new, product_of_new: Stretch::NONE }
    }

    pub fn len(&self) -> usize {
        self.old.len() + self.new.len()
    }

    pub fn push(&mut self, tick: Stretch) {
        self.product_of_new = self.product_of_new.then(tick);
        self.new.push(tick);
    }

    /// Removes the oldest element.
    pub fn pop(&mut self) -> Option<Stretch> {
        if self.old.is_empty() {
            let mut product = Stretch::NONE;
            while let Some(tick) = self.new.pop() {
                product = tick.then(product);
                self.old.push((tick, product));
            }
            self.product_of_new = Stretch::NONE;
        }
        self.old.pop().map(|(tick, _)| tick)
    }

    /// Product of all elements in their order.
    pub fn product(&self) -> Stretch {
        self.old.last().map_or(Stretch::NONE, |(_, product)| *product).then(self.product_of_new)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Interval, Queue, Stretch};
    use crate::expect::Value;

    proptest! {
        #[test]
        fn the_product_is_that_of_all(steps in proptest::collection::vec((-2_i32..3, -2_i32..3, any::<bool>()), 0..60)) {
            let mut queue = Queue::with_capacity(60);
            let mut plain = std::collections::VecDeque::new();
            for (tick, (goal, hold, pop)) in (0..).zip(steps) {
                let value = |x: i32| Interval::exact(Value::of_signal(f64::from(x), tick));
                let stretch = Stretch { goal: value(goal), hold: value(hold) };
                queue.push(stretch);
                plain.push_back(stretch);
                if pop {
                    prop_assert_eq!(queue.pop(), plain.pop_front());
                }
                prop_assert_eq!(queue.len(), plain.len());
                let mut product = Stretch::NONE;
                for s in &plain {
                    product = product.then(*s);
                }
                prop_assert_eq!(queue.product(), product);
            }
        }
    }
}

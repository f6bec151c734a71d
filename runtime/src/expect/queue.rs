//! A queue that knows the product of all that is in it, in constant time on average and without allocation: two stacks,
//! of which one carries the products (Tangwongsan, Hirzel, Schneider, *In-order sliding-window aggregation in worst-case
//! constant time*, 2021, section 2).
//!
//! What is multiplied are stretches of ticks, which is all that a sliding `until` needs.

use super::value::Interval;

/// Consecutive ticks, as `until` sees them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stretch {
    /// The goal at one of the ticks, and the hold at those before it.
    pub goal: Interval,
    /// The hold at all ticks.
    pub hold: Interval,
}

impl Stretch {
    /// No tick.
    pub const NONE: Stretch = Stretch { goal: Interval::FALSE, hold: Interval::TRUE };

    /// This stretch, and the next one behind it.
    pub fn then(self, next: Stretch) -> Stretch {
        Stretch { goal: self.goal.or(self.hold.and(next.goal)), hold: self.hold.and(next.hold) }
    }
}

/// The queue.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    /// The older ones, the oldest on top: each with the product of it and all below it.
    old: Vec<(Stretch, Stretch)>,
    /// The newer ones, the newest on top.
    new: Vec<Stretch>,
    /// The product of the newer ones.
    product_of_new: Stretch,
}

impl Queue {
    /// With room for so many; it must never hold more.
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

    /// Takes the oldest out.
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

    /// All of them, in their order.
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

//! The blocks of a walk, and the mission from its declaration.

use blocks::{Block, Key, Place, ValueType, block};
use mission::declare::{DeclaredMission, Remark, Remarks};
use quantities::Quantity;
use quantities::dimension::{LENGTH, VELOCITY};

use super::Walk;

block! {
    /// A mission of the kind `walk`.
    pub struct WalkBlock = WALK, "a walk" {
        /// The place that the person walks to.
        to: [f64; 2] = required(ValueType::Pair(LENGTH), "[3, 4] m");
    }
    also [
        Key::optional("human", ValueType::Block(&WALKER), "The person who walks: `human NAME { from [0, 0] m }`.").at(Place::Hq),
        Key::optional("humans", ValueType::Each(&ValueType::Block(&WALKER)), "The person who walks, by name.").at(Place::Yaml),
    ]
}

block! {
    /// The person who walks.
    pub struct WalkerBlock = WALKER, "a human of a walk" {
        /// Start of the walk.
        from: [f64; 2] = required(ValueType::Pair(LENGTH), "[0, 0] m");
        /// Speed of the person.
        speed: f64 = or(ValueType::Number(Quantity::above(VELOCITY, 0.0)), "1 m/s");
    }
}

/// Builds the mission; without a person, nobody walks.
pub fn build(declared: &DeclaredMission, remarks: &mut Remarks) -> Walk {
    let to = WalkBlock::read(&declared.settings).to;
    let mut people = declared.of("human");
    let Some(person) = people.next() else {
        let remark = Remark::error("HQ0206", declared.at, "nobody walks");
        remarks.push(remark.help("declare a person: `human anna { from [0, 0] m }`"));
        return Walk { person: String::new(), from: to, to, speed: 1.0, labels: Default::default() };
    };
    if let Some(other) = people.next() {
        remarks.push(Remark::error("HQ0202", other.at, "a walk has one person").label(person.at, "the first one"));
    }
    let WalkerBlock { from, speed } = WalkerBlock::read(&person.settings);
    Walk { person: person.name.clone(), from, to, speed, labels: Default::default() }
}

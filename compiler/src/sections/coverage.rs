//! Keys of a coverage: demands on the limits of stacks.

use blocks::{ByName, Located, Unbound, Word, block};

use super::{Named, ValueType};

const LEVEL: ValueType = ValueType::Choice(&["hard", "soft"]);

block! {
    /// Demands on the limits of stacks.
    pub struct CoverageBlock = COVERAGE, "a coverage" {
        /// States whose stacks have to meet the demands, by their paths; a state stands for all states inside it.
        /// Default, without `stacks` too: all stacks that run, in a scenario too, and move the robot.
        states: Option<Located<Vec<Located<String>>>> =
            optional(ValueType::List(&ValueType::Name(Named::StatePath)), "[carry]");
        /// Stacks that have to meet the demands.
        stacks: Option<Located<Vec<Located<String>>>> =
            optional(ValueType::List(&ValueType::Name(Named::Stack)), "[work]");
        /// Joints whose velocity, position and acceleration have to be limited. Default: all that a stack moves,
        /// including the base.
        joints: Option<Located<Unbound>> = elsewhere(ValueType::Joints);
        /// The speed of each joint that moves is limited: on a `hard` level, or at least on a `soft` one above the
        /// targets.
        velocity: Option<Located<Word>> = optional(LEVEL);
        /// The position of each joint that moves is limited on both sides, except for joints that turn without end and
        /// for the base.
        position: Option<Located<Word>> = optional(LEVEL);
        /// The acceleration of each joint that moves is limited.
        acceleration: Option<Located<Word>> = optional(LEVEL);
        /// Links that are kept apart from each other: `self_collision { between [left_hand]  and [right_hand] }`.
        self_collision: Vec<Located<ApartBlock>> = optional(ValueType::Blocks(&APART));
        /// People from whom links are kept, by name: `people { worker { links [tool, elbow] } }`.
        people: Vec<ByName<PersonBlock>> = optional(ValueType::Of(Named::Human, &ValueType::Block(&PERSON)));
        /// Limits that have to be in the stacks, by the names of their tasks: `limits { table { links [elbow] } }`. A
        /// task of the same type with the same parameters counts too.
        limits: Vec<ByName<NamedLimitBlock>> = optional(ValueType::Of(Named::Task, &ValueType::Block(&NAMED_LIMIT)));
    }
}

block! {
    /// A demand that links are kept apart.
    pub struct ApartBlock = APART, "a demand on self-collision" {
        /// Links on one side: links, arms, points, segments and groups.
        between: Option<Located<Unbound>> = required_elsewhere(ValueType::Links, "[left_hand, right_hand]");
        /// Links on the other side. Default: each two of `between` are kept apart.
        and: Option<Located<Unbound>> = elsewhere(ValueType::Links);
        /// Level that the limit needs: `hard`, or at least `soft` above the targets.
        level: Word = or(LEVEL, "hard");
    }
}

block! {
    /// A demand that links are kept from a person.
    pub struct PersonBlock = PERSON, "a demand on the distance to a person" {
        /// Links that are kept from the person: links, arms, points, segments and groups.
        links: Option<Located<Unbound>> = required_elsewhere(ValueType::Links, "[tool, elbow]");
        /// Points of the person that count. Default: all.
        points: Option<Located<Vec<Located<String>>>> =
            optional(ValueType::List(&ValueType::Name(Named::Point)), "[chest]");
        /// Level that the limit needs: `hard`, or at least `soft` above the targets.
        level: Word = or(LEVEL, "hard");
    }
}

block! {
    /// A demand that a limit is in the stacks.
    pub struct NamedLimitBlock = NAMED_LIMIT, "a demand on a limit" {
        /// Links that the limit has to guard: links, arms, points, segments and groups. Default: it only has to be
        /// there.
        links: Option<Located<Unbound>> = elsewhere(ValueType::Links);
        /// Level that the limit needs: `hard`, or at least `soft` above the targets.
        level: Word = or(LEVEL, "hard");
    }
}

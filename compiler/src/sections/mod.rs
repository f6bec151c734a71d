//! The keys of the language that no task type declares, written once: what each is called, holds and says, whether it may
//! be left out, and in which syntax it stands. The compiler's refusals of unknown keys, the schema, the language server
//! and the page of keys derive from it.
//!
//! A new block is one more [`BlockSchema`], named by the key that holds it. The blocks of missions are declared by their
//! kinds.

mod coverage;
mod field;
mod human;
mod machine;
mod mission_events;
mod obstacle;
mod plant;
mod robot;
mod ros;
mod scenario;
mod spec;
mod stack;

use std::sync::LazyLock;

use dsl::Syntax;

pub use blocks::{Argument, BlockSchema, Key, Members, Named, Place, ValueType};
pub use coverage::{APART, ApartBlock, COVERAGE, CoverageBlock, NAMED_LIMIT, NamedLimitBlock, PERSON, PersonBlock};
pub use field::{FIELD_DISTANCE, SAFETY_FIELD, SafetyFieldBlock};
pub use human::{HUMAN, HUMAN_POINT, HUMAN_SCRIPT, HumanBlock, HumanScriptBlock};
pub use machine::{
    MACHINE, MachineBlock, SIGNAL, STATE, SignalBlock, StateBlock, TRANSITION, TransitionBlock, VARIABLE, WRENCH,
    WrenchBlock,
};
pub use mission::declare::common::RUNS;
pub use mission::declare::driven::DRIVEN;
pub use mission::kinds::MISSION;
pub use mission_events::{APPROACHES, DISTANCES, EVENT, REPLY, WAITS};
pub use obstacle::{OBSTACLE, ObstacleBlock, ROUND, RoundBlock, TRUE_OBSTACLE, TrueObstacleBlock};
pub use plant::{MUJOCO, MujocoBlock, PAYLOAD, PLANT, PayloadBlock, PlantBlock};
pub use robot::{
    ARM, ArmBlock, BASES, LIMIT, LimitBlock, POINT, PointBlock, ROBOT, RobotBlock, SEGMENT, SegmentBlock, prefix,
};
pub use ros::{
    COMMAND_TOPIC, CommandTopicBlock, JOINT_STATES, JointStatesBlock, ROS, RosBlock, SIGNAL_TOPIC, SignalTopicBlock,
};
pub use scenario::{
    LATE, LOST, LateBlock, LostBlock, OF_ALL_SCENARIOS, OF_MISSIONS, OUTCOME, OutcomeBlock, PUSH, PushBlock, SCENARIO,
    SCENARIO_SIMULATOR, SIGNAL_SCRIPT, ScenarioBlock, ScenarioSimulator, SignalScriptBlock, WAYPOINT, WaypointBlock,
};
pub use spec::{ALLOW, PARAM, REPEAT, RUN, RunBlock, SIMULATOR, SPEC, SimulatorBlock};
pub use stack::{CHANGE, LEVEL, LevelBlock, MEMBER, STACK, StackBlock};

/// All blocks, from the outside in: each is followed by the blocks that its keys hold.
pub static ALL: LazyLock<Vec<&'static BlockSchema>> = LazyLock::new(|| {
    let mut all = Vec::new();
    add(&SPEC, &mut all);
    all
});

fn add(schema: &'static BlockSchema, all: &mut Vec<&'static BlockSchema>) {
    if !all.iter().any(|known| std::ptr::eq(*known, schema)) {
        all.push(schema);
        schema.inner().for_each(|inner| add(inner, all));
    }
}

/// Keys of a block in one of the syntaxes.
pub trait InSyntax {
    /// Returns the keys of a syntax.
    fn written(&self, syntax: Syntax) -> impl Iterator<Item = &'static Key>;

    /// Returns the key of this name in a syntax.
    fn key(&self, name: &str, syntax: Syntax) -> Option<&'static Key> {
        self.written(syntax).find(|key| key.name == name)
    }
}

impl InSyntax for BlockSchema {
    fn written(&self, syntax: Syntax) -> impl Iterator<Item = &'static Key> {
        self.keys.iter().filter(move |key| match syntax {
            Syntax::Native => key.is_native(),
            Syntax::Yaml => key.is_yaml(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_stands_once_in_each_spelling_and_says_what_it_is() {
        for section in ALL.iter() {
            for syntax in [Syntax::Native, Syntax::Yaml] {
                let mut names: Vec<&str> = section.written(syntax).map(|k| k.name).collect();
                let count = names.len();
                names.sort_unstable();
                names.dedup();
                assert_eq!(names.len(), count, "{}", section.name);
            }
            for key in section.keys {
                assert!(key.doc.len() > 5 && !key.doc.ends_with(' '), "{}: `{}`", section.name, key.name);
            }
        }
    }

    /// The readers leave these as text, and they say so in a list of their own.
    #[test]
    fn texts_are_those_of_the_readers() {
        let all = ALL.iter().flat_map(|s| s.keys).filter(|k| k.place == Place::Entry);
        let is_text = |holds: &ValueType| {
            matches!(
                holds,
                ValueType::Text
                    | ValueType::File
                    | ValueType::FileWith(_)
                    | ValueType::Binary(_)
                    | ValueType::Urdf
                    | ValueType::Srdf
                    | ValueType::Spec
                    | ValueType::List(ValueType::Text)
            )
        };
        let mut texts: Vec<&str> = all.filter(|k| is_text(&k.value)).map(|k| k.name).collect();
        let mut readers = dsl::vocabulary::TEXT_KEYS.to_vec();
        // A key of several sections is one word.
        texts.sort_unstable();
        texts.dedup();
        readers.sort_unstable();
        assert_eq!(texts, readers);
    }
}

//! The keys of the sections as text, for the docs and the editor. The table itself is [`compiler::sections`].

use std::fmt::Write;

use compiler::sections::{ALL, Named, Place, ValueType};
use mission::kind::Form;
use mission::kinds::KINDS;
use quantities::usual::{JOINT_ANGLE, JOINT_SPEED, JOINT_TRAVEL, JOINT_TRAVEL_SPEED};
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::params::Presence;

use crate::catalogue::{of_joints, presence, quantity, unit, usual};

/// Describes the type of a key's value in words.
pub fn describe(holds: &ValueType) -> String {
    match holds {
        ValueType::Number(q) => quantity(q),
        ValueType::Count(q) if q.describe().is_empty() => "whole number".to_string(),
        ValueType::Count(q) => format!("whole number, {}", q.describe()),
        ValueType::NumberOr(q, words) => {
            format!("{}, or {}", quantity(q), words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" or "))
        }
        ValueType::Numbers(q) => format!("{}, or a list of them", quantity(q)),
        ValueType::Function(of) => {
            let names = of.names().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" and ");
            format!("{}, or an expression of {names}", quantity(&of.result))
        }
        ValueType::Vector(q) => format!("vector in {}{}", unit(q.dimension), usual(q)),
        ValueType::Spot => "position in m, or a place".to_string(),
        ValueType::Pair(d) => format!("two numbers `[x, y]` in {}", unit(*d)),
        ValueType::Range(q) => format!("{}, or `[least, greatest]`", quantity(q)),
        ValueType::Spread(q) => format!("{}, or `normal(mean, deviation)`", quantity(q)),
        ValueType::OfJoint { speed: false } => format!("position {}", of_joints([JOINT_ANGLE, JOINT_TRAVEL])),
        ValueType::OfJoint { speed: true } => format!("speed {}", of_joints([JOINT_SPEED, JOINT_TRAVEL_SPEED])),
        ValueType::Bound => "number in the unit of the value".to_string(),
        ValueType::WordOr(words) => {
            format!("{}, or an expression", words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" or "))
        }
        ValueType::People => "humans, points of them, positions in m".to_string(),
        ValueType::Value => "number, vector or orientation".to_string(),
        ValueType::Sent => "number, vector, orientation or `{ force  moment }`".to_string(),
        ValueType::Values => "list, or whole numbers from one to another".to_string(),
        ValueType::Text | ValueType::File | ValueType::FileWith(_) | ValueType::Binary(_) => "text".to_string(),
        ValueType::Urdf | ValueType::Srdf => "path of a file".to_string(),
        ValueType::Spec => "path of a spec".to_string(),
        ValueType::Flag => "`true` or `false`".to_string(),
        ValueType::Choice(words) => words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" or "),
        ValueType::NewName => "new name".to_string(),
        ValueType::Name(Named::Robot) => "robot".to_string(),
        ValueType::Name(Named::Task) => "task".to_string(),
        ValueType::Name(Named::Stack) => "stack".to_string(),
        ValueType::Name(Named::Level) => "level".to_string(),
        ValueType::Name(Named::Machine) => "machine".to_string(),
        ValueType::Name(Named::Member | Named::Own(_)) => "member of the mission".to_string(),
        ValueType::Name(Named::StatePath) => "path of a state".to_string(),
        ValueType::Name(Named::State) => "state".to_string(),
        ValueType::Name(Named::Mission) => "mission".to_string(),
        ValueType::Name(Named::Person) => "human of the mission".to_string(),
        ValueType::Name(Named::Signal) => "signal or variable".to_string(),
        ValueType::Name(Named::Flag) => "signal of the type `flag`".to_string(),
        ValueType::Name(Named::Event) => "event".to_string(),
        ValueType::Name(Named::Human) => "human".to_string(),
        ValueType::Name(Named::Point) => "point of the human".to_string(),
        ValueType::Name(Named::SignalThere(_)) => "signal of the spec".to_string(),
        ValueType::Name(Named::Obstacle) => "obstacle".to_string(),
        ValueType::Name(Named::HumanThere) => "human of the spec".to_string(),
        ValueType::Name(Named::StateThere) => "state of the spec".to_string(),
        ValueType::Link => "link".to_string(),
        ValueType::Geometries => "points, segments, links, groups".to_string(),
        ValueType::Links => "links, arms, points, segments, groups".to_string(),
        ValueType::Joints => "joints, groups of joints, patterns".to_string(),
        ValueType::Locks => "joints, groups of joints, patterns, or `{ JOINT position .. }`".to_string(),
        ValueType::Positions => {
            format!("`{{ JOINT position .. }}` {}; or a posture of the SRDF", of_joints([JOINT_ANGLE, JOINT_TRAVEL]))
        }
        ValueType::Block(section) => section.name.to_string(),
        ValueType::Blocks(section) => format!("{}, or a list of such", section.name),
        ValueType::LinkOr(section) => format!("link, or {}", section.name),
        ValueType::Each(inner) | ValueType::Of(_, inner) => format!("by name: {}", describe(inner)),
        ValueType::PerJoint(inner) => format!("by joint, group or pattern: {}", describe(inner)),
        ValueType::List(inner) => format!("list: {}", describe(inner)),
        ValueType::Tasks => "task".to_string(),
        ValueType::Declarations => "declarations".to_string(),
    }
}

/// The page of the docs with the keys of all sections.
pub fn markdown() -> String {
    keys() + &measured()
}

/// Lists the measures of missions.
fn measured() -> String {
    let mut out = String::from(
        "\n## What is measured of a mission\n\n\
         Behind a dot in the expectations of a scenario that runs it: `vineyard.makespan`, `h1.waited`, `m1.position`. \
         `distance(m1, h1)` is how far two of them are apart.\n\n| of | | is | |\n|---|---|---|---|\n",
    );
    for (kind, q) in KINDS.iter().flat_map(|kind| (kind.measures)().into_iter().map(move |q| (kind, q))) {
        let is = match q.form {
            Form::Number(NONE) => "number".to_string(),
            Form::Number(d) => format!("number in {}", unit(d)),
            Form::Truth | Form::OfController => "true or false".to_string(),
            Form::Point => "point in m".to_string(),
        };
        let of = match q.of {
            [] => kind.title.to_string(),
            roles => format!("a {} of {}", roles.join(", a "), kind.title),
        };
        let _ = writeln!(out, "| {of} | `{}` | {is} | {} |", q.name, q.doc);
    }
    out
}

fn keys() -> String {
    let mut out = String::from(
        "# Keys\n\n\
         What stands in the blocks of the language, beside the parameters of [task types](../tasks.md). Numbers are written \
         with their units and may name [params](files.md#params); those of this page are constant. This page is generated \
         from the table that the compiler reads.\n",
    );
    for section in ALL.iter() {
        let heading = section.name.trim_start_matches("a ").trim_start_matches("an ").trim_start_matches("the ");
        let _ = write!(out, "\n## {}\n\n| key | holds | where left out | |\n|---|---|---|---|\n", capital(heading));
        for key in section.keys {
            let left_out = match key.presence {
                Presence::Required => "required".to_string(),
                Presence::Optional => String::new(),
                Presence::Default(_) => presence(&key.presence).trim_start_matches("default ").to_string(),
            };
            let only = match key.place {
                Place::Entry | Place::Word => "",
                Place::Hq => " (`.hq`)",
                Place::Yaml => " (YAML)",
            };
            let cell = |text: &str| text.replace('|', "\\|");
            let holds = cell(&describe(&key.value));
            let _ = writeln!(out, "| `{}`{only} | {holds} | {} | {} |", key.name, cell(&left_out), cell(key.doc));
        }
    }
    out
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|c| c.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

//! The keys of the sections as text, for the docs and the editor. The table itself is [`compiler::sections`].

use std::fmt::Write;

use compiler::sections::{ALL, Holds, Named, Place};
use mission::kind::Form;
use mission::kinds::KINDS;
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::params::Presence;

use crate::catalogue::{presence, quantity, unit};

/// What may stand behind a key, in words.
pub fn describe(holds: &Holds) -> String {
    match holds {
        Holds::Number(q) => quantity(q),
        Holds::NumberOr(q, words) => {
            format!("{}, or {}", quantity(q), words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" or "))
        }
        Holds::Numbers(q) => format!("{}, or a list of them", quantity(q)),
        Holds::Vector(d) => format!("vector in {}", unit(*d)),
        Holds::Spot => "position in m, or a place".to_string(),
        Holds::Pair(d) => format!("two numbers `[x, y]` in {}", unit(*d)),
        Holds::Range(q) => format!("{}, or `[least, greatest]`", quantity(q)),
        Holds::Spread(q) => format!("{}, or `normal(mean, deviation)`", quantity(q)),
        Holds::OfJoint { speed: false } => "position in rad or m".to_string(),
        Holds::OfJoint { speed: true } => "speed in rad/s or m/s".to_string(),
        Holds::Bound => "number in the unit of the value".to_string(),
        Holds::WordOr(words) => {
            format!("{}, or an expression", words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" or "))
        }
        Holds::People => "humans, points of them, positions in m".to_string(),
        Holds::Value => "number, vector or orientation".to_string(),
        Holds::Sent => "number, vector, orientation or `{ force  moment }`".to_string(),
        Holds::Values => "list, or whole numbers from one to another".to_string(),
        Holds::Text => "text".to_string(),
        Holds::Urdf => "path of a file".to_string(),
        Holds::Spec => "path of a spec".to_string(),
        Holds::Flag => "`true` or `false`".to_string(),
        Holds::Choice(words) => words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" or "),
        Holds::NewName => "new name".to_string(),
        Holds::Name(Named::Robot) => "robot".to_string(),
        Holds::Name(Named::Stack) => "stack".to_string(),
        Holds::Name(Named::Level) => "level".to_string(),
        Holds::Name(Named::Machine) => "machine".to_string(),
        Holds::Name(Named::Member) => "member of the mission".to_string(),
        Holds::Name(Named::State) => "state".to_string(),
        Holds::Name(Named::Mission) => "mission".to_string(),
        Holds::Name(Named::Person) => "human of the mission".to_string(),
        Holds::Name(Named::SignalThere) => "signal of the spec".to_string(),
        Holds::Name(Named::StateThere) => "state of the spec".to_string(),
        Holds::Name(Named::Signal) => "signal or variable".to_string(),
        Holds::Name(Named::Event) => "event".to_string(),
        Holds::Name(Named::Human) => "human".to_string(),
        Holds::Name(Named::Point) => "point of the human".to_string(),
        Holds::Link => "link".to_string(),
        Holds::Geometries => "points, segments, links, groups".to_string(),
        Holds::Links => "links, arms, points, segments, groups".to_string(),
        Holds::Joints => "joints, groups of joints, patterns".to_string(),
        Holds::Locks => "joints, groups of joints, patterns, or `{ JOINT position .. }`".to_string(),
        Holds::Positions => "`{ JOINT position .. }` in rad or m".to_string(),
        Holds::Block(section) => section.name.to_string(),
        Holds::Blocks(section) => format!("{}, or a list of such", section.name),
        Holds::LinkOr(section) => format!("link, or {}", section.name),
        Holds::Each(inner) | Holds::Of(_, inner) => format!("by name: {}", describe(inner)),
        Holds::PerJoint(inner) => format!("by joint, group or pattern: {}", describe(inner)),
        Holds::List(inner) => format!("in an order: {}", describe(inner)),
        Holds::Tasks => "task".to_string(),
        Holds::Declarations => "declarations".to_string(),
    }
}

/// The page of the docs with the keys of all sections.
pub fn markdown() -> String {
    keys() + &measured()
}

/// What can be expected of missions.
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
    for section in ALL {
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
            let holds = cell(&describe(&key.holds));
            let _ = writeln!(out, "| `{}`{only} | {holds} | {} | {} |", key.name, cell(&left_out), cell(key.doc));
        }
    }
    out
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|c| c.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

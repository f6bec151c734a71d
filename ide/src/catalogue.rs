//! The task catalogue as text: for `hierarq tasks`, and for the generated page of the docs.

use std::fmt::Write;

use compiler::codes::Part;
use quantities::usual::{
    GAIN, JOINT_ACCELERATION, JOINT_ANGLE, JOINT_SPEED, JOINT_TRAVEL, JOINT_TRAVEL_ACCELERATION, JOINT_TRAVEL_SPEED,
    of_joint,
};
use serde_json::{Value as Json, json};
use stdlib_tasks::kinds::safety_planner::PATH;
use stdlib_tasks::params::{Form, ParamInfo, ParamType, Presence, Quantity};
use stdlib_tasks::task::{RowKind, TaskKind};
use stdlib_tasks::{KINDS, dimension::Dimension};

fn row_kind(kind: &TaskKind) -> &'static str {
    match kind.row_kind {
        RowKind::Inequality => "limit",
        RowKind::Equality => "target",
    }
}

/// Returns a list with one line for each type.
pub fn list() -> String {
    let width = KINDS.iter().map(|k| k.name.len()).max().unwrap_or(0);
    let mut out = String::new();
    for kind in KINDS {
        let _ = writeln!(out, "{:<width$}  {:<6}  {}", kind.name, row_kind(kind), kind.summary);
    }
    out.push_str("\n`hierarq tasks TYPE` shows parameters, equations and an example.\n");
    out
}

/// Returns a dimension in words.
pub(crate) fn unit(d: Dimension) -> String {
    if d == stdlib_tasks::dimension::NONE { "no unit".to_string() } else { d.to_string() }
}

/// Returns unit and range of a number.
pub(crate) fn quantity(q: &Quantity) -> String {
    let range = q.describe();
    let comma = if range.is_empty() { String::new() } else { format!(", {range}") };
    let constant = if q.constant { ", constant" } else { "" };
    format!("number in {}{comma}{constant}{}", unit(q.dimension), usual(q))
}

/// Returns the usual sizes of a number, behind its range.
pub(crate) fn usual(q: &Quantity) -> String {
    let usual = q.describe_usual();
    if usual.is_empty() { usual } else { format!(", {usual}") }
}

fn expression(form: &Form) -> String {
    match form {
        Form::Value { orientation: false } => "number or vector of the robot's state, in any unit".to_string(),
        Form::Value { orientation: true } => {
            "number, vector, orientation or pose of the robot's state, in any unit".to_string()
        }
        Form::Like(other) => format!("of the kind and unit of `{other}`; the robot's state may stand in it"),
        Form::Size(other) => format!("`auto`, or a number in the unit of `{other}`, at least 0, constant"),
        Form::Vector(d) => format!("vector in {}; the robot's state may stand in it", unit(*d)),
        Form::Number(q) => format!("{}; the robot's state may stand in it", quantity(q)),
    }
}

/// Returns values by joint in words, from those of revolute and of prismatic joints.
fn joint_values(value: &str, [turn, travel]: [Quantity; 2]) -> String {
    format!("`{{ JOINT {value} .. }}` {}", of_joints([turn, travel]))
}

/// Returns the units of revolute and of prismatic joints with their usual sizes.
pub(crate) fn of_joints(both: [Quantity; 2]) -> String {
    let [turn, travel] = both.map(|q| format!("in {}{}", q.dimension, usual(&q)));
    format!("{turn}, or {travel}")
}

/// Returns the permitted values of a parameter in words.
pub fn describe(ty: &ParamType) -> String {
    match ty {
        ParamType::Scalar(q) => quantity(q),
        ParamType::AutoScalar(q) => format!("`auto`, or a {}", quantity(q)),
        ParamType::Vector(d) => format!("vector in {}", unit(*d)),
        ParamType::PerAxis(q) => format!("{}, or a vector with one for each axis", quantity(q)),
        ParamType::Vectors { least, most, dimension } => {
            let count = if least == most { least.to_string() } else { format!("{least} to {most}") };
            format!("{count} constant vectors in {}", unit(*dimension))
        }
        ParamType::Rotation => "orientation".to_string(),
        ParamType::Gains(names) => format!("rate in 1/s{}, or `{{ {} }}`", usual(&GAIN), names.join(" .. ") + " .."),
        ParamType::Frame => "link".to_string(),
        ParamType::Frames => "links or arms".to_string(),
        ParamType::Arm => "arm".to_string(),
        ParamType::Geometries => "points, segments, links, groups".to_string(),
        ParamType::Obstacles => "obstacles".to_string(),
        ParamType::Pairs(_) => "pairs of links, `[[LINK, LINK], ..]`; a group stands for its links".to_string(),
        ParamType::Joints => "joints, groups of joints".to_string(),
        ParamType::JointPositions => joint_values("value", [JOINT_ANGLE, JOINT_TRAVEL]),
        ParamType::JointVelocities => joint_values("value", [JOINT_SPEED, JOINT_TRAVEL_SPEED]),
        ParamType::JointAccelerations => joint_values("value", [JOINT_ACCELERATION, JOINT_TRAVEL_ACCELERATION]),
        ParamType::PerArm(d) => format!("`{{ ARM value .. }}` in {d}{}", usual(&of_joint(*d))),
        ParamType::PerFrame(_) => "`{ FRAME { .. } .. }`, for links or arms".to_string(),
        ParamType::Axes => "some of the axes `x`, `y`, `z`".to_string(),
        ParamType::Choice(words) => words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(" or "),
        ParamType::Expression(form) => expression(form),
        ParamType::Group(_) => "block".to_string(),
        ParamType::Task => "task".to_string(),
        ParamType::Field => "safety field".to_string(),
        ParamType::Deviations => "`{ PARAMETER { .. } .. }`, in the groups of the other task".to_string(),
    }
}

/// Returns whether a parameter is required, with its default if any.
pub(crate) fn presence(p: &Presence) -> String {
    match p {
        Presence::Required => "required".to_string(),
        Presence::Optional => "optional".to_string(),
        Presence::Default(text) => format!("default `{text}`"),
    }
}

fn rows<'a>(params: &'a [ParamInfo], prefix: &str, out: &mut Vec<(String, &'a ParamInfo)>) {
    for p in params {
        out.push((format!("{prefix}{}", p.name), p));
        match p.ty {
            ParamType::Group(inner) => rows(inner, &format!("{prefix}{}.", p.name), out),
            ParamType::PerFrame(inner) => rows(inner, &format!("{prefix}{}.FRAME.", p.name), out),
            ParamType::Deviations => rows(PATH, &format!("{prefix}{}.PARAMETER.", p.name), out),
            _ => {}
        }
    }
}

/// Returns the complete description of a type for the terminal.
pub fn page(kind: &TaskKind) -> String {
    let mut out = format!("{}  ({})\n{}\n\n{}\n\n", kind.name, row_kind(kind), kind.summary, kind.docs);
    out.push_str("Parameters\n");
    let mut list = Vec::new();
    rows(kind.params, "", &mut list);
    for (name, p) in list {
        let _ = writeln!(out, "  {name}: {}; {}\n      {}", describe(&p.ty), presence(&p.presence), p.text());
    }
    if !kind.positional.is_empty() {
        let _ = writeln!(out, "\nIn parentheses: {}({})", kind.name, kind.positional.join(", "));
    }
    if !kind.current_values.is_empty() {
        let names: Vec<&str> =
            kind.current_values.iter().map(|a| if a.name == "*" { "angle.ARM" } else { a.name }).collect();
        let _ = writeln!(out, "\nFor initial(..): {}", names.join(", "));
    }
    if !kind.outputs.is_empty() {
        out.push_str("\nOutputs while a stack with it runs, as `NAME.OUTPUT` in conditions, expectations and logs\n");
        for output in kind.outputs {
            let _ =
                writeln!(out, "  .{}: number in {}\n      {}", output.name, unit(output.dimension), output.description);
        }
    }
    let _ = write!(out, "\nExample\n{}\n", kind.example.lines().map(|l| format!("  {l}\n")).collect::<String>());
    out
}

/// Returns the description of a type as data.
pub fn json(kind: &TaskKind) -> Json {
    let mut list = Vec::new();
    rows(kind.params, "", &mut list);
    let params: Vec<Json> = list
        .iter()
        .map(|(name, p)| {
            json!({
                "name": name,
                "type": describe(&p.ty),
                "required": p.presence == Presence::Required,
                "default": match p.presence { Presence::Default(t) => Some(t), _ => None },
                "doc": p.text(),
            })
        })
        .collect();
    json!({
        "name": kind.name,
        "row_kind": row_kind(kind),
        "summary": kind.summary,
        "docs": kind.docs,
        "example": kind.example,
        "positional": kind.positional,
        "params": params,
        "outputs": kind.outputs.iter().map(|t| json!({ "name": t.name, "unit": unit(t.dimension), "description": t.description })).collect::<Vec<_>>(),
    })
}

/// Returns the docs page with all types.
pub fn markdown() -> String {
    let mut out = String::from(
        "# Task catalogue\n\nGenerated from the task library; do not edit. `hierarq tasks TYPE` prints the same.\n\n\
         A *limit* keeps a value out of a region and has margins, safe where not negative. A *target* pulls a value to where \
         it should be and has errors.\n\n| type | | summary |\n|---|---|---|\n",
    );
    for kind in KINDS {
        let _ = writeln!(out, "| [`{0}`](#{0}) | {1} | {2} |", kind.name, row_kind(kind), kind.summary);
    }
    for kind in KINDS {
        let _ = write!(out, "\n## {}\n\n{}\n\n", kind.name, kind.docs);
        out.push_str("| parameter | type | | description |\n|---|---|---|---|\n");
        let mut list = Vec::new();
        rows(kind.params, "", &mut list);
        for (name, p) in list {
            let _ = writeln!(
                out,
                "| `{name}` | {} | {} | {} |",
                describe(&p.ty).replace('|', "\\|"),
                presence(&p.presence),
                p.text()
            );
        }
        if !kind.positional.is_empty() {
            let _ = writeln!(out, "\nIn parentheses: `{}({})`.", kind.name, kind.positional.join(", "));
        }
        if !kind.current_values.is_empty() {
            let names: Vec<String> = kind
                .current_values
                .iter()
                .map(|a| format!("`{}`", if a.name == "*" { "angle.ARM" } else { a.name }))
                .collect();
            let _ = writeln!(out, "\nFor `initial(..)`: {}.", names.join(", "));
        }
        if !kind.outputs.is_empty() {
            out.push_str(
                "\nOutputs of a task `NAME` while a stack with it runs, for conditions, expectations and logs:\n\n",
            );
            out.push_str("| output | unit | description |\n|---|---|---|\n");
            for output in kind.outputs {
                let _ =
                    writeln!(out, "| `NAME.{}` | {} | {} |", output.name, unit(output.dimension), output.description);
            }
        }
        let _ = write!(out, "\n```hq\n{}\n```\n", kind.example);
    }
    out
}

/// Returns the docs page with all diagnostic codes.
pub fn codes_markdown() -> String {
    let mut out = format!(
        "# Diagnostic codes\n\nGenerated; do not edit. `hierarq explain CODE` prints the same.\n\nEvery example is compiled \
         by a test: the example under *wrong* causes this code and no other, the example under *right* no diagnostic. \
         Missing parts are added to an example: the line `hierarq 1`, a stack of all its tasks, and this \
         robot, whose path is relative to `examples/`. An example in XML is the robot's URDF.\n\n```hq\n{}```\n",
        compiler::codes::EXAMPLE_ROBOT
    );
    for page in compiler::codes::all() {
        let _ = write!(out, "\n## {}: {}\n", page.code, page.title);
        if page.warning {
            out.push_str(
                "\n*A warning: it can be [allowed](language/files.md#allowed-warnings) where it is intended.*\n",
            );
        }
        for part in page.parts() {
            let _ = match part {
                Part::Text(text) => write!(out, "\n{text}\n"),
                Part::Example { language, bad, text, .. } => {
                    let word = if bad { "Wrong" } else { "Right" };
                    write!(out, "\n*{word}*\n\n```{language}\n{text}```\n")
                }
            };
        }
    }
    out
}

/// Returns the page of a code for the terminal: paragraphs of at most `width` columns, and examples indented below the
/// word "wrong" or "right".
pub fn code_page(page: &compiler::codes::Page, width: usize) -> String {
    let warning = if page.warning { " (warning)" } else { "" };
    let mut out = format!("{}: {}{warning}\n", page.code, page.title);
    for part in page.parts() {
        match part {
            Part::Text(text) => {
                for paragraph in text.split("\n\n") {
                    out.push('\n');
                    wrap(paragraph, width, &mut out);
                }
            }
            Part::Example { bad, text, .. } => {
                let _ = writeln!(out, "\n{}:\n", if bad { "Wrong" } else { "Right" });
                for line in text.lines() {
                    out.push_str(if line.is_empty() { "" } else { "    " });
                    let _ = writeln!(out, "{line}");
                }
            }
        }
    }
    out
}

/// Appends a paragraph, broken at blanks into lines of at most `width` characters.
fn wrap(paragraph: &str, width: usize, out: &mut String) {
    let mut used = 0;
    for word in paragraph.split_whitespace() {
        let length = word.chars().count();
        if used > 0 && used + 1 + length > width {
            out.push('\n');
            used = 0;
        } else if used > 0 {
            out.push(' ');
            used += 1;
        }
        out.push_str(word);
        used += length;
    }
    out.push('\n');
}

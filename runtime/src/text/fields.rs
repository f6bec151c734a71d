//! Safety fields of a program as text.

use std::fmt::Write;

use names::wrapped;
use stdlib_tasks::bound::Slot;
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::field::{DistanceProgram, Over};

use super::operations::operation;
use super::{number, slot};
use crate::program::{Op, Program};

/// Writes each field: the averaged distance, its links, and its points.
pub(super) fn fields(p: &Program, out: &mut String) -> std::fmt::Result {
    if !p.fields.is_empty() {
        writeln!(out, "\nsafety fields")?;
    }
    for field in &p.fields {
        let unit = if field.dimension == NONE { String::new() } else { format!(" in {}", field.dimension) };
        let distance = match &field.distance {
            DistanceProgram::Identity => "the distance".to_string(),
            DistanceProgram::Clamped(reach) => format!("min(d, {} m)", number(*reach)),
            DistanceProgram::Saturating(reach) => {
                format!("{0} m (1 - exp(-d / {0} m))", number(*reach))
            }
            DistanceProgram::Written(w) => format!("${} of the distance", w.value),
        };
        let over = match field.over {
            Over::Mean => "their mean".to_string(),
            Over::Least => "their minimum".to_string(),
            Over::SoftLeast { sharpness } => format!("their soft minimum of sharpness {}", number(sharpness)),
        };
        writeln!(
            out,
            "  {}{unit}: mean of {distance} along {} links, of {} points {over}",
            field.name,
            field.links.len(),
            field.points.len()
        )?;
        let links: Vec<&str> = field.links.iter().map(|l| p.robot.model.link_ref(*l).name.as_str()).collect();
        wrapped("links", &links, out)?;
        let points: Vec<String> = field.points.iter().map(|[at, ..]| slot(p, &Slot { at: *at, len: 3 })).collect();
        wrapped("points", &points.iter().map(String::as_str).collect::<Vec<_>>(), out)?;
        if let DistanceProgram::Written(written) = &field.distance {
            for (i, op) in written.ops.iter().enumerate() {
                let text = if *op == Op::Input(0) { "the distance".to_string() } else { operation(op, '$') };
                writeln!(out, "        ${i} = {text}")?;
            }
            writeln!(out, "      value ${} with slope ${}", written.value, written.slope)?;
        }
    }
    Ok(())
}

//! Draws the machine for Mermaid.
//!
//! Mermaid draws no edge between a state and one inside it. An edge from a state with inner states to one of these
//! starts at a box `in any of NAME`; one to the outer state ends at the innermost state that is entered with it.

use std::fmt::Write;

use super::{Chart, Step};

pub(super) fn draw(c: &Chart) -> String {
    let mut out = format!("%% machine {}\nstateDiagram-v2\n", c.short(0));
    // Writing to a `String` cannot fail.
    let _ = write(c, &mut out);
    out
}

fn write(c: &Chart, out: &mut String) -> std::fmt::Result {
    let mut depth = 0;
    for step in c.steps() {
        match step {
            Step::Enter(0) => {
                depth += 1;
                begin(c, 0, depth, out)?;
            }
            Step::Enter(s) => {
                // Mermaid draws a line between regions.
                if c.is_region(s) && !c.is_first_region(s) {
                    writeln!(out, "{:1$}--", "", 4 * depth)?;
                }
                let name = c.short(s);
                if c.holds_others(s) {
                    // A composite state shows only its title.
                    let about = c.about(s).join(", ");
                    let title = if about.is_empty() { name.to_string() } else { format!("{name} ({about})") };
                    writeln!(out, "{:1$}state \"{2}\" as s{s} {{", "", 4 * depth, escaped(&title))?;
                    depth += 1;
                    begin(c, s, depth, out)?;
                } else {
                    writeln!(out, "{:1$}state \"{2}\" as s{s}", "", 4 * depth, escaped(name))?;
                    for line in c.about(s) {
                        writeln!(out, "{:1$}s{s} : {2}", "", 4 * depth, escaped(&line))?;
                    }
                }
            }
            Step::Leave(0) => {}
            Step::Leave(s) => {
                if c.holds_others(s) {
                    depth -= 1;
                    writeln!(out, "{:1$}}}", "", 4 * depth)?;
                }
                if c.machine.states[s].is_final {
                    writeln!(out, "{:1$}s{s} --> [*]", "", 4 * depth)?;
                }
            }
        }
    }
    for e in &c.edges {
        let to = if c.inside(e.from, e.to) { c.machine.leaf(e.to) } else { e.to };
        let from = if any(c, e.from, to) { format!("any{}", e.from) } else { format!("s{}", e.from) };
        writeln!(out, "    {from} --> s{to} : {}", escaped(e.text))?;
    }
    Ok(())
}

/// True if an edge needs a box of its own as its start.
fn any(c: &Chart, from: usize, to: usize) -> bool {
    from == 0 || (c.holds_others(from) && c.inside(to, from))
}

/// First entries of a state with inner states.
fn begin(c: &Chart, s: usize, depth: usize, out: &mut String) -> std::fmt::Result {
    if let Some(initial) = c.initial(s) {
        writeln!(out, "{:1$}[*] --> s{initial}", "", 4 * depth)?;
    }
    let own = c.edges.iter().filter(|e| e.from == s);
    let needed = own.into_iter().any(|e| {
        let to = if c.inside(e.from, e.to) { c.machine.leaf(e.to) } else { e.to };
        any(c, s, to)
    });
    if needed {
        writeln!(out, "{:1$}state \"in any of {2}\" as any{s}", "", 4 * depth, escaped(c.short(s)))?;
    }
    Ok(())
}

/// Escapes characters that would end a text or a line, as codes of Mermaid.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '#' | ';' | ':' | '"' | '<' | '>' | '{' | '}' | '%' | '&' => {
                let _ = write!(out, "#{};", c as u32);
            }
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

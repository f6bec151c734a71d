//! Draws the machine for Graphviz.
//!
//! A state with inner states is a cluster, and edges end at its border. An edge between a cluster and a state inside it
//! cannot: it starts at a node `in any of NAME`, or ends at the innermost state that is entered.

use std::fmt::Write;

use super::{Chart, Edge, Step};

pub(super) fn draw(c: &Chart) -> String {
    let mut out = String::new();
    // Writing to a `String` cannot fail.
    let _ = write(c, &mut out);
    out
}

fn write(c: &Chart, out: &mut String) -> std::fmt::Result {
    writeln!(out, "digraph {} {{", quoted(c.short(0)))?;
    writeln!(out, "  compound=true;\n  rankdir=TB;\n  fontname=\"sans-serif\";")?;
    writeln!(out, "  node [shape=box, style=rounded, fontname=\"sans-serif\"];")?;
    writeln!(out, "  edge [fontname=\"sans-serif\", fontsize=10];")?;
    let mut depth = 1;
    for step in c.steps() {
        match step {
            Step::Enter(s) if s > 0 && !c.holds_others(s) => {
                let lines: Vec<String> = std::iter::once(c.short(s).to_string()).chain(c.about(s)).collect();
                let border = match c.machine.states[s].is_final {
                    true => ", peripheries=2",
                    false if c.is_region(s) => ", style=\"rounded,dashed\"",
                    false => "",
                };
                writeln!(out, "{:1$}s{s} [label={2}{border}];", "", 2 * depth, quoted(&lines.join("\n")))?;
            }
            Step::Enter(s) => {
                if s > 0 {
                    writeln!(out, "{:1$}subgraph cluster_s{s} {{", "", 2 * depth)?;
                    depth += 1;
                    let title = if c.machine.states[s].is_final {
                        format!("{} (final)", c.short(s))
                    } else {
                        c.short(s).to_string()
                    };
                    let lines: Vec<String> = std::iter::once(title).chain(c.about(s)).collect();
                    writeln!(out, "{:1$}label={2};", "", 2 * depth, quoted(&lines.join("\n")))?;
                    let style = if c.is_region(s) { "\"rounded,dashed\"" } else { "rounded" };
                    writeln!(out, "{:1$}style={style};", "", 2 * depth)?;
                }
                if let Some(initial) = c.initial(s) {
                    writeln!(out, "{:1$}begin{s} [shape=point, width=0.15];", "", 2 * depth)?;
                    let (leaf, head) = end(c, initial, "lhead");
                    writeln!(out, "{:1$}begin{s} -> s{leaf}{2};", "", 2 * depth, attributes(&[head]))?;
                }
                if c.edges.iter().any(|e| e.from == s && begins_inside(c, e)) {
                    let label = quoted(&format!("in any of {}", c.short(s)));
                    writeln!(out, "{:1$}any{s} [label={label}, shape=plaintext];", "", 2 * depth)?;
                }
            }
            Step::Leave(s) if s > 0 && c.holds_others(s) => {
                depth -= 1;
                writeln!(out, "{:1$}}}", "", 2 * depth)?;
            }
            Step::Leave(_) => {}
        }
    }
    for e in &c.edges {
        let (to, mut head) = end(c, e.to, "lhead");
        if c.inside(e.from, e.to) {
            head = None;
        }
        let (from, tail) = match begins_inside(c, e) {
            true => (format!("any{}", e.from), None),
            false => {
                let (leaf, tail) = end(c, e.from, "ltail");
                (format!("s{leaf}"), tail)
            }
        };
        let label = Some(format!("label={}", quoted(e.text)));
        let style = e.fault.then(|| "style=dashed".to_string());
        writeln!(out, "  {from} -> s{to}{};", attributes(&[label, style, tail, head]))?;
    }
    writeln!(out, "}}")
}

/// True if an edge connects a state that has inner states with one of these.
fn begins_inside(c: &Chart, e: &Edge) -> bool {
    c.holds_others(e.from) && (c.inside(e.to, e.from) || c.inside(e.from, e.to))
}

/// Node for an end of an edge, with the cluster at whose border the edge is clipped.
fn end(c: &Chart, state: usize, word: &str) -> (usize, Option<String>) {
    (c.machine.leaf(state), c.holds_others(state).then(|| format!("{word}=cluster_s{state}")))
}

fn attributes(all: &[Option<String>]) -> String {
    let all: Vec<&str> = all.iter().flatten().map(String::as_str).collect();
    if all.is_empty() { String::new() } else { format!(" [{}]", all.join(", ")) }
}

/// Quotes a text for Graphviz.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

//! Pairs of links that a task leaves out: those that the spec names, those that the robot's SRDF disables, and those that touch
//! by how their shapes are drawn.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help};
use robot::{LinkId, contacts};
use stdlib_tasks::bound::{Bound, BoundParams, ExceptedPair, Exception};
use stdlib_tasks::params::ParamInfo;

use super::{Binder, parts};
use crate::robot_binding::BoundRobot;

/// Most pairs of links that a spec can name.
const MAX_PAIRS: usize = 10_000;

impl Binder<'_> {
    /// Pairs of links, `[[hand, wrist], ..]`; a group or an arm stands for all its links.
    pub(super) fn pairs(&mut self, value: &Value, info: &ParamInfo) -> Option<Vec<ExceptedPair>> {
        let mut found: BTreeSet<[LinkId; 2]> = BTreeSet::new();
        let mut good = true;
        let is_list = matches!(value.kind, ValueKind::List(_));
        for item in value.items() {
            let sides = match &item.kind {
                ValueKind::List(sides) if is_list && sides.len() == 2 => sides,
                ValueKind::Missing => return None,
                _ => {
                    let text = format!("`{}` is a list of pairs of links", info.name);
                    let d = Diagnostic::error("HQ0304", item.span, text);
                    self.diagnostics.push(d.help(Help::each(
                        "write each pair in brackets, `[[hand, wrist], [hand, elbow]]`",
                        "write each pair in brackets: `[[hand, wrist], [hand, elbow]]`",
                    )));
                    return None;
                }
            };
            let [Some(a), Some(b)] = [&sides[0], &sides[1]].map(|side| self.links_of(side)) else {
                good = false;
                continue;
            };
            let before = found.len();
            for &i in &a {
                found.extend(b.iter().filter(|&&k| k != i).map(|&k| contacts::pair(i, k)));
            }
            if found.len() > MAX_PAIRS {
                let text = format!("`{}` names more than {MAX_PAIRS} pairs of links", info.name);
                let d = Diagnostic::error("HQ0623", value.span, text);
                self.diagnostics.push(d.help("name the links that are to be kept apart instead"));
                return None;
            }
            if found.len() == before && a == b && a.len() == 1 {
                let d = Diagnostic::error("HQ0308", item.span, "this pair is one link");
                self.diagnostics.push(d.help("name two links, or remove the pair"));
                good = false;
            }
        }
        good.then(|| found.into_iter().map(|links| ExceptedPair { links, why: Exception::Written }).collect())
    }

    /// Links of a side of a pair.
    fn links_of(&mut self, side: &Value) -> Option<BTreeSet<LinkId>> {
        let all = parts::geometries(self.robot, side, self.diagnostics)?;
        Some(all.iter().map(|g| g.link).collect())
    }
}

/// Adds the pairs that nobody has to name to those that the spec names, if both links belong to parts of the task.
pub(super) fn unnamed(robot: &BoundRobot, written: Option<&Bound>, params: &BoundParams) -> Vec<ExceptedPair> {
    let mut all = match written {
        Some(Bound::Pairs(written)) => written.clone(),
        _ => Vec::new(),
    };
    let links: BTreeSet<LinkId> = params
        .values()
        .filter_map(|bound| match bound {
            Bound::Geometries(parts) => Some(parts),
            _ => None,
        })
        .flatten()
        .map(|part| part.link)
        .collect();
    let model = &robot.model;
    let is_open = |[a, b]: &[LinkId; 2]| links.contains(a) && links.contains(b);
    let named: BTreeSet<[LinkId; 2]> = all.iter().map(|pair| pair.links).collect();
    let mut left: Vec<[LinkId; 2]> =
        contacts::pairs(model).into_iter().filter(|pair| is_open(pair) && !named.contains(pair)).collect();
    let disabled = robot.srdf.iter().flat_map(|of| of.srdf.disabled_pairs()).collect::<BTreeMap<_, _>>();
    left.retain(|pair| match disabled.get(pair) {
        Some(reason) => {
            all.push(ExceptedPair { links: *pair, why: Exception::Disabled((*reason).to_string()) });
            false
        }
        None => true,
    });
    let touching = contacts::always_touching(model, &robot.home, &left);
    all.extend(touching.into_iter().map(|links| ExceptedPair { links, why: Exception::Touching }));
    all
}

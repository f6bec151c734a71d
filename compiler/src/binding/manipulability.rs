//! `manipulability(FRAME)`, bound to a frame and the joints that count.

use dsl::tree::Value;
use dsl::{Diagnostic, Span};
use robot::{Data, LinkId, random};
use stdlib_tasks::dimension::{LENGTH, NONE};
use stdlib_tasks::expression::{Leaf, Manipulability, MotionPart};

use super::scope::TaskScope;
use crate::diagnostics::refused::{Refused, refuse};
use crate::expr::{Axes, Graph, Kind, Typed};
use crate::robot_binding::joints;

/// Random postures at which the value is computed: if it is zero at all of them, it is zero everywhere.
const POSTURES: usize = 8;

/// Random postures are the same at every run.
const SEED: u64 = 1;

impl TaskScope<'_> {
    /// Lowers the manipulability of a link; `by` names the joints that count, otherwise all of them do.
    pub(super) fn manipulability(
        &mut self,
        graph: &mut Graph,
        link: LinkId,
        part: MotionPart,
        by: Option<&[Value]>,
        span: Span,
    ) -> Result<Typed, Refused> {
        let model = &self.robot.model;
        let moving: Vec<usize> = model.support(link).iter().map(|s| s.dof as usize).collect();
        let mut dofs = match by {
            None => moving.clone(),
            Some(items) => {
                let mut said = Vec::new();
                match joints(items, model, &self.robot.joint_groups, &mut said) {
                    Some(dofs) => dofs,
                    None => return Err(said.pop().map(Box::new)),
                }
            }
        };
        dofs.retain(|dof| moving.contains(dof));
        dofs.sort_unstable();
        dofs.dedup();
        let needed = part.size();
        let name = &model.link_ref(link).name;
        let of = Manipulability { link, part, dofs };
        if of.dofs.len() < needed {
            let text = format!(
                "this manipulability is always zero: {} of the joints that count move `{name}`, and it has {needed} velocities",
                of.dofs.len()
            );
            let d = Diagnostic::error("HQ0313", span, text);
            return refuse(d.help(match part {
                MotionPart::Whole => "take the velocity of its origin, or of its axes, alone: `manipulability(FRAME, linear)`, `manipulability(FRAME, angular)`",
                _ => "name a frame that more joints move, or more joints",
            }));
        }
        let (mut rng, mut data) = (random::units(SEED), Data::new(model));
        let somewhere = (0..POSTURES).any(|_| {
            model.forward(&model.random_configuration(&mut rng), &mut data);
            of.value(model, &data) > 0.0
        });
        if !somewhere {
            let text =
                format!("this manipulability is zero at every posture: some velocity of `{name}` comes from no joint");
            let d = Diagnostic::error("HQ0313", span, text);
            return refuse(d.help(match part {
                MotionPart::Whole => "take the velocity of its origin, or of its axes, alone: `manipulability(FRAME, linear)`, `manipulability(FRAME, angular)`",
                _ => "name a frame that joints move in all directions, or more joints",
            }));
        }
        let nodes = self.leaf(graph, Leaf::Manipulability(Box::new(of)));
        let volume = LENGTH.power(3).unwrap_or(NONE);
        let dimension = if part == MotionPart::Angular { NONE } else { volume };
        Ok(Typed { kind: Kind::Scalar, dimension, nodes, bare: false, axes: Axes::default(), span })
    }
}

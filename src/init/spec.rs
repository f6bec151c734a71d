//! Writes the proposed spec in `*.hq` syntax.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use robot::{Base, DofUnit, LinkId, Model, Options};

use super::Variant;
use super::home;
use super::limbs::{self, Limb};
use super::names::{is_plain, plain};

/// Name of the group of joints outside of all arms.
static OTHERS: &str = "other_joints";

/// Maximum displacement of the tip to each side \[m\].
const FURTHEST: f64 = 0.05;

/// Comment about the drives of a real robot, which no URDF describes; in words that both syntaxes share.
static DRIVES: &str =
    "  // On a real robot, measure its drives and declare them here: `lag`, the time constant with which the
  // velocity follows a command (50 ms for instance), and `dead_time`, until a command begins to act (10 ms).
  // `tracking_gain` leads the robot to its reference: 2 /s, or what lag and dead time allow, if it is left out.
";

/// Decisions about a robot.
pub(super) struct Plan {
    /// Name of the robot and the spec.
    pub(super) name: String,
    model: Model,
    variant: Variant,
    arms: Vec<Limb>,
    /// Joints outside of all arms that do not start at zero.
    others: Vec<usize>,
    tip: LinkId,
    /// Home configuration.
    q: Vec<f64>,
    /// Displacement of the tip \[m\]; `None` if it cannot move.
    motion: Option<[f64; 3]>,
    /// Degrees of freedom that move the tip.
    dofs: Vec<usize>,
    srdf: Description,
}

/// The part of a plan that an SRDF gives.
#[derive(Default)]
struct Description {
    /// Path for compilation; `None` without an SRDF.
    source: Option<String>,
    /// Posture at home.
    home: Option<String>,
    /// Limit that keeps the links apart.
    apart: Option<String>,
    groups: Vec<String>,
}

/// Quotes a text.
pub(super) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Formats a name as a value, with quotes if necessary.
pub(super) fn named(name: &str) -> String {
    if is_plain(name) { name.to_string() } else { quoted(name) }
}

fn list(items: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", items.into_iter().collect::<Vec<_>>().join(", "))
}

/// Keyword of a base.
pub(super) fn word(base: Base) -> &'static str {
    match base {
        Base::Fixed => "fixed",
        Base::Planar => "planar",
        Base::Unicycle => "unicycle",
        Base::Floating => "floating",
    }
}

impl Plan {
    /// Makes the decisions; `None` if the URDF cannot be read with this variant.
    pub(super) fn new(urdf: &str, variant: &Variant) -> Option<Plan> {
        let options = Options { base: variant.base, lock: variant.lock.clone(), ..Options::default() };
        let (model, _) = Model::from_urdf(urdf, &options).ok()?;
        let found = limbs::limbs(&model);
        let (mut arms, tip, mut dofs) = match found {
            Ok(arms) => {
                let first = arms.first()?;
                let (tip, dofs) = (first.tip, first.dofs.clone());
                (arms, tip, dofs)
            }
            Err(limb) => (Vec::new(), limb.tip, limb.dofs),
        };
        if !variant.arms {
            arms.clear();
        }
        let mut q = model.neutral();
        home::enter(&model, &mut q);
        if arms.is_empty() {
            home::bend(&model, tip, &dofs, &mut q);
        }
        for limb in &arms {
            home::bend(&model, limb.tip, &limb.dofs, &mut q);
        }
        if dofs.is_empty() {
            // The robot has at most a base.
            dofs = (0..model.nv()).collect();
        }
        let motion = motion(&model, tip, &dofs, &q);
        let in_arms: BTreeSet<usize> = arms.iter().flat_map(|a| a.dofs.iter().copied()).collect();
        let at = |d: usize| model.dofs[d].q_index.map_or(0.0, |i| q[i]);
        let others = (0..model.nv()).filter(|d| !in_arms.contains(d) && at(*d) != 0.0).collect();
        let name = plain(&model.name, "robot");
        Some(Plan {
            name,
            model,
            variant: variant.clone(),
            arms,
            others,
            tip,
            q,
            motion,
            dofs,
            srdf: Description::default(),
        })
    }

    /// The model of the proposal.
    pub(super) fn model(&self) -> &Model {
        &self.model
    }

    /// Names an SRDF, and a posture of it as home.
    pub(super) fn describe(&mut self, source: String, home: Option<String>) {
        self.srdf = Description { source: Some(source), home, ..Description::default() };
    }

    /// Posture at home.
    pub(super) fn home(&self) -> Option<&str> {
        self.srdf.home.as_deref()
    }

    /// Takes over the home configuration of a compiled model, and moves the tip from there.
    pub(super) fn start_at(&mut self, model: &Model, home: &[f64]) {
        for d in &self.model.dofs {
            let there = model.dof(&d.name).and_then(|dof| model.dofs[dof].q_index);
            if let Some((own, there)) = d.q_index.zip(there) {
                self.q[own] = home[there];
            }
        }
        self.motion = motion(&self.model, self.tip, &self.dofs, &self.q);
    }

    /// Keeps the links apart by a limit.
    pub(super) fn keep_apart(&mut self, limit: Option<String>) {
        self.srdf.apart = limit;
    }

    /// Groups of the SRDF, for a comment.
    pub(super) fn note_groups(&mut self, groups: Vec<String>) {
        self.srdf.groups = groups;
    }

    fn link(&self, link: LinkId) -> String {
        named(&self.model.link_ref(link).name)
    }

    /// Frame that moves.
    fn frame(&self) -> String {
        self.arms.first().map_or_else(|| self.link(self.tip), |arm| arm.name.clone())
    }

    /// Text of the spec, with this path of the URDF, this one of the SRDF if the plan has one, and this folder of packages.
    pub(super) fn text(&self, urdf: &str, srdf: Option<&str>, package_path: Option<&str>) -> String {
        let mut out =
            String::from("// A first spec, proposed by `hierarq init`. Everything in it is a guess: change it.\n");
        let _ = writeln!(out, "hierarq 1\n\nrobot {} {{\n  urdf {}", self.name, quoted(urdf));
        if let Some(path) = package_path {
            let _ = writeln!(out, "  package_path {}", quoted(path));
        }
        if let Some(own) = &self.srdf.source {
            let _ = writeln!(out, "  srdf {}", quoted(srdf.unwrap_or(own)));
            if !self.srdf.groups.is_empty() {
                let _ = writeln!(out, "  // its groups: {}", self.srdf.groups.join(", "));
            }
        }
        let base = self.variant.base;
        if base == Base::Fixed && self.srdf.source.is_some() {
            out.push_str("  base fixed\n");
        }
        if base != Base::Fixed {
            let guess = if self.variant.guessed { "  // by the names of wheels and legs" } else { "" };
            let _ = writeln!(out, "  base {}{guess}", word(base));
        }
        out.push_str("  rate 100 Hz\n");
        out.push_str(DRIVES);
        if !self.variant.lock.is_empty() {
            let names = list(self.variant.lock.keys().map(|n| named(n)));
            let _ = writeln!(out, "  lock {names}  // the base moves, not its wheels");
        }
        out.push_str(&self.joints());
        if !self.arms.is_empty() {
            out.push_str("  arms {\n");
            for arm in &self.arms {
                let _ = writeln!(out, "    {} {{", arm.name);
                for (word, link) in ["shoulder", "elbow", "wrist"].iter().zip(arm.anatomy.iter().flatten()) {
                    let _ = writeln!(out, "      {word} {}", self.link(*link));
                }
                let _ = writeln!(out, "      tip {}\n    }}", self.link(arm.tip));
            }
            out.push_str("  }\n");
        }
        out.push_str(&self.limits());
        let groups = self.groups();
        if let Some(home) = &self.srdf.home {
            let _ = writeln!(out, "  home {}", named(home));
        } else if !groups.is_empty() {
            // Zeros are the default, but a list that is present is easier to edit.
            out.push_str("  home {\n");
            for (name, dofs) in groups {
                let _ = writeln!(out, "    {name} {}", self.positions(dofs));
            }
            out.push_str("  }\n");
        }
        out.push_str("}\n\n");
        out.push_str(&self.task());
        out.push_str(&self.stack());
        out.push_str("run { stack start  duration 10 s }\n");
        out
    }

    /// Groups of joints, arms first.
    fn groups(&self) -> Vec<(&str, &[usize])> {
        let mut out: Vec<(&str, &[usize])> = self.arms.iter().map(|a| (a.name.as_str(), &a.dofs[..])).collect();
        if !self.others.is_empty() {
            out.push((OTHERS, &self.others));
        }
        out
    }

    fn joints(&self) -> String {
        let line = |(name, dofs): &(&str, &[usize])| {
            format!("    {name} {}\n", list(dofs.iter().map(|&d| named(&self.model.dofs[d].name))))
        };
        let lines: String = self.groups().iter().map(line).collect();
        if lines.is_empty() { lines } else { format!("  joints {{\n{lines}  }}\n") }
    }

    /// Speed limits of a base, which a URDF does not contain.
    fn limits(&self) -> String {
        let speeds: &[(&str, &str)] = match self.variant.base {
            Base::Unicycle => &[("base_forward", "0.5 m/s"), ("base_yaw", "0.7 rad/s")],
            Base::Planar => &[("base_x", "0.5 m/s"), ("base_y", "0.5 m/s"), ("base_yaw", "0.7 rad/s")],
            Base::Fixed | Base::Floating => return String::new(),
        };
        let items: String = speeds.iter().map(|(name, v)| format!("{name} {{ velocity {v} }} ")).collect();
        format!("  limits {{ {items}}}\n")
    }

    fn positions(&self, dofs: &[usize]) -> String {
        let value = |d: &usize| self.model.dofs[*d].q_index.map_or(0.0, |i| self.q[i]);
        let unit = |d: &usize| if self.model.dofs[*d].unit == DofUnit::Metre { "m" } else { "rad" };
        let first = dofs.first().map_or("rad", unit);
        if dofs.iter().all(|d| unit(d) == first) {
            return format!("{} {first}", list(dofs.iter().map(|d| value(d).to_string())));
        }
        list(dofs.iter().map(|d| format!("{} {}", value(d), unit(d))))
    }

    fn task(&self) -> String {
        let Some([x, y, z]) = self.motion else { return String::new() };
        let frame = self.frame();
        format!(
            "// There and back in 4 s, beginning at rest.\ntask reach = frame_position({frame}) {{\n  \
             position initial(position) + [{x}, {y}, {z}] m * (1 - cos(pi*t/(2 s)))\n}}\n\n"
        )
    }

    fn stack(&self) -> String {
        let mut out = String::from("stack start {\n");
        if self.variant.base != Base::Fixed && self.model.dofs.iter().any(|d| d.joint.is_some()) {
            out.push_str("  lock [base]  // let it go once the arms do what they should\n");
        }
        let dofs = &self.model.dofs;
        let positions = dofs.iter().any(|d| d.lower.is_finite() || d.upper.is_finite());
        let speeds = dofs.iter().any(|d| d.velocity.is_finite()) || self.variant.base == Base::Unicycle;
        let speeds = speeds || self.variant.base == Base::Planar;
        let turns = dofs.iter().any(|d| d.joint.is_some() && d.unit == DofUnit::Radian);
        let mut limits = Vec::new();
        if positions {
            limits.push("joint_position_limits");
        }
        limits.push(match (speeds, turns) {
            (true, _) => "joint_velocity_limits",
            (false, true) => "joint_velocity_limits { max 1 rad/s }",
            (false, false) => "joint_velocity_limits { max 0.2 m/s }",
        });
        limits.push(match (speeds, turns) {
            (true, _) => "joint_acceleration_limits",
            (false, true) => "joint_acceleration_limits { max 10 rad/s^2 }",
            (false, false) => "joint_acceleration_limits { max 2 m/s^2 }",
        });
        let _ = writeln!(out, "  level limits hard {{ {} }}", limits.join("  "));
        if let Some(apart) = &self.srdf.apart {
            let _ = writeln!(out, "  level apart hard {{ {apart} }}");
        }
        let moving = if self.motion.is_some() { "reach".to_string() } else { format!("hold({})", self.frame()) };
        let others: Vec<&str> = self.arms.iter().skip(1).map(|a| a.name.as_str()).collect();
        let hold = if others.is_empty() { String::new() } else { format!("  hold({})", others.join(", ")) };
        let _ = writeln!(out, "  level motion {{ {moving}{hold} }}\n}}\n");
        out
    }

    /// Decisions for the user to review.
    pub(super) fn remarks(&self) -> Vec<String> {
        let mut out = Vec::new();
        let joints = self.model.dofs.iter().filter(|d| d.joint.is_some()).count();
        out.push(format!("{}: {joints} joints that move, base {}", self.model.name, word(self.variant.base)));
        for arm in &self.arms {
            out.push(format!("arm `{}`: {} joints, tip {}", arm.name, arm.dofs.len(), self.link(arm.tip)));
        }
        if self.srdf.source.is_some() {
            let home = self.srdf.home.as_ref().map_or("no posture of it as home".to_string(), |h| format!("home {h}"));
            let apart = match self.srdf.apart {
                Some(_) => "the links are kept apart",
                None => "no limit on the whole robot: too many pairs, or links that touch at home",
            };
            out.push(format!("SRDF: {} groups, {home}; {apart}", self.srdf.groups.len()));
        }
        if self.arms.is_empty() {
            out.push(format!("no chain of five joints or more; the frame that moves is {}", self.link(self.tip)));
        }
        out
    }
}

/// Displacement of the tip, along the two axes of its largest mobility.
fn motion(model: &Model, tip: LinkId, dofs: &[usize], q: &[f64]) -> Option<[f64; 3]> {
    let freedom = home::freedom(model, tip, dofs, q);
    let most = freedom.iter().fold(0.0_f64, |m, x| m.max(*x));
    let reach = home::reach(model, tip, dofs).max(most);
    if most < 1e-4 || most < 0.01 * reach {
        return None;
    }
    let size = (0.04 * reach).min(FURTHEST);
    let rounded = if size >= 0.01 { (size * 100.0).floor() / 100.0 } else { (size * 1e4).ceil() / 1e4 };
    let mut axes: BTreeMap<usize, f64> = freedom.iter().copied().enumerate().collect();
    let least = freedom.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map(|(k, _)| k);
    axes.retain(|k, f| Some(*k) != least && *f >= 0.3 * most);
    Some(std::array::from_fn(|k| if axes.contains_key(&k) { rounded } else { 0.0 }))
}

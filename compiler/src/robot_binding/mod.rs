//! Binds the robot of a spec: reads and reduces its URDF, and binds arms, points, groups and home to the model.

mod geometry;
mod home;
mod joints;
mod lookup;
mod urdf;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use dsl::tree::{Block, Robot, Value, ValueKind};
use dsl::{Diagnostic, Fix, Help, Snippet, Sources, Span, Spanned};
use names::suggest;
use robot::{Base, LinkId, Model};
use runtime::program::overshoots;
use stdlib_tasks::bound::{Arm, Geometry};
use stdlib_tasks::dimension::{RATE, TIME};

use crate::expr::constants::Constants;
use crate::forms::{block_of, check_keys, text_of};
use crate::sections::{BASES, ROBOT};

use home::Home;

pub use lookup::{joints, unknown_geometry, unknown_joint, unknown_link};

/// A robot, with everything that names can refer to on it.
#[derive(Clone, Debug)]
pub struct BoundRobot {
    /// Name.
    pub name: Spanned<String>,
    /// Path of the URDF as written.
    pub urdf: String,
    /// The model.
    pub model: Model,
    /// Control period (s).
    pub period: f64,
    /// Span of the rate.
    pub rate_span: Span,
    /// Start configuration.
    pub home: Vec<f64>,
    /// Span of `home`.
    pub home_span: Span,
    /// Maximum time between two ticks (s).
    pub deadline: f64,
    /// Gain of the low-level layer (1/s).
    pub tracking_gain: f64,
    /// Arms, in source order.
    pub arms: Vec<Arm>,
    /// Points and segments, in source order.
    pub geometries: Vec<Geometry>,
    /// Groups of geometry names, including `arms` and `arms.NAME`.
    pub groups: BTreeMap<String, Vec<String>>,
    /// Groups of joints.
    pub joint_groups: JointGroups,
    /// Arms, points, segments and groups with a wrong declaration. They were reported, so their uses are not.
    pub failed: BTreeSet<String>,
}

/// Groups of joints.
#[derive(Clone, Debug, Default)]
pub struct JointGroups {
    /// Degrees of freedom by the group's name, including `all` and `base`.
    pub members: BTreeMap<String, Vec<usize>>,
    /// Groups with a wrong declaration, as in [`BoundRobot::failed`].
    pub failed: BTreeSet<String>,
    /// Joints that the robot's `lock` removes from the model; `members` does not contain them.
    pub locked: BTreeSet<String>,
}

/// Context for reading files.
pub struct Files<'a> {
    /// Folder of the spec, the base of relative paths.
    pub folder: &'a Path,
    /// Folders in which `package://` addresses are searched, besides the usual ones.
    pub package_paths: &'a [PathBuf],
    /// Sources of the diagnostics' spans.
    pub sources: &'a mut Sources,
    /// Receives the diagnostics.
    pub diagnostics: &'a mut Vec<Diagnostic>,
}

/// Reads and binds a robot. Returns `None` if there is no valid model, with diagnostics.
pub fn bind(robot: &Robot, files: &mut Files, constants: &mut Constants) -> Option<BoundRobot> {
    check_keys(&robot.body, &ROBOT, files.diagnostics);
    let missing = |key: &str, example: Snippet| {
        Diagnostic::missing_keys([key], robot.name.span, format!("robot `{}` has no `{key}`", robot.name.value))
            .help(Help::write_for_instance(example))
    };
    let (period, rate_span) = match robot.body.get("rate") {
        Some(e) => (constants.scalar(&e.value, RATE, files.diagnostics).map(|r| 1.0 / r), e.value.span),
        None => {
            files.diagnostics.push(
                missing("rate", Snippet::entry("rate", "100 Hz"))
                    .fix(Fix::entries(robot.name.span, vec![("rate".into(), "100 Hz".into())])),
            );
            (None, robot.name.span)
        }
    };
    let period = period.filter(|p| {
        let good = p.is_finite() && (1e-5..=10.0).contains(p);
        if !good {
            let text = format!("a control rate lies between 0.1 Hz and 100 kHz, and this is {} Hz", 1.0 / p);
            files.diagnostics.push(Diagnostic::error("HQ0308", rate_span, text).help("most arms take 100 Hz to 1 kHz"));
        }
        good
    });
    let base = match robot.body.get("base") {
        None => Base::Fixed,
        Some(e) => match text_of(&e.value) {
            Some("fixed") => Base::Fixed,
            Some("planar") => Base::Planar,
            Some("unicycle") => Base::Unicycle,
            Some("floating") => Base::Floating,
            other => {
                let mut d = Diagnostic::unknown_name(e.value.span, "a base is fixed, planar, unicycle or floating");
                d = match other.and_then(|o| suggest(o, BASES.iter().copied())) {
                    Some(near) => d.meant(near),
                    None => d.help("leave `base` out for an arm that is bolted down"),
                };
                files.diagnostics.push(d);
                Base::Fixed
            }
        },
    };
    let Some(urdf) = robot.body.get("urdf") else {
        files.diagnostics.push(missing("urdf", urdf::urdf_example()));
        return None;
    };
    let Some(path_text) = text_of(&urdf.value).map(str::to_string) else {
        if !matches!(urdf.value.kind, ValueKind::Missing) {
            let d = Diagnostic::error("HQ0304", urdf.value.span, "`urdf` is the path of one file, in quotes");
            files.diagnostics.push(d.help(Help::write_for_instance(urdf::urdf_example())));
        }
        return None;
    };
    let locks = urdf::locks(&robot.body, files.diagnostics);
    let file = urdf::open((&path_text, urdf.value.span), base, robot, files)?;
    let whole = file.whole(!locks.is_empty(), files.diagnostics)?;
    let moves = |model: &Model, diagnostics: &mut Vec<Diagnostic>| {
        if model.nv() == 0 {
            let d = Diagnostic::error("HQ0402", urdf.value.span, "nothing of this robot moves");
            diagnostics.push(
                d.note("every joint of it is fixed, locked, or held in place by its own limits, and its base is fixed")
                    .help("name another URDF, lock fewer joints, or give it a `base`"),
            );
        }
        model.nv() > 0
    };
    if !moves(&whole, files.diagnostics) {
        return None;
    }
    let block = |key: &str, diagnostics: &mut Vec<Diagnostic>| {
        robot.body.get(key).and_then(|e| block_of(&e.value, &format!("`{key}`"), diagnostics))
    };
    let groups = joints::joint_groups(block("joints", files.diagnostics), &whole, files.diagnostics);
    let home_block = block("home", files.diagnostics);
    let mut home = Home::read(home_block, (&whole, &groups), constants, files.diagnostics);
    if let (None, Some(e)) = (home_block, robot.body.get("home")) {
        home.unreadable(e.value.span);
    }
    let (model, joint_groups) = if locks.is_empty() {
        (whole, groups)
    } else {
        let at = urdf::positions(&locks, (&whole, &groups), &home, constants, files.diagnostics);
        let names = at.keys().cloned().collect();
        let model = file.locked(at, files.diagnostics)?;
        if !moves(&model, files.diagnostics) {
            return None;
        }
        let groups = groups.without(names, &whole, &model);
        (model, groups)
    };
    let mut b = Binder { model, robot, constants, failed: BTreeSet::new(), diagnostics: files.diagnostics };
    b.limits(&joint_groups);
    let geometries = b.geometries();
    let arms = b.arms();
    let groups = b.groups(&geometries);
    let (home, home_span) = b.home(&home);
    let tracking_gain = match robot.body.get("tracking_gain") {
        Some(e) => b.constants.scalar(&e.value, RATE, b.diagnostics).unwrap_or(0.0),
        None => 0.0,
    };
    let span = robot.body.get("tracking_gain").map_or(robot.name.span, |e| e.value.span);
    if tracking_gain < 0.0 {
        let text = format!("a tracking gain is at least 0, and this is {tracking_gain} /s");
        b.diagnostics.push(Diagnostic::error("HQ0308", span, text).help("write a rate from 0 up to the control rate"));
    } else if let Some(p) = period.filter(|p| overshoots(tracking_gain, *p)) {
        let text = format!("this tracking gain overshoots: {tracking_gain} /s times {p} s is {:.3}", tracking_gain * p);
        b.diagnostics.push(
            Diagnostic::error("HQ0501", span, text)
                .label(rate_span, format!("a period of {p} s"))
                .note("above 1 the error changes its sign at every tick, above 2 it grows")
                .help(format!("keep it at or below {} /s, or raise the rate", 1.0 / p)),
        );
    }
    let period = period.unwrap_or(0.01);
    let deadline = match robot.body.get("deadline") {
        Some(e) => b.constants.scalar(&e.value, TIME, b.diagnostics).map(|d| (d, e.value.span)),
        None => None,
    };
    if let Some((d, at)) = deadline.filter(|d| d.0 <= period) {
        let text = format!("a deadline is longer than a period, and this is {d} s");
        b.diagnostics.push(
            Diagnostic::error("HQ0308", at, text).label(rate_span, format!("a period of {period} s")).help(Help::with(
                "write for instance {}, or leave it out for two periods",
                [Snippet::entry("deadline", format!("{} ms", 2e3 * period))],
            )),
        );
    }
    let deadline = deadline.map_or(2.0 * period, |d| d.0);
    let (model, failed) = (b.model, b.failed);
    Some(BoundRobot {
        name: robot.name.clone(),
        urdf: path_text,
        model,
        period,
        deadline,
        rate_span,
        home,
        home_span,
        tracking_gain,
        arms,
        geometries,
        groups,
        joint_groups,
        failed,
    })
}

struct Binder<'a, 'c> {
    model: Model,
    robot: &'a Robot,
    constants: &'a mut Constants<'c>,
    failed: BTreeSet<String>,
    diagnostics: &'a mut Vec<Diagnostic>,
}

impl Binder<'_, '_> {
    fn block(&mut self, key: &str) -> Option<Block> {
        let entry = self.robot.body.get(key)?;
        block_of(&entry.value, &format!("`{key}`"), self.diagnostics).cloned()
    }

    /// A block of declarations; reports and removes those whose name is a pattern.
    fn declarations(&mut self, key: &str) -> Option<Block> {
        let mut block = self.block(key)?;
        for e in block.entries.extract_if(.., |e| lookup::is_pattern(&e.key.value)) {
            self.diagnostics.push(joints::pattern_as_name(&e.key));
        }
        Some(block)
    }

    fn link(&mut self, value: &Value) -> Option<(String, LinkId)> {
        let Some(name) = text_of(value) else {
            if !matches!(value.kind, ValueKind::Missing) {
                let d = Diagnostic::error("HQ0304", value.span, "the name of a link is needed here");
                self.diagnostics.push(d.help(Help::with(
                    "write {}, such as {}",
                    [Snippet::entry("NAME", "LINK"), Snippet::entry("elbow", "link_4")],
                )));
            }
            return None;
        };
        match self.model.link(name) {
            Some(id) => Some((name.to_string(), id)),
            None => {
                self.diagnostics.push(unknown_link(&self.model, name, value.span, &[]));
                None
            }
        }
    }
}

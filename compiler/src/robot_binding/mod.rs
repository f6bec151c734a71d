//! Binds the robot of a spec: reads and reduces its URDF, and binds arms, points, groups and home to the model.

mod base_entries;
mod geometry;
mod home;
mod joints;
mod limits;
mod lookup;
mod postures;
mod shapes;
mod srdf;
mod together;
mod urdf;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use blocks::{ByName, Located, Unbound};
use dsl::tree::{Entry, Robot, Value};
use dsl::{Diagnostic, Help, Snippet, Sources, Span, Spanned};
use robot::{Base, LinkId, LinkMesh, Model, ReadUrdf};
use runtime::program::overshoots;
use stdlib_tasks::bound::{Arm, Geometry};

use crate::block_binding::Origins;
use crate::expr::constants::Constants;
use crate::forms::block_of;
use crate::sections::RobotBlock;

use home::Home;

pub(crate) use base_entries::{BaseEntry, ORIENTATION};
pub(crate) use lookup::is_pattern;
pub use lookup::{joints, unknown_geometry, unknown_joint, unknown_link};
pub use postures::Postures;
pub(crate) use srdf::RobotSrdf;
pub use together::{Stand, together};

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
    /// Lag of the drives (s).
    pub lag: f64,
    /// Dead time of the drives (s).
    pub dead_time: f64,
    /// True if the robot is stopped in one tick.
    pub stops_at_once: bool,
    /// True if it goes on by itself when it takes commands again.
    pub resumes_itself: bool,
    /// Signals that must all be true for it to take commands.
    pub enabling: BTreeSet<usize>,
    /// Arms, in source order.
    pub arms: Vec<Arm>,
    /// Points and segments, in source order.
    pub geometries: Vec<Geometry>,
    /// Groups of geometry names, including `arms` and `arms.NAME`.
    pub groups: BTreeMap<String, Vec<String>>,
    /// Groups of joints.
    pub joint_groups: JointGroups,
    /// The SRDFs of its robots, each with its text.
    pub(crate) srdf: Vec<RobotSrdf>,
    /// Meshes of its collision shapes.
    pub(crate) meshes: Vec<LinkMesh>,
    /// Its stand in the world.
    pub stand: Stand,
    /// Named postures.
    pub postures: Postures,
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
    /// Places of the values that the robot's block was read from.
    pub origins: &'a Origins,
    /// Receives the diagnostics.
    pub diagnostics: &'a mut Vec<Diagnostic>,
}

/// Binds a robot whose block was read. Returns `None` if there is no valid model, with diagnostics.
pub fn bind(robot: &Robot, block: &RobotBlock, files: &mut Files, constants: &mut Constants) -> Option<BoundRobot> {
    let base = match block.base {
        "planar" => Base::Planar,
        "unicycle" => Base::Unicycle,
        "floating" => Base::Floating,
        _ => Base::Fixed,
    };
    let path = block.urdf.as_ref()?;
    let path = Spanned::new(path.value.clone(), files.origins.span(path.at));
    let unbound = |of: &Option<Located<Unbound>>| files.origins.unbound(of.as_ref()?);
    let locks = urdf::locks(unbound(&block.lock), files.diagnostics);
    let shapes = shapes::Shapes::read(block, files.origins, files.diagnostics);
    let file = urdf::open(&path, (base, shapes.option()), block.package_path.as_deref(), files)?;
    let ReadUrdf { model: mut whole, warnings, meshes } = file.whole(!locks.is_empty(), files.diagnostics)?;
    shapes.check(&whole, files.diagnostics);
    let srdf_path = block.srdf.as_ref().map(|path| Spanned::new(path.value.clone(), files.origins.span(path.at)));
    // The whole spec would be full of names that only the SRDF has.
    let srdf = match &srdf_path {
        Some(path) => Some(srdf::open(path, &whole, files)?),
        None => None,
    };
    // Messages name the robot as the spec does.
    whole.name.clone_from(&robot.name.value);
    let moves = |model: &Model, diagnostics: &mut Vec<Diagnostic>| {
        if model.nv() == 0 {
            let d = Diagnostic::error("HQ0402", path.span, "nothing of this robot moves");
            diagnostics.push(
                d.note("every joint of it is fixed, locked, or held in place by its own limits, and its base is fixed")
                    .help("name another URDF, lock fewer joints, or give it a `base`"),
            );
        }
        model.nv() > 0
    };
    if whole.nv() == 0 {
        file.warn(&warnings, &whole, files.diagnostics);
    }
    if !moves(&whole, files.diagnostics) {
        return None;
    }
    let groups = unbound(&block.joints).and_then(|value| block_of(value, "`joints`", files.diagnostics));
    let groups = joints::joint_groups(groups, srdf.as_ref().map(|of| &of.srdf), &whole, files.diagnostics);
    let postures = srdf.as_ref().map(|of| Postures::of(of, &whole)).unwrap_or_default();
    let home = Home::read(unbound(&block.home), (&whole, &groups, &postures), constants, files.diagnostics);
    let mut at = urdf::positions(&locks, (&whole, &groups), &home, constants, files.diagnostics);
    if let Some(of) = &srdf {
        srdf::base(of, &whole, robot.body.get("base").is_some(), files.diagnostics);
        let locked = at.keys().cloned().collect();
        let passive = srdf::passive(of, &whole, &locked, files.diagnostics);
        let passive = passive.into_iter().map(|joint| (joint, None)).collect();
        at.extend(urdf::positions(&passive, (&whole, &groups), &home, constants, files.diagnostics));
    }
    let (model, warnings, meshes, joint_groups) = if at.is_empty() && locks.is_empty() {
        (whole, warnings, meshes, groups)
    } else {
        let names = at.keys().cloned().collect();
        let ReadUrdf { mut model, warnings, meshes } = file.locked(at, files.diagnostics)?;
        model.name.clone_from(&robot.name.value);
        if model.nv() == 0 {
            file.warn(&warnings, &model, files.diagnostics);
        }
        if !moves(&model, files.diagnostics) {
            return None;
        }
        let groups = groups.without(names, &whole, &model);
        (model, warnings, meshes, groups)
    };
    let origins = files.origins;
    let diagnostics = &mut *files.diagnostics;
    let mut b = Binder { model, robot, block, constants, origins, srdf, failed: BTreeSet::new(), diagnostics };
    b.limits(&joint_groups);
    file.warn(&warnings, &b.model, b.diagnostics);
    let stand = Stand::read(unbound(&block.at), b.constants, b.diagnostics);
    let geometries = b.geometries();
    let arms = b.arms();
    let groups = b.groups(&geometries);
    let (home, home_span) = b.home(&home);
    let rate = block.rate.as_ref();
    let rate_span = rate.map_or(robot.name.span, |rate| files.origins.span(rate.at));
    let period = rate.map_or(0.01, |rate| 1.0 / rate.value);
    let time = |given: &Option<Located<f64>>| given.as_ref().map_or(0.0, |time| time.value);
    let (lag, dead_time) = (time(&block.lag), time(&block.dead_time));
    // Without knowledge of the drive: a gain that is stable with a lag of a tenth of a second.
    let unknown = if lag + dead_time > 0.0 { f64::INFINITY } else { 2.0 };
    let stable = f64::min(unknown, 0.25 / (lag + dead_time + period));
    let tracking_gain = block.tracking_gain.as_ref().map_or(stable, |gain| gain.value);
    let at = block.tracking_gain.as_ref().map(|gain| gain.at);
    if let Some(at) = at.filter(|_| rate.is_some() && overshoots(tracking_gain, period)) {
        let text = format!(
            "this tracking gain overshoots: {tracking_gain} /s times {period} s is {:.3}",
            tracking_gain * period
        );
        b.diagnostics.push(
            Diagnostic::error("HQ0501", files.origins.span(at), text)
                .label(rate_span, format!("a period of {period} s"))
                .note("above 1 the error changes its sign at every tick, above 2 it grows")
                .help(format!("keep it at or below {} /s, or raise the rate", 1.0 / period)),
        );
    }
    let deadline = block.deadline.as_ref();
    if let Some(Located { at, value }) = deadline.filter(|deadline| deadline.value <= period) {
        let text = format!("a deadline is longer than a period, and this is {value} s");
        b.diagnostics.push(
            Diagnostic::error("HQ0308", files.origins.span(*at), text)
                .label(rate_span, format!("a period of {period} s"))
                .help(Help::with(
                    "write for instance {}, or leave it out for two periods or more",
                    [Snippet::entry("deadline", format!("{} ms", 2e3 * period))],
                )),
        );
    }
    let deadline = deadline.map_or_else(|| runtime::default_deadline(period), |deadline| deadline.value);
    let (model, failed, srdf) = (b.model, b.failed, b.srdf);
    Some(BoundRobot {
        name: robot.name.clone(),
        urdf: path.value,
        model,
        period,
        deadline,
        rate_span,
        home,
        home_span,
        tracking_gain,
        lag,
        dead_time,
        stops_at_once: block.stop == "now",
        resumes_itself: block.resume == "itself",
        enabling: BTreeSet::new(),
        arms,
        geometries,
        groups,
        joint_groups,
        srdf: srdf.into_iter().collect(),
        meshes,
        stand,
        postures,
        failed,
    })
}

struct Binder<'a, 'c> {
    model: Model,
    robot: &'a Robot,
    block: &'a RobotBlock,
    origins: &'a Origins,
    constants: &'a mut Constants<'c>,
    srdf: Option<RobotSrdf>,
    failed: BTreeSet<String>,
    diagnostics: &'a mut Vec<Diagnostic>,
}

impl<'a> Binder<'a, '_> {
    /// Good declarations behind a key of the robot. Those with a wrong value are marked as failed; those whose name is a
    /// pattern are reported.
    fn declarations<T>(&mut self, key: &str, good: &'a [ByName<T>]) -> Vec<&'a ByName<T>> {
        let names: BTreeSet<&str> = good.iter().map(|part| part.name.value.as_str()).collect();
        let written = self.robot.body.get(key).map_or(&[][..], |e| e.value.entries());
        for Entry { key, .. } in written {
            if lookup::is_pattern(&key.value) {
                self.diagnostics.push(joints::pattern_as_name(key));
            } else if !names.contains(key.value.as_str()) {
                self.failed.insert(key.value.clone());
            }
        }
        good.iter().filter(|part| !lookup::is_pattern(&part.name.value)).collect()
    }

    /// Returns the value of a key that is bound here.
    fn unbound(&self, of: Option<&Located<Unbound>>) -> Option<&'a Value> {
        self.origins.unbound(of?)
    }

    fn link(&mut self, name: Option<&Located<String>>) -> Option<LinkId> {
        let Located { at, value: name } = name?;
        let found = self.model.link(name);
        if found.is_none() {
            self.diagnostics.push(unknown_link(&self.model, name, self.origins.span(*at), &[]));
        }
        found
    }
}

//! The robot of a spec: its URDF read and reduced, its arms, points, groups and home bound to the model.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dsl::tree::{Block, Entry, Robot, Value, ValueKind};
use dsl::{Diagnostic, Sources, Span, Spanned};
use nalgebra::{Isometry3, Point3, Vector3};
use robot::{Base, LinkId, Model, Shape};
use stdlib_tasks::bound::{Arm, Geometry};
use stdlib_tasks::dimension::{LENGTH, RATE};

use crate::constants::Constants;
use crate::names::{list, suggest};

/// A robot with everything that names can mean on it.
#[derive(Clone, Debug)]
pub struct BoundRobot {
    /// Its name.
    pub name: Spanned<String>,
    /// The URDF's path as written.
    pub urdf: String,
    /// The model.
    pub model: Model,
    /// Control period, in s.
    pub period: f64,
    /// Where the rate was written.
    pub rate_span: Span,
    /// Start configuration.
    pub home: Vec<f64>,
    /// Where `home` was written.
    pub home_span: Span,
    /// Low-level gain, in 1/s.
    pub tracking_gain: f64,
    /// Arms, in the order declared.
    pub arms: Vec<Arm>,
    /// Points and segments, in the order declared.
    pub geometries: Vec<Geometry>,
    /// Groups of geometry names, `arms` and `arms.NAME` among them.
    pub groups: BTreeMap<String, Vec<String>>,
    /// Groups of joints.
    pub joint_groups: BTreeMap<String, Vec<usize>>,
}

/// What the compiler needs to read files.
pub struct Files<'a> {
    /// Folder of the spec; relative paths start here.
    pub folder: &'a Path,
    /// Where `package://` addresses are looked for, beside the usual places.
    pub package_paths: &'a [PathBuf],
    /// Texts that diagnostics point into.
    pub sources: &'a mut Sources,
    /// Where mistakes go.
    pub diagnostics: &'a mut Vec<Diagnostic>,
}

static KEYS: &[&str] = &[
    "urdf",
    "base",
    "rate",
    "arms",
    "points",
    "segments",
    "groups",
    "joints",
    "home",
    "lock",
    "limits",
    "tracking_gain",
    "package_path",
];

/// Reports a key that has no meaning in a block.
pub fn check_keys(block: &Block, keys: &[&str], what: &str, diagnostics: &mut Vec<Diagnostic>) {
    for (i, e) in block.entries.iter().enumerate() {
        if !keys.contains(&e.key.value.as_str()) {
            diagnostics.push(unknown_key(block, i, keys, what));
        }
    }
}

/// The diagnostic for the unknown key of entry `i`; a word behind a bare number may have been meant as its unit.
pub fn unknown_key(block: &Block, i: usize, keys: &[&str], what: &str) -> Diagnostic {
    let key = &block.entries[i].key;
    let mut d = Diagnostic::error("HQ0205", key.span, format!("{what} has no `{}`", key.value));
    let before = i.checked_sub(1).map(|k| &block.entries[k]);
    if let Some(near) = suggest(&key.value, keys.iter().copied()) {
        d = d.help(format!("did you mean `{near}`?"));
    } else if let Some(Entry { value: Value { kind: ValueKind::Number(n), span }, .. }) = before
        && key.span.start >= span.end
        && key.span.start - span.end <= 2
    {
        d = d.help(format!("if `{}` was meant as the unit of {}, the language does not know it", key.value, n.text));
    } else {
        d = d.help(format!("it may have {}", list(keys.iter().copied(), 20)));
    }
    d
}

/// The text of a value that must be text or a name.
pub fn text_of(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Text(s) | ValueKind::Name(s) => Some(s),
        _ => None,
    }
}

/// A dotted name such as `arms.left`.
pub fn path_of(value: &Value) -> Option<String> {
    match &value.kind {
        ValueKind::Name(n) | ValueKind::Text(n) => Some(n.clone()),
        ValueKind::Field(inner, field) => Some(format!("{}.{}", path_of(inner)?, field.value)),
        _ => None,
    }
}

/// A value as a list: a list's items, or the value itself.
pub fn items_of(value: &Value) -> &[Value] {
    match &value.kind {
        ValueKind::List(items) => items,
        _ => std::slice::from_ref(value),
    }
}

/// The block of a value that must be one.
pub fn block_of<'v>(value: &'v Value, what: &str, diagnostics: &mut Vec<Diagnostic>) -> Option<&'v Block> {
    match &value.kind {
        ValueKind::Block(b) => Some(b),
        ValueKind::Missing => None,
        _ => {
            diagnostics.push(
                Diagnostic::error("HQ0304", value.span, format!("{what} is written in braces"))
                    .help("write `{ name value .. }`"),
            );
            None
        }
    }
}

/// Reads and binds a robot. `None` where no model could be had; the diagnostics say why.
pub fn bind(robot: &Robot, files: &mut Files, constants: &mut Constants) -> Option<BoundRobot> {
    check_keys(&robot.body, KEYS, "a robot", files.diagnostics);
    let missing = |key: &str, example: &str| {
        Diagnostic::error("HQ0206", robot.name.span, format!("robot `{}` has no `{key}`", robot.name.value))
            .help(format!("write for instance `{example}`"))
    };
    let (period, rate_span) = match robot.body.get("rate") {
        Some(e) => (constants.scalar(&e.value, RATE, files.diagnostics).map(|r| 1.0 / r), e.value.span),
        None => {
            files.diagnostics.push(missing("rate", "rate 100 Hz"));
            (None, robot.name.span)
        }
    };
    let period = period.filter(|p| {
        let good = p.is_finite() && (1e-5..=10.0).contains(p);
        if !good {
            files.diagnostics.push(
                Diagnostic::error("HQ0308", rate_span, "a control rate lies between 0.1 Hz and 100 kHz")
                    .help("most arms take 100 Hz to 1 kHz"),
            );
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
                let words = ["fixed", "planar", "unicycle", "floating"];
                let mut d = Diagnostic::error("HQ0201", e.value.span, "a base is fixed, planar, unicycle or floating");
                if let Some(near) = other.and_then(|o| suggest(o, words)) {
                    d = d.help(format!("did you mean `{near}`?"));
                }
                files.diagnostics.push(d);
                Base::Fixed
            }
        },
    };
    let Some(urdf) = robot.body.get("urdf") else {
        files.diagnostics.push(missing("urdf", "urdf \"robots/arm7.urdf\""));
        return None;
    };
    let path_text = text_of(&urdf.value)?.to_string();
    let locks = locks(&robot.body, constants, files.diagnostics);
    let model = read(&path_text, urdf.value.span, base, &locks, robot, files)?;
    let mut b = Binder { model, robot, constants, diagnostics: files.diagnostics };
    let joint_groups = b.joint_groups();
    b.limits(&joint_groups);
    let geometries = b.geometries();
    let arms = b.arms();
    let groups = b.groups(&geometries);
    let (home, home_span) = b.home(&joint_groups, &locks);
    let tracking_gain = match robot.body.get("tracking_gain") {
        Some(e) => b.constants.scalar(&e.value, RATE, b.diagnostics).unwrap_or(0.0),
        None => 0.0,
    };
    if tracking_gain < 0.0 || period.is_some_and(|p| tracking_gain * p > 1.0) {
        let span = robot.body.get("tracking_gain").map_or(robot.name.span, |e| e.value.span);
        b.diagnostics.push(
            Diagnostic::error("HQ0501", span, "the tracking gain overshoots within one period, or is negative")
                .help("keep it between 0 and the rate"),
        );
    }
    let model = b.model;
    Some(BoundRobot {
        name: robot.name.clone(),
        urdf: path_text,
        model,
        period: period.unwrap_or(0.01),
        rate_span,
        home,
        home_span,
        tracking_gain,
        arms,
        geometries,
        groups,
        joint_groups,
    })
}

type Locks = Vec<(Spanned<String>, Option<f64>)>;

/// Joints that the spec takes out of the model: `lock [head_pan]` or `lock { head_pan 0.1 rad }`.
fn locks(body: &Block, constants: &mut Constants, diagnostics: &mut Vec<Diagnostic>) -> Locks {
    let Some(entry) = body.get("lock") else { return Vec::new() };
    match &entry.value.kind {
        ValueKind::Block(block) => {
            block.entries.iter().map(|e| (e.key.clone(), constants.joint_value(&e.value, diagnostics))).collect()
        }
        _ => items_of(&entry.value)
            .iter()
            .filter_map(|v| {
                let name = text_of(v);
                if name.is_none() && !matches!(v.kind, ValueKind::Missing) {
                    diagnostics.push(Diagnostic::error("HQ0304", v.span, "a joint's name is needed here"));
                }
                Some((Spanned::new(name?.to_string(), v.span), None))
            })
            .collect(),
    }
}

/// Reads the URDF twice where needed: once to learn the joints that patterns in `lock` mean, then reduced.
fn read(path_text: &str, span: Span, base: Base, locks: &Locks, robot: &Robot, files: &mut Files) -> Option<Model> {
    let path = files.folder.join(path_text);
    let bytes = match std::fs::read(&path) {
        Ok(b) => b,
        Err(e) => {
            let d = Diagnostic::error("HQ0401", span, format!("cannot read `{path_text}`: {}", io_reason(&e)))
                .note("paths are relative to the file that names them")
                .help(nearby(&path).unwrap_or_else(|| format!("looked for {}", path.display())));
            files.diagnostics.push(d);
            return None;
        }
    };
    let text = match String::from_utf8(bytes) {
        Ok(t) => t,
        Err(e) => {
            let at = e.utf8_error().valid_up_to();
            files.diagnostics.push(
                Diagnostic::error("HQ0402", span, format!("`{path_text}` is not UTF-8 text: byte {at} is none"))
                    .help("save the URDF as UTF-8"),
            );
            return None;
        }
    };
    let urdf_source = files.sources.add(path_text, text.clone());
    let mut package_paths: Vec<PathBuf> = files.package_paths.to_vec();
    if let Some(p) = robot.body.get("package_path").and_then(|e| text_of(&e.value)) {
        package_paths.insert(0, files.folder.join(p));
    }
    let mut options = robot::Options {
        base,
        urdf_dir: path.parent().map(Path::to_path_buf),
        package_paths,
        read_meshes: true,
        ..robot::Options::default()
    };
    let convert = |m: &robot::UrdfMessage, error: bool| {
        let place = Span::new(urdf_source, m.span.start, m.span.end);
        let code = if error { "HQ0402" } else { "HQ0403" };
        let d = if error {
            Diagnostic::error(code, place, m.text.clone())
        } else {
            Diagnostic::warning(code, place, m.text.clone())
        };
        let d = if error { d.label(span, "this robot reads it") } else { d };
        match &m.help {
            Some(h) => d.help(h.clone()),
            None => d,
        }
    };
    let first = Model::from_urdf(&text, &options);
    let full = match first {
        Ok((model, warnings)) if locks.is_empty() => {
            files.diagnostics.extend(warnings.iter().map(|m| convert(m, false)));
            return Some(model);
        }
        Ok((model, _)) => model,
        Err(errors) => {
            files.diagnostics.extend(errors.iter().map(|m| convert(m, true)));
            return None;
        }
    };
    let home = robot.body.get("home");
    for (name, value) in locks {
        let matched: Vec<&robot::Dof> =
            full.dofs.iter().filter(|d| d.joint.is_some() && glob(&name.value, &d.name)).collect();
        if matched.is_empty() {
            files.diagnostics.push(unknown_joint(&full, &name.value, name.span, &[]));
        }
        for d in matched {
            // The home configuration may say where a locked joint stands.
            let at_home = home.and_then(|h| match &h.value.kind {
                ValueKind::Block(b) => b.get(&d.name),
                _ => None,
            });
            let from_home = at_home.and_then(|e| crate::constants::plain_joint_value(&e.value));
            options.lock.insert(d.name.clone(), value.or(from_home).unwrap_or_else(|| 0.0_f64.clamp(d.lower, d.upper)));
        }
    }
    match Model::from_urdf(&text, &options) {
        Ok((model, warnings)) => {
            files.diagnostics.extend(warnings.iter().map(|m| convert(m, false)));
            Some(model)
        }
        Err(errors) => {
            files.diagnostics.extend(errors.iter().map(|m| convert(m, true)));
            None
        }
    }
}

fn io_reason(e: &std::io::Error) -> &'static str {
    match e.kind() {
        std::io::ErrorKind::NotFound => "there is no such file",
        std::io::ErrorKind::PermissionDenied => "permission denied",
        std::io::ErrorKind::IsADirectory => "it is a folder",
        _ => "the system refuses",
    }
}

/// A file of nearly this name in the same folder.
fn nearby(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_str()?.to_string();
    let mut names: Vec<String> = std::fs::read_dir(path.parent()?)
        .ok()?
        .take(1000)
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    suggest(&wanted, names.iter().map(String::as_str)).map(|n| format!("did you mean `{n}`?"))
}

/// `*` stands for any run of characters, `?` for one.
pub fn glob(pattern: &str, name: &str) -> bool {
    let (p, n): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut i, mut k, mut star) = (0, 0, None);
    while k < n.len() {
        if i < p.len() && (p[i] == '?' || (p[i] == n[k] && p[i] != '*')) {
            i += 1;
            k += 1;
        } else if i < p.len() && p[i] == '*' {
            star = Some((i, k));
            i += 1;
        } else if let Some((si, sk)) = star {
            i = si + 1;
            k = sk + 1;
            star = Some((si, sk + 1));
        } else {
            return false;
        }
    }
    p[i..].iter().all(|&c| c == '*')
}

/// The diagnostic for a joint that is not there, with the reason if it is there and does not move.
pub fn unknown_joint(model: &Model, name: &str, span: Span, groups: &[&str]) -> Diagnostic {
    if let Some(j) = model.joint(name) {
        let why = match model.joint_ref(j).drive {
            robot::Drive::Fixed => "it is fixed",
            robot::Drive::Mimic { .. } => "it mimics another joint",
            robot::Drive::Locked(_) => "the robot's `lock` holds it still",
            robot::Drive::Dof(_) => "it cannot be named here",
        };
        return Diagnostic::error("HQ0201", span, format!("joint `{name}` does not move by itself: {why}"));
    }
    let mut known: Vec<&str> = model.dofs.iter().map(|d| d.name.as_str()).collect();
    known.extend(groups);
    let d = Diagnostic::error("HQ0201", span, format!("robot `{}` has no joint `{name}`", model.name));
    match suggest(name, known.iter().copied()) {
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None => d.help(format!("it has {}", list(known, 8))),
    }
}

/// The diagnostic for a link that is not there.
pub fn unknown_link(model: &Model, name: &str, span: Span) -> Diagnostic {
    let known = model.links.iter().map(|l| l.name.as_str());
    let d = Diagnostic::error("HQ0201", span, format!("robot `{}` has no link `{name}`", model.name));
    match suggest(name, known.clone()) {
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None if model.joint(name).is_some() => d.help("this is a joint; frames are named by their links"),
        None => d.help(format!("it has {}", list(known, 8))),
    }
}

struct Binder<'a, 'c> {
    model: Model,
    robot: &'a Robot,
    constants: &'a mut Constants<'c>,
    diagnostics: &'a mut Vec<Diagnostic>,
}

impl Binder<'_, '_> {
    fn block(&mut self, key: &str) -> Option<Block> {
        let entry = self.robot.body.get(key)?;
        block_of(&entry.value, &format!("`{key}`"), self.diagnostics).cloned()
    }

    fn link(&mut self, value: &Value) -> Option<(String, LinkId)> {
        let Some(name) = text_of(value) else {
            if !matches!(value.kind, ValueKind::Missing) {
                self.diagnostics.push(Diagnostic::error("HQ0304", value.span, "the name of a link is needed here"));
            }
            return None;
        };
        match self.model.link(name) {
            Some(id) => Some((name.to_string(), id)),
            None => {
                self.diagnostics.push(unknown_link(&self.model, name, value.span));
                None
            }
        }
    }

    fn joint_groups(&mut self) -> BTreeMap<String, Vec<usize>> {
        let mut groups = BTreeMap::new();
        let nv = self.model.nv();
        if self.model.base.nv() > 0 {
            groups.insert("base".to_string(), (0..self.model.base.nv()).collect());
        }
        groups.insert("all".to_string(), (0..nv).collect());
        for e in self.block("joints").iter().flat_map(|b| &b.entries) {
            let dofs = joints(items_of(&e.value), &self.model, &groups, self.diagnostics);
            if self.model.dof(&e.key.value).is_some() || groups.contains_key(&e.key.value) {
                self.diagnostics.push(
                    Diagnostic::error(
                        "HQ0202",
                        e.key.span,
                        format!("`{}` is already the name of a joint or group", e.key.value),
                    )
                    .help("choose another name for the group"),
                );
            } else if let Some(dofs) = dofs {
                groups.insert(e.key.value.clone(), dofs);
            }
        }
        groups
    }

    fn limits(&mut self, groups: &BTreeMap<String, Vec<usize>>) {
        let Some(block) = self.block("limits") else { return };
        for e in &block.entries {
            let name = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
            let Some(dofs) = joints(std::slice::from_ref(&name), &self.model, groups, self.diagnostics) else {
                continue;
            };
            let Some(inner) = block_of(&e.value, "limits of a joint", self.diagnostics) else { continue };
            check_keys(inner, &["lower", "upper", "velocity"], "a joint's limits", self.diagnostics);
            for dof in dofs {
                let unit = crate::constants::joint_dimension(&self.model, dof);
                let speed = unit.times(RATE).unwrap_or(RATE);
                let mut get = |key: &str, dimension| {
                    inner.get(key).and_then(|x| self.constants.scalar(&x.value, dimension, self.diagnostics))
                };
                let (lower, upper, velocity) = (get("lower", unit), get("upper", unit), get("velocity", speed));
                let d = &mut self.model.dofs[dof];
                d.lower = lower.unwrap_or(d.lower);
                d.upper = upper.unwrap_or(d.upper);
                if let Some(v) = velocity.filter(|v| *v > 0.0) {
                    d.velocity = v;
                } else if velocity.is_some() {
                    let span = inner.get("velocity").map_or(e.key.span, |x| x.value.span);
                    self.diagnostics.push(
                        Diagnostic::error("HQ0308", span, "a velocity limit is more than zero")
                            .help("to keep a joint still, name it in `lock`"),
                    );
                }
                if d.lower > d.upper {
                    let text = format!(
                        "`{}` would have a lower limit of {} above its upper limit of {}",
                        d.name, d.lower, d.upper
                    );
                    self.diagnostics.push(Diagnostic::error("HQ0308", e.value.span, text).help("swap the two"));
                }
            }
        }
    }

    fn arms(&mut self) -> Vec<Arm> {
        let mut arms: Vec<Arm> = Vec::new();
        for e in self.block("arms").iter().flat_map(|b| &b.entries) {
            let Some(inner) = block_of(&e.value, "an arm", self.diagnostics) else { continue };
            check_keys(inner, &["shoulder", "elbow", "wrist", "tip", "points"], "an arm", self.diagnostics);
            let mut get = |key: &str| inner.get(key).and_then(|x| self.link(&x.value)).map(|l| l.1);
            let (shoulder, elbow, wrist, tip) = (get("shoulder"), get("elbow"), get("wrist"), get("tip"));
            match tip {
                Some(tip) => arms.push(Arm { name: e.key.value.clone(), shoulder, elbow, wrist, tip }),
                None if inner.get("tip").is_none() => self.diagnostics.push(
                    Diagnostic::error("HQ0206", e.key.span, format!("arm `{}` has no `tip`", e.key.value))
                        .help("name the link at its end, `tip left_tool`"),
                ),
                None => {}
            }
        }
        arms
    }

    fn geometries(&mut self) -> Vec<Geometry> {
        let mut all: Vec<Geometry> = Vec::new();
        for e in self.block("points").iter().flat_map(|b| &b.entries) {
            let found = match &e.value.kind {
                ValueKind::Block(inner) => {
                    check_keys(inner, &["link", "offset"], "a point", self.diagnostics);
                    let offset = match inner.get("offset") {
                        Some(x) => self.constants.vector(&x.value, LENGTH, self.diagnostics),
                        None => Some([0.0; 3]),
                    };
                    self.required_link(inner, e.key.span).zip(offset)
                }
                _ => self.link(&e.value).map(|l| (l.1, [0.0; 3])),
            };
            if let Some((link, offset)) = found {
                all.push(Geometry::point(e.key.value.clone(), link, Vector3::from(offset)));
            }
        }
        for e in self.block("segments").iter().flat_map(|b| &b.entries) {
            let Some(inner) = block_of(&e.value, "a segment", self.diagnostics) else { continue };
            check_keys(inner, &["link", "from", "to"], "a segment", self.diagnostics);
            let mut end = |key: &str| match inner.get(key) {
                Some(x) => self.constants.vector(&x.value, LENGTH, self.diagnostics),
                None => {
                    self.diagnostics.push(
                        Diagnostic::error("HQ0206", e.key.span, format!("this segment has no `{key}`"))
                            .help("write `{ link NAME  from [x, y, z] m  to [x, y, z] m }`"),
                    );
                    None
                }
            };
            let (from, to) = (end("from"), end("to"));
            let link = self.required_link(inner, e.key.span);
            if let (Some(link), Some(from), Some(to)) = (link, from, to) {
                all.push(segment(&e.key.value, link, from, to));
            }
        }
        for (i, g) in all.iter().enumerate() {
            if all[..i].iter().any(|o| o.name == g.name) {
                let span = self.robot.body.get("segments").map_or(self.robot.name.span, |e| e.value.span);
                self.diagnostics.push(Diagnostic::error(
                    "HQ0202",
                    span,
                    format!("`{}` names a point and a segment", g.name),
                ));
            }
        }
        all
    }

    fn required_link(&mut self, block: &Block, key: Span) -> Option<LinkId> {
        match block.get("link") {
            Some(x) => self.link(&x.value).map(|l| l.1),
            None => {
                self.diagnostics
                    .push(Diagnostic::error("HQ0206", key, "this has no `link`").help("name the link that carries it"));
                None
            }
        }
    }

    fn groups(&mut self, geometries: &[Geometry]) -> BTreeMap<String, Vec<String>> {
        let mut groups: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for e in self.block("arms").iter().flat_map(|b| &b.entries) {
            let ValueKind::Block(inner) = &e.value.kind else { continue };
            if let Some(points) = inner.get("points") {
                let names = self.group(&points.value, geometries, &groups);
                groups.entry("arms".to_string()).or_default().extend(names.clone());
                groups.insert(format!("arms.{}", e.key.value), names);
            }
        }
        for e in self.block("groups").iter().flat_map(|b| &b.entries) {
            let names = self.group(&e.value, geometries, &groups);
            if groups.insert(e.key.value.clone(), names).is_some() {
                self.diagnostics.push(Diagnostic::error(
                    "HQ0202",
                    e.key.span,
                    format!("there is already a group `{}`", e.key.value),
                ));
            }
        }
        groups
    }

    fn group(&mut self, value: &Value, geometries: &[Geometry], groups: &BTreeMap<String, Vec<String>>) -> Vec<String> {
        let mut names = Vec::new();
        for item in items_of(value) {
            let Some(path) = path_of(item) else {
                self.diagnostics.push(Diagnostic::error(
                    "HQ0304",
                    item.span,
                    "the name of a point, segment, link or group is needed here",
                ));
                continue;
            };
            if let Some(members) = groups.get(&path) {
                names.extend(members.iter().cloned());
            } else if geometries.iter().any(|g| g.name == path) || self.model.link(&path).is_some() {
                names.push(path);
            } else {
                self.diagnostics.push(unknown_geometry(&self.model, geometries, groups, &path, item.span));
            }
        }
        names
    }

    fn home(&mut self, groups: &BTreeMap<String, Vec<usize>>, locks: &Locks) -> (Vec<f64>, Span) {
        let mut q = self.model.neutral();
        let Some(entry) = self.robot.body.get("home") else { return (q, self.robot.name.span) };
        let Some(block) = self.block("home") else { return (q, entry.value.span) };
        let base_names: &[&str] = match self.model.base {
            Base::Fixed => &[],
            Base::Planar | Base::Unicycle => &["base_x", "base_y", "base_yaw"],
            Base::Floating => &["base_x", "base_y", "base_z"],
        };
        let mut given: BTreeMap<usize, Span> = BTreeMap::new();
        for e in &block.entries {
            if let Some(i) = base_names.iter().position(|n| *n == e.key.value) {
                let dimension = if e.key.value == "base_yaw" { stdlib_tasks::dimension::ANGLE } else { LENGTH };
                if let Some(x) = self.constants.scalar(&e.value, dimension, self.diagnostics) {
                    q[i] = x;
                }
                continue;
            }
            if locks.iter().any(|(n, _)| glob(&n.value, &e.key.value)) {
                continue;
            }
            let name = Value { kind: ValueKind::Text(e.key.value.clone()), span: e.key.span };
            let Some(dofs) = joints(std::slice::from_ref(&name), &self.model, groups, self.diagnostics) else {
                continue;
            };
            let Some(values) = self.constants.per_joint(&e.value, &dofs, &self.model, self.diagnostics) else {
                continue;
            };
            for (dof, x) in dofs.iter().zip(values) {
                let d = &self.model.dofs[*dof];
                let Some(i) = d.q_index else { continue };
                if let Some(first) = given.insert(i, e.key.span) {
                    self.diagnostics.push(
                        Diagnostic::error("HQ0207", e.key.span, format!("joint `{}` is given twice", d.name))
                            .label(first, "first here"),
                    );
                }
                if x < d.lower || x > d.upper {
                    self.diagnostics.push(
                        Diagnostic::error(
                            "HQ0404",
                            e.value.span,
                            format!("`{}` starts at {x}, outside its limits of {} to {}", d.name, d.lower, d.upper),
                        )
                        .note("values are in rad or m")
                        .help("move the joint inside its limits"),
                    );
                }
                q[i] = x;
            }
        }
        (q, entry.value.span)
    }
}

/// A segment between two points of a link, as a capsule without radius (a point where both ends are one).
fn segment(name: &str, link: LinkId, from: [f64; 3], to: [f64; 3]) -> Geometry {
    let (a, b) = (Point3::from(from), Point3::from(to));
    let along = b - a;
    let length = along.norm();
    if length < 1e-9 {
        return Geometry::point(name, link, a.coords);
    }
    let rotation = nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), &along)
        .unwrap_or_else(|| nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let center = a + along * 0.5;
    let origin = Isometry3::from_parts(center.coords.into(), rotation);
    Geometry { name: name.to_string(), link, origin, shape: Shape::Capsule { radius: 0.0, half_length: length / 2.0 } }
}

/// The diagnostic for a point, segment, link or group that is not there.
pub fn unknown_geometry(
    model: &Model,
    geometries: &[Geometry],
    groups: &BTreeMap<String, Vec<String>>,
    name: &str,
    span: Span,
) -> Diagnostic {
    let mut known: Vec<&str> = geometries.iter().map(|g| g.name.as_str()).collect();
    known.extend(groups.keys().map(String::as_str));
    let links: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
    let d = Diagnostic::error("HQ0201", span, format!("there is no point, segment, group or link `{name}`"));
    match suggest(name, known.iter().chain(&links).copied()) {
        Some(near) => d.help(format!("did you mean `{near}`?")),
        None if !known.is_empty() => d.help(format!("declared are {}", list(known, 10))),
        None => d.help("declare it in the robot: `points { left_elbow arm_left_4_link }`"),
    }
}

/// Degrees of freedom that names, groups and patterns mean, in the order written.
pub fn joints(
    items: &[Value],
    model: &Model,
    groups: &BTreeMap<String, Vec<usize>>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<usize>> {
    let mut dofs: Vec<usize> = Vec::new();
    let mut good = true;
    for item in items {
        let Some(name) = text_of(item) else {
            if !matches!(item.kind, ValueKind::Missing) {
                diagnostics.push(Diagnostic::error("HQ0304", item.span, "the name of a joint or group is needed here"));
            }
            good = false;
            continue;
        };
        let found: Vec<usize> = if let Some(d) = model.dof(name) {
            vec![d]
        } else if let Some(g) = groups.get(name) {
            g.clone()
        } else {
            (0..model.nv()).filter(|&i| name.contains(['*', '?']) && glob(name, &model.dofs[i].name)).collect()
        };
        if found.is_empty() {
            let names: Vec<&str> = groups.keys().map(String::as_str).collect();
            diagnostics.push(unknown_joint(model, name, item.span, &names));
            good = false;
        }
        dofs.extend(found.into_iter().filter(|d| !dofs.contains(d)).collect::<Vec<_>>());
    }
    good.then_some(dofs)
}

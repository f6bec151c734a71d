//! Finds arms in a tree of joints: unbranched chains of at least five joints, with their tips and their anatomy.

use std::collections::BTreeMap;

use robot::{Base, Data, Drive, JointId, JointKind, LinkId, Model};

use super::names::{is_plain, plain, words};

/// Minimum number of joints of an arm.
const JOINTS: usize = 5;

/// Minimum distance of shoulder, elbow and wrist \[m\]; closer links are not distinct points.
const APART: f64 = 0.02;

/// Words in the names of tip links, in order of preference.
static TIPS: &[&str] =
    &["tcp", "tool", "tip", "ee", "eef", "effector", "grasp", "grasping", "gripper", "hand", "palm", "flange", "foot"];

/// Words in the names of gripper joints, which do not belong to the arm.
static GRIPPERS: &[&str] = &["gripper", "finger", "jaw", "thumb", "hand", "grip"];

/// Words in the names of leg joints.
static LEGS: &[&str] = &["leg", "hip", "knee", "ankle", "foot", "thigh", "calf", "haa", "hfe", "kfe"];

/// An arm or a similar limb.
#[derive(Clone, Debug)]
pub(super) struct Limb {
    /// Name in the spec.
    pub(super) name: String,
    /// Degrees of freedom, from the root outwards.
    pub(super) dofs: Vec<usize>,
    /// Link at the end.
    pub(super) tip: LinkId,
    /// Links at shoulder, elbow and wrist, if these are distinct points.
    pub(super) anatomy: Option<[LinkId; 3]>,
}

/// Guesses the base from the names of wheels, and the wheels to be locked, because the base represents them.
pub(super) fn carried(model: &Model) -> (Base, BTreeMap<String, f64>) {
    let has = |name: &str, list: &[&str]| words(name).iter().any(|w| list.contains(&w.as_str()));
    let wheel = |j: &&robot::Joint| {
        j.kind == JointKind::Continuous && matches!(j.drive, Drive::Dof(_)) && has(&j.name, &["wheel", "caster"])
    };
    let wheels: Vec<&robot::Joint> = model.joints.iter().filter(wheel).collect();
    let driven = wheels.iter().filter(|j| !has(&j.name, &["caster"])).count();
    if driven >= 2 {
        let base = if driven == 2 { Base::Unicycle } else { Base::Planar };
        return (base, wheels.iter().map(|j| (j.name.clone(), 0.0)).collect());
    }
    let legs = model.dofs.iter().filter(|d| has(&d.name, LEGS)).count();
    (if legs >= 4 { Base::Floating } else { Base::Fixed }, BTreeMap::new())
}

/// Links with their child joints.
struct Tree<'m> {
    model: &'m Model,
    /// Child joints of each link.
    below: Vec<Vec<JointId>>,
}

/// An unbranched chain of joints.
struct Run {
    dofs: Vec<usize>,
    /// Parent link of the first joint.
    start: LinkId,
    /// Child link of the last joint.
    end: LinkId,
}

impl Tree<'_> {
    fn new(model: &Model) -> Tree<'_> {
        let mut below = vec![Vec::new(); model.links.len()];
        for (k, joint) in model.joints.iter().enumerate() {
            below[joint.parent.index()].push(JointId(k as u32));
        }
        Tree { model, below }
    }

    fn moves(&self, joint: JointId) -> bool {
        matches!(self.model.joint_ref(joint).drive, Drive::Dof(_) | Drive::Mimic { .. })
    }

    /// Links rigidly connected to `link`, starting with `link` itself, and the moving joints on them.
    fn rigid(&self, link: LinkId) -> (Vec<LinkId>, Vec<JointId>) {
        let (mut links, mut heads) = (vec![link], Vec::new());
        let mut next = 0;
        while let Some(&l) = links.get(next) {
            next += 1;
            for &j in &self.below[l.index()] {
                if self.moves(j) {
                    heads.push(j);
                } else {
                    links.push(self.model.joint_ref(j).child);
                }
            }
        }
        (links, heads)
    }

    /// All chains of the tree, in model order.
    fn runs(&self) -> Vec<Run> {
        let mut runs = Vec::new();
        let mut starts = self.rigid(self.model.root()).1;
        starts.reverse();
        while let Some(start) = starts.pop() {
            let root = self.model.joint_ref(start).parent;
            let mut run = Run { dofs: Vec::new(), start: root, end: root };
            let mut joint = start;
            loop {
                let j = self.model.joint_ref(joint);
                if let Drive::Dof(dof) = j.drive {
                    run.dofs.push(dof);
                }
                run.end = j.child;
                let heads = self.rigid(j.child).1;
                match heads.as_slice() {
                    [only] => joint = *only,
                    _ => {
                        starts.extend(heads.into_iter().rev());
                        break;
                    }
                }
            }
            runs.push(run);
        }
        runs
    }

    /// True if `link` is `below`, or a descendant of it.
    fn carries(&self, below: LinkId, link: LinkId) -> bool {
        std::iter::successors(Some(link), |l| self.model.parent(*l)).any(|l| l == below)
    }

    /// Path from the root with the largest number of degrees of freedom.
    fn longest(&self) -> Run {
        let mut best = Run { dofs: Vec::new(), start: self.model.root(), end: self.model.root() };
        let mut paths: Vec<Vec<usize>> = vec![Vec::new(); self.model.links.len()];
        // Parents precede their children.
        for joint in &self.model.joints {
            let mut path = paths[joint.parent.index()].clone();
            if let Drive::Dof(dof) = joint.drive {
                path.push(dof);
            }
            if path.len() > best.dofs.len() {
                best = Run { dofs: path.clone(), start: best.start, end: joint.child };
            }
            paths[joint.child.index()] = path;
        }
        best
    }

    /// Tip among the links rigidly connected to `end`.
    fn tip(&self, end: LinkId) -> LinkId {
        let rank = |link: &LinkId| {
            let words = words(&self.model.link_ref(*link).name);
            let has = |wanted: &str| words.iter().any(|w| w == wanted);
            // The tip of a finger is not the tip of the arm.
            if has("finger") { TIPS.len() } else { TIPS.iter().position(|t| has(t)).unwrap_or(TIPS.len()) }
        };
        self.rigid(end).0.into_iter().min_by_key(rank).unwrap_or(end)
    }
}

/// Arms of a robot; as an error the longest chain, if there are none.
pub(super) fn limbs(model: &Model) -> Result<Vec<Limb>, Limb> {
    let tree = Tree::new(model);
    let long: Vec<Run> = tree.runs().into_iter().filter(|r| r.dofs.len() >= JOINTS).collect();
    let on = |a: &Run, b: &Run| tree.carries(b.end, a.start);
    // A chain that carries a longer one is a trunk. A chain on one of the others is a finger, however long.
    let trunk = |run: &Run| long.iter().any(|r| on(r, run) && r.dofs.len() > run.dofs.len());
    let finger = |run: &Run| long.iter().any(|r| on(run, r) && !trunk(r));
    let keep: Vec<bool> = long.iter().map(|run| !trunk(run) && !finger(run)).collect();
    let mut runs: Vec<Run> = long.into_iter().zip(keep).filter(|(_, keep)| *keep).map(|(run, _)| run).collect();
    if runs.is_empty() {
        runs.push(tree.longest());
    }
    let mut limbs: Vec<Limb> = runs
        .into_iter()
        .map(|mut run| {
            trim(model, &mut run);
            let anatomy = anatomy(model, &run.dofs);
            Limb { name: String::new(), tip: tree.tip(run.end), dofs: run.dofs, anatomy }
        })
        .collect();
    // Arms before legs: the demo motion uses the first limb, and it has the first choice of a name.
    limbs.sort_by_key(|limb| is_leg(model, limb));
    name(model, &mut limbs);
    if limbs.len() == 1 && limbs[0].dofs.len() < JOINTS { Err(limbs.remove(0)) } else { Ok(limbs) }
}

/// Removes gripper joints from the end of an arm.
fn trim(model: &Model, run: &mut Run) {
    while run.dofs.len() > JOINTS {
        let Some(&last) = run.dofs.last() else { return };
        let Some(joint) = model.dofs[last].joint else { return };
        let opens = words(&model.dofs[last].name).iter().any(|w| GRIPPERS.contains(&w.as_str()));
        if !opens {
            return;
        }
        run.dofs.pop();
        run.end = model.joint_ref(joint).parent;
    }
}

/// Link that a degree of freedom moves.
fn moved(model: &Model, dof: usize) -> Option<LinkId> {
    model.dofs[dof].joint.map(|j| model.joint_ref(j).child)
}

/// Shoulder: second joint. Wrist: last but one. Elbow: the joint between them that is farthest from both.
fn anatomy(model: &Model, dofs: &[usize]) -> Option<[LinkId; 3]> {
    let n = dofs.len();
    if n < JOINTS {
        return None;
    }
    let data = Data::new(model);
    let (shoulder, wrist) = (moved(model, dofs[1])?, moved(model, dofs[n - 2])?);
    let (first, last) = (data.position(shoulder), data.position(wrist));
    let nearer = |l: LinkId| (data.position(l) - first).norm().min((data.position(l) - last).norm());
    let between: Option<Vec<LinkId>> = dofs[2..n - 2].iter().map(|&d| moved(model, d)).collect();
    let mut elbow: Option<LinkId> = None;
    for link in between? {
        // Of two joints at the same point, the second follows more joints.
        if elbow.is_none_or(|e| nearer(link) > nearer(e) - 1e-9) {
            elbow = Some(link);
        }
    }
    elbow.filter(|&e| nearer(e) > APART && (first - last).norm() > APART).map(|e| [shoulder, e, wrist])
}

/// Names limbs by the words that their joints have in common, and that do not occur in all limbs.
fn name(model: &Model, limbs: &mut [Limb]) {
    let shared: Vec<Vec<String>> = limbs
        .iter()
        .map(|limb| {
            let mut all = limb.dofs.iter().map(|&d| words(&model.dofs[d].name));
            let mut common = all.next().unwrap_or_default();
            for other in all {
                common.retain(|w| other.contains(w));
            }
            common
        })
        .collect();
    let everywhere = |w: &String| shared.iter().all(|s| s.contains(w));
    let mut taken: Vec<String> = vec!["all".to_string(), "base".to_string(), "arms".to_string()];
    for (limb, words) in limbs.iter_mut().zip(&shared) {
        let mut own: Vec<&str> = words.iter().filter(|w| !everywhere(w) && *w != "joint").map(String::as_str).collect();
        if is_leg(model, limb) && !own.iter().any(|w| w.ends_with("leg")) {
            own.push("leg");
        }
        let first = if own.is_empty() { "arm".to_string() } else { plain(&own.join("_"), "arm") };
        let free = |n: &str| {
            is_plain(n) && model.dof(n).is_none() && model.link(n).is_none() && !taken.contains(&n.to_string())
        };
        let numbered = (2..).map(|i| format!("{first}_{i}"));
        let name = std::iter::once(first.clone()).chain(numbered).find(|n| free(n)).unwrap_or(first);
        taken.push(name.clone());
        limb.name = name;
    }
}

/// True if the names of the limb's joints indicate a leg.
fn is_leg(model: &Model, limb: &Limb) -> bool {
    limb.dofs.iter().any(|&d| words(&model.dofs[d].name).iter().any(|w| LEGS.contains(&w.as_str())))
}

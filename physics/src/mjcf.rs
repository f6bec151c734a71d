//! The model of MuJoCo for the robot of a program: the tree of its links with masses and joints, a drive for each degree of
//! freedom, a payload, and what is around it.
//!
//! Frames are those of the robot: the frame of a body is that of its link, with its joint at zero, and a joint turns about
//! its axis through the origin of that frame. Links touch what is in the room, and each other only if the plant says so: the
//! shapes for distances are larger than the links, and overlap where links meet. Bodies that overlap at home never touch.

use std::fmt::Write;

use nalgebra::{Isometry3, Matrix3, Vector3};
use robot::{Data, Drive, JointKind, Link, LinkId, Model, PlacedShape};
use runtime::program::{Actuators, Gravity, PlantProgram, Program};

use crate::geometry::{Geometries, Group, placed};
use crate::overlaps::{self, Overlap};
use crate::room::Room;

/// Smallest effective inertia of a joint \[kg m² or kg\]: that of a drive.
const LEAST_INERTIA: f64 = 1e-3;

/// Radius of gyration of a link whose inertia the URDF does not give \[m\].
const GYRATION: f64 = 0.02;

/// A model in MuJoCo's XML, with the order of its joints and drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Mjcf {
    /// The text.
    pub xml: String,
    /// For each joint position of the model, its source.
    pub joints: Vec<JointSource>,
    /// For each drive, the degree of freedom that it moves.
    pub drives: Vec<usize>,
    /// Time step \[s\].
    pub step: f64,
    /// Steps in a period of the controller.
    pub steps: usize,
}

/// Source of a joint position of the model: `multiplier * q + offset` of a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSource {
    /// Index in [`Model::dofs`].
    pub dof: usize,
    /// Factor; 1 for a joint that is no follower.
    pub multiplier: f64,
    /// Position with the leader at zero \[rad or m\].
    pub offset: f64,
    /// True for a joint that is no follower.
    pub own: bool,
}

/// Writes the model for a program whose run has a plant, in a room.
pub fn write(program: &Program, room: &Room, plant: &PlantProgram) -> Mjcf {
    let model = &program.robot.model;
    let steps = (program.robot.period / plant.step).round().max(1.0);
    let step = program.robot.period / steps;
    let (mut bodies, mut meshes) = (String::new(), String::new());
    room.write_standing(None, &mut bodies, &mut meshes);
    room.write_moving(&mut bodies, &mut meshes);
    let children = children(model);
    let mut writer = Writer { model, plant, room, children, joints: Vec::new(), xml: bodies, meshes };
    let roots = [LinkId(0)].into_iter().filter(|root| model.base_at(*root).is_none());
    // MuJoCo places bodies from outside only if nothing carries them.
    roots.chain(model.bases.iter().map(|base| base.link)).for_each(|root| writer.link(root));
    let (bodies, meshes) = (std::mem::take(&mut writer.xml), std::mem::take(&mut writer.meshes));
    let gravity = if plant.gravity == Gravity::None { "0 0 0" } else { "0 0 -9.81" };
    let _ = write!(
        writer.xml,
        "<mujoco model=\"robot\">\n<compiler angle=\"radian\" inertiafromgeom=\"false\" balanceinertia=\"true\" boundmass=\"1e-3\" \
         boundinertia=\"1e-6\"/>\n<option timestep=\"{step}\" integrator=\"implicitfast\" gravity=\"{gravity}\"/>\n"
    );
    if !meshes.is_empty() {
        let _ = write!(writer.xml, "<asset>\n{meshes}</asset>\n");
    }
    let _ = write!(writer.xml, "<worldbody>\n{bodies}</worldbody>\n");
    writer.never_touching(&program.robot.home);
    let drives = writer.actuators(&program.robot.home);
    writer.followers();
    writer.xml += "</mujoco>\n";
    Mjcf { xml: writer.xml, joints: writer.joints, drives, step, steps: steps as usize }
}

/// Links that each link carries, in their order.
fn children(model: &Model) -> Vec<Vec<usize>> {
    let mut children = vec![Vec::new(); model.links.len()];
    for (k, joint) in model.joints.iter().enumerate() {
        children[joint.parent.index()].push(k);
    }
    children
}

struct Writer<'p> {
    model: &'p Model,
    plant: &'p PlantProgram,
    room: &'p Room,
    children: Vec<Vec<usize>>,
    joints: Vec<JointSource>,
    xml: String,
    /// Elements `mesh`.
    meshes: String,
}

impl Writer<'_> {
    /// Writes the pairs of bodies that overlap at home, and so never touch.
    fn never_touching(&mut self, home: &[f64]) {
        let link = |link: LinkId| format!("link {}", escaped(&self.model.link_ref(link).name));
        let mut pairs = String::new();
        if self.plant.self_contact {
            for [a, b] in overlaps::of_links(self.model, home) {
                let _ = writeln!(pairs, "<exclude body1=\"{}\" body2=\"{}\"/>", link(a), link(b));
            }
        }
        for Overlap { obstacle: k, link: with } in overlaps::of_obstacles(self.model, home, self.room) {
            let _ = writeln!(pairs, "<exclude body1=\"obstacle {k}\" body2=\"{}\"/>", link(with));
        }
        if !pairs.is_empty() {
            let _ = write!(self.xml, "<contact>\n{pairs}</contact>\n");
        }
    }

    /// Writes the body of a link, with all that it carries.
    fn link(&mut self, link: LinkId) {
        let model = self.model;
        let of = model.link_ref(link);
        let name = escaped(&of.name);
        match (model.base_at(link), of.parent_joint) {
            // A base moves as it is commanded: a mocap body, which is placed from outside.
            (Some(base), _) => {
                let pose = placed(&model.place(base));
                let _ = writeln!(self.xml, "<body name=\"link {name}\" {pose} mocap=\"true\">");
            }
            (None, None) => {
                let _ = writeln!(self.xml, "<body name=\"link {name}\" {}>", placed(&Isometry3::identity()));
            }
            (None, Some(joint)) => {
                let joint = model.joint_ref(joint);
                let held = match joint.drive {
                    Drive::Locked(position) => motion(joint.kind, &joint.axis, position),
                    _ => Isometry3::identity(),
                };
                let compensated = if self.plant.gravity == Gravity::Compensated { " gravcomp=\"1\"" } else { "" };
                let _ =
                    writeln!(self.xml, "<body name=\"link {name}\" {}{compensated}>", placed(&(joint.origin * held)));
                self.joint(joint);
                self.inertial(of);
            }
        }
        let mut geometries = Geometries::default();
        for PlacedShape { origin, shape } in &of.collision {
            let group = Group::Links { each_other: self.plant.self_contact };
            geometries.shape(&format!("link{}", link.index()), origin, shape, group);
        }
        self.xml += &geometries.geoms;
        self.meshes += &geometries.meshes;
        self.room.write_standing(Some(link), &mut self.xml, &mut self.meshes);
        if let Some(payload) = self.plant.payload.as_ref().filter(|p| p.link == link) {
            let [x, y, z] = payload.at;
            let inertia = payload.mass * GYRATION * GYRATION;
            let _ = writeln!(
                self.xml,
                "<body name=\"payload\" pos=\"{x} {y} {z}\"><inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"{inertia} {inertia} \
                 {inertia}\"/></body>",
                payload.mass
            );
        }
        for k in self.children[link.index()].clone() {
            let child = model.joints[k].child;
            if model.base_at(child).is_none() {
                self.link(child);
            }
        }
        self.xml += "</body>\n";
    }

    fn joint(&mut self, joint: &robot::Joint) {
        let source = match joint.drive {
            Drive::Dof(dof) => JointSource { dof, multiplier: 1.0, offset: 0.0, own: true },
            Drive::Mimic { dof, multiplier, offset } => JointSource { dof, multiplier, offset, own: false },
            Drive::Fixed | Drive::Locked(_) => return,
        };
        let kind = if joint.kind == JointKind::Prismatic { "slide" } else { "hinge" };
        let [x, y, z]: [f64; 3] = joint.axis.into();
        let limits = match joint.lower.is_finite() && joint.upper.is_finite() && joint.kind != JointKind::Continuous {
            true => format!(" limited=\"true\" range=\"{} {}\"", joint.lower, joint.upper),
            false => String::new(),
        };
        let _ = writeln!(
            self.xml,
            "<joint name=\"{}\" type=\"{kind}\" axis=\"{x} {y} {z}\"{limits} frictionloss=\"{}\"/>",
            escaped(&joint.name),
            self.plant.friction
        );
        self.joints.push(source);
    }

    fn inertial(&mut self, link: &Link) {
        if link.mass <= 0.0 {
            return;
        }
        let [x, y, z]: [f64; 3] = link.center_of_mass.into();
        let [xx, yy, zz, xy, xz, yz] = inertia(link);
        let _ = writeln!(
            self.xml,
            "<inertial pos=\"{x} {y} {z}\" mass=\"{}\" fullinertia=\"{xx} {yy} {zz} {xy} {xz} {yz}\"/>",
            link.mass
        );
    }

    /// Writes a drive for each degree of freedom of a joint, with gains that give it the time constant of the plant at home.
    /// Returns their degrees of freedom.
    fn actuators(&mut self, home: &[f64]) -> Vec<usize> {
        let model = self.model;
        let inertias = effective_inertias(model, home, self.plant);
        let mut drives = Vec::new();
        self.xml += "<actuator>\n";
        for (dof, d) in model.dofs.iter().enumerate() {
            let Some(joint) = d.joint.map(|j| model.joint_ref(j)) else { continue };
            let (m, t) = (inertias[dof], self.plant.response);
            let gains = match self.plant.actuators {
                Actuators::Velocity => format!("<velocity kv=\"{}\"", m / t),
                // Critically damped.
                Actuators::Position => format!("<position kp=\"{}\" kv=\"{}\"", m / (t * t), 2.0 * m / t),
            };
            let force = match joint.effort.is_finite() && joint.effort > 0.0 {
                true => format!(" forcelimited=\"true\" forcerange=\"{} {}\"", -joint.effort, joint.effort),
                false => String::new(),
            };
            let _ = writeln!(self.xml, "{gains} joint=\"{}\"{force}/>", escaped(&joint.name));
            drives.push(dof);
        }
        self.xml += "</actuator>\n";
        drives
    }

    /// Couples followers to their leaders.
    fn followers(&mut self) {
        let model = self.model;
        let mut couplings = String::new();
        for joint in &model.joints {
            let Drive::Mimic { dof, multiplier, offset } = joint.drive else { continue };
            let Some(leader) = model.dofs[dof].joint.map(|j| model.joint_ref(j)) else { continue };
            let _ = writeln!(
                couplings,
                "<joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{offset} {multiplier} 0 0 0\"/>",
                escaped(&joint.name),
                escaped(&leader.name)
            );
        }
        if !couplings.is_empty() {
            let _ = write!(self.xml, "<equality>\n{couplings}</equality>\n");
        }
    }
}

/// Inertia of a link about its centre of mass: that of the URDF, or that of a small ball.
fn inertia(link: &Link) -> [f64; 6] {
    let [xx, yy, zz, ..] = link.inertia;
    if xx > 0.0 && yy > 0.0 && zz > 0.0 {
        return link.inertia;
    }
    let ball = link.mass * GYRATION * GYRATION;
    [ball, ball, ball, 0.0, 0.0, 0.0]
}

/// Inertia that the drive of each degree of freedom moves in a posture: the diagonal of the joint-space inertia \[kg m² or kg\]; zero for
/// those of the base.
pub fn effective_inertias(model: &Model, q: &[f64], plant: &PlantProgram) -> Vec<f64> {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let mut inertias = vec![0.0; model.nv()];
    let moved = |link: LinkId, dof: usize| model.support(link).iter().any(|s| s.dof as usize == dof);
    for (dof, d) in model.dofs.iter().enumerate() {
        let Some(joint) = d.joint.map(|j| model.joint_ref(j)) else { continue };
        let frame = data.pose(joint.child);
        let axis = frame.rotation * joint.axis;
        let mut sum = 0.0;
        for (k, link) in model.links.iter().enumerate().filter(|(k, _)| moved(LinkId(*k as u32), dof)) {
            let pose = data.pose(LinkId(k as u32));
            let mut add = |mass: f64, center: Vector3<f64>, own: [f64; 6]| {
                if joint.kind == JointKind::Prismatic {
                    sum += mass;
                    return;
                }
                let arm = axis.cross(&((pose * nalgebra::Point3::from(center)).coords - frame.translation.vector));
                let [xx, yy, zz, xy, xz, yz] = own;
                let turned = pose.rotation.inverse() * axis;
                sum += mass * arm.norm_squared()
                    + turned.dot(&(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * turned));
            };
            add(link.mass, link.center_of_mass, if link.mass > 0.0 { inertia(link) } else { [0.0; 6] });
            if let Some(payload) = plant.payload.as_ref().filter(|p| p.link.index() == k) {
                add(payload.mass, Vector3::from(payload.at), [0.0; 6]);
            }
        }
        inertias[dof] = sum.max(LEAST_INERTIA);
    }
    inertias
}

/// Motion of a joint from zero.
fn motion(kind: JointKind, axis: &Vector3<f64>, position: f64) -> Isometry3<f64> {
    match kind {
        JointKind::Fixed => Isometry3::identity(),
        JointKind::Revolute | JointKind::Continuous => Isometry3::rotation(axis * position),
        JointKind::Prismatic => Isometry3::translation(axis.x * position, axis.y * position, axis.z * position),
    }
}

/// A name in XML.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

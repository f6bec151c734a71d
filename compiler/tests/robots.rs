//! Robots as the compiler binds them: the start orientation of a floating base, and several robots in one spec.

use std::collections::BTreeMap;

use crate::common;

use common::{Compiled, compile_both, compile_text, examples};
use dsl::Syntax;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use robot::{Data, LinkId};

#[test]
fn a_floating_base_starts_where_home_and_start_put_it() {
    let text = "hierarq 1
robot arm {
  urdf \"robots/arm7.urdf\"
  base floating
  rate 100 Hz
  home { base_x 0.5 m  base_z 1 m  base_orientation rpy(0, 0, 90 deg)*rpy(0, 20 deg, 0)  joint_4 1 rad }
}
task still = joint_velocity { velocity 0 rad/s }
stack s { level limits hard { joint_velocity_limits }  level motion { still } }
scenario other { start { base_y 2 m  base_orientation axis_angle([1, 1, 0], 1 rad) } }
";
    let deg = std::f64::consts::PI / 180.0;
    let turned = UnitQuaternion::from_euler_angles(0.0, 20.0 * deg, 90.0 * deg);
    let home = Isometry3::from_parts(Translation3::new(0.5, 0.0, 1.0), turned);
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(1.0, 1.0, 0.0));
    let other = Isometry3::from_parts(Translation3::new(0.5, 2.0, 1.0), UnitQuaternion::from_axis_angle(&axis, 1.0));
    for compiled in compile_both(text) {
        let program = compiled.program.expect("a program");
        let model = &program.robot.model;
        let mut data = Data::new(model);
        for (q, expected) in [(&program.robot.home, home), (&program.scenarios[0].start, other)] {
            model.forward(q, &mut data);
            let apart = expected.inv_mul(data.pose(model.root()));
            assert!(apart.translation.vector.norm() < 1e-14 && apart.rotation.angle() < 1e-14, "{q:?}");
        }
    }
}

/// The poses of the links of a program at its home, by name.
fn poses(compiled: &Compiled) -> BTreeMap<String, Isometry3<f64>> {
    let program = compiled.program.as_ref().expect("a program");
    let model = &program.robot.model;
    let mut data = Data::new(model);
    model.forward(&program.robot.home, &mut data);
    (0..model.links.len()).map(|l| (model.links[l].name.clone(), *data.pose(LinkId(l as u32)))).collect()
}

#[test]
fn robots_of_one_spec_stand_where_each_of_them_is_put() {
    let one = |name: &str, more: &str| {
        format!(
            "robot {name} {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  {more}  home {{ joint_2 0.3 rad  joint_4 1 rad }} }}\n"
        )
    };
    let stack = "stack s { level limits hard { joint_position_limits  joint_velocity_limits } }\n";
    let alone = compile_text(&format!("hierarq 1\n{}{stack}", one("arm", "")), Syntax::Native, &examples(), &[]);
    let alone = poses(&alone);
    let text = format!(
        "hierarq 1\n{}{}{stack}",
        one("left", "at [0.2, 0.5, 0.1] m"),
        one("right", "base planar  at pose([0, -0.5, 0] m, rpy(0, 0, 90 deg))")
            .replace("home {", "home { base_x 0.3 m  base_yaw 30 deg")
    );
    let deg = std::f64::consts::PI / 180.0;
    let about_z = |angle: f64| UnitQuaternion::from_euler_angles(0.0, 0.0, angle * deg);
    // 0.3 m along the x axis of its place, which is the y axis of the world.
    let right = Isometry3::from_parts(Translation3::new(0.0, -0.2, 0.0), about_z(120.0));
    for compiled in compile_both(&text) {
        let together = poses(&compiled);
        for (robot, at) in [("left", Isometry3::translation(0.2, 0.5, 0.1)), ("right", right)] {
            for (link, pose) in &alone {
                let apart = (at * pose).inv_mul(&together[&format!("{robot}_{link}")]);
                assert!(apart.translation.vector.norm() < 1e-12 && apart.rotation.angle() < 1e-7, "{robot} {link}");
            }
        }
        let program = compiled.program.expect("a program");
        assert_eq!(program.robot.model.nv(), 17);
        assert_eq!(program.robot.model.dofs[7].name, "right_base_x");
    }
}

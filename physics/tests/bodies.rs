//! Bodies that a robot touches: obstacles that stay, move or come and go, people, surfaces, links.

use std::path::Path;

use crate::{after, compiled, elbow_after, installed, pendulum};

/// Angle of the elbow after such a run, which does not diverge. The lower sphere of the pendulum hangs at [-0.01, 0.07, 0.3] m, so
/// that everything that comes from +y pushes it towards -y, which lessens this angle.
fn pushed(settings: &str, declared: &str, scenario: &str) -> f64 {
    let (angle, diverged) = elbow_after(settings, declared, scenario);
    assert_eq!(diverged, None);
    angle
}

const WALL: &str = "box [2, 0.1, 3] m";

#[test]
fn an_obstacle_that_moves_pushes_the_robot_as_far_as_it_comes() {
    if !installed() {
        return;
    }
    // A wall whose near side comes from y = 0.25 to y = -0.1 in a second.
    let moving = format!("obstacle wall {{ {WALL}  position [0, 0.3 - 0.35*min(time/(1 s), 1), 1] m }}");
    let free = pushed("", "", "");
    assert!(free.abs() < 1e-3, "{free}");
    let angle = pushed("", &moving, "");
    // The sphere of 4 cm hangs 0.7 m below the shoulder, 0.3 m below the elbow.
    assert!(angle < -0.15, "{angle}");
    assert!(pushed("contacts false", &moving, "").abs() < 1e-3);
    // By a signal, as a tracker sends it: where it truly is, not where the controller takes it to be.
    let tracked = format!(
        "signal at : point  timeout 0.5 s  velocity estimated  max_speed 2 m/s
obstacle wall {{ {WALL}  position at + [0, 0.05, 1] m }}"
    );
    let path = "path [{ at 0 s  value [0, 0.25, 0] m }, { at 1 s  value [0, -0.1, 0] m }]";
    let signalled = pushed("", &tracked, &format!("signals {{ at {{ {path} }} }}"));
    assert!((signalled - angle).abs() < 0.02, "{signalled} by a signal, {angle} by the time");
    let late = pushed("", &tracked, &format!("signals {{ at {{ {path}  delay 0.4 s }} }}"));
    assert!((late - signalled).abs() < 0.02, "{late} measured late, {signalled} at once");
}

#[test]
fn an_obstacle_touches_only_while_it_is_there() {
    if !installed() {
        return;
    }
    let wall = |present: &str| format!("obstacle wall {{ {WALL}  position [0, 0, 1] m  present {present} }}");
    let standing = pushed("", &wall("time > 0.5 s"), "");
    assert!(standing.abs() > 0.05, "{standing}");
    assert!(pushed("", &wall("time > 3 s"), "").abs() < 1e-3);
    let half_space = "obstacle rising { plane [0, 0, 1]  position [0, 0, -1 + 0.5*time/(1 s)] m }";
    assert!(pushed("", half_space, "").abs() < 1e-3, "it does not come so high");
    let half_space = "obstacle rising { plane [0, -1, 0]  position [0, 0.5 - 0.3*time/(1 s), 0] m }";
    assert!(pushed("", half_space, "") < -0.1, "a half-space that moves");
}

#[test]
fn people_touch_the_robot_where_they_truly_are() {
    if !installed() {
        return;
    }
    let declared = "human walker { points [left, right]  links [[left, right]]  max_speed 4 m/s }";
    // From y = 0.4 to y = 0.02 at the height of the lower sphere, which is between the two points.
    let walk = |more: &str| {
        format!(
            "humans {{ walker {{ path [{{ at 0 s  value [0, 0.4, 0.3] m }}, {{ at 1 s  value [0, 0.02, 0.3] m }}]
shape {{ left [-0.3, 0, 0] m  right [0.3, 0, 0] m }}  {more} }} }}"
        )
    };
    let angle = pushed("", declared, &walk(""));
    assert!(angle < -0.1, "{angle}");
    assert!(pushed("contacts false", declared, &walk("")).abs() < 1e-3);
    let thick = pushed("person_radius 10 cm", declared, &walk(""));
    assert!(thick < angle - 0.1, "{thick} by a thick one, {angle} by a thin one");
    let unseen = pushed("", declared, &walk("delay 0.15 s  noise 2 cm"));
    assert!((unseen - angle).abs() < 0.02, "{unseen} seen badly, {angle} seen well");
    let apart = "human walker { points [left, right]  max_speed 4 m/s }";
    let unlinked = pushed("", apart, &walk(""));
    assert!(unlinked.abs() < 1e-3, "nothing between two points that are not linked: {unlinked}");
}

#[test]
fn clouds_triangles_and_pieces_are_bodies() {
    if !installed() {
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bodies");
    std::fs::create_dir_all(&folder).expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).expect("written");
        folder.join(name).display().to_string()
    };
    // A plate of points in the plane y = 0, and a box and a sheet as triangles.
    let points: Vec<String> = (0..20).flat_map(|i| (0..20).map(move |k| format!("{} 0 {}", at(i), at(k)))).collect();
    let cloud = write("plate.xyz", &points.join("\n"));
    let solid = write("box.obj", BOX);
    let heights = write("flat.csv", "0,0,0\n0,0,0\n0,0,0\n");
    // All of them come from y = 0.3 to y = -0.05.
    let comes = "[0, 0.3 - 0.35*min(time/(1 s), 1), 0.3] m";
    for (form, most) in [
        (format!("cloud \"{cloud}\"  radius 3 cm"), -0.1),
        (format!("mesh \"{solid}\"  shape triangles"), -0.1),
        (format!("mesh \"{solid}\"  shape pieces"), -0.1),
        (format!("mesh \"{solid}\""), -0.1),
        // Its surface, upwards, is turned towards -y.
        (format!("heightfield \"{heights}\"  cell 0.2 m  orientation rpy(90 deg, 0, 0)"), -0.1),
    ] {
        let angle = pushed("", &format!("obstacle body {{ {form}  position {comes} }}"), "");
        assert!(angle < most, "{form}: {angle}");
    }
}

/// Coordinate of a point of the plate.
fn at(i: usize) -> f64 {
    0.03 * (i as f64 - 9.5)
}

/// A box of 0.6, 0.04 and 0.6 m.
const BOX: &str = "v -0.3 -0.02 -0.3
v 0.3 -0.02 -0.3
v 0.3 0.02 -0.3
v -0.3 0.02 -0.3
v -0.3 -0.02 0.3
v 0.3 -0.02 0.3
v 0.3 0.02 0.3
v -0.3 0.02 0.3
f 1 3 2
f 1 4 3
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 3 4 8
f 3 8 7
f 2 3 7
f 2 7 6
f 1 5 8
f 1 8 4
";

#[test]
fn an_obstacle_on_a_link_touches_the_room_and_other_links() {
    if !installed() {
        return;
    }
    // A wall at rest, which the lower link alone does not reach, and a stick on that link, which does.
    let wall = format!("obstacle wall {{ {WALL}  position [0, 0.42, 1] m }}");
    let stick = "obstacle stick { capsule { radius 2 cm  length 0.3 m }  on lower  position [0, 0.15, -0.3] m  orientation rpy(90 deg, 0, 0) }";
    let turned = |declared: &str| {
        let program = pendulum("response 20 ms", declared);
        after(&program, &[0.0, 1.0], 1.5).1[1]
    };
    let (alone, carried) = (turned(&wall), turned(&format!("{wall}\n{stick}")));
    assert!(carried < alone - 0.2, "{carried} with the stick, {alone} without it");
    let free = turned(stick);
    assert!((free - 0.8).abs() < 0.05, "nothing to touch: {free}");
}

#[test]
fn an_obstacle_in_which_a_link_is_at_home_never_touches_it() {
    if !installed() {
        return;
    }
    // A block around the upper link, which hangs in it, and does not reach the lower one.
    let block = "obstacle block { box [0.5, 0.5, 0.3] m  position [0, 0, 0.9] m }";
    let run = |block: &str| after(&pendulum("response 20 ms", block), &[0.0, 0.5], 1.0).1;
    assert_eq!(run(block), run(""));
}

#[test]
fn links_touch_each_other_if_they_are_asked_to() {
    if !installed() {
        return;
    }
    // Three links fold to a triangle: the sphere of the last one comes to that of the first one, to which it is not joined, at about
    // 2.05 rad of both joints.
    let folded = |settings: &str| {
        let program = compiled(&format!(
            "hierarq 1
robot r {{ urdf \"robots/folding.urdf\"  rate 500 Hz }}
task still = joint_velocity {{ velocity 0 rad/s }}
stack s {{ level l hard {{ joint_velocity_limits }}  level motion {{ still }} }}
run {{ duration 1 s  plant mujoco {{ response 20 ms  {settings} }} }}
"
        ));
        after(&program, &[1.0, 1.0], 2.4).1
    };
    let (through, held) = (folded(""), folded("self_contact true"));
    assert!(through.iter().all(|q| (q - 2.4).abs() < 0.15), "{through:?}");
    assert!(held[0] + held[1] < through[0] + through[1] - 0.1, "{held:?} held, {through:?} through");
}

//! Distances to a point that may be absent, kept by `if(present(..), .., ..)`.

use nalgebra::Vector3;
use robot::{Data, Model};

use super::host::{Host, in_both_syntaxes};

/// Position of the tool, by forward kinematics of its own.
fn tool(host: &mut Host, model: &Model) -> Vector3<f64> {
    let mut data = Data::new(model);
    model.forward(host.robot.measure(), &mut data);
    let link = model.link("tool").expect("the arm has a tool");
    data.pose(link).translation.vector
}

#[test]
fn a_distance_to_what_is_absent_is_kept_from_when_it_is_seen() {
    for value in ["norm(frame(tool).position - o)", "norm(o - frame(tool).position)"] {
        for mut host in in_both_syntaxes(&format!(
            "signal o : point?  timeout 200 ms
             task away = keep(if(present(o), {value}, 5 m)) {{ min 0.15 m  gain 5 /s }}
             task reach = frame_position(tool) {{ position initial(position) + [0.3, 0, 0] m  gain 1 /s }}
             stack go from still {{ add fence hard {{ away }}  add motion {{ reach }} }}
             machine m {{ initial a  on fault(any) -> b  state a {{ stack go  after 9 s -> b }}  final state b }}"
        )) {
            let model = host.controller.evaluator().model().clone();
            let start = tool(&mut host, &model);
            let obstacle = start + Vector3::new(0.25, 0.0, 0.0);
            // Absent, then seen for 4 s, then absent again.
            for k in 0..700 {
                if (20..420).contains(&k) {
                    host.set("o", obstacle.as_slice());
                }
                let seen = host.step();
                assert_eq!((seen.fault, seen.state.as_str()), (None, "a"), "tick {k}");
                let distance = (tool(&mut host, &model) - obstacle).norm();
                assert!(!(20..420).contains(&k) || distance > 0.15 - 1e-3, "{distance} at tick {k}");
            }
            let moved = (tool(&mut host, &model) - start).x;
            assert!(moved > 0.2, "once it is gone, the robot goes on: {moved}");
        }
    }
}

//! Commands as messages.

use ros::commands::{Commander, Motion};
use runtime::program::{CommandForm, CommandTopic, RosProgram};

use crate::specs::{arm, program};

fn topic(form: CommandForm, dofs: &[usize]) -> CommandTopic {
    CommandTopic { name: "c".into(), topic: "/c".into(), form, dofs: dofs.to_vec(), prefix: String::new() }
}

#[test]
fn joints_are_in_the_order_of_their_topic_and_positions_are_those_of_the_configuration() {
    // The base has three coordinates and two velocities, so that the indices of both differ.
    let program = program(&arm("base unicycle } stack s { level l hard { joint_velocity_limits } }"));
    let model = &program.robot.model;
    let velocity: Vec<f64> = (0..model.nv()).map(|i| 10.0 + i as f64).collect();
    let reference: Vec<f64> = (0..model.nq()).map(|i| 20.0 + i as f64).collect();
    let motion = Motion { velocity: &velocity, position: &reference, lasts: 0.002 };
    let of = |form, dofs: &[usize]| Commander::new(&topic(form, dofs), model);
    assert_eq!(of(CommandForm::Velocity, &[3, 2]).numbers(motion).data, [13.0, 12.0]);
    assert_eq!(of(CommandForm::Position, &[3, 2]).numbers(motion).data, [24.0, 23.0]);
    let trajectory = of(CommandForm::Trajectory, &[2, 4]).trajectory(motion);
    assert_eq!(trajectory.joint_names, [model.dofs[2].name.as_str(), model.dofs[4].name.as_str()]);
    let point = &trajectory.points[0];
    assert_eq!((&point.positions[..], &point.velocities[..]), (&[23.0, 25.0][..], &[12.0, 14.0][..]));
    assert_eq!((point.time_from_start.sec, point.time_from_start.nanosec), (0, 2_000_000));
    let twist = of(CommandForm::Twist, &[0, 1]).twist(motion);
    assert_eq!((twist.linear.x, twist.linear.y, twist.angular.z), (10.0, 0.0, 11.0));
}

#[test]
fn without_a_connection_the_usual_topics_serve() {
    let program =
        program(&arm("base planar } stack s { level l hard { joint_velocity_limits } }\nsignal push : flag?"));
    let ros = RosProgram::of(&program);
    let forms: Vec<(&str, CommandForm, usize)> =
        ros.commands.iter().map(|c| (c.topic.as_str(), c.form, c.dofs.len())).collect();
    let joints = program.robot.model.nv() - 3;
    assert_eq!(forms, [("~/commands", CommandForm::Velocity, joints), ("/cmd_vel", CommandForm::Twist, 3)]);
    assert_eq!(ros.odometry.iter().map(|o| o.topic.as_str()).collect::<Vec<_>>(), ["/odom"]);
    assert_eq!((ros.signals[0].topic.as_str(), ros.signals[0].message.as_str()), ("~/push", "std_msgs/Bool"));
}

#[test]
fn bases_of_several_robots_have_topics_of_their_own() {
    let robot =
        |name: &str, base: &str| arm(&format!("base {base} }}")).replacen("robot arm", &format!("robot {name}"), 1);
    let text =
        robot("left", "unicycle") + &robot("right", "floating") + "stack s { level l hard { joint_velocity_limits } }";
    let program = program(&text);
    let (ros, model) = (RosProgram::of(&program), &program.robot.model);
    let topics: Vec<(&str, CommandForm, usize)> =
        ros.commands.iter().map(|c| (c.topic.as_str(), c.form, c.dofs.len())).collect();
    let joints = (CommandForm::Velocity, model.nv() - 8);
    let expected = [
        ("~/commands", joints.0, joints.1),
        ("/left/cmd_vel", CommandForm::Twist, 2),
        ("/right/cmd_vel", CommandForm::Twist, 6),
    ];
    assert_eq!(topics, expected);
    let odometry: Vec<(&str, usize)> = ros.odometry.iter().map(|o| (o.topic.as_str(), o.base)).collect();
    assert_eq!(odometry, [("/left/odom", 0), ("/right/odom", 1)]);
    let velocity: Vec<f64> = (0..model.nv()).map(|i| i as f64).collect();
    let motion = Motion { velocity: &velocity, position: &vec![0.0; model.nq()], lasts: 0.01 };
    let first = model.bases[1].first_dof as f64;
    let left = Commander::new(&ros.commands[1], model).twist(motion);
    let right = Commander::new(&ros.commands[2], model).twist(motion);
    assert_eq!((left.linear.x, left.linear.y, left.angular.z), (0.0, 0.0, 1.0));
    assert_eq!((right.linear.x, right.linear.z, right.angular.x), (first, first + 2.0, first + 3.0));
}

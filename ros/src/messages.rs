//! The messages that a node reads and writes, field by field as the interfaces of ROS 2 declare them (`common_interfaces`,
//! Humble and later). CDR has no names: the order of the fields is what counts.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// Declares messages.
macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $field:ident: $kind:ty),* $(,)? })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
            pub struct $name {
                $($(#[$of])* pub $field: $kind,)*
            }

            impl Message for $name {}
        )*
    };
}

messages! {
    /// `builtin_interfaces/Time`.
    Time {
        /// Seconds since 1970.
        sec: i32,
        /// Nanoseconds after them.
        nanosec: u32,
    }
    /// `std_msgs/Header`.
    Header {
        /// Time of the content.
        stamp: Time,
        /// Frame of the content.
        frame_id: String,
    }
    /// `std_msgs/Bool`.
    Bool {
        /// The value.
        data: bool,
    }
    /// `std_msgs/Float64`.
    Float64 {
        /// The value.
        data: f64,
    }
    /// `std_msgs/Float32`.
    Float32 {
        /// The value.
        data: f32,
    }
    /// `std_msgs/String`.
    Text {
        /// The text.
        data: String,
    }
    /// `std_msgs/MultiArrayDimension`.
    Dimension {
        /// Name.
        label: String,
        /// Length.
        size: u32,
        /// Numbers from one element to the next.
        stride: u32,
    }
    /// `std_msgs/Float64MultiArray`, whose layout is a dimension list and an offset.
    Float64MultiArray {
        /// Dimensions.
        dim: Vec<Dimension>,
        /// Place of the first number.
        data_offset: u32,
        /// The numbers.
        data: Vec<f64>,
    }
    /// `sensor_msgs/JointState`.
    JointState {
        /// Time of the reading.
        header: Header,
        /// Names of joints.
        name: Vec<String>,
        /// Positions in rad or m.
        position: Vec<f64>,
        /// Velocities in rad/s or m/s; may be empty.
        velocity: Vec<f64>,
        /// Torques or forces; may be empty.
        effort: Vec<f64>,
    }
    /// `builtin_interfaces/Duration`.
    Duration {
        /// Seconds.
        sec: i32,
        /// Nanoseconds after them.
        nanosec: u32,
    }
    /// `trajectory_msgs/JointTrajectoryPoint`.
    JointTrajectoryPoint {
        /// Positions in rad or m.
        positions: Vec<f64>,
        /// Velocities in rad/s or m/s.
        velocities: Vec<f64>,
        /// Accelerations; empty.
        accelerations: Vec<f64>,
        /// Torques or forces; empty.
        effort: Vec<f64>,
        /// Time at which they are due, from the start of the trajectory.
        time_from_start: Duration,
    }
    /// `trajectory_msgs/JointTrajectory`.
    JointTrajectory {
        /// Start; zero for now.
        header: Header,
        /// Names of joints.
        joint_names: Vec<String>,
        /// Points.
        points: Vec<JointTrajectoryPoint>,
    }
    /// `geometry_msgs/Point` and `geometry_msgs/Vector3`.
    Vector3 {
        /// x.
        x: f64,
        /// y.
        y: f64,
        /// z.
        z: f64,
    }
    /// `geometry_msgs/Quaternion`.
    Quaternion {
        /// x.
        x: f64,
        /// y.
        y: f64,
        /// z.
        z: f64,
        /// Real part.
        w: f64,
    }
    /// `geometry_msgs/Pose`.
    Pose {
        /// Position in m.
        position: Vector3,
        /// Orientation.
        orientation: Quaternion,
    }
    /// `geometry_msgs/Transform`.
    Transform {
        /// Position of the child in m.
        translation: Vector3,
        /// Orientation of the child.
        rotation: Quaternion,
    }
    /// `geometry_msgs/TransformStamped`.
    TransformStamped {
        /// Time, and the frame in which the child is.
        header: Header,
        /// The child.
        child_frame_id: String,
        /// Pose of the child.
        transform: Transform,
    }
    /// `tf2_msgs/TFMessage`.
    Transforms {
        /// The transforms.
        transforms: Vec<TransformStamped>,
    }
    /// `geometry_msgs/Twist`.
    Twist {
        /// Velocity in m/s.
        linear: Vector3,
        /// Angular velocity in rad/s.
        angular: Vector3,
    }
    /// `geometry_msgs/Wrench`.
    Wrench {
        /// Force in N.
        force: Vector3,
        /// Moment in Nm.
        torque: Vector3,
    }
    /// `geometry_msgs/PointStamped` and `geometry_msgs/Vector3Stamped`.
    Vector3Stamped {
        /// Time and frame.
        header: Header,
        /// The vector.
        vector: Vector3,
    }
    /// `geometry_msgs/QuaternionStamped`.
    QuaternionStamped {
        /// Time and frame.
        header: Header,
        /// The orientation.
        quaternion: Quaternion,
    }
    /// `geometry_msgs/PoseStamped`.
    PoseStamped {
        /// Time and frame.
        header: Header,
        /// The pose.
        pose: Pose,
    }
    /// `geometry_msgs/WrenchStamped`.
    WrenchStamped {
        /// Time and frame.
        header: Header,
        /// The wrench.
        wrench: Wrench,
    }
    /// `sensor_msgs/Imu`.
    Imu {
        /// Time and frame.
        header: Header,
        /// Orientation.
        orientation: Quaternion,
        /// Covariance of the orientation.
        orientation_covariance: [f64; 9],
        /// Angular velocity in rad/s.
        angular_velocity: Vector3,
        /// Covariance of the angular velocity.
        angular_velocity_covariance: [f64; 9],
        /// Acceleration in m/s².
        linear_acceleration: Vector3,
        /// Covariance of the acceleration.
        linear_acceleration_covariance: [f64; 9],
    }
    /// `nav_msgs/Odometry`. Covariances of 36 numbers are read in two parts.
    Odometry {
        /// Time, and frame of the pose.
        header: Header,
        /// Frame of the velocity.
        child_frame_id: String,
        /// The pose.
        pose: Pose,
        /// Covariance of the pose, the first numbers.
        pose_covariance: [f64; 32],
        /// Covariance of the pose, the other numbers.
        pose_covariance_end: [f64; 4],
        /// Velocity along the axes of the child.
        twist: Twist,
        /// Covariance of the velocity, the first numbers.
        twist_covariance: [f64; 32],
        /// Covariance of the velocity, the other numbers.
        twist_covariance_end: [f64; 4],
    }
    /// Request of `std_srvs/Trigger`: it is empty, and ROS 2 sends one byte for that.
    TriggerRequest {
        /// The byte.
        structure_needs_at_least_one_member: u8,
    }
    /// Response of `std_srvs/Trigger`.
    TriggerResponse {
        /// True if it was done.
        success: bool,
        /// The reason, if not.
        message: String,
    }
}

impl Vector3 {
    /// The three numbers.
    pub fn numbers(&self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl Quaternion {
    /// The four numbers, real part first.
    pub fn numbers(&self) -> [f64; 4] {
        [self.w, self.x, self.y, self.z]
    }
}

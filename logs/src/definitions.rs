//! The ROS 2 messages of a log: names and definitions as MCAP stores them with each channel. Constants and comments of
//! the definitions are left out, since nothing of a message depends on them.
//!
//! Source: the interfaces of ROS 2 Humble and later, packages `common_interfaces`, `geometry2` and `rcl_interfaces`.

/// The definition of one message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Name: package and message, `std_msgs/String`.
    pub name: &'static str,
    /// Fields, one a line.
    pub fields: &'static str,
    /// Messages that the fields are made of, all levels of them.
    pub parts: &'static [&'static str],
}

const TIME: &str = "builtin_interfaces/Time";
const DURATION: &str = "builtin_interfaces/Duration";
const HEADER: &str = "std_msgs/Header";
const COLOR: &str = "std_msgs/ColorRGBA";
const POINT: &str = "geometry_msgs/Point";
const VECTOR: &str = "geometry_msgs/Vector3";
const QUATERNION: &str = "geometry_msgs/Quaternion";

/// A text.
pub static STRING: Definition = Definition { name: "std_msgs/String", fields: "string data\n", parts: &[] };

/// Numbers in a row.
pub static NUMBERS: Definition = Definition {
    name: "std_msgs/Float64MultiArray",
    fields: "std_msgs/MultiArrayLayout layout\nfloat64[] data\n",
    parts: &["std_msgs/MultiArrayLayout", "std_msgs/MultiArrayDimension"],
};

/// Positions and velocities of joints.
pub static JOINT_STATE: Definition = Definition {
    name: "sensor_msgs/JointState",
    fields: "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    parts: &[HEADER, TIME],
};

/// Poses of frames.
pub static TRANSFORMS: Definition = Definition {
    name: "tf2_msgs/TFMessage",
    fields: "geometry_msgs/TransformStamped[] transforms\n",
    parts: &["geometry_msgs/TransformStamped", "geometry_msgs/Transform", VECTOR, QUATERNION, HEADER, TIME],
};

/// Bodies and lines to draw.
pub static MARKERS: Definition = Definition {
    name: "visualization_msgs/MarkerArray",
    fields: "visualization_msgs/Marker[] markers\n",
    parts: &[
        "visualization_msgs/Marker",
        "visualization_msgs/MeshFile",
        "visualization_msgs/UVCoordinate",
        "sensor_msgs/CompressedImage",
        "geometry_msgs/Pose",
        POINT,
        VECTOR,
        QUATERNION,
        COLOR,
        DURATION,
        HEADER,
        TIME,
    ],
};

/// Conditions of the parts of a system.
pub static DIAGNOSTICS: Definition = Definition {
    name: "diagnostic_msgs/DiagnosticArray",
    fields: "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
    parts: &["diagnostic_msgs/DiagnosticStatus", "diagnostic_msgs/KeyValue", HEADER, TIME],
};

/// Fields of the messages that others are made of.
static PARTS: [(&str, &str); 17] = [
    (TIME, "int32 sec\nuint32 nanosec\n"),
    (DURATION, "int32 sec\nuint32 nanosec\n"),
    (HEADER, "builtin_interfaces/Time stamp\nstring frame_id\n"),
    (COLOR, "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n"),
    ("std_msgs/MultiArrayLayout", "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n"),
    (POINT, "float64 x\nfloat64 y\nfloat64 z\n"),
    (VECTOR, "float64 x\nfloat64 y\nfloat64 z\n"),
    (QUATERNION, "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
    ("visualization_msgs/MeshFile", "string filename\nuint8[] data\n"),
    ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte level\nstring name\nstring message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n",
    ),
];

static MARKER: (&str, &str) = (
    "visualization_msgs/Marker",
    "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n\
     geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\nbool frame_locked\n\
     geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n\
     sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n\
     string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
);

impl Definition {
    /// The name that a schema has in MCAP: `std_msgs/msg/String`.
    pub fn schema_name(&self) -> String {
        self.name.replacen('/', "/msg/", 1)
    }

    /// The definition with those of all its parts, as MCAP's schema encoding `ros2msg` has it.
    pub fn text(&self) -> String {
        let mut text = self.fields.to_string();
        for part in self.parts {
            let fields = PARTS.iter().chain([&MARKER]).find(|known| known.0 == *part).map_or("", |known| known.1);
            text += &format!("{}\nMSG: {part}\n{fields}", "=".repeat(80));
        }
        text
    }
}

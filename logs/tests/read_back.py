"""Reads a log in MCAP with two libraries that know nothing of Hierarq, and compares its numbers with `log.csv`.

    python read_back.py LOG.mcap LOG.csv
"""

import csv
import json
import math
import sys
from pathlib import Path

TOPICS = {
    "/robot_description": "std_msgs/msg/String",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/command": "std_msgs/msg/Float64MultiArray",
    "/hierarq/columns": "std_msgs/msg/Float64MultiArray",
    "/state": "std_msgs/msg/String",
    "/fault": "std_msgs/msg/String",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/closest_points": "visualization_msgs/msg/MarkerArray",
}


def rows(path):
    """Rows of the log as numbers, without state and fault; an empty cell is none."""
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            yield {name: float(x) if x else None for name, x in row.items() if name not in ("state", "fault")}


def same(found, expected):
    """True for the same bits, or for a number that is not finite in place of an empty cell."""
    if expected is None:
        return not math.isfinite(found)
    return found == expected and math.copysign(1, found) == math.copysign(1, expected)


def check(messages, columns, expected):
    """Compares messages, `(topic, time in ns, message)`, with the rows of the log."""
    tick, transforms, markers, latest = 0, 0, 0, {}
    for topic, time, message in messages:
        latest[topic] = message
        if topic == "/hierarq/columns":
            row = expected[tick]
            assert time == round(row["time"] * 1e9), (time, row["time"])
            assert len(message.data) == len(columns) == len(row)
            for name, x in zip(columns, message.data):
                assert same(x, row[name]), (tick, name, x, row[name])
            joints, command = latest["/joint_states"], latest["/command"]
            for name, q, v in zip(joints.name, joints.position, joints.velocity):
                assert same(q, row[f"q.{name}"]) and same(v, row[f"v.{name}"]), (tick, name)
            names = [name for name in row if name.startswith("cmd.")]
            assert [row[name] for name in names] == list(command.data), tick
            tick += 1
        elif topic in ("/tf", "/tf_static"):
            for t in message.transforms:
                r = t.transform.rotation
                assert abs(math.sqrt(r.x**2 + r.y**2 + r.z**2 + r.w**2) - 1) < 1e-9, t.child_frame_id
                transforms += 1
        elif topic.endswith(("points", "people", "obstacles", "walls", "keep_out")):
            for marker in message.markers:
                assert marker.ns and len(marker.colors) in (0, len(marker.points))
                markers += 1
    assert tick == len(expected), (tick, len(expected))
    assert latest["/robot_description"].data.startswith("<?xml")
    assert transforms > 0
    return tick, transforms, markers


def with_mcap_ros2(path, expected):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        schemas = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
        for topic, name in TOPICS.items():
            assert schemas.get(topic, name) == name, (topic, schemas[topic])
        columns = next(c for c in summary.channels.values() if c.topic == "/hierarq/columns").metadata["columns"]
        attachments = {a.name for a in reader.iter_attachments()}
        assert "program.json" in attachments and len(attachments) >= 2, attachments
        assert {m.name for m in reader.iter_metadata()} == {"hierarq", "hierarq_end"}
        decoded = ((c.topic, m.log_time, ros) for _, c, m, ros in reader.iter_decoded_messages(log_time_order=False))
        return json.loads(columns), check(decoded, json.loads(columns), expected)


def with_rosbags(path, columns, expected):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([Path(path)], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        latched = {c.topic for c in reader.connections if c.ext.offered_qos_profiles[0].durability.value == 1}
        assert {"/robot_description", "/tf_static"} <= latched, latched
        decoded = ((c.topic, time, reader.deserialize(raw, c.msgtype)) for c, time, raw in reader.messages())
        # Messages of one time may come in another order: those of a tick are sorted as they were written.
        order = ["/joint_states", "/command", "/hierarq/columns"]
        key = lambda m: (m[1], order.index(m[0]) if m[0] in order else len(order))
        return check(sorted(decoded, key=key), columns, expected)


if __name__ == "__main__":
    log, table = sys.argv[1:]
    expected = list(rows(table))
    columns, counts = with_mcap_ros2(log, expected)
    assert with_rosbags(log, columns, expected) == counts
    print("%s: %d ticks, %d transforms, %d markers agree in both libraries" % (Path(log).name, *counts))

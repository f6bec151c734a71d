"""An independent participant: a robot of joints that move as they are commanded, on CycloneDDS.

Reads what it is to do from its arguments as JSON, and prints what it saw as JSON, one object in the last line.
"""

import json
import os
import random
import signal
import sys
import time
from dataclasses import dataclass, field

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl import annotations as annotate
from cyclonedds.idl import types
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

INT, UINT, FLOAT = types.int32, types.uint32, types.float64


@dataclass
@annotate.final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: INT = 0
    nanosec: UINT = 0


@dataclass
@annotate.final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
@annotate.final
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: types.sequence[str]
    position: types.sequence[FLOAT]
    velocity: types.sequence[FLOAT]
    effort: types.sequence[FLOAT]


@dataclass
@annotate.final
class Dimension(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"):
    label: str
    size: UINT
    stride: UINT


@dataclass
@annotate.final
class Layout(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"):
    dim: types.sequence[Dimension]
    data_offset: UINT


@dataclass
@annotate.final
class Numbers(IdlStruct, typename="std_msgs::msg::dds_::Float64MultiArray_"):
    layout: Layout
    data: types.sequence[FLOAT]


@dataclass
@annotate.final
class Number(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):
    data: FLOAT


@dataclass
@annotate.final
class Flag(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


@dataclass
@annotate.final
class Text(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str


@dataclass
@annotate.final
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: FLOAT = 0.0
    y: FLOAT = 0.0
    z: FLOAT = 0.0


@dataclass
@annotate.final
class PointStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PointStamped_"):
    header: Header
    point: Vector3


@dataclass
@annotate.final
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: FLOAT = 0.0
    y: FLOAT = 0.0
    z: FLOAT = 0.0
    w: FLOAT = 1.0


@dataclass
@annotate.final
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass
@annotate.final
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    position: Vector3
    orientation: Quaternion
    covariance: types.array[FLOAT, 36]


@dataclass
@annotate.final
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist
    covariance: types.array[FLOAT, 36]


@dataclass
@annotate.final
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
@annotate.final
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
@annotate.final
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
@annotate.final
class Transforms(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: types.sequence[TransformStamped]


@dataclass
@annotate.final
class Duration(IdlStruct, typename="builtin_interfaces::msg::dds_::Duration_"):
    sec: INT
    nanosec: UINT


@dataclass
@annotate.final
class TrajectoryPoint(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectoryPoint_"):
    positions: types.sequence[FLOAT]
    velocities: types.sequence[FLOAT]
    accelerations: types.sequence[FLOAT]
    effort: types.sequence[FLOAT]
    time_from_start: Duration


@dataclass
@annotate.final
class Trajectory(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectory_"):
    header: Header
    joint_names: types.sequence[str]
    points: types.sequence[TrajectoryPoint]


@dataclass
@annotate.final
class TriggerRequest(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    # The mapping of CycloneDDS: who asks, and which question it is.
    client: types.uint64
    number: types.int64
    structure_needs_at_least_one_member: types.uint8 = 0


@dataclass
@annotate.final
class TriggerResponse(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    client: types.uint64
    number: types.int64
    success: bool = False
    message: str = ""


RELIABLE = Policy.Reliability.Reliable(duration(milliseconds=100))
LAST = Policy.History.KeepLast(8)
SENSOR = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, LAST)
COMMAND = Qos(RELIABLE, Policy.Durability.Volatile, LAST)
LATCHED = Qos(RELIABLE, Policy.Durability.TransientLocal, LAST)


def number(x):
    """A number of the arguments: JSON has no `nan` and `inf`."""
    return float(x)


class Schedule:
    """What is to be at a time: the last of some pairs of a time and a thing that has come."""

    def __init__(self, pairs, default):
        self.pairs, self.default = pairs, default

    def at(self, now):
        return next((thing for time, thing in reversed(self.pairs) if time <= now), self.default)


class Participant:
    """A participant of the domain, with what it has heard."""

    def __init__(self, to_do):
        self.participant = DomainParticipant(to_do["domain"])
        self.to_do = to_do
        self.names = to_do["names"]
        self.period = to_do["period"]
        node = to_do.get("node", "/hierarq")
        self.commands = None if to_do.get("deaf") == 1.0 else self.reader(node + "/commands", Numbers, COMMAND)
        self.state = self.reader(node + "/state", Text, LATCHED)
        self.fault = self.reader(node + "/fault", Text, LATCHED)
        self.seen = {"state": [], "fault": [], "commands": 0, "first": [], "last": [], "largest": 0.0, "answers": []}
        self.calls = [[at, self.service(name)] for at, name in to_do.get("calls", [])]

    def writer(self, topic, kind, qos):
        return DataWriter(self.participant, Topic(self.participant, "rt" + topic, kind), qos=qos)

    def reader(self, topic, kind, qos):
        return DataReader(self.participant, Topic(self.participant, "rt" + topic, kind), qos=qos)

    def service(self, name):
        """The two topics of a service."""
        ask = Topic(self.participant, f"rq{name}Request", TriggerRequest)
        answer = Topic(self.participant, f"rr{name}Reply", TriggerResponse)
        return DataWriter(self.participant, ask, qos=COMMAND), DataReader(self.participant, answer, qos=COMMAND)

    def call(self, now):
        """Asks what is due, and takes the answers."""
        if self.calls and now >= self.calls[0][0]:
            ask, answer = self.calls[0][1]
            if len(self.calls[0]) == 2:
                ask.write(TriggerRequest(7, 1 + len(self.seen["answers"])))
                self.calls[0].append("asked")
            for got in self.taken(answer):
                # Each caller sees all answers, and knows its own by their numbers.
                if (got.client, got.number) == (7, 1 + len(self.seen["answers"])):
                    self.seen["answers"].append([got.success, got.message])
                    self.calls.pop(0)
                    break

    @staticmethod
    def taken(reader):
        """Messages that have arrived, without those that only say that a writer has gone."""
        return [sample for sample in reader.take(N=32) if sample.sample_info.valid_data]

    def listen(self):
        for command in self.taken(self.commands) if self.commands else []:
            self.hear(list(command.data))
        for key in ("state", "fault"):
            self.seen[key] += [text.data for text in self.taken(getattr(self, key))]

    def hear(self, command):
        self.seen["commands"] += 1
        self.seen["first"] = self.seen["first"] or command
        self.seen["last"] = command
        self.seen["largest"] = max([self.seen["largest"], *map(abs, command)])

    def tick(self, now):
        """What it does besides listening."""


class Robot(Participant):
    """Publishes the states of its joints, and moves as it is commanded."""

    def __init__(self, to_do):
        super().__init__(to_do)
        self.position = list(to_do["position"])
        self.velocity = [0.0] * len(self.names)
        self.order = to_do.get("order", list(range(len(self.names))))
        self.states = self.writer(to_do.get("joint_states", "/joint_states"), JointState, SENSOR)
        self.manners = Schedule(to_do.get("manners", []), None)
        # Times at which somebody moves the first joint by hand, with the angles (rad).
        self.pushes = to_do.get("pushes", [])
        if to_do.get("traces"):
            self.seen["way"] = []
        # A base that nothing moves: pairs of a time and its x (m) from then on.
        self.base = Schedule(to_do["base"], 0.0) if "base" in to_do else None
        if self.base:
            self.odometry = self.writer("/odom", Odometry, SENSOR)
            self.twist = self.reader("/cmd_vel", Twist, COMMAND)
        self.stamp = Time(2_000_000_000, 0)

    def hear(self, command):
        super().hear(command)
        # A network that loses commands: a robot keeps its velocity then.
        if random.random() < self.to_do.get("deaf", 0.0):
            return
        if self.to_do.get("form") == "position":
            self.position = command
        else:
            # A base, which has no place in this message, stands first.
            self.velocity = [0.0] * (len(self.names) - len(command)) + command

    def tick(self, now):
        self.position = [q + v * self.period for q, v in zip(self.position, self.velocity)]
        while self.pushes and now >= self.pushes[0][0]:
            self.position[0] += self.pushes.pop(0)[1]
        if "way" in self.seen:
            self.seen["way"].append([now, self.position[0]])
        names = ["a_gripper_joint"] + [self.names[i] for i in self.order]
        position = [0.04] + [self.position[i] for i in self.order]
        manner = self.manners.at(now)
        if manner == "silent":
            return
        if manner == "without positions":
            position = []
        elif manner == "too many positions":
            position = position + [0.0]
        elif manner is not None:
            # The first joint is at this number.
            position[1] = number(manner)
        if self.to_do.get("stamps") == "backwards":
            self.stamp = Time(self.stamp.sec - 1, 0)
        self.states.write(JointState(Header(stamp=self.stamp), names, position, [], []))
        if self.base:
            pose = PoseWithCovariance(Vector3(x=self.base.at(now)), Quaternion(), [0.0] * 36)
            still = TwistWithCovariance(Twist(), [0.0] * 36)
            self.odometry.write(Odometry(Header(stamp=self.stamp), "base", pose, still))
            self.seen["largest_twist"] = max(
                [self.seen.get("largest_twist", 0.0), *(abs(twist.linear.x) for twist in self.taken(self.twist))]
            )

    def report(self):
        return self.seen | {"position": self.position}


class Sensors(Participant):
    """Publishes values, and moves nothing."""

    def report(self):
        return self.seen


class Values:
    """Topics with values of signals."""

    def __init__(self, of, to_do):
        self.mute = to_do.get("mute", [0.0, 0.0])
        self.frame = to_do.get("frame", "world")
        values = to_do.get("values", {})
        kinds = [("numbers", Number, self.number), ("points", PointStamped, self.point), ("flags", Flag, Flag)]
        self.topics = [
            (of.writer(topic, kind, SENSOR), made, Schedule(to_do.get("later", {}).get(name, []), values[name]))
            for key, kind, made in kinds
            for name, topic in to_do.get(key, {}).items()
        ]
        # Pairs of frames, with the pose of the second one in the first one: x y z, and a quaternion x y z w.
        self.fixed = of.writer("/tf_static", Transforms, LATCHED) if "fixed" in to_do else None
        for parent, child, pose in to_do.get("fixed", []):
            transform = Transform(Vector3(*pose[:3]), Quaternion(*pose[3:]))
            self.fixed.write(Transforms([TransformStamped(Header(frame_id=parent), child, transform)]))
        # Flags that are sent once when they change, and kept for those who come later. Without a value (`null`) nobody publishes them.
        self.of = of
        self.latched = [[topic, Schedule(pairs, None), None, None] for topic, pairs in to_do.get("latched", {}).items()]
        self.wrong = of.writer(to_do["wrong_type"], Text, SENSOR) if "wrong_type" in to_do else None

    def number(self, value):
        return Number(number(value))

    def point(self, value):
        return PointStamped(Header(frame_id=self.frame), Vector3(*map(number, value)))

    def tick(self, now):
        if self.mute[0] <= now < self.mute[1]:
            return
        for writer, made, value in self.topics:
            writer.write(made(value.at(now)))
        for flag in self.latched:
            topic, values, last, writer = flag
            value = values.at(now)
            if value != last:
                writer = (writer or self.of.writer(topic, Flag, LATCHED)) if value is not None else None
                flag[2:] = [value, writer]
                if writer:
                    writer.write(Flag(value))
        if self.wrong is not None:
            self.wrong.write(Text("no point"))


def main():
    to_do = json.loads(sys.argv[1])
    random.seed(7)
    time.sleep(to_do.get("late", 0.0))
    who = Robot(to_do) if to_do.get("robot", True) else Sensors(to_do)
    values = Values(who, to_do)
    ends = [(to_do[key], sent) for key, sent in (("dies", signal.SIGKILL), ("freezes", signal.SIGSTOP)) if key in to_do]
    start = time.monotonic()
    ticks = 0
    heard = None
    # A discovery whose messages are lost takes its time: some wait for their first command.
    while (now := time.monotonic() - start) < to_do["seconds"] and not (heard and now > heard + to_do["after_first"]):
        if "after_first" in to_do and heard is None and who.seen["commands"]:
            heard = now
        for at, sent in ends:
            if now >= at:
                os.kill(os.getpid(), sent)
        who.listen()
        who.tick(now)
        values.tick(now)
        who.call(now)
        ticks += 1
        time.sleep(max(0.0, start + ticks * who.period - time.monotonic()))
    who.listen()
    print(json.dumps(who.report()))


if __name__ == "__main__":
    main()

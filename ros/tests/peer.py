"""An independent participant: a robot of joints that move as they are commanded, on CycloneDDS.

Reads what it is to do from its arguments as JSON, and prints what it saw as JSON, one object in the last line.
"""

import json
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


class Robot:
    """Publishes the states of its joints, and moves as it is commanded."""

    def __init__(self, to_do):
        self.participant = DomainParticipant(to_do["domain"])
        self.names = to_do["names"]
        self.position = list(to_do["position"])
        self.velocity = [0.0] * len(self.names)
        self.period = to_do["period"]
        self.order = to_do.get("order", list(range(len(self.names))))
        self.states = self.writer(to_do.get("joint_states", "/joint_states"), JointState, SENSOR)
        self.commands = self.reader(to_do.get("commands", "/hierarq/commands"), Numbers, COMMAND)
        node = to_do.get("node", "/hierarq")
        self.state = self.reader(node + "/state", Text, LATCHED)
        self.fault = self.reader(node + "/fault", Text, LATCHED)
        self.seen = {"state": [], "fault": [], "commands": 0, "last": [], "largest": 0.0, "answers": []}
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

    def publish(self):
        pick = lambda of: [of[i] for i in self.order]
        extra = ["a_gripper_joint"]
        self.states.write(
            JointState(Header(), extra + pick(self.names), [0.04] + pick(self.position), [], [])
        )

    @staticmethod
    def taken(reader):
        """Messages that have arrived, without those that only say that a writer has gone."""
        return [sample for sample in reader.take(N=32) if sample.sample_info.valid_data]

    def listen(self):
        for command in self.taken(self.commands):
            self.velocity = list(command.data)
            self.seen["commands"] += 1
            self.seen["last"] = self.velocity
            self.seen["largest"] = max([self.seen["largest"], *map(abs, self.velocity)])
        for key in ("state", "fault"):
            self.seen[key] += [text.data for text in self.taken(getattr(self, key))]

    def move(self):
        self.position = [q + v * self.period for q, v in zip(self.position, self.velocity)]

    def run(self, seconds, each=lambda t: None, quiet=None):
        """Lives for some seconds; between the times in `quiet` it says nothing."""
        start = time.monotonic()
        tick = 0
        while (now := time.monotonic() - start) < seconds:
            self.listen()
            self.move()
            if quiet is None or not quiet[0] <= now < quiet[1]:
                self.publish()
            each(now)
            self.call(now)
            tick += 1
            time.sleep(max(0.0, start + tick * self.period - time.monotonic()))
        self.listen()


def main():
    to_do = json.loads(sys.argv[1])
    robot = Robot(to_do)
    numbers = {name: robot.writer(topic, Number, SENSOR) for name, topic in to_do.get("numbers", {}).items()}
    points = {name: robot.writer(topic, PointStamped, SENSOR) for name, topic in to_do.get("points", {}).items()}
    wrong = None
    if "wrong_type" in to_do:
        wrong = robot.writer(to_do["wrong_type"], Text, SENSOR)

    mute = to_do.get("mute", [0.0, 0.0])

    def each(now):
        if mute[0] <= now < mute[1]:
            return
        for name, of in numbers.items():
            of.write(Number(to_do["values"][name]))
        for name, of in points.items():
            of.write(PointStamped(Header(frame_id=to_do.get("frame", "world")), Vector3(*to_do["values"][name])))
        if wrong is not None:
            wrong.write(Text("no point"))

    robot.run(to_do["seconds"], each, to_do.get("quiet"))
    robot.seen["position"] = robot.position
    print(json.dumps(robot.seen))


if __name__ == "__main__":
    main()

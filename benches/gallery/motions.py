"""Random motions that are hard on an arm: targets out of reach, folded arms, targets that jump, wishes that fight.

A motion is drawn from a robot, a kind and a seed, and means the same to every controller: where the robot starts, where
its tip is to be at each time, and what a second frame wishes below it. Lengths are in m, angles in rad, times in s.
"""

from dataclasses import dataclass
from pathlib import Path
import random

import numpy as np
import pinocchio as pin

HERE = Path(__file__).resolve().parent
DATA = Path(pin.__file__).parents[4] / "share/example-robot-data/robots"
RATES = [50, 100, 500, 1000]  # Hz
GAIN = 2.0  # 1/s, of every task; the default of Hierarq
BRAKING = 10.0  # 1/s, times the speed limit: the acceleration limit of a joint; the default of Hierarq

KINDS = {
    "out of reach": "still target, 0.2 to 2 m away in any direction",
    "pose out of reach": "the same, orientation to be kept",
    "in and out": "target on a line that is 0.4 to 4 m long, there and back in 2 to 8 s",
    "pose in and out": "the same, orientation to be kept",
    "jumping": "target that jumps to and fro by 0.2 to 1 m every 1 to 2 s",
    "folded": "still target within 5 cm of the first joint's axis, at the height of the arm",
    "fighting": "still targets 0.2 to 1 m apart from where the tip and, one level below, the frame before its wrist stand",
    "small": "target on a line of 2 to 8 cm, there and back in 2 to 8 s: what most of them can follow",
}
STILL = {"out of reach", "pose out of reach", "folded", "fighting"}


@dataclass
class Robot:
    """A URDF, the frame that is to reach, a frame further up its chain, and its joints as Pinocchio has them."""

    name: str
    urdf: Path
    tip: str
    middle: str

    def __post_init__(self):
        whole = pin.buildModelFromUrdf(str(self.urdf))
        # Wheels without an end and fingers have no part in the motion; locked, positions and velocities have one size.
        out = [j for j in range(1, whole.njoints) if whole.nqs[j] != 1 or "finger" in whole.names[j]]
        self.model = pin.buildReducedModel(whole, out, pin.neutral(whole))
        self.names = list(self.model.names)[1:]
        self.sliding = [self.model.joints[i].shortname().startswith("JointModelP") for i in range(1, self.model.njoints)]
        self.lower = np.maximum(self.model.lowerPositionLimit, -6.3)
        self.upper = np.minimum(self.model.upperPositionLimit, 6.3)
        self.speed = np.maximum(self.model.velocityLimit, 0.1)
        self.acceleration = BRAKING * self.speed

    def place(self, q, frame):
        """Where a frame stands at positions q, as an SE3."""
        data = self.model.createData()
        pin.framesForwardKinematics(self.model, data, q)
        return data.oMf[self.model.getFrameId(frame)].copy()


def robots():
    """The robots of the gallery, by name."""
    found = [
        Robot("arm7", HERE.parents[1] / "examples/robots/arm7.urdf", "tool", "link_4"),
        Robot("UR5", DATA / "ur_description/urdf/ur5_robot.urdf", "tool0", "wrist_1_link"),
        Robot("Panda", DATA / "panda_description/urdf/panda.urdf", "panda_hand", "panda_link5"),
        Robot("TIAGo", DATA / "tiago_description/robots/tiago_no_hand.urdf", "arm_tool_link", "arm_4_link"),
        Robot("Talos", DATA / "talos_data/robots/talos_reduced.urdf", "gripper_left_base_link", "arm_left_4_link"),
        Robot("G1", DATA / "g1_description/urdf/g1_29dof_rev_1_0.urdf", "left_wrist_yaw_link", "left_elbow_link"),
    ]
    return {robot.name: robot for robot in found}


@dataclass
class Motion:
    """What a robot is to do: `tip(t)` is start + way * shape(t), the orientation that of the start if `pose`."""

    robot: Robot
    kind: str
    seed: int
    duration: float = 8.0

    def __post_init__(self):
        dice = random.Random(f"{self.robot.name} {self.kind} {self.seed}")
        robot = self.robot
        lower, upper = np.maximum(robot.lower, -2.5), np.minimum(robot.upper, 2.5)
        share = np.array([dice.uniform(0.3, 0.7) for _ in robot.names])
        # As many digits as the spec has.
        self.home = np.round(lower + share * (upper - lower), 6)
        self.rate = RATES[self.seed % len(RATES)]
        self.start = robot.place(self.home, robot.tip)
        self.pose = self.kind.startswith("pose")
        self.period = dice.choice([2.0, 4.0, 8.0])
        direction = np.array([dice.gauss(0, 1) for _ in range(3)])
        direction /= np.linalg.norm(direction)
        size = dice.choice([0.2, 0.5, 1.0, 2.0])
        self.second = None
        if self.kind == "jumping":
            size, self.period = dice.uniform(0.2, 1.0), dice.choice([2.0, 4.0])
        elif self.kind == "small":
            size = dice.uniform(0.01, 0.04)
        elif self.kind == "fighting":
            size = dice.uniform(0.2, 1.0)
            away = np.array([dice.gauss(0, 1) for _ in range(3)])
            away *= dice.uniform(0.2, 1.0) / np.linalg.norm(away)
            self.second = np.round(robot.place(self.home, robot.middle).translation + away, 6)
        self.way = direction * size
        if self.kind == "folded":
            data = robot.model.createData()
            pin.forwardKinematics(robot.model, data, self.home)
            chain = robot.model.supports[robot.model.frames[robot.model.getFrameId(robot.tip)].parentJoint].tolist()
            shoulder = data.oMi[chain[-6]].translation
            self.way = shoulder + 0.05 * direction - self.start.translation
        self.way = np.round(self.way, 6)

    def shape(self, t):
        """The share of the way at time t and its two derivatives in time."""
        w = 2 * np.pi / self.period
        if self.kind in STILL:
            return 1.0, 0.0, 0.0
        if self.kind == "jumping":
            return (1.0 if np.sin(w * t) > 1e-6 else 0.0), 0.0, 0.0
        return np.sin(w * t), w * np.cos(w * t), -w * w * np.sin(w * t)

    def target(self, t):
        """Position, velocity and acceleration of the tip's target at time t."""
        s, ds, dds = self.shape(t)
        return self.start.translation + s * self.way, ds * self.way, dds * self.way

#!/usr/bin/env python3
"""Writes the reference kinematics that the robot crate is tested against, computed by Pinocchio.

Needs the PyPI packages `pin` and `numpy` (`pip install pin numpy`).  From the repository root:

    python3 robot/tests/oracle/pinocchio_oracle.py

reads examples/robots/{canopies,arm7}.urdf and writes robot/tests/data/oracle_*.json, one file for
a robot and a kind of base.  The same seed gives the same configurations on every run.

File: {"pinocchio", "urdf", "base", "joints", "velocities", "configurations"}; a configuration is
{"q", "joints", "links": {name: {"p", "R", "J"}}}.

- base     "fixed", "planar" or "floating": what joins base_link to the world.
- joints   names of the entries of q that belong to the file's joints, in Pinocchio's order (depth
           first; brothers by the name of the joint, as urdfdom sorts them).
- q        fixed: the joints.  planar: x, y, yaw, then the joints.  floating: x, y, z, then the
           unit quaternion w, x, y, z, then the joints.  m, rad.
- p, R     origin [m] and rotation of the link in the world: a point is p + R * (its local place).
- J        6 x nv, linear rows first, then angular, in axes of the world at the link's origin
           (LOCAL_WORLD_ALIGNED).  Columns as in `velocities`: the base's columns come first and
           are rates of the base along the axes of base_link itself (planar: vx, vy, yaw rate;
           floating: vx, vy, vz, wx, wy, wz).  A unicycle base has columns 0 and 2 of the planar.

Numbers are written so that they read back exactly, except that those below 1e-15 become 0.
"""
import json
from pathlib import Path

import numpy as np
import pinocchio as pin

ROOT = Path(__file__).resolve().parents[3]
DATA = ROOT / "robot" / "tests" / "data"
ROOTS = {"fixed": None, "planar": pin.JointModelPlanar, "floating": pin.JointModelFreeFlyer}
BASE_Q = {
    "fixed": [],
    "planar": ["x", "y", "yaw"],
    "floating": ["x", "y", "z", "qw", "qx", "qy", "qz"],
}
BASE_V = {"fixed": [], "planar": ["vx", "vy", "wz"], "floating": ["vx", "vy", "vz", "wx", "wy", "wz"]}
CANOPIES = [
    "torso_column_link", "torso_link", "head_link", "head_camera", "arm_left_4_link",
    "left_forearm", "left_tool", "arm_right_6_link", "right_tool",
]
ARM7 = ["link_2", "link_4", "link_6", "tool"]
FILES = [
    ("oracle_canopies", "canopies", "fixed", CANOPIES, 1),
    ("oracle_canopies_planar", "canopies", "planar", CANOPIES, 2),
    ("oracle_canopies_floating", "canopies", "floating", CANOPIES, 3),
    ("oracle_arm7", "arm7", "fixed", ARM7, 4),
]
COUNT = 12


def random_configuration(base, lower, upper, rng):
    """A random configuration: as this project writes it, and as Pinocchio does."""
    joints = rng.uniform(lower, upper)
    if base == "fixed":
        return joints, joints
    place = rng.uniform(-2.0, 2.0, size=2 if base == "planar" else 3)
    if base == "planar":
        yaw = rng.uniform(-3.1, 3.1)
        ours = np.concatenate([place, [yaw], joints])
        theirs = np.concatenate([place, [np.cos(yaw), np.sin(yaw)], joints])
        return ours, theirs
    w, x, y, z = (lambda u: u / np.linalg.norm(u))(rng.normal(size=4))
    ours = np.concatenate([place, [w, x, y, z], joints])
    theirs = np.concatenate([place, [x, y, z, w], joints])
    return ours, theirs


def plain(array):
    """Nested lists of floats, rounding noise removed."""
    array = np.where(np.abs(array) < 1e-15, 0.0, array)
    return array.tolist()


def link_data(model, data, link):
    """Pose and Jacobian of one link at the configuration that `data` holds."""
    frame = model.getFrameId(link, pin.FrameType.BODY)
    if frame >= model.nframes:
        raise SystemExit(f"no link {link}")
    pose = data.oMf[frame]
    jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
    return {"p": plain(pose.translation), "R": plain(pose.rotation), "J": plain(jacobian)}


def oracle(robot, base, links, seed):
    """The content of one file."""
    urdf = f"examples/robots/{robot}.urdf"
    fixed = pin.buildModelFromUrdf(str(ROOT / urdf))
    joints = list(fixed.names)[1:]
    root = ROOTS[base]
    model = fixed if root is None else pin.buildModelFromUrdf(str(ROOT / urdf), root())
    if list(model.names)[-len(joints):] != joints:
        raise SystemExit("the order of the joints depends on the base")
    data = model.createData()
    rng = np.random.default_rng(seed)
    configurations = []
    for _ in range(COUNT):
        ours, theirs = random_configuration(
            base, fixed.lowerPositionLimit, fixed.upperPositionLimit, rng
        )
        pin.computeJointJacobians(model, data, theirs)
        pin.updateFramePlacements(model, data)
        configurations.append({
            "q": ours.tolist(),
            "joints": BASE_Q[base] + joints,
            "links": {link: link_data(model, data, link) for link in links},
        })
    return {
        "pinocchio": pin.__version__,
        "urdf": urdf,
        "base": base,
        "joints": joints,
        "velocities": BASE_V[base] + joints,
        "configurations": configurations,
    }


def main():
    DATA.mkdir(parents=True, exist_ok=True)
    for name, robot, base, links, seed in FILES:
        path = DATA / f"{name}.json"
        text = json.dumps(oracle(robot, base, links, seed), separators=(",", ":"))
        path.write_text(text + "\n")
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()

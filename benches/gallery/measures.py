"""What a trace is judged by. Nothing here knows which controller it came from."""

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize

from motions import STILL

TURN = 0.01  # share of the speed limit below which a joint counts as one that stands
SHORT = 0.2  # s; two turns less than this apart are a reversal
REST = 0.01  # share of the speed limit
NEAR = 1e-3  # m


def jumps(motion, trace):
    """How many ticks have a change of some joint's velocity beyond its acceleration limit, and the largest acceleration
    as a multiple of the limit."""
    ratio = np.abs(np.diff(trace.v, axis=0, prepend=0 * trace.v[:1])) * motion.rate / motion.robot.acceleration
    return int((ratio > 1.001).any(axis=1).sum()), float(ratio.max())


def reversals(motion, trace):
    """How often a joint turns and back again within 0.2 s, all joints together."""
    count = 0
    for velocity, limit in zip(trace.v.T, motion.robot.speed):
        side = np.where(velocity > TURN * limit, 1, np.where(velocity < -TURN * limit, -1, 0))
        moving = np.flatnonzero(side)
        turns = trace.t[moving[1:]][side[moving[1:]] != side[moving[:-1]]]
        count += int((np.diff(turns) < SHORT - 1e-9).sum())
    return count


def passed(motion, trace):
    """How far positions and speeds are beyond their limits at most, as a share of the speed limit (positions: in rad or m)."""
    robot = motion.robot
    beyond = max((robot.lower - trace.q).max(), (trace.q - robot.upper).max(), 0.0)
    return max(float(beyond), float((np.abs(trace.v) / robot.speed).max() - 1.0), 0.0)


def errors(motion, trace):
    """The distance of the tip from its target at each tick, in m."""
    robot, data = motion.robot, motion.robot.model.createData()
    frame = robot.model.getFrameId(robot.tip)
    found = []
    for t, q in zip(trace.t, trace.q):
        pin.framesForwardKinematics(robot.model, data, q)
        found.append(np.linalg.norm(data.oMf[frame].translation - motion.target(t)[0]))
    return np.array(found)


def nearest(motion, q):
    """The distance of the tip from a still target at the nearest point of its reach that L-BFGS finds from q, in m."""
    robot, data = motion.robot, motion.robot.model.createData()
    frame, target = robot.model.getFrameId(robot.tip), motion.target(1.0)[0]
    def cost(x):
        pin.computeJointJacobians(robot.model, data, x)
        pin.updateFramePlacements(robot.model, data)
        e = data.oMf[frame].translation - target
        return 0.5 * e @ e, pin.getFrameJacobian(robot.model, data, frame, pin.LOCAL_WORLD_ALIGNED)[:3].T @ e
    box = list(zip(robot.lower, robot.upper))
    found = minimize(cost, np.clip(q, robot.lower, robot.upper), jac=True, bounds=box, method="L-BFGS-B",
                     options={"maxiter": 2000, "ftol": 1e-16, "gtol": 1e-10})
    return float(np.sqrt(2 * found.fun))


def judge(motion, trace):
    """All of it, as a dictionary that JSON can hold."""
    over, largest = jumps(motion, trace)
    found = {"jumps": over, "acceleration": largest, "reversals": reversals(motion, trace), "passed": passed(motion, trace)}
    distance = errors(motion, trace)
    if motion.kind in STILL:
        last = trace.v[-max(1, int(0.5 * motion.rate)):]
        found["moving"] = bool((np.abs(last) > REST * motion.robot.speed).any())
        if not motion.pose:
            best = nearest(motion, trace.q[-1])
            found["short"] = float(distance[-1] - best)
            outside = np.flatnonzero(distance > distance[-1] + NEAR)
            found["time"] = float(trace.t[outside[-1]]) if len(outside) else 0.0
    if motion.kind == "small":
        found["error"] = float(distance[motion.rate:].mean())
    return found

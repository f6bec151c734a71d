"""Solves the first program of an exploration with HiGHS, written anew from the paper, and compares the cost with that of Hierarq.

`pip install highspy highsbox`, then `python3 mission/examples/explore_highs.py HIERARQ SPEC [SECONDS]`, where HIERARQ is the program and the mission of
the spec has `engine highs`. Everything is computed from the problem as `compile --format json` has it and from the expected way in the plan.

The formulation is that of (10a) to (10p) with one binary for each side of each obstacle, where Hierarq has parts of the free ground; like Hierarq it holds
between samples (three points of a motion), keeps out of wherever the person can walk in each period, and counts delay and the reserve.
Robots start at rest, so that the constraints of the first period are the plain ones. Dynamics: acceleration.
"""

import json
import subprocess
import sys

import highspy
import numpy as np

DELAY, RESERVE_COST, RESERVE = 0.004, 4.0, 0.3
LIMIT = 1e3  # of positions and velocities, beyond every one that occurs


def hierarq(*arguments):
    done = subprocess.run([sys.argv[1], *arguments], capture_output=True, text=True)
    return json.loads(done.stdout)


def faces(corners):
    """Half-planes `n . x <= b` of a convex polygon whose corners run counter-clockwise, as pairs `(n, b)`."""
    out = []
    for a, b in zip(np.array(corners), np.roll(np.array(corners), -1, axis=0)):
        edge = b - a
        normal = np.array([edge[1], -edge[0]]) / np.hypot(*edge)
        out.append((normal, normal @ a))
    return out


def reach(points, normal):
    """The support of a set of points along a direction."""
    return max(np.array(points) @ normal)


def directions(*polygons):
    """Normals of the Minkowski sum of polygons."""
    found = []
    for polygon in polygons:
        for normal, _ in faces(polygon):
            if all(np.abs(normal - other).max() > 1e-9 for other in found):
                found.append(normal)
    return found


spec, seconds = sys.argv[2], float(sys.argv[3]) if len(sys.argv) > 3 else 600.0
problem = next(m["explore"]["problem"] for m in hierarq("compile", "--format", "json", spec)["missions"])
plan = hierarq("plan", spec, "--json")
T, robots, targets = problem["period"], problem["robots"], problem["targets"]
person = problem["person"]
walk = [a for a in plan["activities"] if a["agent"] == person["name"]]
way = [walk[0]["way"][0]] + [at for part in walk for at in part["way"][1:]]
taken = {a["target"] for a in walk if a.get("target")}
N = len(way) - 1
strides = person["speed"] * T * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
assert all(robot["dynamics"] == "acceleration" for robot in robots)

h = highspy.Highs()
h.setOptionValue("output_flag", False)
h.setOptionValue("time_limit", seconds)
h.setOptionValue("mip_rel_gap", problem["planner"]["gap"])
cost = 0


def real(low=-LIMIT, high=LIMIT):
    return h.addVariable(lb=low, ub=high)


def binary():
    return h.addVariable(lb=0, ub=1, type=highspy.HighsVarType.kInteger)


def along(normal, point):
    return sum(float(n) * x for n, x in zip(normal, point) if abs(n) > 1e-12)


motions = []
for robot in robots:
    at = [robot["start"]]
    speed = [[0.0, 0.0]]
    pieces = []
    for k in range(N):
        u = [real(-robot["acceleration"], robot["acceleration"]) for _ in range(2)]
        for x in u:
            size = real(0.0)
            h.addConstr(size - x >= 0)
            h.addConstr(size + x >= 0)
            cost += problem["effort"] * size
        new, fast = [real(), real()], [real(-robot["speed"], robot["speed"]) for _ in range(2)]
        for i in range(2):
            h.addConstr(new[i] - u[i] * (0.5 * T * T) - T * speed[k][i] - at[k][i] == 0)
            h.addConstr(fast[i] - u[i] * T - speed[k][i] == 0)
        middle = [at[k][i] + (0.5 * T) * speed[k][i] for i in range(2)]
        pieces.append([at[k], middle, new])
        at.append(new)
        speed.append(fast)
    for x in speed[N]:
        h.addConstr(1.0 * x == 0)
    motions.append(pieces)

span = 2.0 * np.ptp(np.array(problem["area"]), axis=0).max()  # big M of positions
for robot, pieces in zip(robots, motions):
    for k, three in enumerate(pieces):
        for normal, bound in faces(problem["area"]):
            # The start is within the region: of the first period the end alone is a constraint.
            for point in three[1:] if k else three[2:]:
                h.addConstr(along(normal, point) <= bound - reach(robot["body"], normal))
        for obstacle in problem["obstacles"]:
            sides = []
            back = -np.array(robot["body"])
            for normal in directions(obstacle["shape"], back):
                z = binary()
                sides.append(z)
                bound = reach(obstacle["shape"], normal) + reach(back, normal)
                for point in three[1:]:
                    h.addConstr(along(normal, point) - 2 * span * z >= bound - 2 * span)
            h.addConstr(sum(sides) >= 1)
        sides = []
        back = -np.array(robot["body"])
        short = real(0.0, RESERVE * person["speed"] * T) if k == 0 else None
        if k == 0:
            cost += RESERVE_COST * short
        for normal in directions(person["body"], back, strides):
            z = binary()
            sides.append(z)
            share = [0.0, 0.5, 1.0]
            for part, point in zip(share[1:], three[1:]):
                bound = normal @ way[k] + reach(person["body"], normal) + reach(back, normal) + part * reach(strides, normal)
                row = along(normal, point) - 2 * span * z
                if k == 0 and part == 1.0:
                    h.addConstr(row + short >= bound - 2 * span + RESERVE * person["speed"] * T)
                else:
                    h.addConstr(row >= bound - 2 * span)
        h.addConstr(sum(sides) >= 1)

links = {}
for k in range(N):
    for i in range(len(robots)):
        for j in range(i):
            sides = []
            back = -np.array(robots[j]["body"])
            for normal in directions(robots[i]["body"], back):
                z = binary()
                sides.append(z)
                bound = reach(-np.array(robots[i]["body"]), normal) + reach(-back, normal)
                for p, q in zip(motions[i][k][1:], motions[j][k][1:]):
                    h.addConstr(along(normal, p) - along(normal, q) - 4 * span * z >= bound - 4 * span)
            h.addConstr(sum(sides) >= 1)
            z = links[i, j, k] = links[j, i, k] = binary()
            for normal, bound in faces(problem["connection"]):
                for p, q in zip(motions[i][k][1:], motions[j][k][1:]):
                    h.addConstr(along(normal, p) - along(normal, q) + 4 * span * z <= bound + 4 * span)
    sees = []
    lack = real(0.0, RESERVE * person["speed"] * T) if k == 0 else None
    if k == 0:
        cost += RESERVE_COST * lack
    for i in range(len(robots)):
        z = binary()
        sees.append(z)
        for normal, bound in faces(problem["connection"]):
            for part, p in zip([0.5, 1.0], motions[i][k][1:]):
                row = along(normal, p) + 4 * span * z
                right = bound + normal @ way[k] - part * reach(strides, normal) + 4 * span
                if k == 0 and part == 1.0:
                    h.addConstr(row - lack <= right - RESERVE * person["speed"] * T)
                else:
                    h.addConstr(row <= right)
    h.addConstr(sum(sees) >= 1)
    for i in range(len(robots)):
        for j in range(i):
            degree = [sum(links[m, n, k] for n in range(len(robots)) if n != m) for m in (i, j)]
            h.addConstr(degree[0] + degree[1] >= len(robots))

for target in targets:
    if target["name"] in taken:
        continue
    once = []
    for pieces in motions:
        for k in range(N):
            z = binary()
            once.append(z)
            cost += -target["worth"] * (1 - DELAY * (k + 1)) * z
            for normal, bound in faces(target["shape"]):
                h.addConstr(along(normal, pieces[k][2]) + 2 * span * z <= bound + 2 * span)
    h.addConstr(sum(once) <= 1)

h.minimize(cost)
own, bound = h.getInfo().objective_function_value, h.getInfo().mip_dual_bound
given, given_bound = plan["cost"]["total"], plan["status"].get("gap", {}).get("bound", plan["cost"]["total"])
print(f"{spec}: HiGHS {own:.4f} (bound {bound:.4f}), Hierarq {given:.4f} (bound {given_bound:.4f})")
# Neither bound may be above the cost of the other one, but for the tolerances of both.
slack = 0.01 * max(1.0, abs(own))
sys.exit(0 if bound <= given + slack and given_bound <= own + slack else 1)

"""Solves what `schedules_outside` prints with OR-Tools CP-SAT and compares the costs. `pip install ortools`.

Everything is computed from the problem alone: durations (5.12c), ways and energies (5.2) to (5.4), scales, cost (5.5).
"""

import json
import math
import statistics
import sys

from ortools.sat.python import cp_model

TICKS = 10**3  # of a second
UNITS = 10**10  # of the cost


def energy(robot, length, time):
    """(5.3): what a way takes."""
    e = robot["energy"]
    return 0.0 if length == 0 else e["standby"] * time + e["friction"] * length + e["drag"] * length**2 / time


def ways(problem, robot, agent):
    """Lengths of going, proximity and depositing, and the speeds of the first and the second."""
    (x, y), (u, v) = robot["depot"], agent["place"]
    back, near = math.hypot(x - u, y - v), agent["wait_distance"]
    slow, fast = robot["speed"]["low"], robot["speed"]["high"]
    assert slow == fast and not agent["approaches"]
    # Whatever is asked of the approach is held within the cruising speeds.
    return (abs(back - near), near, back), slow


def solve(problem):
    robots, agents, weights = problem["robots"], problem["agents"], problem["weights"]
    assert problem["distances"] == "straight" and not problem["begun"] and problem["scales"] is None
    most = [max(ways(problem, r, a)[0][k] for r in robots for a in agents) for k in range(3)]
    slowest, fastest = min(r["speed"]["low"] for r in robots), max(r["speed"]["high"] for r in robots)
    count = sum(a["operations"] for a in agents)
    longest = max(r["serve"] for r in robots) + max(r["deposit"] for r in robots)
    scale_end = count * sum(most) / slowest + count * longest
    scale_wait = (most[0] + most[1]) / slowest

    def worst(length):
        power = lambda e: e["standby"] * length / slowest + e["friction"] * length + e["drag"] * fastest * length
        return max(power(r["energy"]) for r in robots)

    scale_energy = [worst(length) for length in most]

    model = cp_model.CpModel()
    quantile = statistics.NormalDist().inv_cdf(problem["confidence"])
    tick = lambda seconds: round(seconds * TICKS)
    horizon = tick(sum(a["operations"] * (a["duration"]["mean"] * 3) for a in agents) + 2 * scale_end)
    cost, busy = [], [[] for _ in robots]
    end = model.new_int_var(0, horizon, "")
    price = lambda per_second: round(per_second * UNITS / TICKS)
    for agent in agents:
        lasts = tick(agent["duration"]["mean"] + quantile * agent["duration"]["sigma"])
        ends = lasts
        for operation in range(agent["operations"]):
            serving = model.new_int_var(0, horizon, "")
            served = model.new_int_var(0, horizon, "")
            model.add(serving >= ends)
            chosen = []
            for number, robot in enumerate(robots):
                lengths, speed = ways(problem, robot, agent)
                going, near, back = (length / speed for length in lengths)
                here = model.new_bool_var("")
                chosen.append(here)
                first, last = tick(going + near), tick(robot["serve"] + back + robot["deposit"])
                model.add(serving >= first).only_enforce_if(here)
                model.add(served == serving + tick(robot["serve"])).only_enforce_if(here)
                model.add(end >= serving + last).only_enforce_if(here)
                leaves = model.new_int_var(-horizon, horizon, "")
                model.add(leaves == serving - first)
                busy[number].append(model.new_optional_fixed_size_interval_var(leaves, first + last, here, ""))
                zeta = agent["approach_weights"][operation] if agent["approach_weights"] else 1.0
                parts = [energy(robot, length, length / speed) for length in lengths]
                parts = [part / scale if scale > 0 else 0.0 for part, scale in zip(parts, scale_energy)]
                parts[1] *= zeta
                cost.append(round(weights["energy"] / 3 * sum(parts) * UNITS) * here)
            model.add_exactly_one(chosen)
            human = agent["kind"] == "human"
            alpha = agent["wait_weights"][operation] if human and agent["wait_weights"] else 1.0
            alpha = alpha if human else weights["worker_wait"]
            final = operation + 1 == agent["operations"]
            # The agent begins again once it has been served; after its last operation it waits until it is served.
            cost.append(price(alpha / scale_wait) * ((serving if final else served) - ends))
            ends = served + lasts
    for intervals in busy:
        model.add_no_overlap(intervals)
    cost.append(price(weights["makespan"] / scale_end) * end)
    model.minimize(sum(cost))
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = 30
    solver.parameters.num_workers = 1
    status = solver.solve(model)
    return solver.objective_value / UNITS, solver.best_objective_bound / UNITS, status == cp_model.OPTIMAL, solver.wall_time


wrong = count = open_there = 0
for line in sys.stdin:
    given = json.loads(line)
    found, bound, proven, seconds = solve(given["problem"])
    open_there += not proven
    near = abs(found - given["cost"]) <= 2e-4 * max(found, 1e-9)
    # What CP-SAT has not proven in time is not better, and its bound not above.
    between = bound * (1 - 2e-4) <= given["cost"] <= found * (1 + 2e-4)
    good = given["proven"] and (near if proven else between)
    count += 1
    wrong += not good
    shape = f"{len(given['problem']['agents'])} agents, {len(given['problem']['robots'])} robots"
    print(
        f"seed {given['seed']}: {shape}, {given['by']} {given['cost']:.6f}, CP-SAT {found:.6f} "
        f"{'proven' if proven else 'open'} in {seconds:.2f} s{'' if good else '  DIFFERENT'}"
    )
print(f"{count} problems, {wrong} different, {open_there} not proven by CP-SAT in time")
sys.exit(wrong > 0)

"""Solves what `layers_outside` prints with OR-Tools CP-SAT and compares the costs. `pip install ortools`."""

import json
import sys

from ortools.sat.python import cp_model

TICKS = 10**5  # of a second
UNITS = 10**12  # of the cost

wrong = 0
count = 0
open_there = 0
for line in sys.stdin:
    problem = json.loads(line)
    model = cp_model.CpModel()
    layers = 1 + max(task["layer"] for task in problem["tasks"])
    horizon = sum(int(max(mode[2] for mode in task["modes"]) * TICKS) + 1 for task in problem["tasks"])
    cost, used, busy = [], {}, {}
    ends = [model.new_int_var(0, horizon, "") for _ in range(layers)]
    for task in problem["tasks"]:
        layer = task["layer"]
        choices = []
        for agent, thing, time, price in task["modes"]:
            chosen = model.new_bool_var("")
            length = round(time * TICKS)
            start = model.new_int_var(0, horizon, "")
            interval = model.new_optional_fixed_size_interval_var(start, length, chosen, "")
            if layer > 0:
                model.add(start >= ends[layer - 1]).only_enforce_if(chosen)
            model.add(start + length <= ends[layer]).only_enforce_if(chosen)
            busy.setdefault(agent, []).append(interval)
            if thing >= 0:
                used.setdefault(thing, []).append(chosen)
            cost.append(round(price * UNITS) * chosen)
            choices.append(chosen)
        model.add_exactly_one(choices)
    for chosen in used.values():
        model.add_at_most_one(chosen)
    for intervals in busy.values():
        model.add_no_overlap(intervals)
    for before, after in zip(ends, ends[1:]):
        model.add(before <= after)
    model.minimize(sum(cost) + round(problem["second"] * UNITS / TICKS) * ends[-1])
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = 20
    solver.parameters.num_workers = 1
    status = solver.solve(model)
    found = solver.objective_value / UNITS
    off = abs(found - problem["cost"]) / max(abs(found), 1e-9)
    proven = status == cp_model.OPTIMAL
    open_there += not proven
    # What CP-SAT has not proven in time must not be better, and its bound not above.
    bound = solver.best_objective_bound / UNITS
    between = bound * (1 - 1e-4) <= problem["cost"] <= found * (1 + 1e-4)
    good = problem["proven"] and (off < 1e-4 if proven else between)
    count += 1
    wrong += not good
    print(
        f"seed {problem['seed']}: {len(problem['tasks'])} tasks, branch and bound {problem['cost']:.6f}, "
        f"CP-SAT {found:.6f} {solver.status_name(status)} in {solver.wall_time:.2f} s{'' if good else '  DIFFERENT'}"
    )
print(f"{count} problems, {wrong} different, {open_there} not proven by CP-SAT in time")
sys.exit(wrong > 0)

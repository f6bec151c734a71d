"""What a tick costs from Python: `controller.step` beside the same ticks in Rust, and a batch beside one thread.

    pip install ./python
    python python/examples/cost_of_a_call.py
"""

import os
import time
from pathlib import Path

import numpy as np

import hierarq

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def figures(times: list[float]) -> str:
    low, high, worst = np.percentile(times, [50, 99, 100]) * 1e6
    return f"median {low:6.1f} us   99 % {high:6.1f} us   worst {worst:7.1f} us"


def steps(program: hierarq.Program, ticks: int) -> list[float]:
    """Times of single steps (s) along the run of the spec."""
    controller = program.controller()
    q = program.robot.home
    times = []
    for _ in range(ticks):
        before = time.perf_counter()
        command = controller.step(q)
        times.append(time.perf_counter() - before)
        q = command.position
    return times


def batch(program: hierarq.Program, n: int, threads: int, ticks: int) -> list[float]:
    """Times of steps of a batch (s)."""
    robots = program.batch(n, threads=threads)
    q = np.tile(program.robot.home, (n, 1))
    times = []
    for _ in range(ticks):
        before = time.perf_counter()
        robots.step(q)
        times.append(time.perf_counter() - before)
        q = robots.position
    return times


if __name__ == "__main__":
    for name in ("hello", "safety_tasks"):
        program = hierarq.load(EXAMPLES / f"{name}.hq")
        ticks = round(program.duration / program.period)
        one = batch(program, 1, 1, ticks)
        called = steps(program, ticks)
        print(f"{name}: step            {figures(called)}")
        print(f"{name}: batch of one    {figures(one)}")
    cores = os.cpu_count() or 1
    program = hierarq.load(EXAMPLES / "safety_tasks.hq")
    # In turn, so that a change of the machine's clock meets both.
    alone, together = [], []
    for _ in range(5):
        alone += batch(program, 1000, 1, 20)
        together += batch(program, 1000, cores, 20)
    share = np.median(alone) / np.median(together) / cores
    print(f"1,000 robots, 1 thread        {figures(alone)}")
    print(f"1,000 robots, {cores} threads       {figures(together)}")
    print(f"that is {100 * share:.0f} % of {cores} cores")

#!/usr/bin/env python3
"""How `check`, a tick and the memory of a run grow with the size of a spec: joints, levels, rows, states.

    cargo build --release
    python3 benches/sizes/sizes.py [--program target/release/hierarq] [NAME ..]

Writes a chain of joints as a URDF and a spec for each size into a folder of its own, and prints a table in Markdown. Times are those
of one process after the other; a size that is refused shows its code. Linux, Python 3.9, no packages.
"""

import argparse
import json
import os
import re
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def urdf(joints):
    """A chain of revolute joints about x, y, z in turn, 2 m long whatever their number."""
    parts = ['<robot name="chain"><link name="link_0"/>']
    axes = ["1 0 0", "0 1 0", "0 0 1"]
    for i in range(1, joints + 1):
        parts.append(
            f'<link name="link_{i}"/><joint name="joint_{i}" type="revolute"><parent link="link_{i - 1}"/>'
            f'<child link="link_{i}"/><origin xyz="0 0 {2 / joints:.6f}"/><axis xyz="{axes[i % 3]}"/>'
            f'<limit lower="-2.5" upper="2.5" velocity="2" effort="10"/></joint>'
        )
    return "".join(parts) + "</robot>"


def robot(joints):
    home = " ".join(f"joint_{i} {0.3 * (-1) ** i:.1f} rad" for i in range(1, joints + 1, max(1, joints // 12)))
    points = " ".join(f"p{i} link_{i}" for i in range(1, joints + 1))
    return f'hierarq 1\nrobot chain {{\n  urdf "chain_{joints}.urdf"  rate 100 Hz\n  home {{ {home} }}\n  points {{ {points} }}\n}}\n'


LIMITS = "  level limits hard { joint_position_limits joint_velocity_limits joint_acceleration_limits }\n"


def motion(joints):
    """A hand that goes to and fro, and a posture below."""
    return (
        f"  level hand {{ frame_position(link_{joints}) {{ position initial(position) + [0.1, 0.1, -0.1] m * sin(2*pi*t/(4 s)) }} }}\n"
        "  level posture { joint_position { target 0 rad  gain 0.5 /s } }\n"
    )


def of_joints(joints):
    return joints, robot(joints) + "stack s {\n" + LIMITS + motion(joints) + "}\nrun { duration 5 s }\n"


def of_levels(joints, levels):
    """Levels that can all be met, each with joints of its own, below that of limits."""
    text = robot(joints) + "stack s {\n" + LIMITS
    each = joints // (levels - 1)
    for k in range(levels - 1):
        targets = " ".join(f"joint_{k * each + i} 0.3 rad * sin(2*pi*t/({4 + k % 5} s))" for i in range(1, each + 1))
        text += f"  level l{k} {{ joint_position {{ target {{ {targets} }} }} }}\n"
    return joints, text + "}\nrun { duration 5 s }\n"


def of_fights(joints, levels):
    """Levels that ask links along the chain for more than the joints before them can do."""
    text = robot(joints) + "stack s {\n" + LIMITS
    for k in range(levels - 2):
        goal = f"initial(position) + [0.02, 0, 0] m * sin(2*pi*t/({3 + k % 5} s))"
        text += f"  level l{k} {{ frame_position(link_{3 + k * 7 % (joints - 3)}) {{ position {goal} }} }}\n"
    return joints, text + "  level posture { joint_position { target 0 rad  gain 0.5 /s } }\n}\nrun { duration 5 s }\n"


def of_rows(joints, rows):
    """Walls far around the links of the chain: rows that never become active."""
    tasks = []
    points = [f"p{1 + i % joints}" for i in range(rows)]
    walls = [points[i : i + joints] for i in range(0, rows, joints)]
    for k, names in enumerate(walls):
        z = -3 - 0.01 * k
        tasks.append(
            f"virtual_wall({', '.join(names)}) {{ through [[0, 0, {z:.2f}], [1, 0, {z:.2f}], [0, 1, {z:.2f}]] m  d_min 0 m }}"
        )
    text = robot(joints) + "stack s {\n" + LIMITS + "  level walls hard {\n    " + "\n    ".join(tasks) + "\n  }\n"
    return joints, text + motion(joints) + "}\nrun { duration 2 s }\n"


def of_states(joints, states):
    """A machine that goes round all its states, one stack for all of them."""
    text = robot(joints) + "stack s {\n" + LIMITS + motion(joints) + "}\nmachine m {\n  initial s0\n"
    text += "  on fault(any) -> halted\n  final state halted { stack s }\n"
    for i in range(states):
        text += f"  state s{i} {{ stack s  after 30 ms -> s{(i + 1) % states} }}\n"
    return joints, text + "}\nrun { machine m  duration 5 s }\n"


SIZES = {
    "7 joints": lambda: of_joints(7),
    "60 joints": lambda: of_joints(60),
    "100 joints": lambda: of_joints(100),
    "200 joints": lambda: of_joints(200),
    "60 joints, 6 levels": lambda: of_levels(60, 6),
    "60 joints, 11 levels": lambda: of_levels(60, 11),
    "60 joints, 21 levels": lambda: of_levels(60, 21),
    "60 joints, 5 levels that fight": lambda: of_fights(60, 5),
    "60 joints, 20 levels that fight": lambda: of_fights(60, 20),
    "60 joints, 500 rows of walls": lambda: of_rows(60, 500),
    "60 joints, 1,000 rows of walls": lambda: of_rows(60, 1000),
    "60 joints, 1,500 rows of walls": lambda: of_rows(60, 1500),
    "60 joints, 5,000 rows of walls": lambda: of_rows(60, 5000),
    "7 joints, 500 states": lambda: of_states(7, 500),
    "7 joints, 4,000 states": lambda: of_states(7, 4000),
}


def process(arguments, folder):
    """What it said, its exit code, its seconds of processor, and its memory in MiB."""
    out = open(os.path.join(folder, "said"), "wb+")
    child = subprocess.Popen(arguments, stdout=out, stderr=subprocess.STDOUT, cwd=folder)
    _, status, used = os.wait4(child.pid, 0)
    out.seek(0)
    return out.read().decode(errors="replace"), os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.path.join(ROOT, "target/release/hierarq"))
    parser.add_argument("--keep", help="the folder for specs and robots, which is then kept")
    parser.add_argument("names", nargs="*")
    given = parser.parse_args()
    folder = given.keep or tempfile.mkdtemp(prefix="hierarq-sizes-")
    os.makedirs(folder, exist_ok=True)
    print("| | check | tick, median / p99 / worst (µs) | a run of so many seconds, processor time | memory of `check` / of the run |")
    print("|---|---:|---:|---:|---:|")
    for name, make in SIZES.items():
        if given.names and name not in given.names:
            continue
        joints, text = make()
        with open(os.path.join(folder, f"chain_{joints}.urdf"), "w") as file:
            file.write(urdf(joints))
        spec = os.path.join(folder, re.sub(r"\W+", "_", name) + ".hq")
        with open(spec, "w") as file:
            file.write(text)
        said, code, checked, small = process([given.program, "check", spec], folder)
        if code != 0:
            print(f"| {name} | refused: {', '.join(sorted(set(re.findall('HQ[0-9]{4}', said)))) or said.strip()} | | | |")
            continue
        said, code, seconds, memory = process([given.program, "run", spec, "--out", os.path.join(folder, "out"), "--json"], folder)
        summary = json.load(open(os.path.join(folder, "out", "summary.json")))
        tick = summary["tick_us"]
        failed = "" if code == 0 else f" (exit {code})"
        print(
            f"| {name}{failed} | {checked:.2f} s | {tick['median']:.0f} / {tick['p99']:.0f} / {tick['max']:.0f} "
            f"| {summary['duration_s']:.0f} s: {seconds:.1f} s | {small:.0f} / {memory:.0f} MiB |",
            flush=True,
        )


if __name__ == "__main__":
    main()

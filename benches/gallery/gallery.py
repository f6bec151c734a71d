"""Puts Hierarq, Pink and TSID through the same hard motions and writes the table of the book. `--help` says how."""

import argparse
from concurrent.futures import ProcessPoolExecutor
import json
import os
from pathlib import Path
import tempfile

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from controllers import CONTROLLERS
from measures import NEAR, judge
from motions import KINDS, Motion, robots

BOOK = Path(__file__).resolve().parents[2] / "docs/src/robots/hard_motion.md"
BEGIN, END = "<!-- table: begin -->\n", "<!-- table: end -->\n"


def run(job):
    robot, kind, seed, duration, controller, folder = job
    motion = Motion(run.robots[robot], kind, seed, duration)
    place = Path(folder) / f"{robot}-{kind}-{seed}-{len(controller)}".replace(" ", "_")
    result = {"robot": robot, "kind": kind, "seed": seed, "rate": motion.rate, "controller": controller}
    try:
        result |= judge(motion, CONTROLLERS[controller](motion, place))
    except Exception as e:  # A controller that gives up is a result.
        result["gave_up"] = f"{type(e).__name__}: {e}"[:600]
    return result


def prepare():
    run.robots = robots()


def share(of, total):
    return f"{of} of {total}" if total else ""


def table(results, robots, controllers):
    """One row a controller and robot."""
    head = ["", "robot", "gave up", "jumps beyond the limit: motions (ticks)", "largest acceleration / limit",
            "reversals: motions with more than 2 (most)", "still target: moving at the end", "more than 1 mm short of the nearest point",
            "time to it: median, s", "small: mean error, mm"]
    lines = ["| " + " | ".join(head) + " |", "|---|---|" + "---:|" * (len(head) - 2)]
    for controller in controllers:
        for robot in robots:
            all_ = [r for r in results if r["controller"] == controller and r["robot"] == robot]
            ran = [r for r in all_ if "gave_up" not in r]
            still, short = [r for r in ran if "moving" in r], [r for r in ran if "short" in r]
            small = [r["error"] for r in ran if "error" in r]
            jumping, turning = [r for r in ran if r["jumps"]], [r for r in ran if r["reversals"] > 2]
            lines.append("| " + " | ".join([
                controller, robot, share(len(all_) - len(ran), len(all_)),
                f"{len(jumping)} ({sum(r['jumps'] for r in jumping)})",
                f"{max((r['acceleration'] for r in ran), default=0):.3g}",
                f"{len(turning)} ({max((r['reversals'] for r in ran), default=0)})",
                share(sum(r["moving"] for r in still), len(still)),
                share(sum(r["short"] > NEAR for r in short), len(short)),
                f"{np.median([r['time'] for r in short]):.1f}" if short else "",
                f"{1e3 * np.mean(small):.2f}" if small else "",
            ]) + " |")
    return "\n".join(lines) + "\n"


def main():
    known = robots()
    args = argparse.ArgumentParser(description=__doc__)
    args.add_argument("--seeds", type=int, default=25, help=f"motions of each of the {len(KINDS)} kinds and robots")
    args.add_argument("--robots", nargs="+", default=list(known), choices=list(known))
    args.add_argument("--kinds", nargs="+", default=list(KINDS), choices=list(KINDS))
    args.add_argument("--controllers", nargs="+", default=list(CONTROLLERS), choices=list(CONTROLLERS))
    args.add_argument("--duration", type=float, default=Motion.duration, help="of each motion, in s")
    args.add_argument("--list", action="store_true", help="print the motions of Hierarq that are not smooth")
    args.add_argument("--json", type=Path, help="write every result there")
    args.add_argument("--keep", type=Path, help="folder for specs and logs; a temporary one otherwise")
    args.add_argument("--write", action="store_true", help=f"put the table into {BOOK.name}")
    args = args.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = str(args.keep or temporary)
        jobs = [(r, k, s, args.duration, c, folder) for c in args.controllers for r in args.robots for k in args.kinds for s in range(args.seeds)]
        with ProcessPoolExecutor(os.cpu_count(), initializer=prepare) as pool:
            results = []
            for result in pool.map(run, jobs, chunksize=4):
                results.append(result)
                bad = "gave_up" in result or result["jumps"] or result["reversals"] > 2 or result.get("moving") or result.get("short", 0) > NEAR
                if args.list and bad and result["controller"].startswith("Hierarq"):
                    print(json.dumps(result), flush=True)
    if args.json:
        args.json.write_text("\n".join(json.dumps(result) for result in results) + "\n")
    found = table(results, args.robots, args.controllers)
    print(found)
    if args.write:
        text = BOOK.read_text()
        before, rest = text.split(BEGIN)
        BOOK.write_text(before + BEGIN + found + END + rest.split(END)[1])


if __name__ == "__main__":
    main()

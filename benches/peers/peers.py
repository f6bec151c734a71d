"""Times solvers beside each other on the same problems, and whole ticks of controllers on the same robot.

    python benches/peers/peers.py [--ticks N] [--write]

Everything runs one after the other on this machine. `--write` puts the tables into the book.
"""

import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile

import numpy as np

import hierarchy
import ticks as whole

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGE = ROOT / "docs/src/internals/peers.md"

# Examples whose ticks are solved: what each is, and the spec.
STREAMS = {
    "cooperative motion, all of it can be met": "cooperative_motion",
    "3.A: limits and walls pressed": "safety_tasks",
    "hands that swap sides": "hard/swapping_hands",
    "three levels that fight": "hard/two_wishes",
    "an arm out of reach": "hard/out_of_reach",
}
# The ticks of this one once more in random order: every tick another state.
SHUFFLED = "hands that swap sides"


def hierarq(*arguments, well=(0,)):
    """The release build of this repository; exits that are well."""
    done = subprocess.run([ROOT / "target/release/hierarq", *arguments], cwd=ROOT, capture_output=True, text=True)
    if done.returncode not in well:
        raise RuntimeError(f"hierarq {' '.join(map(str, arguments))}: {done.stdout[-400:]}{done.stderr[-800:]}")
    return done.stdout


def library(folder):
    """`cascade.cpp` with the eiquadprog of the Python package."""
    prefix = next(pathlib.Path(p) / "cmeel.prefix" for p in sys.path if (pathlib.Path(p) / "cmeel.prefix/include/eiquadprog").is_dir())
    out = folder / "cascade.so"
    flags = ["-O3", "-DNDEBUG", "-std=c++17", "-shared", "-fPIC", f"-I{prefix}/include", "-I/usr/include/eigen3"]
    link = [f"-L{prefix}/lib", "-leiquadprog", f"-Wl,-rpath,{prefix}/lib"]
    subprocess.run(["g++", *flags, HERE / "cascade.cpp", "-o", out, *link], check=True)
    return out


def streams(folder, most):
    """Files of problems, by what they are; consecutive ticks but for the last."""
    files = {}
    for name, spec in STREAMS.items():
        file = folder / f"{len(files)}.jsonl"
        # A limit that is passed by what sampling in time loses is none of our business here.
        hierarq("run", f"examples/{spec}.hq", "--out", folder / "run", "--problems", file, well=(0, 1))
        lines = file.read_text().splitlines()[:most]
        file.write_text("\n".join(lines) + "\n")
        files[name] = file
    lines = files[SHUFFLED].read_text().splitlines()
    random.Random(1).shuffle(lines)
    file = folder / "shuffled.jsonl"
    file.write_text("\n".join(lines) + "\n")
    files["the same ticks in random order"] = file
    return files


def ours(file, folder, *flags):
    """Times and points of `hierarq solve`, and the worst residual of the certificate."""
    answers = folder / "answers.jsonl"
    told = json.loads(hierarq("solve", file, "--answers", answers, "--json", *flags))
    lines = [json.loads(line) for line in answers.read_text().splitlines()]
    assert all(line["status"] == "optimal" for line in lines), file
    proof = told["all"]["certificate"]["value"]
    return [line["us"] for line in lines], [np.array(line["x"]) for line in lines], proof


def figures(us):
    us = np.sort(us)
    return [us[len(us) // 2], us[int(0.99 * (len(us) - 1))], us[-1]]


def number(x):
    return f"{x:.0f}" if x >= 99.5 else f"{x:.2g}"


def solver_table(name, file, folder, peers):
    """The rows of one stream."""
    warm, best, proof = ours(file, folder)
    cold, _, _ = ours(file, folder, "--cold")
    problems = hierarchy.read(file)
    n, rows = problems[0][0].a.shape[1], [len(level.lower) for level in problems[0]]
    lines = [f"**{name}**: {len(problems)} ticks, {n} variables, levels of {' + '.join(map(str, rows))} rows; our answers hold the certificate to {proof:.0e}.", ""]
    lines += ["| | median µs | p99 | worst | median as a multiple of ours | a level worse by, median | at most | unsolved |", "|---|---:|---:|---:|---:|---:|---:|---:|"]
    base = figures(warm)[0]
    def row(label, us, points):
        found = [(levels, x, y) for levels, x, y in zip(problems, points, best) if x is not None]
        apart = np.sort([max(hierarchy.worse(*one), 0.0) for one in found]) if found else np.array([np.nan])
        cells = [number(v) for v in figures(us)] + [f"{figures(us)[0] / base:.1f}", f"{apart[len(apart) // 2]:.0e}", f"{apart[-1]:.0e}"]
        lines.append(f"| {label} | " + " | ".join(cells) + f" | {sum(x is None for x in points)} |")
        print(lines[-1], flush=True)
    print(lines[0])
    row("Hierarq", warm, best)
    row("Hierarq, cold", cold, best)
    for label, make in peers.items():
        peer = make()
        answers = [peer.solve(levels) for levels in problems]
        row(label, [us for _, us in answers], [x for x, _ in answers])
    return lines + [""]


def tick_table(most):
    lines = ["| | median µs | p99 | worst | median as a multiple of ours |", "|---|---:|---:|---:|---:|"]
    base = None
    for label, us in whole.measure(hierarq, most):
        base = base or us[0]
        lines.append(f"| {label} | " + " | ".join([number(v) for v in us] + [f"{us[0] / base:.1f}"]) + " |")
        print(lines[-1], flush=True)
    return lines + [""]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--ticks", type=int, default=1000, help="the most of each stream")
    options.add_argument("--write", action="store_true", help="put the tables into the book")
    options = options.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        shared = library(folder)
        peers = {
            "DAQP, its hierarchies": hierarchy.Daqp,
            "eiquadprog, a program a level": lambda: hierarchy.Eiquadprog(shared),
            "quadprog, a program a level": lambda: hierarchy.Programs(hierarchy.with_quadprog),
            "ProxQP, a program a level": lambda: hierarchy.Programs(hierarchy.WithProxQp()),
            "Clarabel, a program a level": lambda: hierarchy.Programs(hierarchy.with_clarabel),
        }
        tables = {"solvers": [], "ticks": tick_table(options.ticks)}
        for name, file in streams(folder, options.ticks).items():
            tables["solvers"] += solver_table(name, file, folder, peers)
    if options.write:
        page = PAGE.read_text()
        for part, lines in tables.items():
            begin, end = f"<!-- {part} -->\n", f"<!-- end of {part} -->"
            head, rest = page.split(begin)
            page = head + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1]
        PAGE.write_text(page)


if __name__ == "__main__":
    main()

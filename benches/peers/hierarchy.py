"""Hierarchies as `hierarq solve` reads them, and what other solvers make of them."""

import ctypes
import json
import time

import clarabel
import daqp
import numpy as np
import proxsuite
import quadprog
from scipy import sparse

# What a quadratic program needs to be strictly convex: as in `cascade.cpp`.
EPS = 1e-6

# Bounds that a level hands on are this much wider than what it reached: to rounding they contradict each other otherwise.
ROOM = 1e-8


class Level:
    """Rows `lower <= a x <= upper` of one priority, with weights."""

    def __init__(self, fields, n):
        bound = lambda values, none: np.array([none if v is None else v for v in values], float)
        rows = fields["A"]
        self.a = np.tile(np.eye(n), (rows["identity"], 1)) if isinstance(rows, dict) else np.array(rows, float).reshape(-1, n)
        self.lower, self.upper = bound(fields["lo"], -np.inf), bound(fields["up"], np.inf)
        self.weight = np.array(fields.get("weight") or np.ones(len(self.lower)), float)
        self.hard = bool(fields.get("hard"))
        self.equal = self.lower == self.upper


def read(path):
    """All problems of a file."""
    problems = []
    with open(path) as file:
        for line in file:
            fields = json.loads(line)
            problems.append([Level(level, fields["n"]) for level in fields["levels"]])
    return problems


class Programs:
    """The quadratic programs of a hierarchy, one a level, as a controller without a solver of hierarchies writes them; see
    `cascade.cpp`. `solve` takes (H, g, E, e, C, lower, upper) for `min x H x / 2 + g x, E x = e, lower <= C x <= upper` and
    gives the point, or none."""

    def __init__(self, solve):
        self.solve_program = solve

    def solve(self, levels):
        """The point, or none, and the CPU time in microseconds of all programs of the hierarchy, building apart."""
        n, us = levels[0].a.shape[1], 0.0
        x, equal, values = np.zeros(n), np.zeros((0, n)), np.zeros(0)
        above, lower, upper = np.zeros((0, n)), np.zeros(0), np.zeros(0)
        for number, level in enumerate(levels):
            wishes, limits = level.equal & (level.weight > 0), ~level.equal & (level.weight > 0)
            limits &= np.isfinite(level.lower) | np.isfinite(level.upper)
            if level.hard:
                equal, values = np.vstack([equal, level.a[level.equal]]), np.append(values, level.lower[level.equal])
                above = np.vstack([above, level.a[limits]])
                lower, upper = np.append(lower, level.lower[limits]), np.append(upper, level.upper[limits])
                continue
            if not wishes.any() and not limits.any():
                continue
            slacks = int(limits.sum())
            h, g = np.zeros((n + slacks, n + slacks)), np.zeros(n + slacks)
            a, w = level.a[wishes], level.weight[wishes]
            h[:n, :n] = a.T @ (w[:, None] * a) + EPS * np.eye(n)
            h[n:, n:] = np.diag(level.weight[limits])
            g[:n] = -a.T @ (w * level.lower[wishes])
            own = level.a[limits]
            c = np.block([[above, np.zeros((len(above), slacks))], [own, np.eye(slacks)]])
            e = np.hstack([equal, np.zeros((len(equal), slacks))])
            program = (h, g, e, values, c, np.append(lower, level.lower[limits]), np.append(upper, level.upper[limits]))
            begin = time.thread_time_ns()
            z = self.solve_program(number, *program)
            us += 1e-3 * (time.thread_time_ns() - begin)
            if z is None or not np.all(np.isfinite(z)):
                return None, us
            x = z[:n]
            equal, values = np.vstack([equal, a]), np.append(values, a @ x)
            above = np.vstack([above, own])
            lower = np.append(lower, np.minimum(level.lower[limits], own @ x - ROOM))
            upper = np.append(upper, np.maximum(level.upper[limits], own @ x + ROOM))
        return x, us


def with_quadprog(_number, h, g, e, values, c, lower, upper):
    """quadprog: Goldfarb and Idnani, cold."""
    below, above = np.isfinite(lower), np.isfinite(upper)
    rows, bounds = np.vstack([e, c[below], -c[above]]), np.concatenate([values, lower[below], -upper[above]])
    try:
        return quadprog.solve_qp(h, -g, rows.T.copy(), bounds, len(e))[0]
    except ValueError:
        return None


def with_clarabel(_number, h, g, e, values, c, lower, upper):
    """Clarabel: interior point, its own tolerances."""
    below, above = np.isfinite(lower), np.isfinite(upper)
    rows = sparse.csc_matrix(np.vstack([e, -c[below], c[above]]))
    bounds = np.concatenate([values, -lower[below], upper[above]])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    cones = [clarabel.ZeroConeT(len(e)), clarabel.NonnegativeConeT(len(bounds) - len(e))]
    found = clarabel.DefaultSolver(sparse.csc_matrix(np.triu(h)), g, rows, bounds, cones, settings).solve()
    return np.array(found.x) if found.status == clarabel.SolverStatus.Solved else None


class WithProxQp:
    """ProxQP, dense, warm from the last tick's program of the same level; accuracy 1e-6, no more than 1000 iterations."""

    def __init__(self):
        self.programs = {}

    def __call__(self, number, h, g, e, values, c, lower, upper):
        shape = (number, len(g), len(values), len(lower))
        program = self.programs.get(shape)
        if program is None:
            program = proxsuite.proxqp.dense.QP(len(g), len(values), len(lower))
            program.settings.eps_abs = 1e-6
            program.settings.max_iter = 1000
            program.settings.initial_guess = proxsuite.proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
            program.init(h, g, e, values, c, lower, upper)
            self.programs[shape] = program
        else:
            program.update(h, g, e, values, c, lower, upper)
        program.solve()
        solved = program.results.info.status == proxsuite.proxqp.PROXQP_SOLVED
        return program.results.x.copy() if solved else None


def worse(levels, x, best):
    """By how much the worst level is violated more than by another point."""
    def violation(level, x):
        value = level.a @ x
        apart = np.maximum(value - level.upper, 0) + np.maximum(level.lower - value, 0)
        return np.linalg.norm(apart if level.hard else np.sqrt(level.weight) * apart)
    return max(violation(level, x) - violation(level, best) for level in levels)


class Daqp:
    """DAQP's own hierarchies, cold: its levels have no weights, so that rows are scaled."""

    def solve(self, levels):
        n, big = levels[0].a.shape[1], 1e20
        scale = [np.sqrt(level.weight) if not level.hard else np.ones(len(level.lower)) for level in levels]
        rows = np.ascontiguousarray(np.vstack([s[:, None] * level.a for s, level in zip(scale, levels)]))
        bounded = lambda side: np.clip(np.concatenate([s * side(level) for s, level in zip(scale, levels)]), -big, big)
        with np.errstate(invalid="ignore"):
            lower, upper = bounded(lambda level: level.lower), bounded(lambda level: level.upper)
        lower, upper = np.nan_to_num(lower, nan=-big), np.nan_to_num(upper, nan=big)
        ends = np.cumsum([0] + [len(level.lower) for level in levels]).astype(np.intc)
        sense = np.zeros(len(lower), dtype=np.intc)
        begin = time.thread_time_ns()
        x, _, flag, _ = daqp.solve(np.eye(n), np.zeros(n), rows, upper, lower, sense, break_points=ends)
        us = 1e-3 * (time.thread_time_ns() - begin)
        return (np.array(x) if flag > 0 else None), us


class Eiquadprog:
    """`cascade.cpp`: eiquadprog called from C++, building included, cold."""

    def __init__(self, library):
        self.call = ctypes.CDLL(str(library)).cascade

    def solve(self, levels):
        n = levels[0].a.shape[1]
        array = lambda values, kind=np.float64: np.ascontiguousarray(values, dtype=kind)
        sizes, hard = array([len(l.lower) for l in levels], np.intc), array([l.hard for l in levels], np.intc)
        numbers = [np.concatenate([getattr(l, name) for l in levels]) for name in ("lower", "upper", "weight")]
        numbers = [array(np.clip(v, -1e301, 1e301)) for v in numbers]
        rows, x, us = array(np.vstack([l.a for l in levels])), np.zeros(n), ctypes.c_double()
        pointer = lambda a: a.ctypes.data_as(ctypes.c_void_p)
        failed = self.call(n, len(levels), pointer(sizes), pointer(hard), pointer(rows), *map(pointer, numbers), pointer(x), ctypes.byref(us))
        return (None if failed else x), us.value

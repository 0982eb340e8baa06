"""Integrators that are not in the library, on its right-hand side through SciPy: the reference, and those shown and dropped."""

from __future__ import annotations

import time

import numpy as np
from common import FULL, STEP, TINY, moving
from evodevo_sim.physics.forces import make_scratch
from kernels import many_accelerations, slope
from scipy.integrate import BDF, RK23, Radau, solve_ivp
from scipy.linalg.lapack import dgbtrf
from scipy.sparse import bmat, csr_matrix, eye, kron
from scipy.sparse.csgraph import reverse_cuthill_mckee
from tqdm import tqdm

OUTSIDERS = {"RK23": RK23, "BDF": BDF, "Radau": Radau}


class Counted:
    """The right-hand side of y = (positions, velocities), (4 N,), counting its calls."""

    def __init__(self, system):
        self.system, self.cells, self.scratch, self.calls = system, len(system.body.position), make_scratch(system.body), 0

    def __call__(self, t, y):
        self.calls += 1
        p, v = np.ascontiguousarray(y).reshape(2, 2, self.cells)
        out = np.empty((2, self.cells))
        slope(self.system, t, p, v, self.scratch, out)
        return np.concatenate((v.ravel(), out.ravel()))

    def start(self):
        return np.concatenate((self.system.body.position.T.ravel(), np.zeros(2 * self.cells)))


def reference(system, seconds):
    """(2, N) positions by DOP853 at 1e-12."""
    right = Counted(system)
    y = solve_ivp(right, (0, seconds), right.start(), "DOP853", rtol=1e-12, atol=1e-12, t_eval=[seconds]).y
    return y[: 2 * right.cells, -1].reshape(2, -1)


def touching(body):
    """(N, N) sparse: which cells act upon each other, through a spring or a chamber."""
    cells = len(body.position)
    pairs = list(zip(body.spring_a, body.spring_b)) + [(a, b) for t in body.triangle for a in t for b in t]
    for first, last in zip(body.polygon_start[:-1], body.polygon_start[1:]):
        corners = body.polygon_cell[first:last]
        pairs += [(a, b) for a in corners for b in corners]
    i, j = np.array(pairs, np.int64).T
    near = csr_matrix((np.ones(len(i)), (i, j)), (cells, cells))
    return (near + near.T + eye(cells)).tocsr()


def lu_in_evaluations(system):
    """What one LU of an implicit step costs, in force evaluations: banded, (2 N, 2 N), by LAPACK, in the best order of cells."""
    body = system.body
    near = touching(body)
    order = reverse_cuthill_mckee(near, symmetric_mode=True)
    i, j = near[order][:, order].nonzero()
    band = 2 * int(abs(i - j).max()) + 1
    size = 2 * len(body.position)
    matrix = np.asfortranarray(np.random.default_rng(0).standard_normal((3 * band + 1, size)))
    matrix[2 * band] += 10.0 * band
    p, v, rest = moving(body)
    scratch, out = make_scratch(body), np.empty_like(p)
    many_accelerations(body, system.law, rest, p, v, scratch, out, 1)
    factor, force = np.inf, np.inf
    for _ in range(20):
        began = time.thread_time()
        for _ in range(20):
            dgbtrf(matrix, band, band)
        factor = min(factor, (time.thread_time() - began) / 20)
        began = time.thread_time()
        many_accelerations(body, system.law, rest, p, v, scratch, out, 1000)
        force = min(force, (time.thread_time() - began) / 1000)
    return factor / force


def outside(system, intervals, effort, note):
    """Rows of RK23, BDF and Radau at several tolerances: work as force evaluations a control step, and position.

    Like ours they end a step with every control step, where in a life the muscles jump; `across`, for comparison, they do not,
    since the muscles here are smooth.  Implicit methods are charged for every evaluation, those of Jacobians by differences among
    them (grouped, so that they take few), and for an LU in real numbers; triangular solves are free here.
    """
    cells = len(system.body.position)
    near = kron(np.ones((2, 2)), touching(system.body))
    sparse = bmat([[csr_matrix((2 * cells, 2 * cells)), eye(2 * cells)], [near, near]]).tocsr()
    factor = lu_in_evaluations(system)
    rows = []
    for name, power, length in tqdm(list(cases(effort, intervals)), desc=note, leave=False):
        more = {} if name == "RK23" else {"jac_sparsity": sparse}
        found = solve(OUTSIDERS[name], Counted(system), intervals, length, rtol=10.0**-power, atol=10.0**-power, **more)
        if found is None:
            continue
        y, (calls, newton, jacobians, factorisations) = found
        rows.append({
            "integrator": name if length == 1 else f"{name} across", "effort": 10.0**-power,
            "evaluations": calls + factor * factorisations,
            "without_jacobians": newton + factor * factorisations, "jacobians": jacobians, "factorisations": factorisations,
            "lu_in_evaluations": factor, "position": y[: 2 * cells].reshape(2, -1),
        })
    return rows


def cases(effort, intervals):
    """(name, power of the tolerance, control steps in one go)."""
    single = {"RK23": range(2, 8), "BDF": (2, 4), "Radau": (2, 4)} if effort == FULL else dict.fromkeys(OUTSIDERS, (3,))
    across = {"RK23": range(2, 8), "BDF": range(3, 7), "Radau": range(2, 5)} if effort == FULL else dict.fromkeys(OUTSIDERS, (4,))
    for powers, length in ((single, 1), (across, intervals)) if effort > TINY else ((single, 1),):
        for name in OUTSIDERS:
            for power in powers[name]:
                yield name, power, length


def solve(kind, right, intervals, length, **more):
    """(state at the end, (evaluations, those but for Jacobians, Jacobians, factorisations) a control step), None if it failed."""
    used, y, h = np.zeros(3), right.start(), STEP / 8
    for k in range(0, intervals, length):
        solver = kind(right, k * STEP, y, (k + length) * STEP, first_step=min(h, 0.999999 * STEP), **more)
        h = 0.0
        while solver.status == "running":
            solver.step()
            h = max(h, solver.step_size or 0.0)  # the last step, cut short, says nothing about the next
        if solver.status != "finished":
            return None
        y, h = solver.y, max(h, solver.h_abs)
        used += solver.nfev, solver.njev, solver.nlu
    return y, (right.calls / intervals, *(used / intervals))

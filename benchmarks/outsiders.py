"""Integrators that are not in the library, on its right-hand side through SciPy: the reference, and those shown and dropped."""

from __future__ import annotations

import time

import numpy as np
from common import FULL, STEP, TINY, moving
from evodevo_sim.physics import make_scratch
from kernels import many_accelerations, slope
from scipy.integrate import solve_ivp
from scipy.linalg.lapack import dgbtrf
from scipy.sparse import bmat, csr_matrix, eye, kron
from scipy.sparse.csgraph import reverse_cuthill_mckee
from tqdm import tqdm

OUTSIDERS = ("RK23", "BDF", "Radau")


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
    return (csr_matrix((np.ones(len(i)), (i, j)), (cells, cells)) + csr_matrix((np.ones(len(i)), (j, i)), (cells, cells)) + eye(cells)).tocsr()


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

    Implicit methods are charged for every evaluation, those of Jacobians by differences among them (grouped, so that they take
    few), and for an LU in real numbers; triangular solves are free here.
    """
    right, seconds = Counted(system), intervals * STEP
    near = kron(np.ones((2, 2)), touching(system.body))
    sparse = bmat([[csr_matrix((2 * right.cells, 2 * right.cells)), eye(2 * right.cells)], [near, near]]).tocsr()
    factor = lu_in_evaluations(system)
    powers = {"RK23": range(2, 9), "BDF": range(2, 8), "Radau": range(2, 7)} if effort == FULL else dict.fromkeys(OUTSIDERS, (3, 5))
    powers = dict.fromkeys(OUTSIDERS, (3,)) if effort == TINY else powers
    rows = []
    for name, power in tqdm([(name, k) for name in OUTSIDERS for k in powers[name]], desc=note, leave=False):
        right.calls = 0
        more = {} if name == "RK23" else {"jac_sparsity": sparse}
        found = solve_ivp(right, (0, seconds), right.start(), name, rtol=10.0**-power, atol=10.0**-power, t_eval=[seconds], **more)
        rows.append({
            "integrator": name, "effort": 10.0**-power, "evaluations": (right.calls + factor * found.nlu) / intervals,
            "without_jacobians": (found.nfev + factor * found.nlu) / intervals,
            "jacobians": found.njev / intervals, "factorisations": found.nlu / intervals, "lu_in_evaluations": factor,
            "position": found.y[: 2 * right.cells, -1].reshape(2, -1),
        })
    return rows

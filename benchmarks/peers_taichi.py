"""The springs of peers.py in Taichi, which is imported with this module; its kernels read their own source without annotations."""

import numpy as np
import taichi as ti


def make(body, stiffness, damping, gravity, friction, step):
    """(run, height): as methods of the other engines."""
    ti.init(arch=ti.cpu, cpu_max_num_threads=1, default_fp=ti.f64, fast_math=False, log_level=ti.ERROR, offline_cache=False)
    cells, springs = len(body.position), body.rest_length.size
    x, v, f = (ti.Vector.field(2, ti.f64, cells) for _ in range(3))
    pair, rest = ti.Vector.field(2, ti.i32, springs), ti.field(ti.f64, springs)
    x.from_numpy(np.array(body.position))
    pair.from_numpy(np.stack((body.spring_a, body.spring_b), axis=1).astype(np.int32))
    rest.from_numpy(np.array(body.rest_length))

    @ti.kernel
    def advance(substeps: ti.i32):
        ti.loop_config(serialize=True)
        for _ in range(substeps):
            for i in range(cells):
                f[i] = ti.Vector([0.0, -gravity])
            for e in range(springs):
                i, j = pair[e][0], pair[e][1]
                d, u = x[j] - x[i], v[j] - v[i]
                inverse = 1.0 / ti.sqrt(d.dot(d))
                pull = (stiffness * (1.0 - rest[e] * inverse) + damping * u.dot(d) * inverse * inverse) * d
                f[i] += pull
                f[j] -= pull
            for i in range(cells):
                v[i] += step * f[i]
                if x[i][1] + step * v[i][1] < 0.0:
                    landing = -x[i][1] / step
                    most = friction * (landing - v[i][1])
                    v[i][1] = landing
                    v[i][0] = v[i][0] - ti.math.clamp(v[i][0], -most, most)
                x[i] += step * v[i]

    def run(substeps):
        advance(substeps)
        ti.sync()

    return run, lambda: float(x.to_numpy()[:, 1].mean())

"""The laws of docs/reference/model.md once more, in plain NumPy, for bodies whose faces and outline are known: a second opinion."""

import numpy as np
from scipy.integrate import solve_ivp


def grid(columns=5, rows=3, seed=0):
    """A shaken grid with a diagonal in all squares but the last, and a tail: the document of a body file, faces, outline."""
    rng = np.random.default_rng(seed)
    n = lambda c, r: r * columns + c
    points = [(c, r) for r in range(rows) for c in range(columns)] + [(columns, rows - 1)]
    position = np.array(points, float) + rng.uniform(-0.1, 0.1, (len(points), 2))
    springs, faces = [], []
    for r in range(rows):
        for c in range(columns):
            if c + 1 < columns:
                springs.append((n(c, r), n(c + 1, r)))
            if r + 1 < rows:
                springs.append((n(c, r), n(c, r + 1)))
            if c + 1 < columns and r + 1 < rows:
                a, b, d, e = n(c, r), n(c + 1, r), n(c + 1, r + 1), n(c, r + 1)
                if (c, r) == (columns - 2, rows - 2):
                    faces.append((a, b, d, e))
                else:
                    springs.append((a, d))
                    faces += [(a, b, d), (a, d, e)]
    springs.append((n(columns - 1, rows - 1), n(columns, rows - 1)))
    sides = [tuple(sorted(side)) for face in faces for side in zip(face, face[1:] + face[:1])]
    outline = [tuple(sorted(s)) for s in springs if sides.count(tuple(sorted(s))) < 2]
    cells = len(points)
    document = {
        "position": position.tolist(),
        "velocity": rng.normal(0, 0.1, (cells, 2)).tolist(),
        "mass": rng.uniform(0.5, 2.0, cells).tolist(),
        "springs": [list(s) for s in springs],
        "rest_length": [float(np.linalg.norm(position[a] - position[b]) * rng.uniform(0.95, 1.05)) for a, b in springs],
        "stiffness": 300.0,
        "damping": 5.0,
        "pressure": 350.0,
        "chambers": "faces",
        "activation": {
            "amplitude": rng.uniform(0, 0.4, cells).tolist(),
            "frequency": rng.uniform(0.5, 1.5, cells).tolist(),
            "phase": rng.uniform(0, 6, cells).tolist(),
        },
        "scene": {"drag_normal": 80.0, "drag_tangential": 0.6, "gravity": 0.0, "friction": 0.5},
    }
    return document, faces, outline


def forces(document, faces, outline, scene, t, p, v):
    """(N, 2) N: straight from the table of laws, edge by edge."""
    activation = {key: np.array(value) for key, value in document["activation"].items()}
    a = activation["amplitude"] * np.sin(2 * np.pi * activation["frequency"] * t + activation["phase"])
    start = np.array(document["position"])
    total = np.zeros_like(p)
    for (i, j), rest in zip(document["springs"], document["rest_length"]):
        length = np.linalg.norm(p[j] - p[i])
        u = (p[j] - p[i]) / length
        f = document["stiffness"] * (length - (1 + 0.2 * (a[i] + a[j])) * rest) + document["damping"] * (v[j] - v[i]) @ u
        total[i] += f * u
        total[j] -= f * u
    for face in faces:
        area = lambda q: 0.5 * sum(q[i][0] * q[j][1] - q[i][1] * q[j][0] for i, j in zip(face, face[1:] + face[:1]))  # noqa: B023  (called within its round)
        pressure = document["pressure"] * (1 - area(p) / area(start))
        for i, j in zip(face, face[1:] + face[:1]):  # counter-clockwise: outward is to the right
            d = p[j] - p[i]
            push = 0.5 * pressure * np.array([d[1], -d[0]])
            total[i] += push
            total[j] += push
    if scene == "swim":
        for i, j in outline:
            d = p[j] - p[i]
            length = np.linalg.norm(d)
            along, across = d / length, np.array([-d[1], d[0]]) / length
            mean = 0.5 * (v[i] + v[j])
            t_speed, n_speed = mean @ along, mean @ across
            f = -length * (
                document["scene"]["drag_tangential"] * t_speed * abs(t_speed) * along
                + document["scene"]["drag_normal"] * n_speed * abs(n_speed) * across
            )
            total[i] += 0.5 * f
            total[j] += 0.5 * f
    return total


def solve(document, faces, outline, scene, time):
    """(position, velocity), (T, N, 2) each, by DOP853."""
    cells = len(document["position"])
    mass = np.array(document["mass"])[:, None]

    def slope(t, y):
        p, v = y.reshape(2, cells, 2)
        return np.concatenate((v, forces(document, faces, outline, scene, t, p, v) / mass)).ravel()

    start = np.concatenate((document["position"], document["velocity"])).ravel()
    y = solve_ivp(slope, (0, time[-1]), start, "DOP853", rtol=1e-10, atol=1e-11, t_eval=time).y.T.reshape(-1, 2, cells, 2)
    return y[:, 0], y[:, 1]

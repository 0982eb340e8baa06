"""The force loop of forces.c, compiled here with cc and called through ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).with_name("forces.c")
# Without -ffp-contract=off gcc would fuse multiplications and additions where the processor can, and bits would differ.
FLAGS = {"cc -O3": ("-O3",), "cc -O3 -march=native": ("-O3", "-march=native")}
_SIZES = ("cells", "springs", "triangles", "polygons", "outlines")
_DOUBLES = ("inverse_mass", "triangle_area", "polygon_area", "rest")
_INDICES = ("a", "b", "left", "right", "triangle", "polygon_start", "polygon_cell", "outline")
_LAW = ("stiffness", "damping", "pressure", "drag_normal", "drag_tangential")


class _Body(ctypes.Structure):
    _fields_ = (
        [(name, ctypes.c_int64) for name in _SIZES]
        + [(name, ctypes.c_void_p) for name in (*_DOUBLES, *_INDICES)]
        + [(name, ctypes.c_double) for name in _LAW]
        + [(name, ctypes.c_void_p) for name in ("edge", "push")]
    )


def compiled(directory: Path) -> dict:
    """{flags: library}, or nothing where there is no C compiler."""
    if not shutil.which("cc"):
        return {}
    directory.mkdir(parents=True, exist_ok=True)
    libraries = {}
    for name, flags in FLAGS.items():
        target = (directory / f"forces{len(libraries)}.so").resolve()
        subprocess.run(["cc", *flags, "-ffp-contract=off", "-shared", "-fPIC", "-o", target, SOURCE, "-lm"], check=True)
        libraries[name] = ctypes.CDLL(str(target))
    return libraries


def caller(library, in_passes, body, law, rest, position, velocity, calls):
    """(action, out): the action fills out (2, N) with accelerations, that many times over."""
    chambers = body.triangle_area.size + body.polygon_area.size
    arrays = {
        "inverse_mass": body.inverse_mass, "triangle_area": body.triangle_area, "polygon_area": body.polygon_area, "rest": rest,
        "a": body.spring_a, "b": body.spring_b, "left": body.spring_left, "right": body.spring_right, "triangle": body.triangle,
        "polygon_start": body.polygon_start, "polygon_cell": body.polygon_cell, "outline": body.outline_spring,
        "edge": np.zeros((4, rest.size)), "push": np.zeros(chambers + 1),
    }
    for name in arrays:
        arrays[name] = np.ascontiguousarray(arrays[name], np.uint32 if name in _INDICES else np.float64)
    sizes = (len(body.position), rest.size, body.triangle_area.size, body.polygon_area.size, body.outline_spring.size)
    pointers = {name: array.ctypes.data for name, array in arrays.items()}
    structure = _Body(**dict(zip(_SIZES, sizes)), **pointers, **{name: getattr(law, name) for name in _LAW})
    out, position, velocity = np.empty(position.shape), np.ascontiguousarray(position), np.ascontiguousarray(velocity)

    def action(keep=arrays):  # noqa: ARG001  (what pointers point at lives as long as the action)
        library.many(
            ctypes.byref(structure), int(in_passes), *(ctypes.c_void_p(array.ctypes.data) for array in (position, velocity, out)),
            ctypes.c_int64(calls),
        )

    return action, out

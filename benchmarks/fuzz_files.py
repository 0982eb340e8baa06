"""Genome, body, world and target files damaged at random: each must be read, or refused in one short line, within a second.

    python benchmarks/fuzz_files.py [READER ...] [--files N] [--seed N] [--keep DIR]

Good files are damaged one to four times each: bits flipped, parts cut, swapped and doubled, lines likewise, spellings that are traps
put in, brackets nested, encodings changed.  Prints for each reader how many were read and refused, the longest message and the slowest
file, and what was wrong: exceptions of another kind, messages that are long, of several lines or without the file's name, slow
files.  Exit code 1 if anything was.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import sys
import tempfile
import time
from collections import namedtuple
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from evodevo_sim.genetics.genome_file import genome_text
from evodevo_sim.live.targets import load_points
from evodevo_sim.own_body.body_file import BodyError
from evodevo_sim.parameters import default_task
from evodevo_sim.worlds import with_world
from tqdm import tqdm

from evodevo_sim import GenomeError, ParameterError, load_body, load_genome, random_genome

MOST_CHARACTERS = 300
MOST_SECONDS = 1.0
TRAPS = """1e-5 1E5 1:30 -1:30:00 0x_ 0x1F 0o17 017 0b1 1_000 .5 5. . - + -- e 1e999 -1e999 1e-999 .nan .NaN .inf -.inf nan inf Infinity
NaN true True yes no on off maybe null ~ Null 2024-02-30 2024-02-28 2024-02-28T25:00:00Z 0000-00-00 12:60 !
!!binary !!python/object:os.system !!int !!bool !!timestamp !!set &a *a << <<: ? : - | > |9 % %TAG @ ` ' " [ ] { } [] {} , # ... ---
\\x \\u12 \\ud800 0.1.2 1e5e5 +-1 １２ ٣""".split()
TRAPS += ["", " ", "\t", "\0", "\r", "\ufeff", "\u2028", "\x85", "\x1b[31m", "\ud7ff"]
TRAPS += ["9" * 400, "9" * 5000, "x" * 10_000, "[" * 50, "{a: " * 50]
TRAPS += ["a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]", "- " * 30, "? " * 30, '"' + "\\n" * 300 + '"', "0." + "1" * 3000, "!" + "t" * 900]
Reader = namedtuple("Reader", "read error ending good")  # read(path); error that it raises; a name's ending; good texts


def readers() -> dict[str, Reader]:
    """Every reader, with good files."""
    about = {"task": "swim", "made": "2024-02-28"}
    genomes = [genome_text(random_genome(np.random.default_rng(k), units), about) for k, units in enumerate((0, 3, 20))]
    return {
        "genome": Reader(load_genome, GenomeError, ".yaml", genomes),
        "body": Reader(load_body, BodyError, ".yaml", [*_BODIES, json.dumps(_grid(4)), json.dumps(_grid(3), indent="\t")]),
        "world": Reader(lambda path: with_world(default_task("walk"), path), ParameterError, ".yaml", _WORLDS),
        "target_yaml": Reader(load_points, ParameterError, ".yaml", ["- [1, 2]\n- [-3.5, 4.0]\n" * 5, "[[1, 2], [3e0, .5],\n [5, 6]]"]),
        "target_csv": Reader(load_points, ParameterError, ".csv", ["x,y\n1, 2\n\n# no more\n-3.5,4e0\n", '"1","2"\n3,4\n' * 5]),
    }


_BODIES = [
    (
        "position: [[0, 0], [1, 0], [0.5, 0.9]]\nsprings: [[0, 1], [1, 2], [0, 2]]\nrest_length: [1, 1, 1.1]\n"
        "velocity: [[0, 0], [1, 0], [0, 1]]\n"
        "activation: {amplitude: 0.3, frequency: 1.0, phase: [0, 1, 2]}\nscene: {drag_normal: 100, drag_tangential: 0.5}\nmass: [1, 2, 3]\n"
    ),
    "position:\n- [0, 0]\n- [1, 0]\n- [1, 1]\n- [0, 1]\nsprings: gabriel\nchambers: faces\nstiffness: 1e2\ndamping: 1e-3\npressure: 4e2\n",
]
_WORLDS = [
    (
        "ground: [[-50, 0], [4, 0], [4.1, 0.5], [50, 0.5]]   # m\nceiling: [[-50, 100], [8, 100], [8.1, 3], [50, 3]]\n"
        "friction: 0.8\ngravity: 5.0\n"
    ),
    "steps: {rise: 0.3, run: 3, level: 6}\nfriction: 8e-1\n", "rough: {seed: 1, spacing: 1, height: 0.5, level: 6}\n",
    "bumps:\n  height: 0.6\n  width: 1.5\n  apart: 6\n  level: 6\n", "slope: -8.5\n", '{"slope": 3, "friction": 0.5}',
]


def _grid(n):
    position = [[float(x), float(y)] for y in range(n) for x in range(n)]
    springs = [[k, k + 1] for k in range(n * n) if (k + 1) % n] + [[k, k + n] for k in range(n * n - n)]
    return {"position": position, "springs": springs, "mass": 1.5, "chambers": "faces", "activation": {"amplitude": [0.1] * n * n}}


def damaged(data: bytes, random: random.Random) -> bytes:
    """A file's bytes with one to four damages."""
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        data = random.choice(DAMAGES)(data, random)
    return data


def _span(data, random, most=40):
    """Two places of the file, the first not behind the second."""
    start = random.randint(0, len(data))
    return start, min(len(data), start + random.randint(0, most))


def _flip(data, random):
    changed = bytearray(data or b"\0")
    for _ in range(random.choice((1, 1, 3, 20))):
        changed[random.randrange(len(changed))] ^= 1 << random.randrange(8)
    return bytes(changed)


def _cut(data, random):
    start, end = _span(data, random)
    return data[:start] if random.random() < 0.3 else data[:start] + data[end:]


def _double(data, random):
    start, end = _span(data, random, random.choice((3, 40, 400)))
    return data[:end] + data[start:end] * random.choice((1, 1, 5, 100)) + data[end:]


def _swap(data, random):
    a, b = sorted(_span(data, random, 8) for _ in range(2))
    return data if a[1] > b[0] else data[: a[0]] + data[slice(*b)] + data[a[1] : b[0]] + data[slice(*a)] + data[b[1] :]


def _lines(data, random):
    lines = data.split(b"\n")
    k = random.randrange(len(lines))
    how = random.randrange(4)
    if how == 0:
        lines.insert(random.randint(0, len(lines)), lines[k])
    elif how == 1:
        del lines[k]
    elif how == 2:
        random.shuffle(lines)
    else:
        lines[k] = random.choice((b"\t", b" ", b"    ", b"- ", b"---\n", b"# ")) + lines[k]
    return b"\n".join(lines)


def _trap(data, random):
    return _put(data, random.choice(TRAPS).encode("utf-8", "replace"), random)


def _word(data, random):
    """A word of the file in the place of another."""
    words = re.findall(rb"[\w.+-]+", data)
    return _put(data, random.choice(words), random) if words else data


def _put(data, text, random):
    """A text somewhere, or in the place of a number, a word or a bracketed list."""
    places = [match.span() for match in re.finditer(random.choice((rb"[-+.\w]+", rb"\[[^][]*\]", rb"\{[^{}]*\}")), data)]
    if not places or random.random() < 0.2:
        places = [(random.randint(0, len(data)),) * 2]
    start, end = random.choice(places)
    return data[:start] + text + data[end:]


def _nest(data, random):
    deep = random.choice((3, 20, 1000, 20_000))
    opening, closing = random.choice(((b"[", b"]"), (b"{a: ", b"}"), (b'{"a":', b"}"), (b"- ", b""), (b"? ", b""), (b"[{", b"}]")))
    return _put(data, opening * deep + b"1" + closing * random.choice((deep, deep, 0)), random)


def _encode(data, random):
    text, how = data.decode("utf-8", "replace"), random.choice(("utf-16", "utf-16-le", "utf-32", "utf-8-sig", "latin-1", "crlf", "cr"))
    if how in ("crlf", "cr"):
        return data.replace(b"\n", b"\r\n" if how == "crlf" else b"\r")
    return text.encode(how, "replace")


DAMAGES = (_flip, _cut, _double, _swap, _lines, _trap, _trap, _trap, _word, _nest, _encode)


@dataclass
class Found:
    """read, refused: numbers of files; longest: characters; slowest: s; faults: texts."""

    read: int = 0
    refused: int = 0
    longest: int = 0
    slowest: float = 0.0
    faults: list[str] = field(default_factory=list)


def fuzz(name: str, files: int, seed: int, directory: Path, keep: Path | None = None) -> Found:
    """Give damaged files to a reader.  Args: directory: for the file; keep: where those with faults are kept, if anywhere."""
    reader, found = readers()[name], Found()
    path = directory / f"{name}{reader.ending}"
    for good in reader.good:  # what a first file of a kind compiles or imports is no time of the others
        path.write_bytes(good.encode())
        _look(reader, path, Found())
    for number in tqdm(range(files), desc=name, unit="file", leave=False, disable=files < 1000):
        draw = random.Random(f"{seed} {name} {number}")
        data = damaged(draw.choice(reader.good).encode(), draw)
        path.write_bytes(data)
        fault = _look(reader, path, found)
        if fault:
            found.faults.append(f"{name} {number}: {fault}")
            if keep:
                (keep / f"{number}-{path.name}").write_bytes(data)
    return found


def _look(reader, path, found):
    """Read one file.  Returns what is wrong with how it went, or nothing."""
    message, began = None, time.thread_time()
    try:
        reader.read(path)
    except reader.error as error:
        message = str(error)
    except BaseException as error:
        return f"{type(error).__name__}: {str(error)[:200]}"
    seconds = time.thread_time() - began
    found.slowest = max(found.slowest, seconds)
    if seconds > MOST_SECONDS:
        return f"{seconds:.2f} s"
    if message is None:
        found.read += 1
        return None
    found.refused, found.longest = found.refused + 1, max(found.longest, len(message))
    if len(message) > MOST_CHARACTERS or "\n" in message or not message.isprintable():
        return f"{len(message)} characters, {message.count(chr(10)) + 1} lines: {message[:100]!r}"
    return None if path.name in message else f"does not name the file: {message!r}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("readers", nargs="*", metavar="READER", help=f"{', '.join(readers())} (default: all)")
    parser.add_argument("--files", type=int, default=10_000, help="for each reader (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="equal seeds, equal files (default %(default)s)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="a directory for the files with faults, made if there is none")
    given = parser.parse_args()
    unknown = set(given.readers) - set(readers())
    if unknown:
        parser.error(f"reader {unknown.pop()!r} is unknown: choose from {', '.join(readers())}")
    if given.keep:
        given.keep.mkdir(parents=True, exist_ok=True)
    faults = []
    with tempfile.TemporaryDirectory() as directory:
        for name in given.readers or readers():
            found = fuzz(name, given.files, given.seed, Path(directory), given.keep)
            faults += found.faults
            print(
                f"{name:12} {found.read:6} read  {found.refused:6} refused  {len(found.faults):4} faults  "
                f"longest message {found.longest} characters  slowest {found.slowest:.3f} s", flush=True,
            )
    print("\n".join(faults[:50]))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

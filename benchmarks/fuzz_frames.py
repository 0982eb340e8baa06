"""The frame parser under fuzzed input: it must never raise, invent a message, grow, or miss the frame that comes after.

    python benchmarks/fuzz_frames.py [--inputs N] [--seed N]

An input is garbage, or good frames of all kinds, damaged: bits flipped, bytes changed, put in, left out and doubled, frames cut, joined,
swapped, endless.  It is fed in pieces of any length to one parser that goes on for ever; after each one a good frame must arrive.
Prints how many inputs there were of each kind and what came of them; exit code 1 if anything was wrong.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable

import numpy as np
from evodevo_sim.hardware.protocol import (
    MOST_FRAME,
    Arm,
    Command,
    Fault,
    Hello,
    Message,
    Mode,
    Parser,
    State,
    Stop,
    Welcome,
    alike,
    encode,
)

Rng = np.random.Generator


def message(rng: Rng) -> Message:
    """A message of any kind."""
    cells = int(rng.choice([0, 1, 5, 31, 64, 255], p=[0.1, 0.2, 0.3, 0.3, 0.09, 0.01]))
    match int(rng.integers(6)):
        case 0:
            return Hello(int(rng.integers(256)))
        case 1:
            return Arm(bool(rng.integers(2)), bool(rng.integers(2)))
        case 2:
            return Stop()
        case 3:
            return Command(int(rng.integers(65536)), rng.normal(size=cells).astype(np.float32))
        case 4:
            return Welcome(*(int(rng.integers(256)) for _ in range(3)), int(rng.integers(2**32)), int(rng.integers(65536)), "eel")
    numbers = (int(rng.integers(65536)), int(rng.integers(2**32)), int(rng.integers(65536)))
    marker = rng.normal(size=(cells, 2)).astype(np.float32)
    return State(*numbers, Mode(int(rng.integers(3))), Fault(int(rng.integers(32))), rng.normal(size=cells).astype(np.float32), marker)


def garbage(rng: Rng, frame: bytes) -> bytes:
    return rng.bytes(int(rng.integers(300)) + len(frame) % 8)


def flipped(rng: Rng, frame: bytes) -> bytes:
    damaged = bytearray(frame)
    for _ in range(int(rng.integers(1, 5))):
        damaged[int(rng.integers(len(damaged)))] ^= 1 << int(rng.integers(8))
    return bytes(damaged)


def changed(rng: Rng, frame: bytes) -> bytes:
    at = int(rng.integers(len(frame)))
    return frame[:at] + bytes([int(rng.integers(256))]) + frame[at + 1 :]


def inserted(rng: Rng, frame: bytes) -> bytes:
    at = int(rng.integers(len(frame) + 1))
    return frame[:at] + rng.bytes(int(rng.integers(1, 9))) + frame[at:]


def left_out(rng: Rng, frame: bytes) -> bytes:
    at, count = int(rng.integers(len(frame))), int(rng.integers(1, 9))
    return frame[:at] + frame[at + count :]


def doubled(rng: Rng, frame: bytes) -> bytes:
    first, last = sorted(rng.integers(len(frame) + 1, size=2).tolist())
    return frame[:last] + frame[first:]


def cut(rng: Rng, frame: bytes) -> bytes:
    return frame[: int(rng.integers(len(frame)))]


def joined(rng: Rng, frame: bytes) -> bytes:
    other = encode(message(rng))
    return frame[: int(rng.integers(len(frame)))] + other[int(rng.integers(len(other))) :]


def swapped(rng: Rng, frame: bytes) -> bytes:
    first, last = sorted(rng.integers(len(frame) + 1, size=2).tolist())
    return frame[last:] + frame[first:last] + frame[:first]


def zeros(rng: Rng, frame: bytes) -> bytes:
    return bytes(int(rng.integers(50))) + frame[1:-1].replace(b"\1", b"\0")


def endless(rng: Rng, frame: bytes) -> bytes:
    most = MOST_FRAME + 50 if rng.random() < 0.05 else 600
    return frame[1:2] * int(rng.integers(most - 100, most))


KINDS: tuple[Callable[[Rng, bytes], bytes], ...] = (
    garbage, flipped, changed, inserted, left_out, doubled, cut, joined, swapped, zeros, endless,
)


def fuzz(inputs: int, seed: int) -> tuple[Counter[str], list[str]]:
    """(inputs and messages by their kinds, what was wrong, a line each)."""
    rng, parser, told, wrong = np.random.default_rng(seed), Parser(), Counter[str](), list[str]()
    frames = [encode(message(rng)) for _ in range(500)]
    known = set(frames)
    for k in range(inputs):
        kind = KINDS[int(rng.integers(len(KINDS)))]
        data = kind(rng, frames[int(rng.integers(len(frames)))])
        told[kind.__name__] += 1
        try:
            found, place = [], 0
            while place < len(data):
                length = int(rng.integers(1, 2 * len(data) + 1))
                found += parser.feed(data[place : place + length])
                place += length
            end = Stop() if k % 2 else Hello(k % 256)
            *more, last = [*found, *parser.feed(encode(end))] or [None]  # a frame without its end is whole where the next one begins
            if last is None or not alike(last, end):
                wrong.append(f"input {k}, {kind.__name__}: the good frame after it is {last}")
            for one in more:  # what is whole in it may arrive, and nothing else
                told["messages that were whole in it"] += 1
                frame = encode(one)
                if frame[1:-1] not in data and frame not in known:
                    wrong.append(f"input {k}, {kind.__name__}: it makes {one} of what holds no such frame")
        except Exception as error:
            wrong.append(f"input {k}, {kind.__name__}: {type(error).__name__}: {error}")
            parser = Parser()
        if len(parser._rest) > MOST_FRAME:
            wrong.append(f"input {k}, {kind.__name__}: it keeps {len(parser._rest)} bytes")
        if len(wrong) > 20:
            break
    told["frames that were none"] = parser.damaged
    return told, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=1_000_000, help="(default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="(default %(default)s)")
    given = parser.parse_args()
    began = time.perf_counter()
    told, wrong = fuzz(given.inputs, given.seed)
    for name, count in told.items():
        print(f"{count:>10,}  {name}")
    print(f"{given.inputs:,} inputs in {time.perf_counter() - began:.0f} s; {len(wrong)} wrong")
    print("\n".join(wrong), end="\n" * bool(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

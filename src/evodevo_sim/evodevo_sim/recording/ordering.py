"""Messages in the order of time, whatever order the file has them in."""

from __future__ import annotations

from collections.abc import Sequence

_LATE = 2 * 10**9  # ns, later than which no message arrives that belongs before others


def lives(stamps: Sequence[int], times: Sequence[int]) -> list[list[int]]:
    """The messages of each life, e.g. between resets of a simulator: indices, by stamp.

    A message that was recorded late has a stamp that none before it had, and goes where it belongs.  After a reset stamps come
    again, or all are below those before.

    Args: stamps: ns, in the messages; times: ns, when each was recorded; those of equal time in the order that they have.
    """
    order = sorted(range(len(stamps)), key=times.__getitem__)
    found: list[dict[int, int]] = []  # stamp: index
    top: int | None = None
    late: list[int] = []
    for i in order:
        stamp = stamps[i]
        if top is None or stamp >= top or stamp not in found[-1]:
            if top is None:
                found.append({})
            late = [] if top is None or stamp >= top else [*late, i]
            found[-1][stamp] = i  # also of one that was sent again
            top = stamp if top is None else max(top, stamp)
        else:  # a stamp comes again: what came just before it, below the others, may be of the new life too
            began, ended = times[i] - stamp, times[found[-1][top]] - top  # how far records are behind stamps, in either life
            early = [k for k in late if abs(times[k] - stamps[k] - began) < abs(times[k] - stamps[k] - ended)]
            for k in early:
                del found[-1][stamps[k]]
            found.append({stamps[k]: k for k in (*early, i)})
            top, late = max(found[-1]), []
    if found:
        found[-1:] = _parted(found[-1], times)
    return [[life[stamp] for stamp in sorted(life)] for life in found]


def _parted(life: dict[int, int], times: Sequence[int]) -> list[dict[int, int]]:
    """A life in two where all of its later messages are below all of the earlier ones, and too late for them."""
    if len(life) < 3:
        return [life]
    order = sorted(life, key=lambda stamp: times[life[stamp]])
    least, low = [], order[0]
    for stamp in order:
        least.append(low := min(low, stamp))
    most = order[-1]
    for k in range(len(order) - 2, 0, -1):  # two or more messages behind
        most = max(most, order[k])
        before = least[k - 1]
        if most < before and times[life[order[k]]] - times[life[before]] > _LATE:
            return [{s: life[s] for s in order[:k]}, {s: life[s] for s in order[k:]}]
    return [life]

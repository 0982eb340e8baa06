"""Types of messages compared by their meaning: names, kinds and order of fields, not the text that tells them.

What makes no difference: comments, spacing, default values, constants, bounds, the order of the types that a type is made of, and
whether those are named in full.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*)(?:<=\d+)?(\[[^\]]*\])?\s+([a-z]\w*)(?!\s*=)(?:\s|$|#)")
_PARTS = re.compile(r"^={3,}\s*$", re.MULTILINE)
_HEAD = re.compile(r"^\s*MSG:\s*(\S+)\s*$", re.MULTILINE)
_SIMPLE = {
    "bool", "float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "string", "wstring",
}
_SAME = {"byte": "uint8", "char": "uint8"}  # the same bytes
_IMPLIED = dict.fromkeys(("builtin_interfaces/Time", "builtin_interfaces/Duration"), (("sec", "int32"), ("nanosec", "uint32")))

Types = dict[str, tuple[tuple[str, str], ...]]


def short(name: str) -> str:
    """`package/msg/Name` as `package/Name`."""
    return name.replace("/msg/", "/")


def types_of(name: str, text: str) -> Types:
    """Of a type and those that it is made of, from a `ros2msg` text: the (name, kind) of each field, in order."""
    found: Types = dict(_IMPLIED)
    current = short(name)
    for part in _PARTS.split(text):
        head = _HEAD.search(part)
        if head:
            current, part = short(head[1]), part[: head.start()] + part[head.end() :]
        package = current.partition("/")[0]
        fields = (match for line in part.splitlines() if (match := _FIELD.match(line)))
        found[current] = tuple((match[3], _kind(match[1], match[2] or "", package)) for match in fields)
    return found


def _kind(base: str, many: str, package: str) -> str:
    base = _SAME.get(base, base)
    if base not in _SIMPLE:
        base = short(base) if "/" in base else f"{package}/{base}"
    size = many.strip("[]").strip()
    return base + (f"[{size}]" if size.isdigit() else "[]" if many else "")


@dataclass
class Difference:
    """Of a recorded type from ours.  same: none at all; missing: fields that it lacks, as (type, field); ignored: those that it has
    beyond ours; other: why it is another type altogether, or nothing."""

    same: bool = True
    missing: list[tuple[str, str]] = field(default_factory=list)
    ignored: list[tuple[str, str]] = field(default_factory=list)
    other: str = ""


def compare(name: str, recorded: Types, ours: Types) -> Difference:
    """How a recorded type and those that it is made of differ from ours of the same name."""
    difference, queue = Difference(), [short(name)]
    for current in queue:
        there, here = recorded.get(current), ours[current]
        if there is None:
            difference.other = f"the definition of {current} is missing"
            return difference
        kinds, known = dict(there), dict(here)
        changed = [one for one in known if one in kinds and kinds[one] != known[one]]
        if changed:
            difference.other = f"{current}.{changed[0]} is {kinds[changed[0]]}, not {known[changed[0]]}"
            return difference
        difference.same &= there == here
        difference.missing += [(current, one) for one in known if one not in kinds]
        difference.ignored += [(current, one) for one in kinds if one not in known]
        for one, kind in here:
            part = kind.partition("[")[0]
            if one in kinds and "/" in part and part not in queue:
                queue.append(part)
    return difference

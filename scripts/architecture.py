"""Draws docs/images/architecture.svg from the imports, and says which imports point the wrong way.

    python scripts/architecture.py [FILE]

A room is a sub-package or a module at the top of `evodevo_sim`.  A room may import from rooms above it in ROOMS, never from below.
"""

from __future__ import annotations

import ast
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "evodevo_sim" / "evodevo_sim"
FIGURE = ROOT / "docs" / "images" / "architecture.svg"

# From the foundation up: name, what it holds, where the paper tells of it.
ROOMS = (
    ("inputs", "how numbers are spelt and values shown; base of the errors about them", ""),
    ("text_file", "files that people write: YAML and JSON, read within limits", ""),
    ("extras", "which extra of the package brings a library", ""),
    ("command_process", "the life of a command: signals, standard streams, exit code", ""),
    ("whole_file", "files written whole or not at all", ""),
    ("lazy", "packages that import what they offer when it is asked for", ""),
    ("kernels", "how compiled code is made, cached and put into vector registers", ""),
    ("profiles", "heights of ground and ceiling, as numbers", ""),
    ("palettes", "colours of cells by their activation", "Figs. 3-5"),
    ("task_kinds", "the one table of tasks: swim, walk, chemotaxis, yours", "4"),
    ("parameters", "every number of the model, with unit and range", ""),
    ("worlds", "grounds to walk on: presets and files", "4.1"),
    ("genetics", "genome and its file; gene regulatory network: affinities, one step of all cells", "2.1"),
    ("development", "growth: division, adhesion, morphogens; Gabriel graph; body", "2.2, 2.3"),
    ("physics", "springs, chambers, drag; steps and their bounds; contact, friction; energy", "2.3, 4"),
    ("own_body", "bodies of your own, from files", ""),
    ("brain", "one control step of the network; its senses: scent, eyes, noise", "2.1, 4.3"),
    ("plant", "what a brain drives: the contract, and the simulated bodies", "4"),
    ("tasks", "evaluate: a kernel, a fitness and an audit for each task", "4"),
    ("live", "an animat step by step, at a pace; targets", "4.3"),
    ("hardware", "bodies of rubber and air: the line, its protocol, calibration, limits; an emulated one", ""),
    ("analysis", "what motions are like: gaits by name, turning", "4, Fig. 6"),
    ("identification", "across the reality gap: tracking error, numbers of a body fitted to recordings", ""),
    ("library", "what the package offers to Python", ""),
    ("ros", "the table of topics; messages to and from objects; callbacks that cannot end a node", ""),
    ("recording", "rosbag2 recordings: writer, readers", ""),
    ("view", "Rerun, and pictures as PNG, SVG, PDF", "Figs. 2-6"),
    ("nodes", "nodes: services and live topics, thin over the above", ""),
    ("commands", "command lines of ros2 run evodevo_sim", ""),
)
EDGE = "ros"  # from here on ROS, MCAP and Rerun may be imported


def modules() -> dict[str, Path]:
    """Dotted names below evodevo_sim, and their files."""
    found = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = file.relative_to(PACKAGE).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def room_of(module: str) -> str:
    return module.partition(".")[0]


def imports() -> list[tuple[str, str]]:
    """(importing module, imported module), within evodevo_sim; imports inside functions count too, those for types alone do not."""
    known, found = modules(), []
    for module, file in known.items():
        if not module:
            continue  # the package's own names are those of all rooms
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for_types = {
            id(node) for test in ast.walk(tree) if isinstance(test, ast.If) and "TYPE_CHECKING" in ast.dump(test.test)
            for node in ast.walk(test)
        }
        for node in ast.walk(tree):
            if id(node) in for_types:
                continue
            for name in _targets(node, module, file.name == "__init__.py"):
                target = name
                while target and target not in known:
                    target = target.rpartition(".")[0]
                if target:
                    found.append((module, target))
    return found


def _targets(node: ast.AST, module: str, is_package: bool) -> list[str]:
    if isinstance(node, ast.Import):
        return [name.name.removeprefix("evodevo_sim.") for name in node.names if name.name.startswith("evodevo_sim.")]
    if not isinstance(node, ast.ImportFrom):
        return []
    if node.level:
        here = module.split(".") if is_package else module.split(".")[:-1]
        base = here[: len(here) - node.level + 1] + (node.module.split(".") if node.module else [])
    elif node.module and node.module.partition(".")[0] == "evodevo_sim":
        base = node.module.split(".")[1:]
    else:
        return []
    return [".".join([*base, name.name]) for name in node.names]


def between_rooms() -> dict[tuple[str, str], list[tuple[str, str]]]:
    """(importing room, imported room): the imports behind it."""
    found: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for one, other in imports():
        if room_of(one) != room_of(other):
            found.setdefault((room_of(one), room_of(other)), []).append((one, other))
    return found


def faults() -> list[str]:
    """Rooms that nobody placed, and imports that point down."""
    order = [name for name, _, _ in ROOMS]
    rooms = {room_of(module) for module in modules()} - {""}
    wrong = [f"room {room!r} has no place in ROOMS" for room in sorted(rooms - set(order))]
    for (one, other), behind in sorted(between_rooms().items()):
        if {one, other} <= set(order) and order.index(one) < order.index(other):
            wrong += [f"{importing} imports {imported}, which stands below it" for importing, imported in behind]
    return wrong


def _needed(arrows: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Arrows without those that a longer way implies, so that the figure can be read."""
    below: dict[str, set[str]] = {}
    for name, _, _ in ROOMS:
        direct = {other for one, other in arrows if one == name}
        below[name] = direct.union(*(below.get(other, set()) for other in direct))
    return {
        (one, other) for one, other in arrows
        if not any(other in below.get(middle, set()) for start, middle in arrows if start == one and middle != other)
    }


def contents(room: str) -> str:
    """Modules of a room, and with a slash its sub-packages; of a single module nothing."""
    below = {name.split(".")[1] + "/" * (name.count(".") > 1) for name in modules() if name.startswith(room + ".")}
    return ", ".join(sorted(name for name in below if name + "/" not in below))


def _rows(names: Sequence[str], text: dict[str, str]) -> dict[str, tuple[float, float]]:
    """Top and height of each room, inches downward from 0."""
    top, rows = 0.0, {}
    for name in names:
        height = 0.46 + 0.15 * len(text[name].splitlines())
        rows[name], top = (top, height), top + height + 0.1
    return rows


def _lanes(names: Sequence[str], trunks: dict[str, list[str]]) -> dict[str, int]:
    """A lane for the trunk of each imported room, short ones first, so that no two lie upon each other."""
    lanes: dict[str, int] = {}
    spans: dict[str, tuple[int, int]] = {to: (names.index(to), max(names.index(one) for one in ones)) for to, ones in trunks.items()}
    for to in sorted(trunks, key=lambda name: (spans[name][1] - spans[name][0], spans[name])):
        first, last = spans[to]
        taken = {lanes[other] for other in lanes if spans[other][0] <= last and first <= spans[other][1]}
        lanes[to] = next(lane for lane in range(len(trunks)) if lane not in taken)
    return lanes


def draw(path: Path) -> None:
    """Write the figure: a row for each room, and for each imported room a trunk that leads up to it from all that import from it."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "evodevo"
    matplotlib.rcParams["svg.fonttype"] = "none"  # text stays text: small, and found by a search
    import matplotlib.pyplot as plt

    present = {room_of(module) for module in modules()}
    rooms = [room for room in ROOMS if room[0] in present]
    names = [name for name, _, _ in rooms]
    text = {name: "\n".join(textwrap.wrap(contents(name), 92)) for name in names}
    rows = _rows(names, text)
    trunks: dict[str, list[str]] = {}
    for one, other in sorted(_needed(set(between_rooms())), key=lambda arrow: [names.index(room) for room in arrow]):
        trunks.setdefault(other, []).append(one)
    lanes = _lanes(names, trunks)
    wide, lane_width = 8.4, 0.27
    right = wide + lane_width * (max(lanes.values()) + 2)
    bottom = max(top + height for top, height in rows.values())
    figure = plt.figure(figsize=(right + 0.3, bottom + 0.3))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_xlim(-0.15, right + 0.15)
    axes.set_ylim(bottom + 0.15, -0.15)
    axes.axis("off")

    # Where lines touch a box: its own trunk's arrowhead near the top, below it a line for each room that it imports from.
    leaving = {name: [to for to in sorted(trunks, key=lambda to: lanes[to]) if name in trunks[to]] for name in names}
    colours = ("#1f5fa8", "#b3541e", "#2b7d4f", "#8a3f8f", "#5b5b5b", "#a8872a", "#b02a4a", "#1d7f8c")
    for to, ones in trunks.items():
        colour, x = colours[names.index(to) % len(colours)], wide + lane_width * (lanes[to] + 1)
        line = {"color": colour, "lw": 1.3, "solid_capstyle": "round"}
        head = rows[to][0] + 0.13
        touch = {one: rows[one][0] + rows[one][1] - 0.11 * (len(leaving[one]) - leaving[one].index(to)) for one in ones}
        axes.plot((x, x), (head, max(touch.values())), **line)
        arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.3, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=(wide, head), xytext=(x, head), arrowprops=arrow)
        for y in touch.values():
            axes.plot((wide, x), (y, y), **line)
            axes.plot(x, y, "o", color=colour, ms=3.2)
    edge_from = names.index(EDGE)
    for k, (name, what, section) in enumerate(rooms):
        top, height = rows[name]
        face = "#e6eff8" if k < edge_from else "#fcebd9"
        axes.add_patch(plt.Rectangle((0, top), wide, height, facecolor=face, edgecolor="0.45", lw=0.8, zorder=3))
        axes.text(0.12, top + 0.22, name, va="center", fontsize=11, fontweight="bold", zorder=4)
        if section:
            axes.text(wide - 0.12, top + 0.22, f"paper {section}", ha="right", va="center", fontsize=8.5, color="0.3", zorder=4)
        axes.text(1.8, top + 0.22, what, va="center", fontsize=9.5, zorder=4)
        for number, part in enumerate(text[name].splitlines()):
            axes.text(1.8, top + 0.45 + 0.15 * number, part, va="center", fontsize=8, color="0.3", zorder=4)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else FIGURE)
    wrong = faults()
    print("\n".join(wrong) or "all imports point to rooms above")
    sys.exit(bool(wrong))

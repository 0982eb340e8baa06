"""Draws docs/images/architecture.svg from the imports, and says which imports point the wrong way.

    python scripts/architecture.py [FILE]

A room is a sub-package or a module at the top of `evodevo_sim`.  A room may import from rooms above it in ROOMS, never from below.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "evodevo_sim" / "evodevo_sim"
FIGURE = ROOT / "docs" / "images" / "architecture.svg"

# From the foundation up: name, what it holds, where the paper tells of it.
ROOMS = (
    ("inputs", "numbers and errors of what people give", ""),
    ("text_file", "YAML and JSON with limits", ""),
    ("extras", "what an extra brings", ""),
    ("command_process", "signals, streams, exit codes", ""),
    ("whole_file", "files written whole or not at all", ""),
    ("lazy", "packages import what is asked for", ""),
    ("kernels", "how compiled code is made", ""),
    ("profiles", "heights of ground and ceiling", ""),
    ("task_kinds", "table of tasks", "4"),
    ("parameters", "every number of the model", ""),
    ("worlds", "grounds to walk on", "4.1"),
    ("genetics", "genome, regulatory network", "2.1"),
    ("development", "growth, Gabriel graph, body", "2.2, 2.3"),
    ("physics", "forces, steps, contact, energy", "2.3, 4"),
    ("own_body", "bodies from files", ""),
    ("brain", "one control step of the network", "2.1, 4"),
    ("plant", "what a brain drives", "4"),
    ("tasks", "swim, walk, chemotaxis; audits", "4"),
    ("live", "an animat at a pace", ""),
    ("analysis", "gaits, turning", "4, Fig. 6"),
    ("library", "what the package offers", ""),
    ("ros", "messages, processes, command lines", ""),
    ("recording", "rosbag2 in MCAP", ""),
    ("view", "Rerun, figures", "Figs. 2-6"),
    ("nodes", "simulator, chase", ""),
    ("commands", "audit, gait, replay, ...", ""),
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
            for target in _targets(node, module, file.name == "__init__.py"):
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


def floors() -> dict[str, int]:
    """The floor of each room: one above the highest of those that it imports from."""
    arrows, height = between_rooms(), {}
    for name, _, _ in ROOMS:
        height[name] = max((height[other] + 1 for one, other in arrows if one == name and other in height), default=0)
    return height


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


def draw(path: Path) -> None:
    """Write the figure.  An arrow leads from a room to one that it imports from."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "evodevo"
    import matplotlib.pyplot as plt

    present = {room_of(module) for module in modules()}
    rooms = [room for room in ROOMS if room[0] in present]
    height = {name: floor for name, floor in floors().items() if name in present}
    names = [name for name, _, _ in rooms]
    wide, high = 3.3, 0.9
    place = {}
    for floor in range(max(height.values()) + 1):
        row = [name for name in names if height[name] == floor]
        for k, name in enumerate(row):
            place[name] = ((k - (len(row) - 1) / 2) * (wide + 0.5), floor * (high + 0.65))
    figure, axes = plt.subplots(figsize=(11, 0.82 * (max(height.values()) + 1) + 0.8))
    edge_from = names.index(EDGE)
    for one, other in sorted(_needed(set(between_rooms()))):
        if one in place and other in place:
            (x, y), (u, v) = place[one], place[other]
            bend = 0.0 if height[one] - height[other] == 1 else 0.12 * (1 if x <= u else -1)
            axes.annotate(
                "", xy=(u, v + high / 2), xytext=(x, y - high / 2),
                arrowprops={"arrowstyle": "-|>", "color": "0.55", "lw": 0.9, "connectionstyle": f"arc3,rad={bend}", "shrinkA": 0, "shrinkB": 0},
            )
    for k, (name, what, section) in enumerate(rooms):
        x, y = place[name]
        colour = "#dbe9f6" if k < edge_from else "#fbe6cf"
        axes.add_patch(plt.Rectangle((x - wide / 2, y - high / 2), wide, high, facecolor=colour, edgecolor="0.35", lw=0.9, zorder=3))
        axes.text(x, y + 0.18, name, ha="center", va="center", fontsize=10, fontweight="bold", zorder=4)
        below = what + (f"  ({section})" if section else "")
        axes.text(x, y - 0.2, below, ha="center", va="center", fontsize=6.8, zorder=4)
    axes.set_xlim(min(x for x, _ in place.values()) - wide * 0.6, max(x for x, _ in place.values()) + wide * 0.6)
    axes.set_ylim(-high, max(y for _, y in place.values()) + high)
    axes.axis("off")
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else FIGURE)
    wrong = faults()
    print("\n".join(wrong) or "all imports point to rooms above")
    sys.exit(bool(wrong))

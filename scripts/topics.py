"""Writes the table of topics in docs/reference/messages.md from `evodevo_sim.ros.topics`.

    python scripts/topics.py
"""

from __future__ import annotations

import re
from pathlib import Path

from evodevo_sim.recording.definitions import type_name
from evodevo_sim.ros.topics import DRAWN, TOPICS

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "messages.md"
_PLACE = re.compile(r"(?<=<!-- topics -->\n).*?(?=<!-- end of topics -->)", re.DOTALL)


def table() -> str:
    """The table, as Markdown."""
    rows = [("topic", "type", "service", "published by", "in `Recording`", "what")]
    for topic in (*TOPICS, *DRAWN):
        kept = "of each life" if topic.lives else "all" if topic.many else "the last"
        where = f"`{topic.attribute}`, {kept}" if topic.attribute else "not read"
        kind = f"`{type_name(topic.type).replace('/msg/', '/')}`"
        rows.append((f"`{topic.name}`", kind, topic.service.name, f"`{topic.by}`" if topic.by else "recorded only", where, topic.what))
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]]) + "\n"


def with_table(text: str) -> str:
    """A page with the table in its place."""
    return _PLACE.sub(lambda _: table(), text)


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8")), encoding="utf-8")

"""Films as web pages: one file that asks no network for anything."""

from __future__ import annotations

import html
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

# A browser that keeps to this asks nobody for anything: what a page needs is in it.
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"


def asset(name: str) -> str:
    """The text of a file beside this one."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def whole_page(title: str, body: str, styles: Sequence[str] = (), scripts: Sequence[str] = ()) -> str:
    """A page that stands alone.  Args: body: HTML; styles, scripts: texts of CSS and JavaScript."""
    parts = [
        "<!DOCTYPE html>", '<html lang="en">', "<head>", '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">', '<link rel="icon" href="data:,">',
        f"<title>{html.escape(title)}</title>", *(f"<style>\n{text}</style>" for text in styles), "</head>", "<body>", body,
        *(f"<script>\n{text}</script>" for text in scripts), "</body>", "</html>",
    ]
    return "\n".join(parts) + "\n"


def film_figure(document: dict[str, Any], title: str, about: str = "", alone: bool = False, level: int = 2) -> str:
    """A film as a part of a page that has player.css, picture.js and player.js.

    Args: document: of `packing.pack`; about: a line below the title; alone: whether it plays at once, and hears all keys of the
        page; level: of its heading.
    """
    data = json.dumps({**document, "label": label_of(document, title)}, separators=(",", ":")).replace("<", "\\u003c")
    said = "".join(f'<p class="about">{html.escape(line)}</p>' for line in (about, *document["notes"]) if line)
    return (
        f'<figure class="film"{" data-alone" if alone else ""}>'
        f"<figcaption><h{level}>{html.escape(title)}</h{level}>{said}</figcaption>"
        f'<noscript><p class="about">The film plays where JavaScript is allowed.</p></noscript>'
        f'<script type="application/json">{data}</script></figure>'
    )


def label_of(document: dict[str, Any], title: str) -> str:
    """What a screen reader says of a film."""
    growth, life = document["growth"], document["life"]
    parts = []
    if growth:
        parts.append(f"growth from {growth['count'][0]} to {growth['count'][-1]} cells in {growth['steps'][-1]} steps")
    if life:
        parts.append(f"{life['milliseconds'][-1] / 1e3:.1f} s of motion of {life['cells']} cells")
    return f"Film of {title}: {', then '.join(parts)}"


def film_page(document: dict[str, Any], title: str, about: str = "") -> str:
    """A page that is a film alone."""
    body = f"<main>{film_figure(document, title, about, alone=True, level=1)}</main>"
    return whole_page(title, body, [asset("page.css"), asset("player.css")], [asset("picture.js"), asset("player.js")])

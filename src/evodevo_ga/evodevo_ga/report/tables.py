"""Tables and texts of a page."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence


def text(value: object) -> str:
    """A value as a page shows it: escaped."""
    return html.escape(str(value))


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[object]], shown: bool = True) -> str:
    """A table whose first column names its rows; a narrow page scrolls it alone.  Args: shown: whether all see the caption."""
    body = "".join(
        f'<tr><th scope="row">{text(first)}</th>{"".join(f"<td>{text(value)}</td>" for value in rest)}</tr>' for first, *rest in rows
    )
    names = "".join(f'<th scope="col">{text(name)}</th>' for name in head)
    seen = f'<p class="caption" aria-hidden="true">{text(caption)}</p>' if shown else ""  # it stays where the table scrolls
    wide = ' class="wide"' if len(head) > 3 else ""
    return (
        f'{seen}<div class="scrolls" tabindex="0" role="region" aria-label="{text(caption)}">'
        f'<table{wide}><caption class="spoken">{text(caption)}</caption>'
        f"<thead><tr>{names}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def paragraph(said: str, kind: str = "") -> str:
    """A paragraph.  Args: kind: its class."""
    mark = f' class="{kind}"' if kind else ""
    return f"<p{mark}>{text(said)}</p>"


def commands(lines: Sequence[str]) -> str:
    """Lines to be typed."""
    return f'<pre tabindex="0" role="region" aria-label="commands"><code>{text(chr(10).join(lines))}</code></pre>'


def download(name: str, content: str) -> str:
    """A link that saves a text as a file; the page holds it."""
    data = base64.b64encode(content.encode()).decode()
    return f'<a download="{text(name)}" href="data:text/plain;base64,{data}">{text(name)}</a>'


def number(value: float, digits: int = 4) -> str:
    """A number, or a dash where it is not known."""
    if value != value:
        return "-"
    return f"{value:,.0f}" if abs(value) >= 10.0**digits else f"{value:.{digits}g}"

"""Figures as files: PNG for the screen, SVG and PDF for papers.  The same figure gives the same bytes at any time."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

# No date in any of them.
_UNDATED = {".png": {}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
# PDF embeds its fonts as TrueType, which journals ask for and in which text can be found; SVG holds text as outlines, which look
# the same where the font is missing.  Names of SVG elements follow from their content.
_STYLE: Any = {"pdf.fonttype": 42, "svg.fonttype": "path", "svg.hashsalt": "evodevo"}


def save_figure(figure: Figure, path: str | os.PathLike, **options: Any) -> None:
    """Save a figure in the format that the ending of `path` names, one of `files.PICTURES`.  Args: options: of `Figure.savefig`."""
    ending = Path(path).suffix.lower()
    with matplotlib.rc_context(_STYLE):
        figure.savefig(path, format=ending[1:], metadata=_UNDATED[ending], **options)

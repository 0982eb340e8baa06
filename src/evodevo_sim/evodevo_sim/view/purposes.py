"""One layout of the Rerun viewer for each purpose: watch, grow, think, evolve."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..recording import Recording, RecordingError
from ..recording.facts import purposes
from ..recording.life import Life
from .palettes import DEFAULT

PURPOSES = {
    "watch": "growth and motion, with curves and the run",
    "grow": "divisions, lineage, clones, morphogens",
    "think": "the network, concentrations of a cell, muscles and their phases",
    "evolve": "fitness, diversity, descent, and a gallery of champions",
}


def chosen(recording: Recording, life: Life, show: str | None) -> str:
    """The purpose to show: the one that is asked for, or else to watch, or of a run without a life, to see how it evolved.

    Raises RecordingError where the recording does not serve it; the message says what is missing, and what can be shown instead.
    """
    missing = purposes(recording, life)
    if show is None:
        return "watch" if not missing["watch"] or missing["evolve"] else "evolve"
    if missing[show]:
        others = [name for name, lacks in missing.items() if not lacks]
        instead = f"--show {' or '.join(others)} works" if others else "there is nothing to show"
        raise RecordingError(f"{recording.path} cannot be shown by --show {show}: it holds {missing[show]}; {instead}")
    return show


def log_purpose(
    stream: Any, recording: Recording, life: Life, show: str, step: Callable[[str], None], palette: str = DEFAULT, cell: int | None = None,
) -> Any:
    """Log what a purpose shows.  Args: step: called with the name of each part before it is logged.  Returns: its blueprint."""
    import rerun as rr

    from .summary import markdown

    notes = ""
    if show == "watch":
        from .rerun_log import log_recording
        from .views import blueprint

        layout = blueprint(recording, life)
        log_recording(stream, recording, life, step, palette)
        return layout
    if show == "grow":
        from . import grow_view

        step("growth")
        story = grow_view.log_growth(stream, recording, life, palette)
        layout = grow_view.blueprint(life, story)
    elif show == "think":
        from . import think_view

        step("thoughts")
        thoughts, analysis = think_view.log_thoughts(stream, recording, life, cell, palette)
        layout, notes = think_view.blueprint(life, thoughts, analysis, cell), think_view.trust(thoughts)
    else:
        from ..parameters import Task
        from ..ros.messages import task_from_message
        from . import evolve_view

        step("champions")
        task = Task() if recording.settings is None else task_from_message(recording.settings.task)
        gallery = evolve_view.log_run(stream, recording, task, palette)
        layout = evolve_view.blueprint(gallery, min(len(recording.champions), evolve_view.MOST))
    text = (f"*{notes}.*\n\n" if notes else "") + markdown(recording, life, palette)
    stream.log("summary", rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN), static=True)
    return layout

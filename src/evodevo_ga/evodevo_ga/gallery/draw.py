"""From the directory of a run to its gallery."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from evodevo_sim.view.body_map import BodyMap, gaits_in

from .content import Content, read_content
from .lives import Life, folder_of, frame_time, keep, live

_BETWEEN = "  ·  "


def gallery(
    directory: Path, audits: bool = True, workers: int = 1, done: Callable[[], object] = lambda: None, say: Callable[[str], object] = print
) -> BodyMap:
    """The map of a run's archive; its animals' genomes, with their audits, are left in the run's directory.

    Args: done: called after each animal; say: told what must be known, a line each.  Raises ResumeError, GalleryError, OSError.
    """
    content, notes = read_content(directory)
    for line in notes:
        say(line)
    lives = live(content, audits, workers, done)
    keep(lives, content, folder_of(directory))
    return map_of(content, lives)


def map_of(content: Content, lives: Sequence[Life]) -> BodyMap:
    """The map of lives."""
    shown = [life.shown for life in lives]
    facts = [
        f"{len(lives)} of {content.x.bins * content.y.bins} kinds", gaits_in(shown), f"best {max(one.fitness for one in shown):.4g} m",
        audited(lives), best_that_stands(lives), f"{content.evaluations} evaluations, seed {content.seed}",
    ]
    title = f"{content.name}: unlike animals that {'walk' if content.task.has_ground else 'swim'}"
    return BodyMap(title, _BETWEEN.join(filter(None, facts)), content.x, content.y, shown, frame_time(content.task))


def best_that_stands(lives: Sequence[Life]) -> str:
    """The fittest whose audit stands, in words, where the fittest of all fails."""
    best = max(lives, key=lambda life: life.shown.fitness)
    others = [life for life in lives if life.stands]
    if best.stands is not False:
        return ""
    if not others:
        return "none that stands"
    other = max(others, key=lambda life: life.shown.fitness)
    return f"best that stands {other.shown.fitness:.4g} m ({other.file})"


def audited(lives: Sequence[Life]) -> str:
    """How many audits stand, in words; empty where there were none."""
    verdicts = [life.stands for life in lives if life.stands is not None]
    return f"{sum(verdicts)} of {len(verdicts)} audits stand" if verdicts else ""

"""Records a whole life: growth, body and locomotion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..analysis.stretches import filled, speeds
from ..ros.messages import body_message, cell_states_message, graph_message, target_message, time_message
from ..ros.topics import BODY, CELL_STATES, GROWTH_BODY, GROWTH_STATES, TARGET_POSE
from ..tasks.evaluation import Performance


def seen_alone(performance: Performance) -> Performance:
    """The same life without the moments in which nothing was seen, and what was not seen of others filled in (`stretches.filled`)."""
    seen = np.isfinite(performance.position).any(axis=(1, 2))
    time = performance.time[seen]
    position, velocity = (filled(time, values[seen]) for values in (performance.position, performance.velocity))
    whole = np.isfinite(position).all(axis=(1, 2))
    velocity = speeds(time, position, velocity)
    return replace(
        performance, time=time[whole], position=position[whole], velocity=velocity[whole], activation=performance.activation[seen][whole]
    )


def record_performance(recorder: Any, performance: Performance, stamp: int) -> None:
    """Write a life to a `Recorder`, from `stamp` ns on.

    Growth comes first, a regulation step as long as a control step, and the stamps in the messages run on from it.
    """
    step = float(performance.time[1] - performance.time[0])
    edges = np.empty((0, 2))
    for k, (position, activation) in enumerate(zip(performance.growth, performance.growth_activation)):
        seconds, alive = k * step, np.isfinite(position[:, 0])
        now = stamp + round(seconds * 1e9)
        if not np.array_equal(edges, performance.growth_edges[k]):
            edges = performance.growth_edges[k]
            recorder.write(GROWTH_BODY.name, graph_message(position[alive], edges, stamp=seconds), now)
        still = np.zeros((int(alive.sum()), 2))
        recorder.write(GROWTH_STATES.name, cell_states_message(position[alive], still, activation[alive], k, seconds), now)
    if performance.body is None:
        return
    born = len(performance.growth) * step
    recorder.write(BODY.name, body_message(performance.body, stamp=born), stamp + round(born * 1e9))
    if performance.target is not None:
        target = target_message(performance.target, time_message(born))
        recorder.write(TARGET_POSE.name, target, stamp + round(born * 1e9))
    states = zip(performance.time, performance.position, performance.velocity, performance.activation)
    for k, (time, position, velocity, activation) in enumerate(states):
        if np.isfinite(position).any():
            seconds = born + time
            recorder.write(
                CELL_STATES.name, cell_states_message(position, velocity, activation, k, seconds), stamp + round(seconds * 1e9)
            )

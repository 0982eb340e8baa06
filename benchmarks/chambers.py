"""How many bodies turn a chamber inside out under extreme actuation, by the ratio of pressure to stiffness c_p / k.

    python benchmarks/chambers.py [--bodies 200] [--cells 32] [--seconds 10]

Every cell expands or contracts in full, neighbours against each other, and swaps at each half period: rest lengths of 0.6 to 1.4.
The rest is as in the default swim task but for the steps, 8 times as fine, so that what inverts does so by its own forces.
"""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np
from evodevo_sim.parameters import with_settings
from evodevo_sim.physics.control_step import advance
from evodevo_sim.physics.forces import Ramp, make_law, make_scratch, set_rest_lengths
from evodevo_sim.physics.soundness import INVERTED, SOUND, UNSTABLE
from evodevo_sim.physics.step_size import choose_substeps, substeps_in_drag
from random_bodies import random_body
from tqdm import tqdm

from evodevo_sim import Task

RATIOS = (0.25, 0.5, 1.0, 2.0)
PERIODS = (10, 30, 100)  # control steps
FINER = 8


def alternating(rng, body):
    """+1 or -1 for every cell, unlike most of its neighbours: greedy, from random signs."""
    sign = rng.choice([-1.0, 1.0], len(body.position))
    for _ in range(4):
        for i in rng.permutation(len(sign)):
            near = np.concatenate((body.spring_b[body.spring_a == i], body.spring_a[body.spring_b == i]))
            total = sign[near].sum()
            sign[i] = -np.sign(total) if total else sign[i]
    return sign


def live(body, sign, period, task, steps):
    """How the body's life ends."""
    law = make_law(task.material.arguments(), task.scene.arguments())
    substeps = choose_substeps(body, law, task.control_step)
    position, velocity = body.position.T.copy(), np.zeros(body.position.T.shape)
    rest, before, scratch = body.rest_length.copy(), body.rest_length.copy(), make_scratch(body)
    for k in range(steps):
        before[:] = rest
        set_rest_lengths(body, law, sign * (1.0 if k // (period // 2) % 2 else -1.0), rest)
        many = FINER * substeps_in_drag(body, law, position, velocity, task.control_step, substeps, scratch)
        outcome = advance(body, law, Ramp(before, rest, 0.0), position, velocity, task.control_step, many, scratch)
        if outcome != SOUND:
            return outcome
    return SOUND


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", type=int, default=200)
    parser.add_argument("--cells", type=int, default=32)
    parser.add_argument("--seconds", type=float, default=10.0, help="of life (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    count = {ratio: Counter() for ratio in RATIOS}
    for number in tqdm(range(given.bodies), unit="body"):
        rng = np.random.default_rng((given.seed, number))
        body = random_body(rng, "grown", given.cells, Task().material.mass)
        sign, period = alternating(rng, body), int(rng.choice(PERIODS))
        for ratio in RATIOS:
            task = with_settings(Task(), {"material.pressure": ratio * Task().material.stiffness})
            count[ratio][live(body, sign, period, task, round(given.seconds / task.control_step))] += 1
    print(f"{given.bodies} bodies of {given.cells} cells, k = {Task().material.stiffness:g} N/m, {given.seconds:g} s")
    print(f"{'c_p / k':>8}{'sound':>8}{'inverted':>10}{'unstable':>10}")
    for ratio, ends in count.items():
        print(f"{ratio:8g}{ends[SOUND]:8}{ends[INVERTED]:10}{ends[UNSTABLE]:10}")


if __name__ == "__main__":
    main()

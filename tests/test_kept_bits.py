"""Evaluations keep their bits: a change of structure or speed alters no fitness and no distance, to the last bit."""

import json
from pathlib import Path

import pytest
from evodevo_sim.tasks.evaluation import invalid
from evodevo_sim.tasks.outcome import Status
from kept import bits, cases

from evodevo_sim import evaluate

KEPT = json.loads(Path(__file__).with_name("kept.json").read_text())


@pytest.mark.parametrize("case", list(cases()), ids=lambda case: case[0])
def test_bits_are_those_that_were_kept(case):
    name, genome, task, seed = case
    assert bits(evaluate(genome, task, seed)) == KEPT[name]


def test_every_kind_of_end_and_size_is_among_them_but_for_lives_that_a_bar_stops():
    ends = {row[2] for row in KEPT.values()} | {invalid("no genome").status.name}
    assert ends == {status.name for status in Status if status != Status.STOPPED}
    assert set(KEPT) == {case[0] for case in cases()} and len(KEPT) >= 30
    sizes = {row[3] for row in KEPT.values()}
    assert {8, 16, 32, 64} <= sizes

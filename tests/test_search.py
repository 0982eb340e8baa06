"""Searches behind one interface: the bits of each, whole runs and resumed ones, and schemes from outside."""

import numpy as np
import pytest
from evodevo_ga import Evolution, Settings, scheme
from evodevo_sim import random_genome
from searches import run_on

GIVEN = tuple(random_genome(np.random.default_rng(k), 6) for k in (1, 2, 3))
SMALL = {"population": 30, "generations": 9}
CASES = {
    "panmictic": ({}, "panmictic", "swim", ()),
    "paper": ({}, "paper", "swim", ()),
    "alps": ({"age_gap": 2, "layers": 3}, "alps", "swim", ()),
    "niches": ({"founders": 90}, "niches", "swim", ()),
    "one layer": ({"layers": 1, "elite": 5}, "alps", "swim", ()),
    "one niche": ({"niches": 1, "founders": 0}, "niches", "swim", ()),
    "layers of a population": ({"layers": 5, "age_gap": 1, "elite": 1}, "panmictic", "walk", ()),
    "niches of a population": ({"niches": 10, "elite": 1, "tournament": 3}, "paper", "walk", GIVEN[:1]),
    "niches in place of layers": ({"layers": 1, "niches": 3}, "alps", "swim", GIVEN),
    "founders in layers": ({"layers": 3, "founders": 100, "age_gap": 3}, "alps", "swim", GIVEN[:2]),
    "from champions": ({"start_share": 0.7}, "panmictic", "chemotaxis", GIVEN),
    "layered seekers": ({"age_gap": 3, "layers": 3, "crossover": 0.6}, "alps", "chemotaxis", GIVEN[:2]),
    "seekers in niches": ({"founders": 60, "start_share": 1.0}, "niches", "chemotaxis", GIVEN),
}
DIGESTS = {  # of seeds 1 and 2^63 - 1
    "panmictic": ["48a11b91c0e2ce11", "87949051a7f17f8a"],
    "paper": ["eb540ba754fbf3d8", "b93300efa9ceed32"],
    "alps": ["19835dccc169396a", "988b05622b5fbe78"],
    "niches": ["10fdb4506ac1f1f2", "b9603341f6718890"],
    "one layer": ["bc56d8e5db5213fd", "8da905803a711c54"],
    "one niche": ["e53f9ca74d40d965", "6b4828712a9c9b4b"],
    "layers of a population": ["6276e6fc77644a0f", "14cee51e3bbc188a"],
    "niches of a population": ["ca871da191e5cf1c", "3756d7e3a79cc3be"],
    "niches in place of layers": ["7c75d41553b81e06", "2c510340ad4f4faf"],
    "founders in layers": ["ccac48f843e0fa7f", "0db6d71b6cbadfdd"],
    "from champions": ["cbdc03a07e147779", "cc4684a42de23b15"],
    "layered seekers": ["d2ee0130720be799", "2fc41563cd1d1d1c"],
    "seekers in niches": ["a3a453090a94074a", "569f0360d738434d"],
}


def evolution_of(case, seed):
    numbers, name, task, start = CASES[case]
    return Evolution(Settings(**SMALL | scheme(name, task) | numbers), seed, start)


@pytest.mark.parametrize("case", CASES)
def test_a_search_gives_the_same_bits_for_ever(case):
    assert [run_on(evolution_of(case, seed)) for seed in (1, 2**63 - 1)] == DIGESTS[case]

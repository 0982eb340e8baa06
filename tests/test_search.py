"""Searches behind one interface: the bits of each, whole runs and resumed ones, and schemes from outside."""

import copy
import json
import re
from pathlib import Path

import numpy as np
import pytest
from evodevo_ga.arguments import parse
from searches import run_on, stand_in

from evodevo_ga import SCHEMES, Evolution, Parents, Scheme, Search, Settings, child_of, register, scheme, schemes
from evodevo_sim import GenomeError, ParameterError, random_genome

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

PAGE = Path(__file__).parent.parent / "docs" / "guide" / "search.md"


def evolution_of(case, seed):
    numbers, name, task, start = CASES[case]
    return Evolution(Settings(**SMALL | scheme(name, task) | numbers | {"generations": SMALL["generations"]}), seed, start)


@pytest.mark.parametrize("case", CASES)
def test_a_search_gives_the_same_bits_for_ever(case):
    assert [run_on(evolution_of(case, seed)) for seed in (1, 2**63 - 1)] == DIGESTS[case]


@pytest.fixture
def registry():
    """What a test registers is gone afterwards."""
    before = dict(schemes._schemes)
    yield
    schemes._schemes.clear()
    schemes._schemes.update(before)


class Climb(Search):
    """Children of the champion alone; it counts how often one of them was better, and takes a scale of its own from that."""

    def __init__(self, settings, most=3):
        super().__init__(settings)
        self.most, self.gains = most, 0

    def breed(self, population, generation, rng):
        return [child_of(Parents(population[:1]), self.settings, rng) for _ in range(2 + self.gains % self.most)]

    def survive(self, population, children, generation):
        best = max(population + children, key=lambda one: one.evaluation.fitness)
        self.gains += best not in population
        return [*children[:2], best]

    def state(self):
        return {"gains": self.gains}

    def restore(self, state):
        self.gains = state["gains"]


def resumed(evolution):
    """It, rebuilt from nothing but a text."""
    return Evolution.resumed(json.loads(json.dumps(evolution.state(), allow_nan=False)))


@pytest.mark.parametrize("case", CASES)
def test_a_run_that_goes_on_from_its_state_has_the_same_bits(case):
    for generations in range(0, 9, 2):
        one = evolution_of(case, 5)
        run_on(one, generations)
        two = resumed(one)
        assert two.state() == one.state() and run_on(two) == run_on(one) and two.state() == one.state()


def test_genomes_that_were_asked_and_not_evaluated_are_asked_again():
    one = evolution_of("alps", 3)
    run_on(one, 3)
    before = one.state()
    asked = one.ask()
    assert one.state() == before and resumed(one).ask() == asked == one.ask()


def values(state):
    """(places, value) of all that a state holds, but the elements of lists beyond the first, which are like it."""
    found = [((), state)]
    for place, value in found:
        inner = value.items() if isinstance(value, dict) else list(enumerate(value))[:1] if isinstance(value, list) else ()
        found += [((*place, name), item) for name, item in inner]
    return found[1:]


def test_a_state_that_is_damaged_anywhere_is_refused_in_one_line():
    evolution = evolution_of("from champions", 1)
    run_on(evolution, 2)
    whole = evolution.state()
    places = [place for place, _ in values(whole) if place[0] != "search"]
    assert len(places) > 60
    for place in places:
        *path, last = place
        for damage in ("lost", None, "x"):
            state = copy.deepcopy(whole)
            holder = state
            for step in path:
                holder = holder[step]
            if damage != "lost":
                holder[last] = damage
            elif isinstance(holder, dict):
                del holder[last]
            if (
                (isinstance(holder, list) and damage == "lost")
                or (last == "cause" and damage == "x")
                or ("operators" in path and damage == "x")
            ):
                continue  # a shorter list, another text: as whole as it was
            with pytest.raises((ParameterError, GenomeError)) as refused:
                Evolution.resumed(state)
            assert "\n" not in str(refused.value) and len(str(refused.value)) <= 300


@pytest.mark.parametrize("name", ["panmictic", "paper", "alps", "niches", "climb", "sizes"])
def test_what_a_search_promises(registry, name):
    """Breeding changes nothing, the best is first and never lost, and every child comes from those that had stayed."""
    register(Scheme("climb", "children of the champion alone", {}, Climb))
    exec(example().split("task = ")[0], {})
    elsewhere = {"archive", "gaits", "one-body"}  # which grow bodies, in files of their own
    assert set(SCHEMES) - elsewhere == {"panmictic", "paper", "alps", "niches", "climb", "sizes"}  # a new one is added above
    evolution = Evolution(Settings(**scheme(name) | SMALL | {"founders": 0, "generations": 15}), 4, GIVEN, name)
    numbers, bred = {}, 0
    while not evolution.finished:
        before, state = {one.number: one for one in evolution.population}, evolution.state()
        asked = evolution.ask()
        if before:
            bred_twice = [evolution.search.breed(evolution.population, evolution.generation + 1, np.random.default_rng(9)) for _ in "12"]
            assert bred_twice[0] == bred_twice[1]
        assert evolution.state() == state and len({genome.key() for genome in asked}) == len(asked)
        evolution.tell([stand_in(genome) for genome in asked])
        fitness = [one.evaluation.fitness for one in evolution.population]
        assert fitness == sorted(fitness, reverse=True)
        assert fitness[0] >= max([one.evaluation.fitness for one in (*before.values(), *evolution.children)])
        assert [one.number for one in evolution.children] == list(range(bred, bred + len(evolution.children)))
        bred += len(evolution.children)
        numbers |= {one.number: one for one in evolution.children}
        for child in evolution.children:
            made = child.operators
            if not evolution.generation:
                before = numbers  # mutants of what was given, in the same generation
            assert set(child.parents) <= set(before) and ("crossover" in made) == (len(child.parents) == 2)
            assert (child.parents == ()) == (made[:1] in (("given",), ("random",)))
            if len(child.parents) == 1:
                assert (made == ()) == (child.genome == before[child.parents[0]].genome) or made[0] in ("duplicate", "delete")
        assert all(one.genome == numbers[one.number].genome and one.evaluation == stand_in(one.genome) for one in evolution.population)
    assert evolution.bred == bred


def test_a_scheme_from_outside_is_searched_with_by_its_name(registry):
    numbers = {"population": 12, "crossover": 0.0}
    register(Scheme("climb", "children of the champion alone", numbers, lambda settings: Climb(settings, most=5)))
    options = parse(["--scheme", "climb", "--generations", "6"])
    assert (options.scheme, options.settings.population, options.settings.crossover) == ("climb", 12, 0.0)
    evolution = Evolution(options.settings, 1, options.start, options.scheme)
    run_on(evolution, 3)
    assert evolution.search.most == 5 and len(evolution.ask()) < 9 and run_on(resumed(evolution)) == run_on(evolution)
    assert evolution.generation == 5


def test_a_scheme_from_outside_is_told_of_in_the_help(registry, capsys):
    register(Scheme("climb", "children of the champion alone: 100 % of them", {"population": 12}, Climb))
    with pytest.raises(SystemExit):
        parse(["--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "climb: children of the champion alone: 100 % of them" in said and "12 for climb" in said


def test_schemes_that_cannot_work_are_refused_in_one_line(registry, capsys):
    register(Scheme("climb", "children of the champion alone", {}, Climb))
    register(Scheme("climb", "children of the champion alone", {}, Climb))  # the same once more
    with pytest.raises(ParameterError, match=r"scheme 'climb' is taken: give yours another name than panmictic, .*, one-body, climb"):
        register(Scheme("climb", "another", {}, Climb))
    with pytest.raises(ParameterError, match="scheme 'mine': setting 'islands' is unknown: choose one of population, generations"):
        Scheme("mine", "", {"islands": 3})
    known = "panmictic, paper, alps, niches, archive, gaits, one-body, climb"
    with pytest.raises(ParameterError, match=f"scheme 'newton' is unknown: choose one of {known}"):
        Evolution(scheme="newton")
    with pytest.raises(TypeError):
        SCHEMES["climb"].settings["population"] = 3
    for arguments, says in (
        ("--scheme newton", f"scheme 'newton' is unknown: choose one of {known}"),
        ("--scheme climb --layers 5", "settings.layers is 5: give 1, the search of scheme 'climb' has no layers"),
    ):
        with pytest.raises(SystemExit) as left:
            parse(arguments.split())
        said = capsys.readouterr().err
        assert left.value.code == 2 and says in said and said.count("\n") == 1


@pytest.mark.parametrize("method, done", [("breed", "bred"), ("survive", "settled")])
def test_a_search_that_gives_nobody_is_named(registry, method, done):
    register(Scheme("empty", "gives nobody", {}, type("Empty", (Climb,), {method: lambda self, *_: []})))
    with pytest.raises(ValueError, match=f"the search of scheme 'empty' has {done} nobody"):
        run_on(Evolution(Settings(**SMALL), 1, scheme="empty"))


def example():
    return re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)[1]


def test_the_search_of_the_documentation_runs(registry, capsys):
    names = {}
    exec(example(), names)
    evolution = names["evolution"]
    assert evolution.generation == 2 and "sizes" in SCHEMES and parse(["--scheme", "sizes"]).settings.point_decades == 1.0
    cells = [one.evaluation.metrics.cells for one in evolution.population]
    assert len(set(cells)) == len(cells) > 1 and max(cells) <= 8
    assert capsys.readouterr().out.startswith("{")

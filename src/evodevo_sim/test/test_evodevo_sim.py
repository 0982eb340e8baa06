"""The installed package, as `colcon test` runs it: what needs no other package.  The suite is in `tests/` of the repository."""

from importlib.metadata import distribution

from evodevo_sim.parameters import with_settings

from evodevo_sim import Status, Task, champions, evaluate, load_champion


def test_a_champion_evaluates_to_the_same_bits_twice():
    task = with_settings(Task(), {"control_steps": 120})
    first = evaluate(load_champion("ribbon"), task)
    assert first.status == Status.OK and first.fitness > 0.0 and first == evaluate(load_champion("ribbon"), task)


def test_champions_are_installed():
    assert len(champions()) >= 7 and all(file.is_file() for file in champions().values())


def test_entry_points_load():
    commands = [one for one in distribution("evodevo_sim").entry_points if one.group == "console_scripts"]
    assert commands and all(callable(one.load()) for one in commands)

"""The parts of a run's wall time: each moment counts once, for the innermost part under way, and the parts add up to the whole."""

from evodevo_ga.times import REST, Times, table
from rich.console import Console


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_each_moment_counts_once_for_the_innermost_part():
    clock = Clock()
    times = Times(clock)
    clock.now = 1.0  # rest
    with times("outer"):
        clock.now = 3.0
        with times("inner"):
            clock.now = 7.0
        clock.now = 8.0
    with times("inner"):
        clock.now = 8.5
    clock.now = 10.0
    assert times.seconds() == {"outer": 3.0, "inner": 4.5, REST: 2.5}
    clock.now = 12.0
    assert sum(times.seconds().values()) == 12.0


def test_a_part_that_fails_is_over():
    clock = Clock()
    times = Times(clock)
    try:
        with times("part"):
            clock.now = 1.0
            raise KeyError
    except KeyError:
        clock.now = 3.0
    assert times.seconds() == {"part": 1.0, REST: 2.0}


def test_the_table_tells_shares():
    console = Console(width=80)
    with console.capture() as shown:
        console.print(table({"a part": 1.5, REST: 0.5}, "beside it: nothing"))
    text = shown.get()
    assert "2.0 s of wall time" in text and "75.0 %" in text and "25.0 %" in text and "beside it: nothing" in text

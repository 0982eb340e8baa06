"""Targets to chase: what files draw, what random ones keep, and what is wrong with a file in one line."""

import numpy as np
import pytest
from evodevo_sim.live.targets import Drawn, Random, load_points

from evodevo_sim import ParameterError


@pytest.mark.parametrize(
    "name, text",
    [("a.csv", "x,y\n1, 2\n\n# no more\n-3.5,4e0\n"), ("b.csv", "1,2\n-3.5,4\n"), ("c.yaml", "- [1, 2]\n- [-3.5, 4.0]\n")],
)
def test_points_come_from_csv_and_yaml(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    points = load_points(tmp_path / name)
    assert points.tolist() == [[1.0, 2.0], [-3.5, 4.0]]
    drawn = Drawn(points)
    assert [drawn.following((9.0, 9.0)) for _ in range(3)] == [(1.0, 2.0), (-3.5, 4.0), None]


@pytest.mark.parametrize(
    "name, text, says",
    [
        ("a.csv", "1,2\n3,four\n", "line 2: [3, 'four'] is no point"),
        ("b.csv", "1,2,3\n", "line 1"),
        ("c.csv", "1,nan\n", "line 1: [1, 'nan'] is no point"),
        ("d.csv", "", "is empty"),
        ("d2.csv", "x,y\n", "no points"),
        ("e.yaml", "- [1, 2]\n- {x: 1}\n", "point 2"),
        ("f.yaml", "x: 1\n", "holds no list"),
        ("g.yaml", "- [1, 2\n", "neither YAML nor JSON from line 2"),
        ("h.yaml", "- 7\n", "point 1: 7 is no point"),
    ],
)
def test_a_file_that_draws_nothing_is_named_with_the_mend(tmp_path, name, text, says):
    (tmp_path / name).write_text(text)
    with pytest.raises(ParameterError) as caught:
        load_points(tmp_path / name)
    assert says in str(caught.value) and "give a line" in str(caught.value) and "\n" not in str(caught.value)


def test_what_is_no_file_or_no_text_is_named(tmp_path):
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfd\x00")
    for path in (tmp_path / "none.csv", tmp_path / "binary.csv"):
        with pytest.raises(ParameterError, match="give a line"):
            load_points(path)


def test_random_targets_are_seeded_and_keep_their_distance():
    one, same, other = Random(3, 5.0, 9.0), Random(3, 5.0, 9.0), Random(4, 5.0, 9.0)
    centre = np.array([2.0, -1.0])
    targets = [one.following(centre) for _ in range(50)]
    assert targets == [same.following(centre) for _ in range(50)] != [other.following(centre) for _ in range(50)]
    away = np.hypot(*(np.array(targets) - centre).T)
    assert 5.0 <= away.min() < 5.5 and 8.5 < away.max() <= 9.0
    with pytest.raises(ParameterError, match="nearer first"):
        Random(1, 9.0, 5.0)

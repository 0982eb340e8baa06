"""Bodies of your own through the command: closed forms, a second solver written from the laws, and every bad input."""

import copy
import json

import numpy as np
import pytest
import yaml
from evodevo_sim.commands.simulate import main
from evodevo_sim.physics.energy import stored_energy
from evodevo_sim.recording import read_recording
from plain import grid, solve

from evodevo_sim import load_body, make_own_body, simulate_body

SQUARE = {"position": [[0, 0], [1, 0], [1, 1], [0, 1]], "springs": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]]}


@pytest.fixture
def command(tmp_path):
    """Runs the command on a document; returns the NPZ file's arrays."""
    count = iter(range(100))

    def run(document, scene, duration, *more, code=0):
        k = next(count)
        body = tmp_path / f"body{k}.json"
        body.write_text(json.dumps(document))
        out, npz = tmp_path / f"bag{k}", tmp_path / f"{k}.npz"
        arguments = [body, "--scene", scene, "--duration", duration, "--out", out, "--npz", npz, *more]
        assert main([str(a) for a in arguments]) == code
        run.bag = out
        return np.load(npz)

    return run


def energy(document, scene, result):
    """Total energy of every frame, J, with rest lengths at rest."""
    from evodevo_sim.own_body.motion import make_scene

    s = make_scene(make_own_body(document), scene)
    frames = zip(result["position"], result["velocity"])
    return np.array([sum(stored_energy(s.body, s.law, s.body.rest_length, s.gravity, p.T.copy(), v.T.copy())) for p, v in frames])


# --- files in, files out -----------------------------------------------------------------------------------------------


def test_frames_come_every_step_or_60_times_a_second_and_at_the_end(command):
    result = command(SQUARE, "swim", 0.99)
    assert result["time"] == pytest.approx([*np.arange(60) / 60, 0.99]) and len(result["time"]) == 61
    assert {key: (array.dtype.name, array.shape) for key, array in result.items()} == {
        "time": ("float64", (61,)), "position": ("float64", (61, 4, 2)), "velocity": ("float64", (61, 4, 2)),
    }
    assert command(SQUARE, "swim", 0.1, "--dt", 0.001)["time"] == pytest.approx(np.arange(101) / 1000, abs=1e-15)


def test_the_recording_replays_the_motion(command):
    document, _, _ = grid()
    result = command(document, "swim", 0.5, "--dt", 1 / 240)
    recording = read_recording(command.bag)
    assert recording.body.cells == 16 and len(recording.body.chamber_area) == 15
    assert len(recording.states) == 31 and recording.states[-1].step == 120
    assert np.array_equal(recording.states[-1].position_x, result["position"][-1, :, 0])
    a = {key: np.array(value) for key, value in document["activation"].items()}
    assert recording.states[-1].activation == pytest.approx(a["amplitude"] * np.sin(np.pi * a["frequency"] + a["phase"]))


def test_yaml_and_json_and_python_say_the_same(tmp_path):
    document, _, _ = grid()
    (tmp_path / "a.json").write_text(json.dumps(document))
    (tmp_path / "a.yaml").write_text(yaml.safe_dump(document))
    bodies = load_body(tmp_path / "a.json"), load_body(tmp_path / "a.yaml"), make_own_body(document)
    ends = [simulate_body(body, "swim", 0.5).position[-1] for body in bodies]
    assert np.array_equal(ends[0], ends[1]) and np.array_equal(ends[0], ends[2])


def test_yaml_reads_1e_3_as_a_number(tmp_path):
    (tmp_path / "a.yaml").write_text("position: [[0, 0], [1, 0]]\nchambers: []\ndamping: 1e-3\n")
    assert load_body(tmp_path / "a.yaml").stuff.damping == 1e-3


def test_rest_lengths_stay_with_their_springs_in_any_order():
    springs = [[2, 3], [1, 0], [0, 2], [3, 0], [2, 1]]
    body = make_own_body({**SQUARE, "springs": springs, "rest_length": [1.23, 1.10, 1.02, 1.30, 1.12]}).body
    ends = np.column_stack((body.spring_a, body.spring_b))
    assert dict(zip(map(tuple, ends.tolist()), body.rest_length)) == {(2, 3): 1.23, (0, 1): 1.1, (0, 2): 1.02, (0, 3): 1.3, (1, 2): 1.12}
    assert body.shortest == 1.02


def test_chambers_as_lists_of_all_faces_are_the_faces():
    document, faces, _ = grid()
    listed = copy.deepcopy(document)
    listed["chambers"] = [list(face)[::-1] for face in faces]
    ends = [simulate_body(make_own_body(d), "swim", 0.5).position[-1] for d in (document, listed)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-12)


# --- a second solver ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", ["swim", "free"])
def test_an_independent_solver_agrees(command, scene):
    document, faces, outline = grid()
    if scene == "free":
        document["scene"] = {}
    result = command(document, scene, 1.0)
    position, velocity = solve(document, faces, outline, scene, result["time"])
    assert np.abs(result["position"] - position).max() < 1e-6
    assert np.abs(result["velocity"] - velocity).max() < 2e-5
    exact = command(document, scene, 1.0, "--tolerance", 1e-11)
    assert np.abs(exact["position"] - position).max() < 1e-8


# --- closed forms ------------------------------------------------------------------------------------------------------


def test_two_masses_on_a_spring(command):
    document = {"position": [[0, 0], [1.3, 0]], "rest_length": 1, "mass": 2, "stiffness": 40, "damping": 1, "chambers": []}
    result = command(document, "free", 2.0)
    t, a = result["time"], 0.5
    w = np.sqrt(40 - a * a)
    exact = 1 + 0.3 * np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))
    assert result["position"][:, 1, 0] - result["position"][:, 0, 0] == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("scene, integrator", [("walk", "euler"), ("free", "rk4"), ("free", "verlet"), ("free", "adaptive")])
def test_free_fall_is_exact(command, scene, integrator):
    document = {**SQUARE, "position": [[x, y + 6] for x, y in SQUARE["position"]], "velocity": [[2, 1]] * 4, "scene": {"gravity": 9.81}}
    result = command(document, scene, 1.2, "--integrator", integrator)
    t = result["time"][:, None, None]
    fall = np.concatenate((2 * t, t - 0.5 * 9.81 * t * t), axis=2)
    assert result["position"] == pytest.approx(np.array(document["position"]) + fall, abs=1e-9)


def test_a_sinking_bar_reaches_its_terminal_speed(command):
    document = {"position": [[0, 0], [1, 0]], "chambers": [], "scene": {"gravity": 9.81, "drag_normal": 50}}
    assert command(document, "free", 3.0)["velocity"][-1, :, 1] == pytest.approx(-np.sqrt(2 * 9.81 / 50), rel=1e-9)


def test_scenes_take_their_own_terms_alone(command):
    document = {**SQUARE, "velocity": [[1, 0]] * 4, "scene": {"drag_normal": 9, "drag_tangential": 9, "gravity": 5, "friction": 0}}
    swim = command(document, "swim", 0.5)["velocity"][-1]
    assert swim[:, 1].mean() == pytest.approx(0, abs=1e-6) and swim[:, 0].mean() < 0.6
    walk = command(document, "walk", 0.5)["velocity"][-1]
    assert walk[:, 0].mean() == pytest.approx(1, abs=1e-9)
    assert command({**document, "scene": {}}, "free", 0.5)["velocity"][-1] == pytest.approx(np.array([[1, 0]] * 4), abs=1e-9)


# --- the ground --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cells", [1, 4])
def test_a_sliding_block_stops_where_coulomb_says(command, cells):
    document = {"position": [[0, 0]], "chambers": []} if cells == 1 else {**SQUARE, "stiffness": 1e4, "pressure": 1e4, "damping": 100}
    for v, mu in ((2.0, 0.5), (0.5, 0.2)):
        there = {**document, "velocity": [[v, 0]] * cells, "scene": {"gravity": 9.81, "friction": mu}}
        result = command(there, "walk", 2.0)
        travelled = (result["position"][-1] - result["position"][0])[:, 0].mean()
        assert travelled == pytest.approx(v * v / (2 * mu * 9.81), rel=0.01)
        assert np.abs(result["velocity"][-1]).max() < 1e-6


def test_a_block_at_rest_stays_put(command):
    document = {**SQUARE, "stiffness": 1000, "damping": 20}
    result = command(document, "walk", 20.0)
    late = result["position"][-240:]
    assert np.abs(late - late[0]).max() < 1e-9 and np.abs(result["velocity"][-1]).max() < 1e-9
    assert np.abs(late[0, :2, 0] - [0, 1]).max() < 1e-3 and (late[:, :2, 1] == 0).all()  # it has sagged a little


def test_a_bounce_never_gains_energy_nor_enters_the_ground(command):
    c, s = np.cos(0.4), np.sin(0.4)
    for friction in (0.0, 0.8):
        for damping in (0.0, 3.0):
            document = {
                **SQUARE, "position": (np.array(SQUARE["position"]) @ [[c, s], [-s, c]] + [0, 1.5]).tolist(),
                "velocity": [[1.0, 0.5]] * 4, "damping": damping, "scene": {"friction": friction},
            }
            result = command(document, "walk", 4.0)
            total = energy(document, "walk", result)
            assert (total <= total[0] * 1.005).all()
            assert result["position"][..., 1].min() >= 0
            if damping:
                assert total[-1] < 0.7 * total[0]


# --- faults ------------------------------------------------------------------------------------------------------------


def changed(**values):
    return {**SQUARE, **values}


BAD = {
    "position is missing": ({"mass": 1}, "position is missing"),
    "no cells": ({"position": []}, "position has 0 cells"),
    "not a document": ([1, 2], "the file is [1, 2]"),
    "three coordinates": (changed(position=[[0, 0], [1, 0, 0], [1, 1], [0, 1]]), "position[1] is [1, 0, 0]"),
    "text": (changed(position=[[0, 0], [1, "a"], [1, 1], [0, 1]]), "position[1][1] is 'a'"),
    "truth": (changed(position=[[0, 0], [1, True], [1, 1], [0, 1]]), "position[1][1] is True"),
    "nan": (changed(position=[[0, 0], [1, float("nan")], [1, 1], [0, 1]]), "position[1][1] is nan"),
    "infinite": (changed(velocity=[[0, 0], [0, 0], [float("inf"), 0], [0, 0]]), "velocity[2][0] is inf"),
    "few velocities": (changed(velocity=[[0, 0]]), "velocity has 1 entries, but there are 4 cells"),
    "coincident": (changed(position=[[0, 0], [1, 0], [1, 1], [1, 0]]), "position[1] and position[3]"),
    "collinear": ({"position": [[0, 0], [1, 0], [2, 0]]}, "position: all cells lie on one line"),
    "massless": (changed(mass=0), "mass is 0"),
    "one massless": (changed(mass=[1, 1, -2, 1]), "mass[2] is -2"),
    "masses short": (changed(mass=[1, 1]), "mass has 2 entries, but there are 4 cells"),
    "nan stiffness": (changed(stiffness=float("nan")), "stiffness is nan"),
    "negative damping": (changed(damping=-1), "damping is -1"),
    "pressure list": (changed(pressure=[1]), "pressure is [1]"),
    "disconnected": (changed(springs=[[0, 1], [2, 3]]), "springs do not reach cell 2"),
    "crossing": (changed(springs=SQUARE["springs"] + [[1, 3]]), "springs[4] and springs[5] cross"),
    "through": ({"position": [[0, 0], [1, 0], [2, 0], [1, 1]], "springs": [[0, 1], [1, 2], [0, 3], [0, 2]]},
                "springs[3] runs through cell 1"),
    "no such cell": (changed(springs=[[0, 1], [1, 4]]), "springs[1][1] is 4"),
    "self": (changed(springs=[[0, 1], [1, 1]]), "springs[1] is [1, 1]"),
    "twice": (changed(springs=SQUARE["springs"] + [[1, 0]]), "springs[5] joins cells 0 and 1 as springs[0]"),
    "other graph": (changed(springs="delaunay"), "springs is 'delaunay'"),
    "rest length": (changed(rest_length=[1, 1, 1, 0, 1]), "rest_length[3] is 0"),
    "rest lengths": (changed(rest_length=[1, 1]), "rest_length has 2 entries, but there are 5 springs"),
    "chamber word": (changed(chambers="all"), "chambers is 'all'"),
    "open chamber": (changed(chambers=[[0, 1, 3]]), "chambers[0] has a side from cell 1 to cell 3"),
    "chamber twice": (changed(chambers=[[0, 1, 2], [0, 2, 3], [2, 1, 0]]), "chambers[2] and chambers[0] lie on the same side"),
    "chamber within another": (changed(chambers=[[0, 1, 2, 3], [0, 2, 3]]), "chambers[1] and chambers[0] lie on the same side"),
    "small chamber": (changed(chambers=[[0, 1]]), "chambers[0] is [0, 1]"),
    "flat chamber": ({"position": [[0, 0], [1, 0], [2, 1e-8]], "springs": [[0, 1], [1, 2], [0, 2]]}, "has an area of 5e-09"),
    "too stiff": ({**SQUARE, "stiffness": 1e9, "mass": 1e-6}, "steps a second"),
    "amplitude": (changed(activation={"amplitude": 2}), "activation.amplitude is 2"),
    "frequency": (changed(activation={"amplitude": 0.2, "frequency": [1, 1, 1, -1]}), "activation.frequency[3] is -1"),
    "phase": (changed(activation={"phase": [0, 0]}), "activation.phase has 2 entries"),
    "unknown": (changed(masss=1), "unknown key 'masss': did you mean 'mass'"),
    "unknown below": (changed(scene={"drag": 1}), "unknown key 'scene.drag': did you mean"),
    "scene list": (changed(scene=[1]), "scene is [1]"),
    "gravity": (changed(scene={"gravity": [0, -9.81]}), "scene.gravity is [0, -9.81]"),
}


def refused(tmp_path, capsys, text, *more):
    body = tmp_path / "body.yaml"
    body.write_text(text)
    with pytest.raises(SystemExit) as raised:
        main([str(body), "--duration", "1", "--out", str(tmp_path / "bag"), "--npz", str(tmp_path / "a.npz"), *more])
    assert raised.value.code == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and said.startswith("simulate: ")
    return said


@pytest.mark.parametrize("document, says", BAD.values(), ids=BAD)
def test_a_bad_body_is_one_line_that_names_the_field_and_leaves_nothing(tmp_path, capsys, document, says):
    assert says in refused(tmp_path, capsys, json.dumps(document))
    assert [path.name for path in tmp_path.iterdir()] == ["body.yaml"]


@pytest.mark.parametrize("arguments, says", [
    (["--dt", "0"], "dt is 0.0"), (["--dt", "nan"], "dt is nan"), (["--dt", "0.5"], "stable for this body up to about"),
    (["--dt", "1e-9"], "dt is 1e-09"), (["--tolerance", "-1"], "tolerance is -1.0"), (["--tolerance", "nan"], "tolerance is nan"),
    (["--dt", "0.01", "--tolerance", "1e-6"], "choose one of them"), (["--duration", "-3"], "duration is -3.0"),
    (["--duration", "1e5", "--dt", "1e-6"], "do not fit in memory"), (["--scene", "fly"], "scene 'fly' is unknown"),
    (["--integrator", "leapfrog"], "integrator 'leapfrog' is unknown"),
    (["--scene", "walk", "--integrator", "rk4"], "walk meets its ground"),
    (["--integrator", "rk4", "--tolerance", "1e-6"], "tolerance is for integrator adaptive"),
    (["--integrator", "adaptive", "--dt", "0.01"], "give tolerance in place of dt"), (["--duration", "x"], "'x' is no number"),
])
def test_a_bad_argument_is_one_line_and_leaves_nothing(tmp_path, capsys, arguments, says):
    assert says in refused(tmp_path, capsys, json.dumps(SQUARE), *arguments)
    assert [path.name for path in tmp_path.iterdir()] == ["body.yaml"]


def test_bad_files_and_places_are_one_line(tmp_path, capsys):
    assert "neither YAML nor JSON" in refused(tmp_path, capsys, "position: [[0, 0")
    assert "start no cell below it" in refused(tmp_path, capsys, "position: [[0, -1], [1, 0]]\nchambers: []", "--scene", "walk")
    (tmp_path / "a.npz").write_text("mine")
    assert "a.npz exists already" in refused(tmp_path, capsys, json.dumps(SQUARE))
    (tmp_path / "a.npz").unlink()
    (tmp_path / "bag").mkdir()
    assert "bag exists already" in refused(tmp_path, capsys, json.dumps(SQUARE))
    with pytest.raises(SystemExit) as raised:
        main([str(tmp_path / "none.yaml"), "--duration", "1", "--out", str(tmp_path / "new")])
    assert raised.value.code == 2 and "No such file" in capsys.readouterr().err


def test_a_body_that_folds_ends_with_a_named_cause_and_what_came_before(command, capsys):
    document = {**SQUARE, "velocity": [[60, 0], [-60, 0], [0, 0], [0, 0]], "pressure": 0}
    result = command(document, "free", 2.0, code=1)
    assert "turned inside out" in capsys.readouterr().err
    assert 1 <= len(result["time"]) < 121 and np.isfinite(result["position"]).all()


def test_the_recording_of_a_walk_holds_its_world_and_replay_draws_it(tmp_path, capsys):
    from evodevo_sim.recording.life import life_of
    from evodevo_sim.ros.messages import scene_from_message

    body = tmp_path / "body.yaml"
    body.write_text(
        yaml.safe_dump({"position": [[0, 1], [1, 1], [0.5, 1.9]], "springs": [[0, 1], [1, 2], [0, 2]], "chambers": [[0, 1, 2]]}),
    )
    (tmp_path / "hill.yaml").write_text("ground: [[-5, 0], [0.5, 0.7], [5, 0]]\nceiling: [[-5, 9], [5, 9]]\nfriction: 0.4\n")
    walk = [str(body), "--scene", "walk", "--duration", "1"]
    assert main([*walk, "--world", str(tmp_path / "hill.yaml"), "--out", str(tmp_path / "hill")]) == 0
    recording = read_recording(tmp_path / "hill")
    scene = scene_from_message(recording.scene)
    assert scene.ground_x == (-5.0, 0.5, 5.0) and scene.ground_y == (0.0, 0.7, 0.0) and (scene.gravity, scene.friction) == (9.81, 0.4)
    life = life_of(recording)
    ground, ceiling = life.surfaces(-5.0, 5.0)
    assert ground[1].tolist() == [0.5, 0.7] and ceiling[0, 1] == 9
    assert main([*walk, "--out", str(tmp_path / "flat")]) == 0
    [ground] = life_of(read_recording(tmp_path / "flat")).surfaces(-5.0, 5.0)
    assert np.abs(ground[:, 1]).max() == 0
    assert main([str(body), "--duration", "1", "--out", str(tmp_path / "swim")]) == 0
    assert life_of(read_recording(tmp_path / "swim")).surfaces(-5.0, 5.0) == []
    (tmp_path / "spike.yaml").write_text("ground: [[0.3, 0], [0.4, 1.2], [0.5, 0]]\n")
    with pytest.raises(SystemExit) as raised:
        main([*walk, "--world", str(tmp_path / "spike.yaml"), "--out", str(tmp_path / "inside")])
    assert raised.value.code == 2 and "an edge of the outline passes through a tip of the world" in capsys.readouterr().err


# --- at the rim of what numbers hold -------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale, drag", [(1.0, 1e5), (1.0, 1e6), (30.0, 40.0), (300.0, 40.0)])
def test_a_body_of_any_size_moves_from_rest_against_any_drag(scale, drag):
    """From rest, steps cannot follow from drag: it is 0 there, and thousands of times the rate of the body a moment later."""
    document = {
        "position": (scale * np.array([(0, 0), (1, 0), (0.5, 0.9), (1.5, 0.9)])).tolist(), "scene": {"drag_normal": drag},
        "activation": {"amplitude": 0.3, "frequency": 1.0, "phase": [0, 1, 2, 3]},
    }
    motion = simulate_body(make_own_body(document), "swim", 0.2)
    exact = simulate_body(make_own_body(document), "swim", 0.2, tolerance=1e-8 * scale)
    assert not motion.cause and not exact.cause and motion.time[-1] == 0.2
    assert np.abs(motion.position - exact.position).max() < 1e-5 * scale


def test_what_blows_up_names_the_flag_that_may_help(monkeypatch):
    from evodevo_sim.own_body import motion
    from evodevo_sim.physics.soundness import UNSTABLE

    monkeypatch.setattr(motion, "follow", lambda *_: (UNSTABLE, 0, 0.0))
    own = make_own_body(SQUARE)
    assert "--tolerance 1e-6" in simulate_body(own, "swim", 1.0).cause
    assert "give a shorter dt, or none" in simulate_body(own, "swim", 1.0, dt=0.01).cause
    assert "--tolerance" not in simulate_body(own, "swim", 1.0, tolerance=1e-6).cause  # which it has


def turned_lattice(n=3):
    c, s = np.cos(0.3), np.sin(0.3)
    return np.array([(i, j) for i in range(n + 1) for j in range(n + 1)], float) @ np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("size", [0.1, 1.0, 100.0])
@pytest.mark.parametrize("shift", [(2e4, 0.0), (-9e5, 9e5), (0.0, 3e5)])
def test_a_body_is_the_same_wherever_it_is(size, shift):
    """Squares are ties of the Gabriel graph; areas as products of coordinates would be off by more than the whole body."""
    position = size * turned_lattice()
    at = np.arange(len(position))
    faces = [[k, k + 4, k + 5, k + 1] for k in at if k % 4 < 3 and k < 12]
    document = {"activation": {"amplitude": 0.2, "frequency": 1.0, "phase": (0.9 * at).tolist()}}
    for chambers in ("faces", [list(map(int, face)) for face in faces]):
        here, there = (make_own_body({**document, "position": p.tolist(), "chambers": chambers}) for p in (position, position + shift))
        assert len(here.body.rest_length) == 24 and len(here.body.polygon_area) == 9
        for a, b in zip(here.body, there.body):
            assert np.array_equal(np.asarray(a).shape, np.asarray(b).shape)
        assert np.array_equal(here.body.spring_a, there.body.spring_a) and np.array_equal(here.body.spring_b, there.body.spring_b)
        assert there.body.polygon_area == pytest.approx(here.body.polygon_area, rel=1e-7)
    ways = [(m.position[-1] - m.position[0]) for m in (simulate_body(own, "swim", 0.5) for own in (here, there))]
    assert ways[1] == pytest.approx(ways[0], abs=1e-5 * size)


def test_a_graph_of_many_cells_far_off_is_that_at_the_origin():
    position = turned_lattice(15)  # by the tree
    here, there = (make_own_body({"position": (position + shift).tolist()}).body for shift in (0.0, 7e5))
    assert len(here.rest_length) == 480
    assert np.array_equal(here.spring_a, there.spring_a) and np.array_equal(here.spring_b, there.spring_b)


def test_coordinates_that_cannot_hold_a_shape_are_refused():
    document = {"position": (1e-5 * turned_lattice() + 9e5).tolist()}
    with pytest.raises(ValueError, match="coordinates of up to 9e\\+05 m are too coarse for cells that are 1e-05 m apart") as caught:
        make_own_body(document)
    assert len(str(caught.value)) <= 300
    assert make_own_body({"position": (1e-5 * turned_lattice()).tolist()})


def test_a_line_is_a_line_far_off():
    line = np.outer(np.arange(40.0), (np.cos(1.0), np.sin(1.0))) + 8e5
    with pytest.raises(ValueError, match="all cells lie on one line"):
        make_own_body({"position": line.tolist()})


@pytest.mark.parametrize("degrees", [3.0, 8.0, 30.0])
@pytest.mark.parametrize("start", [0.0, 7.3, 41.7])
def test_a_body_set_on_a_slope_by_cosine_and_sine_stands_there(tmp_path, degrees, start):
    t = np.deg2rad(degrees)
    along, up = np.array([np.cos(t), np.sin(t)]), np.array([-np.sin(t), np.cos(t)])
    position = [(start + x + 0.5 * y) * along + 0.87 * y * up for y in range(2) for x in range(3)]
    (tmp_path / "slope.yaml").write_text(f"slope: {degrees}\n")
    own = make_own_body({"position": [p.tolist() for p in position]})
    motion = simulate_body(own, "walk", 1.0, world=str(tmp_path / "slope.yaml"))
    assert not motion.cause
    assert np.abs(motion.position[-1] - motion.position[0])[:3].max() < 0.02  # below the friction angle its feet stay
    sunk = make_own_body({"position": [(p - (0, 1e-6)).tolist() for p in position]})
    with pytest.raises(ValueError, match="start no cell below it"):
        simulate_body(sunk, "walk", 1.0, world=str(tmp_path / "slope.yaml"))

"""`handsim object check` and `handsim grasp --object`."""

from pathlib import Path

import imageio.v3 as iio
import mujoco
import numpy as np
import pytest
import trimesh

from handsim.grasping.planning.trials import own_object
from handsim.grasping.rollout_file import read_rollout


@pytest.fixture
def can(tmp_path: Path) -> Path:
    """A can in millimetres that lies along y, as many programs have what stands."""
    mesh = trimesh.creation.cylinder(33, 122, sections=32)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    mesh.export(tmp_path / "can.stl")
    return tmp_path / "can.stl"


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(own_object, "MOST_TRIED", 3)
    monkeypatch.setattr(own_object, "N_COMPARED", 1)


def test_check_says_what_the_contract_names(run, can):
    said = run("object", "check", can, "--json").json()
    assert (said["watertight"], said["mended"], said["n_pieces"]) == (True, [], 1)
    np.testing.assert_allclose(said["size_m"], [0.066, 0.066, 0.122], rtol=0.01)
    assert said["mass_kg"] == pytest.approx(0.414, abs=0.005)
    assert said["scale"] == 0.001
    first = said["resting_poses"][0]
    assert first["name"] == "+y" and first["tips_at_deg"] == pytest.approx(28, abs=1)
    assert [each.split()[0] for each in said["guessed"]] == ["unit", "mass", "up"]


def test_check_takes_what_is_given_and_says_it_in_words(run, can):
    said = run("object", "check", can, "--up", "y", "--scale", "0.001", "--mass", "0.35")
    assert said.out.startswith("can: 66 x 66 x 122 mm as it stands, 0.35 kg, 1 convex piece\n")
    assert "watertight" in said.out and "guessed" not in said.out
    assert "+y up" in said.out


def test_check_says_what_was_mended(run, can):
    mesh = trimesh.load_mesh(can)
    mesh.invert()
    mesh.export(can)
    said = run("object", "check", can)
    assert "mended: inside out: turned right side out" in said.out


def test_check_draws_the_ways_to_rest(run, can, tmp_path):
    run("object", "check", can, "-o", tmp_path / "sheet.png")
    assert (tmp_path / "sheet.png").stat().st_size > 10_000
    cube = trimesh.creation.box((0.05, 0.05, 0.05))
    cube.export(tmp_path / "cube.stl")
    run("object", "check", tmp_path / "cube.stl", "-o", tmp_path / "six.png")
    assert iio.imread(tmp_path / "six.png").shape[:2] == (2 * 260 + 2, 3 * 300 + 4), "no empty cell"
    said = run("object", "check", can, "-o", tmp_path / "sheet.txt")
    assert said.code == 2
    assert "suffix '.txt'" in said.err


def test_check_refuses_in_one_line_with_the_cause(run, tmp_path):
    cup = trimesh.creation.revolve(np.array([[0, 0], [35, 0], [40, 90]]), sections=24)
    cup.export(tmp_path / "cup.stl")
    said = run("object", "check", tmp_path / "cup.stl", "--json")
    assert said.code == 2
    assert said.out == "" and said.err.count("\n") == 1
    assert "cup.stl: the mesh is not watertight: 1 hole" in said.err


def test_an_own_object_is_grasped_and_the_choice_is_said(run, can, tmp_path, quick):
    out = tmp_path / "out"
    said = run("grasp", "demonstrator", "--object", can, "--mass", "0.35", "--jobs", "1",
               "-o", out, "--json")  # fmt: skip
    # Four fingers from above slip on a smooth can; three do not, nor four from the side.
    assert "chosen: can from" in said.err and "2 of 3 grasps held when tried" in said.err
    assert "guessed: unit mm" in said.err
    verdict = said.json()
    assert (verdict["task"], verdict["nominal_success"]) == ("can-lift", True)
    assert verdict["grasp"]["fingers"][0] == "thumb"
    assert (verdict["grasps_tried"], verdict["grasps_held_by_script"]) == (3, 2)
    assert verdict["object"]["mass_kg"] == 0.35
    assert read_rollout(out / "can-lift.npz").outcome.success


def test_a_left_hand_grasps_the_thing_of_the_file_and_says_so_in_its_frame(
    run, tmp_path, quick, monkeypatch
):
    """A wedge, wide at -y and narrow at +y, as it lies in the rollout and in what is said."""
    monkeypatch.setattr(own_object, "MOST_TRIED", 1)
    monkeypatch.setattr(own_object, "STEADY", 99.0)
    monkeypatch.setattr(own_object, "N_PERTURBED", 0)
    corners = [(x, y, z) for x, y in ((-20, -30), (20, -30), (12, 40), (-12, 40)) for z in (0, 70)]
    wedge = trimesh.convex.convex_hull(np.array(corners))
    wedge.export(tmp_path / "wedge.stl")
    said = run("grasp", "demonstrator", "--object", tmp_path / "wedge.stl", "--up", "z",
               "--mass", "0.1", "--side", "left", "--base", "free", "--jobs", "1",
               "-o", tmp_path / "out", "--json")  # fmt: skip
    assert said.code == 0, said.err
    grasp = said.json()["grasp"]
    rollout = read_rollout(tmp_path / "out" / "wedge-lift.npz")
    model, data = rollout.model(), mujoco.MjData(rollout.model())
    mujoco.mj_forward(model, data)
    body, hit = data.body("object"), np.zeros(1, np.int32)
    turn = body.xmat.reshape(3, 3)
    site = data.site("grasp")
    np.testing.assert_allclose(turn.T @ (site.xpos - body.xpos), grasp["point_m"], atol=1e-6)
    opposition = turn.T @ site.xmat.reshape(3, 3)[:, 0]
    np.testing.assert_allclose(opposition, grasp["opposition"], atol=1e-6)
    assert abs(grasp["point_m"][1]) > 1e-3  # otherwise a mirror would show the same
    groups, z = np.array([0, 0, 1, 1, 0, 0], dtype=np.uint8), 0.035
    for y, half in ((-0.03, 0.019429), (0.03, 0.012571)):
        start = body.xpos + turn @ np.array([0.1, y, z])
        depth = mujoco.mj_ray(model, data, start, turn @ np.array([-1.0, 0, 0]), groups, 1, -1, hit)
        assert 0.1 - depth == pytest.approx(half, abs=1e-4)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "neither is given"),
        (["--task", "cube-raise", "--object", "CAN"], "both are given"),
        (["--task", "cube-raise", "--up", "y"], "--up is about an own object"),
        (["--object", "CAN", "--replay"], "--replay is about recorded objects"),
        (["--object", "CAN", "--leave-out", "cup"], "--leave-out is about recorded objects"),
        (["--object", "none.stl"], "none.stl: no such file"),
        (["--object", "CAN", "--scale", "1"], "longest side is 122 m"),
        (["--object", "CAN", "--mass", "-1"], "mass -1 kg"),
        (["--object", "CAN", "--pieces", "nowhere"], "nowhere: no such folder"),
    ],
)
def test_what_does_not_go_together_is_refused(run, can, tmp_path, options, words):
    given = [str(can) if each == "CAN" else each for each in options]
    said = run("grasp", *given, "-o", tmp_path / "out")
    assert said.code == 2
    assert words in said.err and said.err.count("\n") == 1
    assert not (tmp_path / "out").exists()

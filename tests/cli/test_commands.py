"""The commands and their JSON, as the README shows them."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from handsim.cli.reporting import _progress_asked
from handsim.grasping.rollout_file import read_rollout
from handsim.joints import JOINT_NAMES
from handsim.learning.controller import GraspController
from handsim.recordings.posture_file import read_postures
from handsim.tasks.table_one import TASK_NAMES

REAL = Path(__file__).parents[2] / "../shared/data/reach_to_grasp"
LEARN_KEYS = {
    "method",
    "n_recordings",
    "n_components",
    "variance_explained",
    "n_coefficients",
    "iterations",
    "seconds",
    "cost_start",
    "cost_end",
}
TRIAL_KEYS = {
    "seed",
    "success",
    "reason",
    "lift_m",
    "peak_slip_m",
    "peak_tilt_deg",
    "hold_s",
    "contacts",
}


@pytest.fixture
def learned(run, tmp_path):
    path = tmp_path / "c.npz"
    result = run("learn", "-o", path, "--json")
    assert result.code == 0
    assert set(result.json()) >= LEARN_KEYS
    return path


def test_learn_and_evaluate_the_built_in_experiments(run, learned):
    result = run("evaluate", learned, "--json")
    assert result.code == 0
    scores = result.json()
    assert scores["n_recordings"] == scores["n_arrived"] == len(TASK_NAMES)
    assert scores["ratio"] < 0.60  # 0.57 for the 24 experiments
    assert scores["ratio"] == pytest.approx(scores["path_error_deg"] / scores["straight_error_deg"])
    assert {row["name"] for row in scores["per_recording"]} == set(TASK_NAMES)


def test_learning_says_whether_progress_pays_and_can_be_told(run, tmp_path):
    """The report tells what was asked for, so that its commands make the same controller."""
    path = tmp_path / "c.npz"
    said = run("learn", "-o", path, "--components", 2)
    assert said.code == 0
    assert re.search(
        r"left out: 0\.\d{3} of a .* a coordinate, 0\.\d{3} without; learned with", said.err
    )
    chosen = GraspController.load(path)
    pays = chosen.left_out.progress_pays
    assert chosen.guide.progress is pays and _progress_asked(chosen) == []
    flag = "--without-progress" if pays else "--with-progress"
    said = run("learn", "-o", path, "--components", 2, flag)
    assert said.code == 0 and f"learned with{'out' if pays else ''} it" in said.err
    told = GraspController.load(path)
    assert told.guide.progress is not pays and _progress_asked(told) == [flag]
    assert _progress_asked(replace(chosen, left_out=None)) == []
    for other in (["--field-only"], ["--method", "pde"]):
        refused = run("learn", "-o", path, flag, *other)
        assert refused.code == 2 and f"{flag} with --field-only" in refused.err


def test_learning_twice_gives_the_same_file(run, learned, tmp_path):
    assert run("learn", "-o", tmp_path / "d.npz").code == 0
    assert (tmp_path / "d.npz").read_bytes() == learned.read_bytes()


@pytest.mark.real_data
@pytest.mark.skipif(
    not REAL.is_dir(), reason="the published recordings are not beside the checkout"
)
@pytest.mark.ci
@pytest.mark.slow
def test_people_are_imported_learned_and_followed(run, tmp_path):
    files = sorted(REAL.glob("*_raw.mat"))
    folder, controller = tmp_path / "R", tmp_path / "c.npz"
    options = ("--format", "west-rtg", "--subject", 4, "-o", folder)
    assert run("recordings", "import", *files, *options).code == 0
    assert run("recordings", "info", folder, "--json").json()["n_recordings"] == 20
    learned = run("learn", folder, "-o", controller, "--json").json()
    assert learned["n_recordings"] == 20
    scores = run("evaluate", controller, folder, "--json").json()
    assert scores["n_arrived"] == 20
    assert scores["ratio"] <= 0.70


def test_postures_end_at_the_destination_in_the_subspace(run, tmp_path):
    out = tmp_path / "p.csv"
    result = run("postures", "--task", "cube-raise", "-o", out)
    assert result.code == 0
    time, q = read_postures(out)
    assert q.shape == (len(time), len(JOINT_NAMES))
    again = tmp_path / "again.csv"
    assert run("postures", "--goal", out, "-o", again, "--duration", "0.8").code == 0
    time_again, q_again = read_postures(again)
    assert time_again[-1] == pytest.approx(0.8)
    # The last posture lies in the subspace, so that going there ends there.
    np.testing.assert_allclose(q_again[-1], q[-1], atol=np.deg2rad(0.5))


def test_postures_need_one_destination(run, tmp_path):
    assert run("postures", "-o", tmp_path / "p.csv").code == 2


def test_grasp_writes_a_rollout_and_says_what_happened(run, tmp_path):
    result = run("grasp", "--task", "cube-raise", "--trials", 1, "-o", tmp_path, "--json")
    assert result.code == 0
    said = result.json()
    assert said["task"] == "cube-raise"
    assert said["nominal_success"] is True
    assert said["trials"] == 1
    nominal, perturbed = said["per_trial"]
    assert set(nominal) >= TRIAL_KEYS
    assert (nominal["nominal"], perturbed["nominal"]) == (True, False)
    assert perturbed["seed"] != nominal["seed"]
    assert nominal["lift_m"] >= 0.10
    assert nominal["hold_s"] >= 2.99
    rollout = read_rollout(tmp_path / "cube-raise.npz")
    assert rollout.outcome.success
    assert rollout.outcome.lift_m == pytest.approx(nominal["lift_m"])
    assert (tmp_path / f"cube-raise-{perturbed['seed']}.npz").is_file()


def test_required_success_decides_the_exit_code(run):
    slippery = ("--task", "tall-glass-top-move", "--friction", "0.05", "--json")
    failed = run("grasp", "demonstrator", *slippery, "--require-success")
    assert failed.code == 1
    assert failed.json()["nominal_success"] is False
    assert failed.json()["per_trial"][0]["reason"] in ("missed", "slipped", "tilted")
    assert run("grasp", "demonstrator", *slippery).code == 0


def test_replay_takes_the_recorded_destination(run):
    said = run("grasp", "--task", "tall-glass-top-move", "--replay", "--json").json()
    assert said["nominal_success"] is True


def test_render_makes_video_and_contact_sheet(run, read_video, tmp_path):
    source = tmp_path / "p.csv"
    run("postures", "--task", "cube-raise", "-o", source, "--duration", "0.5")
    video, sheet = tmp_path / "p.mp4", tmp_path / "p.png"
    size = ("--size", "160x120")
    assert run("render", source, "-o", video, *size, "--fps", "20").code == 0
    about, frames = read_video(video)
    assert frames[0].shape == (120, 160, 3)
    assert abs(len(frames) / 20 - 0.5) <= 1 / 20 + 1e-9
    assert abs(about["duration"] - 0.5) <= 1 / 20 + 1e-9
    assert run("render", source, "-o", sheet, *size, "--postures", "4").code == 0
    assert iio.imread(sheet).std() > 5


def test_hand_build_writes_a_model_of_the_size_asked_for(run, tmp_path):
    mujoco = pytest.importorskip("mujoco")
    for length in (0.16, 0.20):
        assert run("hand", "build", "-o", tmp_path, "--hand-length", length).code == 0
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "right_hand.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        reach = data.site("middle_tip").xpos - data.body("palm").xpos
        assert np.linalg.norm(reach) == pytest.approx(0.99 * length, rel=0.01)


def test_recordings_info_in_words_and_in_json(run):
    said = run("recordings", "info", "--json").json()
    assert said["n_recordings"] == len(TASK_NAMES)
    assert "synthetic" in said["subjects"]
    assert "synthetic" in run("recordings", "info").out


def test_doctor_says_what_renders(run):
    result = run("doctor")
    assert result.code in (0, 1)
    assert "mujoco" in result.out
    assert "ffmpeg" in result.out


def test_help_starts_quickly_because_nothing_heavy_is_imported():
    code = (
        "import sys, handsim.cli; "
        "heavy = {'mujoco', 'sklearn', 'scipy', 'matplotlib', 'trimesh'} & set(sys.modules); "
        "sys.exit(','.join(heavy) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_certified_learning_is_certified_and_the_exit_code_says_so(run, tmp_path):
    path = tmp_path / "c.npz"
    assert run("learn", "-o", path, "--certified", "--components", 2).code == 0
    proven = run("certify", path, "--json")
    assert proven.code == 0
    said = proven.json()
    assert said["certified"] is True
    assert said["arrivals"] == said["starts"] > 0
    assert said["other_minima"] == []
    assert said["k_min"] <= said["k"]


@pytest.mark.ci
@pytest.mark.slow
def test_figures_are_drawn_as_png_and_svg(run, tmp_path):
    result = run("figures", "-o", tmp_path / "figures", "--paper", tmp_path / "all.pdf")
    assert result.code == 0
    assert "wrote 16 pictures" in result.err
    assert (tmp_path / "all.pdf").read_bytes().startswith(b"%PDF")
    drawn = {path.name for path in (tmp_path / "figures").iterdir()}
    for name in ("fig3_learning", "fig5_variance", "fig6_paths", "fig7_components"):
        assert {f"{name}.png", f"{name}.svg"} <= drawn

"""The shipped reaches of a person: whole, plausible, learned, proven, made from their source."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from handsim import certify, data_folder, evaluate, learn_controller
from handsim.recordings.contents import summarise
from handsim.recordings.folder import read_recordings
from handsim.recordings.plausibility import anomalies
from handsim.recordings.recording import RecordingSet

PEOPLE = data_folder("assets") / "people"
SOURCE = Path(__file__).parents[3] / "shared/data/pillow_reach/recording.tsv"


@pytest.fixture(scope="module")
def pillow() -> RecordingSet:
    return read_recordings(PEOPLE / "pillow")


def test_they_are_whole_and_plausible(pillow: RecordingSet) -> None:
    assert len(pillow) == 20
    assert anomalies(pillow) == ()
    assert {r.hand.side for r in pillow} == {"right"}
    assert all("BSD-3-Clause" in r.extra["source"] for r in pillow)
    assert (PEOPLE / "LICENSE").read_text().startswith("Copyright 2021-2022 Alexander Fabisch")
    for r in pillow:
        assert {"palm_x_m", "palm_qw", "elbow_x_m", "shoulder_x_m", "object_x_m"} <= set(r.channels)
        assert r.not_seen == {"wrist_flexion", "wrist_deviation"}


def test_they_go_as_measured_on_the_markers(pillow: RecordingSet) -> None:
    """Duration, peak speed and aperture within 5 % of the medians of the published markers."""
    medians = summarise(pillow)["median_reach"]
    assert medians["duration_s"] == pytest.approx(1.02, rel=0.05)
    assert medians["peak_speed_at"] == pytest.approx(0.52, rel=0.05)
    assert medians["aperture_at"] == pytest.approx(0.69, rel=0.05)


def test_they_are_learned_and_proven(pillow: RecordingSet) -> None:
    learned = learn_controller(pillow, certified=True)
    assert learned.summary["variance_explained"] > 0.90
    scores = evaluate(learned.controller, pillow)
    assert scores.n_arrived == 20 and scores.ratio < 0.85
    assert certify(learned.controller, per_dimension=2).certified


@pytest.mark.real_data
@pytest.mark.skipif(
    not SOURCE.is_file(), reason="the published recording is not beside the checkout"
)
def test_they_are_made_from_their_source(
    pillow: RecordingSet, script: Callable[[str], ModuleType], tmp_path: Path
) -> None:
    made = script("assets/people/make.py").reaches(SOURCE)
    assert [r.name for r in made] == [r.name for r in pillow]
    for ours, again in zip(pillow, made, strict=True):
        np.testing.assert_allclose(again.q, ours.q, rtol=0, atol=np.deg2rad(0.02))
        np.testing.assert_allclose(again.time, ours.time, rtol=0, atol=1e-6)

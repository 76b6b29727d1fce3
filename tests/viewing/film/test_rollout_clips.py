from dataclasses import fields

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout.record import Phase, Rollout
from handsim.joints import CONTACT_PARTS
from handsim.tasks.rules import Outcome
from handsim.viewing.film.clips import render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.overlay import (
    FORCE_COLOUR,
    PATH_COLOUR,
    Caption,
    ForceBars,
    SubspaceInset,
)
from handsim.viewing.film.rollout_clips import rollout_clip

N = 21


def rollout(ball: mujoco.MjModel, success: bool, forces: bool = True, n_z: int = 3) -> Rollout:
    """A ball that rises, pressed by the thumb, with a record that starts at 2 s."""
    time = np.linspace(0, 1, N)
    qpos = np.tile(ball.qpos0, (N, 1))
    qpos[:, 2] += time
    values = {field.name: np.zeros((N, 1)) for field in fields(Rollout)}
    values.update(
        task="cube-raise",
        driver="controller",
        model_xml="""<mujoco><worldbody><light pos="0 0 3"/><body pos="0 0 .3"><freejoint/>
        <geom size=".1"/></body></worldbody></mujoco>""",
        assets={},
        time=2.0 + time,
        qpos=qpos,
        qvel=np.zeros((N, ball.nv)),
        z=np.column_stack([time] * n_z) if n_z else np.zeros((N, 0)),
        contact_force=np.outer(time, [5.0 * forces] + [0.0] * (len(CONTACT_PARTS) - 1)),
        phases=(Phase("reach", 2.0), Phase("lift", 2.5)),
        conditions=Conditions(),
        outcome=Outcome(success, None if success else "dropped", 0.1, 0.0, 0.0, 2.0, 5, 0.0),
        versions={},
    )
    return Rollout(**values)


def test_clip_shows_what_was_recorded_from_its_start(ball: mujoco.MjModel) -> None:
    clip = rollout_clip(rollout(ball, success=True))
    caption, forces, inset = clip.overlays
    assert clip.time[0] == 0
    assert clip.duration == pytest.approx(1.0)
    assert isinstance(caption, Caption)
    assert caption.lines == ("cube-raise, controller", "success")
    assert caption.phases == ((0.0, "reach"), (0.5, "lift"))
    assert isinstance(forces, ForceBars)
    assert forces.labels == CONTACT_PARTS
    assert isinstance(inset, SubspaceInset)


def test_failure_is_named(ball: mujoco.MjModel) -> None:
    caption = rollout_clip(rollout(ball, success=False)).overlays[0]
    assert isinstance(caption, Caption)
    assert caption.lines[1] == "failed: dropped"


def test_only_what_there_is_to_show_is_shown(ball: mujoco.MjModel) -> None:
    assert len(rollout_clip(rollout(ball, True, forces=False)).overlays) == 2
    assert len(rollout_clip(rollout(ball, True, n_z=0)).overlays) == 2
    assert len(rollout_clip(rollout(ball, True, n_z=1)).overlays) == 2
    assert len(rollout_clip(rollout(ball, True), measurements=False).overlays) == 1


def test_frames_show_it_all(rendering: str, ball: mujoco.MjModel) -> None:
    view = View(width=320, height=240, fps=4)
    frames = list(render_clips([rollout_clip(rollout(ball, True))], view))
    bars = [(frame == FORCE_COLOUR).all(axis=-1).sum() for frame in frames]
    assert bars[0] == 0
    assert all(np.diff(bars) > 0), "the force grows"
    assert all((frame == PATH_COLOUR).all(axis=-1).any() for frame in frames)

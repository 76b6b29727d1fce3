from dataclasses import fields, replace
from typing import Any

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout.record import Phase, Rollout
from handsim.joints import CONTACT_PARTS
from handsim.tasks.grip_rules import MAX_MARGIN
from handsim.tasks.rules import Outcome
from handsim.types import HandSize
from handsim.viewing.film.clips import render_clips, render_sheet
from handsim.viewing.film.force_bars import LIMIT_COLOUR, ForceBars
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.overlay import (
    BAD_COLOUR,
    FORCE_COLOUR,
    GOOD_COLOUR,
    PATH_COLOUR,
    Caption,
    SubspaceInset,
    Verdict,
)
from handsim.viewing.film.rollout_clips import PAUSE_S, force_limit, rollout_clip, verdict_of

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
    assert caption.lines == ("cube-raise, controller",)
    assert caption.phases == ((0.0, "reach"), (0.5, "lift"))
    assert isinstance(forces, ForceBars)
    assert forces.labels == CONTACT_PARTS
    assert isinstance(inset, SubspaceInset)


def pressed(ball: mujoco.MjModel, first: int, last: int) -> Rollout:
    """A failed run in which the thumb presses from one sample to another."""
    force = np.zeros((N, len(CONTACT_PARTS)))
    force[first : last + 1, 0] = 2.0
    return replace_fields(rollout(ball, success=False), contact_force=force)


def replace_fields(run: Rollout, **changes: Any) -> Rollout:
    return Rollout(**{field.name: getattr(run, field.name) for field in fields(run)} | changes)


def test_success_is_known_at_the_end_of_the_hold(ball: mujoco.MjModel) -> None:
    assert verdict_of(rollout(ball, success=True)) == Verdict(1.0, "held", good=True)


def test_failure_is_known_when_the_object_is_lost(ball: mujoco.MjModel) -> None:
    verdict = verdict_of(pressed(ball, 4, 11))
    assert verdict.time == pytest.approx(12 / 20)
    assert verdict.text == "failed: dropped"
    assert not verdict.good


@pytest.mark.parametrize(("first", "last"), [(4, N - 1), (N, N)])
def test_failure_of_what_is_touched_to_the_end_or_never_is_known_at_the_end(
    ball: mujoco.MjModel, first: int, last: int
) -> None:
    assert verdict_of(pressed(ball, first, last)).time == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("lost", "good", "expected"), [(11, False, 12), (N - 1, False, 20), (N - 1, True, 20)]
)
def test_films_show_the_verdict_from_its_frame_on(
    rendering: str, ball: mujoco.MjModel, lost: int, good: bool, expected: int
) -> None:
    run = pressed(ball, 4, lost)
    if good:
        run = replace_fields(run, outcome=rollout(ball, success=True).outcome)
    frames = list(render_clips([rollout_clip(run)], View(width=160, height=120, fps=20)))
    assert len(frames) == N + 20 * PAUSE_S, "the end is shown for a second more"
    colour = GOOD_COLOUR if good else BAD_COLOUR
    shown = [bool((frame == colour).all(axis=-1).any()) for frame in frames]
    assert shown.index(True) == expected
    assert all(shown[expected:])


def test_limit_is_that_of_lifted_tasks(ball: mujoco.MjModel) -> None:
    outcome = Outcome(True, None, 0.1, 0.0, 0.0, 2.0, 5, 0.0, need_n=1.5)
    run = rollout(ball, success=True)
    for task, need, limit in (
        ("cube-raise", 1.5, MAX_MARGIN * 1.5),
        ("stapler-use", 1.5, 0.0),
        ("my-own-thing", 1.5, MAX_MARGIN * 1.5),
        ("my-own-thing", 1.0, 0.0),
        ("cube-raise", 0.0, 0.0),  # of schema 1
    ):
        changed = replace_fields(run, task=task, outcome=replace(outcome, need_n=need))
        assert force_limit(changed) == pytest.approx(limit), task
        bars = rollout_clip(changed).overlays[1]
        assert isinstance(bars, ForceBars)
        assert (bars.need, bars.limit) == (need, pytest.approx(limit))


def test_the_second_view_is_away_from_the_arm(ball: mujoco.MjModel) -> None:
    for side, below_caption in (("right", False), ("left", True)):
        conditions = Conditions(hand=HandSize(side=side))
        clip = rollout_clip(replace_fields(rollout(ball, True), conditions=conditions))
        inset = clip.overlays[2]
        assert clip.inset_below_caption == below_caption
        assert isinstance(inset, SubspaceInset)
        assert inset.below_caption != below_caption
        bars = clip.in_sheets[1]
        assert isinstance(bars, ForceBars)
        assert bars.at_right != below_caption


def test_contact_sheets_show_forces_and_verdict(rendering: str, ball: mujoco.MjModel) -> None:
    run = rollout(ball, True)
    run = replace_fields(run, outcome=replace(run.outcome, need_n=1.0))
    sheet = render_sheet(rollout_clip(run), View(width=320, height=240), n=4, columns=2)
    assert sheet.shape == (6 * 240 + 5 * 2, 2 * 320 + 2, 3), "usual, chair and side, two times"
    cells = [
        [sheet[242 * row : 242 * row + 240, 322 * i : 322 * i + 320] for i in range(2)]
        for row in range(6)
    ]
    for row in range(6):
        for cell in cells[row]:
            assert (cell == LIMIT_COLOUR).all(axis=-1).any() == (row in (0, 3)), row
    forces = [(cell == FORCE_COLOUR).all(axis=-1).sum() for row in (0, 3) for cell in cells[row]]
    assert forces[0] == 0
    assert all(np.diff(forces) > 0)
    good = [(cell == GOOD_COLOUR).all(axis=-1).any() for row in (0, 3) for cell in cells[row]]
    assert good == [False, False, False, True]


def test_small_pictures_have_a_caption_alone(rendering: str, ball: mujoco.MjModel) -> None:
    run = replace_fields(rollout(ball, True), task="tall-glass-side-rotate")
    for width, height, roomy in ((160, 120, False), (279, 240, False), (320, 240, True)):
        frame = list(render_clips([rollout_clip(run)], View(width=width, height=height, fps=4)))[3]
        for colour in (FORCE_COLOUR, PATH_COLOUR):
            assert (frame == colour).all(axis=-1).any() == roomy, (width, colour)


def test_contact_sheet_of_another_camera_shows_it_alone(
    rendering: str, ball: mujoco.MjModel
) -> None:
    view = View("top", width=64, height=48)
    assert render_sheet(rollout_clip(rollout(ball, True)), view, n=4, columns=2).shape == (
        98,
        130,
        3,
    )


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
    assert all(np.diff(bars[:5]) > 0), "the force grows"
    assert len(set(bars[4:])) == 1, "the end is shown"
    assert all((frame == PATH_COLOUR).all(axis=-1).any() for frame in frames)

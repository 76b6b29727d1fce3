"""MuJoCo's one handler of warnings is the user's again, however runs overlap."""
# pyright: reportAttributeAccessIssue=false

import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest

from handsim.silence import silent

BALL = "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"


@pytest.fixture
def heard() -> Iterator[list[str]]:
    """What a handler of the user's hears."""
    told: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(told.append)
    yield told
    mujoco.set_mju_user_warning(before)


def warn() -> None:
    """Make MuJoCo warn of a position that is no number."""
    model = mujoco.MjModel.from_xml_string(BALL)
    data = mujoco.MjData(model)
    data.qpos[0] = np.nan
    mujoco.mj_step(model, data)
    assert data.warning.number.sum() > 0


def test_a_handler_hears_nothing_inside_and_everything_afterwards(heard):
    with silent():
        warn()
    assert heard == []
    warn()
    assert len(heard) == 1


def test_interleaved_threads_are_silent_to_the_last_and_restore_the_users_handler(heard):
    """The first in is the first out, which stacked handlers do not survive."""
    first_in, second_in, first_out = (threading.Event() for _ in range(3))
    handlers = []

    def first() -> None:
        with silent():
            first_in.set()
            assert second_in.wait(10)
        first_out.set()

    def second() -> None:
        assert first_in.wait(10)
        with silent():
            second_in.set()
            assert first_out.wait(10)
            handlers.append(mujoco.get_mju_user_warning())
            warn()
            assert heard == []

    users = mujoco.get_mju_user_warning()
    with ThreadPoolExecutor(2) as pool:
        for run in [pool.submit(first), pool.submit(second)]:
            run.result(timeout=20)
    assert handlers != [users]
    assert mujoco.get_mju_user_warning() is users
    warn()
    assert len(heard) == 1


def test_many_threads_that_come_and_go(heard, monkeypatch):
    """Threads change places wherever the handler is looked at or set."""
    users = mujoco.get_mju_user_warning()
    look, start = mujoco.get_mju_user_warning, threading.Barrier(8)

    def look_slowly():
        handler = look()
        time.sleep(1e-4)
        return handler

    def come_and_go() -> None:
        start.wait(10)
        for _ in range(20):
            with silent():
                assert look() is not users

    monkeypatch.setattr(mujoco, "get_mju_user_warning", look_slowly)
    with ThreadPoolExecutor(8) as pool:
        for run in [pool.submit(come_and_go) for _ in range(8)]:
            run.result(timeout=30)
    assert look() is users
    assert heard == []


def test_none_is_none_again():
    before = mujoco.get_mju_user_warning()
    try:
        mujoco.set_mju_user_warning(None)
        with silent():
            assert mujoco.get_mju_user_warning() is not None
        assert mujoco.get_mju_user_warning() is None
    finally:
        mujoco.set_mju_user_warning(before)


def test_nested_and_left_by_an_exception(heard):
    users = mujoco.get_mju_user_warning()
    with silent():
        with pytest.raises(RuntimeError, match="inside"), silent():
            raise RuntimeError("inside")
        warn()
        assert heard == []
    assert mujoco.get_mju_user_warning() is users
    warn()
    assert len(heard) == 1


def test_a_handler_set_meanwhile_stays(heard):
    told: list[str] = []
    with silent():
        mujoco.set_mju_user_warning(told.append)
        own = mujoco.get_mju_user_warning()
    assert mujoco.get_mju_user_warning() is own
    warn()
    assert len(told) == 1
    assert heard == []


def test_a_handler_set_meanwhile_is_kept_from_hearing_the_next_run(heard):
    told: list[str] = []
    with silent():
        mujoco.set_mju_user_warning(told.append)
        with silent():
            warn()
    assert told == []
    warn()
    assert len(told) == 1

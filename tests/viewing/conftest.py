from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.errors import MissingToolError, RenderingError
from handsim.types import Frame
from handsim.viewing.opengl.backend import choose_backend

from .chromium import Browser, open_browser

BALL = """
<mujoco>
  <worldbody>
    <light pos="0 -1 3"/>
    <geom type="plane" size="2 2 .1" rgba=".4 .5 .6 1"/>
    <body name="ball" pos="0 0 .3"><freejoint/><geom type="ellipsoid" size=".3 .2 .1"/></body>
    <camera name="fixed" pos="0 -2 .6" xyaxes="1 0 0 0 .2 1"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="session")
def rendering() -> str:
    """The backend that renders here; tests that draw are skipped where there is none."""
    try:
        return choose_backend()
    except (MissingToolError, RenderingError) as error:
        pytest.skip(str(error))


@pytest.fixture
def ball() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(BALL)


@pytest.fixture
def frames() -> list[Frame]:
    """Ten frames in which a bright square moves."""
    made = [np.full((64, 96, 3), 60, np.uint8) for _ in range(10)]
    for i, frame in enumerate(made):
        frame[20:40, 5 * i : 5 * i + 20] = (230, 120, 40)
    return made


@pytest.fixture
def target(tmp_path: Path) -> Path:
    """A folder that must hold nothing but what is asked for."""
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


@pytest.fixture
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with open_browser(tmp_path_factory.mktemp("chromium")) as opened:
        yield opened

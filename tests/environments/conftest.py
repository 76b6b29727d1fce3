"""Environments of the tests, closed afterwards."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest


@pytest.fixture
def make() -> Iterator[Callable[..., Any]]:
    """Make an environment of handsim by its arguments."""
    gymnasium = pytest.importorskip("gymnasium", reason="comes with handsim[gym]")
    from handsim.environments import ID

    made = []

    def build(**values: Any) -> Any:
        made.append(gymnasium.make(ID, **values))
        return made[-1]

    yield build
    for env in made:
        env.close()

"""What tests of several packages need."""

import gc
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import pytest

Frame = np.ndarray

BREAK_ELSEWHERE = ("test_determinism.py", "test_environments.py", "test_shipped.py")
"""What fails first on another machine; it is run first, so that nobody waits to hear of it."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.name not in BREAK_ELSEWHERE)


@pytest.fixture(scope="session")
def read_video() -> Callable[[Path], tuple[dict[str, Any], list[Frame]]]:
    def read(path: Path) -> tuple[dict[str, Any], list[Frame]]:
        """Metadata and frames of a video, as its reader finds them."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # imageio-ffmpeg leaves a pipe open
            reader = imageio_ffmpeg.read_frames(str(path))
            metadata = next(reader)
            width, height = metadata["size"]
            frames = [np.frombuffer(raw, np.uint8).reshape(height, width, 3) for raw in reader]
            del reader
            gc.collect()
        return metadata, frames

    return read

"""What `recordings info` says of a set."""

import numpy as np
import pytest

from handsim.joints import N_JOINTS, UPPER
from handsim.recordings.contents import summarise
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize


def test_summary_counts_what_leaves_the_ranges() -> None:
    q = np.tile(np.full(N_JOINTS, 0.05), (20, 1))
    q[:5, 5] = UPPER[5] + 0.1
    one = Recording("a", np.arange(20) / 50, q, 1, "s", "cube", "cube-raise", HandSize(0.19, 0.085))
    two = Recording(
        "b", np.arange(20) / 50, q[5:].repeat(2, 0)[:20], 2, "s", "jar", "t", HandSize(0.2, 0.09)
    )
    found = summarise(RecordingSet((one, two)))
    assert found["n_recordings"] == 2 and found["n_frames"] == 40
    assert found["objects"] == {"cube": 1, "jar": 1}
    assert found["rate_hz"]["median"] == pytest.approx(50)
    assert found["hand_sizes_m"] == [[0.19, 0.085], [0.2, 0.09]]
    assert found["n_frames_out_of_range"] == 5
    assert list(found["out_of_range"]) == ["index_pip"]
    assert found["out_of_range"]["index_pip"]["n_frames"] == 5
    rows = {row["name"]: row for row in found["recordings"]}
    assert rows["a"]["side"] == "right" and rows["a"]["frames"] == 20
    assert rows["a"]["light"] == "red"
    assert [each["kind"] for each in rows["b"]["warnings"]] == ["radians", "constant"]

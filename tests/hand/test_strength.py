import numpy as np
import pytest

from handsim.hand.anthropometry import HandGeometry
from handsim.hand.strength import FINGERTIP_FORCE, SATURATION, position_gains, torque_limits
from handsim.joints import JOINT_INDEX
from handsim.types import HandSize


@pytest.mark.parametrize(
    ("joint", "lever"),
    [
        ("index_mcp", 0.2 * (0.245 + 0.143 + 0.097)),
        ("index_pip", 0.2 * (0.143 + 0.097)),
        ("index_dip", 0.2 * 0.097),
        ("index_abduction", 0.5 * 0.2 * (0.245 + 0.143 + 0.097)),
        ("thumb_rotation", 0.2 * (0.251 + 0.196 + 0.158)),
        ("thumb_abduction", 0.2 * (0.251 + 0.196 + 0.158)),
        ("thumb_mcp", 0.2 * (0.196 + 0.158)),
        ("thumb_ip", 0.2 * 0.158),
        ("palm_arch", 2 * 0.09),
        ("wrist_flexion", 4 * 0.2 * (0.446 + 0.266)),
        ("wrist_deviation", 4 * 0.2 * (0.446 + 0.266)),
    ],
)
def test_torque_limit_is_force_times_lever(joint, lever):
    geometry = HandGeometry(HandSize(0.2, 0.09))
    index = JOINT_INDEX[joint]
    assert torque_limits(geometry)[index] == pytest.approx(FINGERTIP_FORCE * lever, rel=1e-12)
    assert position_gains(geometry)[index] == pytest.approx(
        FINGERTIP_FORCE * lever / SATURATION, rel=1e-12
    )


def test_every_joint_has_strength():
    assert np.all(torque_limits(HandGeometry()) > 0.3)

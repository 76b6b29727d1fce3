"""Names of what is recorded beside the joints: places and poses in the frame of the cameras."""

import numpy as np

from handsim.hand.anthropometry import HandGeometry
from handsim.recordings.fitting.fit_hand import HandFit
from handsim.recordings.fitting.rigid import quaternions_of
from handsim.types import Array


def position_channels(name: str, position: Array) -> dict[str, Array]:
    """Return a place (n, 3) [m] as channels ``<name>_x_m`` and so on."""
    return {f"{name}_{axis}_m": position[:, i] for i, axis in enumerate("xyz")}


def pose_channels(name: str, rotation: Array, position: Array) -> dict[str, Array]:
    """Return a pose, (n, 3, 3) and (n, 3) [m], as channels of place and unit quaternion."""
    turned = quaternions_of(rotation)
    return {
        **position_channels(name, position),
        **{f"{name}_q{part}": turned[:, i] for i, part in enumerate("wxyz")},
    }


PALM_CENTRE = 0.5
"""Where the middle of the palm is on the way from the wrist centre to the middle finger's MCP."""


def channels_of_fit(fit: HandFit, aperture: Array | None = None) -> dict[str, Array]:
    """Return the palm's pose, the aperture and how well each frame fits.

    Parameters
    ----------
    fit
    aperture : (n,) [m]
        Distance from thumb tip to index tip where it was measured; that of the fitted hand
        otherwise.
    """
    kinematics = fit.points.kinematics
    middle = PALM_CENTRE * HandGeometry(fit.hand).mcp("middle")  # on the axis, the same on a left
    if aperture is None:
        aperture = kinematics.aperture(fit.q)
    return {
        **pose_channels("palm", fit.rotation, fit.position + fit.rotation @ middle),
        "aperture_m": np.where(fit.lost, np.nan, aperture),
        "fit_residual_m": fit.frame_residual,
        "fit_bad": fit.bad.astype(float),
    }

"""Check of a machine: which of the parts for rendering and encoding are there and work."""

import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

from handsim.viewing.film.video import ENCODER_INSTALL
from handsim.viewing.opengl.backend import ProbeResult, install_command, probe

PACKAGES = ("mujoco", "numpy", "scipy", "scikit-learn", "imageio", "imageio-ffmpeg", "pillow")


@dataclass(frozen=True)
class Check:
    """One row of the doctor's table.

    Attributes
    ----------
    name
        What was looked at.
    ok
        It is there and works.
    detail
        Version, or driver and frame rate, or why it does not work.
    remedy
        The command that puts it right; empty where nothing is wrong.
    """

    name: str
    ok: bool
    detail: str
    remedy: str = ""


def doctor(seconds: float = 0.3) -> list[Check]:
    """Look at Python, the libraries, every OpenGL backend and the video encoder.

    Parameters
    ----------
    seconds
        How long each backend renders for its frame rate [s].
    """
    findings = [Check("python", True, platform.python_version())]
    findings += [_package(name) for name in PACKAGES]
    findings += [_backend(probe(name, seconds)) for name in ("egl", "osmesa")]
    return [*findings, _encoder()]


def can_render(findings: list[Check]) -> bool:
    """Return whether one backend renders and the encoder runs: all that a video needs."""
    by_name = {finding.name: finding.ok for finding in findings}
    return (by_name["gl egl"] or by_name["gl osmesa"]) and by_name["ffmpeg"]


def _package(name: str) -> Check:
    try:
        return Check(name, True, version(name))
    except PackageNotFoundError:
        return Check(name, False, "not installed", f"pip install {name}")


def _backend(result: ProbeResult) -> Check:
    name = f"gl {result.backend}"
    if not result.ok:
        return Check(name, False, result.reason, install_command(result.backend))
    rate = result.frames_per_second
    return Check(name, True, f"{result.driver}, {rate or 0:.0f} frames/s at 320 x 240")


def _encoder() -> Check:
    try:
        import imageio_ffmpeg

        executable = imageio_ffmpeg.get_ffmpeg_exe()
        return Check("ffmpeg", True, f"{imageio_ffmpeg.get_ffmpeg_version()}, {executable}")
    except (ImportError, RuntimeError, OSError) as error:
        return Check("ffmpeg", False, str(error).splitlines()[0], ENCODER_INSTALL)

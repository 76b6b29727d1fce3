"""Movements into a video, a GIF or a picture, in one call."""

from collections.abc import Iterable
from pathlib import Path

from handsim.grasping.rollout.record import Rollout
from handsim.learning.controller import PostureSequence
from handsim.recordings.recording import Recording
from handsim.types import Frame, Progress
from handsim.viewing.film.clips import Clip, render_sheet, save_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.overlay import Caption
from handsim.viewing.film.posture_clips import posture_clip, posture_model
from handsim.viewing.film.rollout_clips import rollout_clip
from handsim.viewing.opengl.backend import choose_backend

Shown = Rollout | Recording | PostureSequence | Clip
"""What can be drawn: a simulated grasp, postures over time, or what `clip_of` makes of them."""


def render(
    shown: Shown | Iterable[Shown],
    path: Path | str,
    *,
    camera: str = "view",
    size: tuple[int, int] = (640, 480),
    fps: float = 30.0,
    n_postures: int = 8,
    measurements: bool = True,
    progress: Progress | None = None,
) -> int:
    """Draw movements in true time into a file; rollouts show their end for a second more.

    Parameters
    ----------
    shown
        A rollout, a recording, a posture sequence or a clip; several make a grid.
    path
        ``.mp4``, ``.gif`` or ``.png``. The picture of one movement is its contact sheet; of
        several, one picture of each at its end. The file is replaced only when all is drawn.
    camera
        ``view``, ``front``, ``side``, ``palm``, ``top``, ``chair``, ``orbit``, ``follow``, or a
        camera of the model. Beside ``view`` a rollout's film has an inset of what the person sees
        from the chair, and its contact sheet has rows of ``chair`` and ``side``. Of a robot hand
        the inset, and the last row, is the person's hand that it follows.
    size
        Width and height of the video, or of each picture of a contact sheet [pixels].
    fps
        Frames a second.
    n_postures
        Pictures in a contact sheet.
    measurements
        Whether what was measured of a rollout is drawn in, and other views beside.
    progress
        Called with the fraction done.

    Returns
    -------
    int
        Number of frames or pictures drawn.

    Raises
    ------
    InputError
        If the size or the rate is outside what can be drawn, or the suffix is another.
    UnknownNameError
        If there is no camera of that name.
    MissingToolError
        If nothing renders on this machine.
    """
    view = View(camera, *size, fps)
    clips = [clip_of(each, measurements=measurements) for each in _several(shown)]
    choose_backend()
    return save_clips(clips, path, view, n_postures=n_postures, progress=progress)


def contact_sheet_of(
    shown: Shown, n: int = 6, *, camera: str = "view", size: tuple[int, int] = (320, 240)
) -> Frame:
    """Return pictures along a movement as one, (height, width, 3).

    Parameters
    ----------
    shown
        A rollout, a recording or a posture sequence.
    n
        Number of pictures.
    camera, size
        As in `render`; the size is that of each picture.
    """
    choose_backend()
    return render_sheet(clip_of(shown), View(camera, *size), n)


def clip_of(shown: Shown, *, measurements: bool = True, caption: str = "") -> Clip:
    """Return a movement as it is drawn.

    Parameters
    ----------
    shown
    measurements
        Whether what was measured of a rollout is drawn in.
    caption
        Written onto postures; by default the name of a recording.
    """
    if isinstance(shown, Clip):
        return shown
    if isinstance(shown, Rollout):
        return rollout_clip(shown, measurements)
    if isinstance(shown, Recording):
        overlays = (Caption((caption or shown.name,)),)
        return posture_clip(shown.time, shown.q, posture_model(shown.hand), overlays)
    overlays = (Caption((caption,)),) if caption else ()
    return posture_clip(shown.time, shown.q, overlays=overlays)


def _several(shown: Shown | Iterable[Shown]) -> Iterable[Shown]:
    # A posture sequence is a tuple, too.
    return [shown] if isinstance(shown, Rollout | Recording | PostureSequence | Clip) else shown

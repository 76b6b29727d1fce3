"""The layout ``markers``: optical motion capture of a hand, an arm and an object.

Which marker is what says a TOML file (`handsim.recordings.points.marker_map`), or the likeness of
names. handsim's own hand is fitted to the markers on the hand: its size, the place of each marker
on its segment, and the angles. Flexion and spreading are positive by the geometry of that hand.

The wrist's angles follow from the forearm, which runs from the elbow's markers to the wrist centre
of the fitted hand. One marker does not tell where the elbow's centre is: in a published recording
the deviation then came out at -15 to -39 deg. Therefore two are needed, unless the map asks for it.
Palm, elbow, shoulder, torso and object are kept in the frame of the cameras. The aperture is the
distance of the markers on the tips of thumb and index finger, where both are.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from handsim.errors import FileError
from handsim.joints import JOINT_INDEX
from handsim.recordings.fitting.fit_hand import HandFit, fit_hand
from handsim.recordings.gaps import bridge
from handsim.recordings.importers.keypoints import BRIDGED_S, notes_of_fit
from handsim.recordings.importers.layout import ImportOptions, Layout
from handsim.recordings.points.beside_hand import (
    EPICONDYLE,
    elbow_centre,
    middle,
    rigid_pose,
    wrist_angles,
)
from handsim.recordings.points.channels import (
    channels_of_fit,
    pose_channels,
    position_channels,
)
from handsim.recordings.points.clocks import Clock, clock_of
from handsim.recordings.points.marker_files import MarkerFile, read_marker_file
from handsim.recordings.points.marker_map import (
    LENGTH_UNITS,
    MarkerMap,
    read_marker_map,
    roles_by_name,
    roles_of_map,
    side_by_name,
)
from handsim.recordings.points.marker_roles import BODY_ROLES, MarkerRoles
from handsim.recordings.recording import MIN_FRAMES, Recording, RecordingSet
from handsim.types import Array
from handsim.wording import number_of

UNSURE_SIZE = (
    "markers tell the size of the hand to about a tenth only: state it where it was measured"
)
LEAST_HAND_MARKERS = 7
"""Markers on the hand without which no posture can be found: a palm's three and some fingers'."""
_HAND_EXTENT = (0.02, 0.2)
"""Root mean square distance of a hand's markers from their middle, which tells the unit [m]."""
_WRIST = [JOINT_INDEX["wrist_flexion"], JOINT_INDEX["wrist_deviation"]]


def read_markers(files: Sequence[Path], options: ImportOptions) -> RecordingSet:
    """Read files of markers, one continuous recording each.

    Raises
    ------
    FileError
        If a file or the map is missing or damaged, or too few markers are on the hand.
    MissingToolError
        If a file is C3D and the library that reads it is not installed.
    InputError
        If the hand is seen in too few frames, or its side cannot be told.
    """
    said = None if options.column_map is None else read_marker_map(options.column_map)
    made = [_recording(file, number, options, said) for number, file in enumerate(files, start=1)]
    return RecordingSet(tuple(made))


def _recording(
    path: Path, number: int, options: ImportOptions, said: MarkerMap | None
) -> Recording:
    content = read_marker_file(path)
    if said is not None and options.column_map is not None:
        roles = roles_of_map(options.column_map, said, content.names)
    else:
        roles = roles_by_name(content.names)
    on_hand = [name for name in content.names if name in roles.on_hand()]
    _check_hand(path, on_hand, content)
    n = len(content.positions)
    clock = clock_of(str(path), n, content.stamps, options.rate_hz, content.rate_hz)
    positions, notes = _in_metres(path, content, on_hand, said)
    positions, bridged = _bridged(clock, positions[clock.kept], options.bridge_s or BRIDGED_S)
    notes += bridged
    marker = {name: positions[:, i] for i, name in enumerate(content.names)}
    arm = [name for role in BODY_ROLES for name in roles.named(role)]
    fit = fit_hand(
        str(path),
        [roles.on_hand()[name] for name in on_hand],
        np.stack([marker[name] for name in on_hand], axis=1),
        hand=options.hand,
        side=options.side or (said.side if said else None) or side_by_name(arm),
        palm_known=False,
        step_s=float(np.median(np.diff(clock.time))),
    )
    wanted = None if said is None else said.wrist
    if wanted is None:
        wanted = len(roles.named("elbow")) > 1
    q, wrist = _with_wrist(fit, marker, roles) if wanted else (fit.q, [])
    return Recording(
        name=path.stem,
        time=clock.time,
        q=q,
        number=number,
        subject=str(options.subject or 1),
        object=options.object or "unknown",
        task=options.task or "unknown",
        hand=fit.hand,
        channels={
            **channels_of_fit(fit, _aperture(marker, roles)),
            **_channels_beside(marker, roles),
        },
        notes=(
            *roles.notes,
            *clock.notes,
            *notes,
            *notes_of_fit(fit, wrist=bool(wrist)),
            *(() if options.hand else (UNSURE_SIZE,)),
            *wrist,
        ),
    )


def _check_hand(path: Path, on_hand: list[str], content: MarkerFile) -> None:
    n = len(content.positions)
    if n < MIN_FRAMES:
        raise FileError(f"{path}: {number_of(n, 'frame')}; at least {MIN_FRAMES} are needed")
    if len(on_hand) < LEAST_HAND_MARKERS:
        raise FileError(
            f"{path}: {len(on_hand)} of {len(content.names)} markers taken for markers on the "
            f"hand, at least {LEAST_HAND_MARKERS} are needed; say by --map which is what: "
            f"{', '.join(content.names)[:300]}"
        )


def _in_metres(
    path: Path, content: MarkerFile, on_hand: list[str], said: MarkerMap | None
) -> tuple[Array, list[str]]:
    """Return positions in metres, and how their unit was known."""
    positions = np.where(
        np.abs(np.nan_to_num(content.positions, nan=np.inf)) < 1e9, content.positions, np.nan
    )
    hand = positions[:, [content.names.index(name) for name in on_hand]]
    whole = hand[np.isfinite(hand).all(axis=(1, 2))]
    if not len(whole):
        raise FileError(
            f"{path}: no frame in which all {len(on_hand)} markers of the hand are seen"
        )
    extent = float(np.median(np.sqrt(((whole - middle(whole)[:, None]) ** 2).sum(2).mean(1))))
    given = (said.metres_per_unit if said else None) or content.metres_per_unit
    if given is not None and _HAND_EXTENT[0] <= given * extent < _HAND_EXTENT[1]:
        return positions * given, []
    for unit, factor in LENGTH_UNITS.items():
        if _HAND_EXTENT[0] <= factor * extent < _HAND_EXTENT[1]:
            wrong = "" if given is None else ", against what is said of them"
            return positions * factor, [f"positions taken as {unit} by the size of the hand{wrong}"]
    raise FileError(
        f"{path}: the markers of the hand are {extent:g} from their middle, which is no hand in m, "
        "cm or mm; check which marker is what (--map)"
    )


def _bridged(clock: Clock, positions: Array, longest: float) -> tuple[Array, list[str]]:
    """Return positions with short gaps bridged, and notes of those and of the long ones."""
    flat, filled = bridge(clock.time, positions.reshape(len(positions), -1), longest)
    made = flat.reshape(positions.shape)
    notes: list[str] = []
    if filled.any():
        count = int(filled.reshape(positions.shape)[..., 0].sum())
        notes.append(
            f"gaps of at most {longest:g} s bridged: {number_of(count, 'position')} of markers"
        )
    left = int((~np.isfinite(made[..., 0])).sum())
    if left:
        notes.append(
            f"{number_of(left, 'position')} of markers missing, longer than that: fitted without "
            "them"
        )
    return made, notes


def _with_wrist(
    fit: HandFit, marker: dict[str, Array], roles: MarkerRoles
) -> tuple[Array, list[str]]:
    """Return the angles with those of the wrist, and how these were found."""
    elbows = roles.named("elbow")
    if not elbows:
        return fit.q, []
    elbow = middle(np.stack([marker[name] for name in elbows], axis=1))
    notes = [f"wrist angles from {', '.join(elbows)} to the wrist centre of the fitted hand"]
    shoulders = roles.named("shoulder")
    if len(elbows) == 1 and shoulders:
        shoulder = middle(np.stack([marker[name] for name in shoulders], axis=1))
        elbow = elbow_centre(elbow, shoulder, fit.position, fit.hand.side)
        notes.append(
            f"{elbows[0]} taken for {1000 * EPICONDYLE:g} mm beside the joint, on its outer side"
        )
    angles = wrist_angles(fit, elbow)
    known = np.isfinite(angles).all(axis=1)
    if not known.any():
        return fit.q, []
    q, frames = fit.q.copy(), np.arange(len(angles))
    for column, joint in enumerate(_WRIST):
        q[:, joint] = np.interp(frames, frames[known], angles[known, column])
    return q, notes


def _aperture(marker: dict[str, Array], roles: MarkerRoles) -> Array | None:
    """Return the distance of the markers on both tips, (n,) [m]; None unless both are there."""
    thumb, index = (roles.named(tip) for tip in ("thumb_tip", "index_tip"))
    if not (thumb and index):
        return None
    return np.linalg.norm(marker[thumb[0]] - marker[index[0]], axis=1)


def _channels_beside(marker: dict[str, Array], roles: MarkerRoles) -> dict[str, Array]:
    made: dict[str, Array] = {}
    for role in BODY_ROLES:
        names = roles.named(role)
        if names:
            place = middle(np.stack([marker[name] for name in names], axis=1))
            made.update(position_channels(role, place))
    names = roles.named("object")
    if names:
        rotation, position = rigid_pose(np.stack([marker[name] for name in names], axis=1))
        made.update(
            pose_channels("object", rotation, position)
            if np.isfinite(rotation).any()
            else position_channels("object", position)
        )
    return made


LAYOUT = Layout(
    "markers",
    "optical motion capture: tab-separated or CSV exports with '<marker> X', or C3D",
    read_markers,
    frozenset({"bridge_s", "column_map", "hand", "object", "rate_hz", "side", "subject", "task"}),
)

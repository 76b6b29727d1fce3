"""Movements as a rerun recording: curves of all quantities, and the hand and the object in 3-D."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from handsim.exports.episode import Episode
from handsim.exports.episode_clip import bare_clip
from handsim.exports.export_sources import Exported, episodes_of
from handsim.exports.libraries import library
from handsim.files import replacing
from handsim.types import Progress
from handsim.viewing.film.clip import Clip
from handsim.viewing.live.shapes import geom_colour, geom_mesh, visible_geoms

TIMELINE = "time"
"""Time since the start of each movement, so that several play beside each other."""
_LONGEST_PLANE = 2.0
"""Half of the longest side that is drawn of a floor [m]."""


def write_rerun(exported: Exported, path: Path, progress: Progress | None = None) -> None:
    """Write movements as a rerun recording (``.rrd``), as a whole or not at all.

    Each movement is below its own name: ``<name>/<quantity>`` has curves, in SI units and radians,
    ``<name>/scene/<body>`` the bodies of the model, moving.

    Parameters
    ----------
    exported
        A rollout, a recording, a posture sequence, or several.
    path
    progress
        Called with the fraction done.

    Raises
    ------
    MissingToolError
        If rerun-sdk is not installed.
    InputError
        If there is nothing to export.
    FileError
        If the file cannot be written.
    """
    rerun = library("rerun")
    episodes = episodes_of(exported)
    with replacing(Path(path)) as temporary:
        recording = rerun.RecordingStream("handsim")
        memory = recording.memory_recording()
        recording.log("/", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for number, episode in enumerate(episodes, start=1):
            _add_curves(rerun, recording, episode)
            _add_scene(rerun, recording, episode.name, bare_clip(episode))
            if progress is not None:
                progress(number / len(episodes))
        temporary.write_bytes(memory.drain_as_bytes())


def _add_curves(rerun: Any, recording: Any, episode: Episode) -> None:
    said = {"task": episode.task, "sentence": episode.sentence, **episode.facts}
    text = json.dumps(said, indent=2, ensure_ascii=False)
    recording.log(_entity(rerun, episode.name, "facts"), rerun.TextDocument(text), static=True)
    time = _times(rerun, episode.time - episode.time[0])
    for quantity in episode.quantities:
        entity = _entity(rerun, episode.name, quantity.name)
        names = [
            f"{column} [{unit}]" if unit else column
            for column, unit in zip(quantity.columns, quantity.units, strict=True)
        ]
        recording.log(entity, rerun.SeriesLines(names=names), static=True)
        recording.send_columns(
            entity, indexes=[time], columns=rerun.Scalars.columns(scalars=quantity.values)
        )


def _add_scene(rerun: Any, recording: Any, name: str, clip: Clip) -> None:
    """Add the geoms of the model once, and where its bodies are over time."""
    model = clip.model
    shown = visible_geoms(model)
    for geom in shown:
        body = _body(model, int(model.geom_bodyid[geom]))
        mesh, colour = geom_mesh(model, geom), geom_colour(model, geom)
        vertices = np.clip(mesh.vertices, -_LONGEST_PLANE, _LONGEST_PLANE)
        recording.log(
            _entity(rerun, name, "scene", body, str(geom)),
            rerun.Mesh3D(
                vertex_positions=vertices,
                triangle_indices=mesh.faces,
                vertex_normals=mesh.vertex_normals,
                albedo_factor=[round(255 * part) for part in colour],
            ),
            _placed(rerun, model.geom_pos[geom], model.geom_quat[geom]),
            static=True,
        )
    positions, turns = _poses(clip)
    time = _times(rerun, clip.time)
    for body in sorted({int(model.geom_bodyid[geom]) for geom in shown} - {0}):
        recording.send_columns(
            _entity(rerun, name, "scene", _body(model, body)),
            indexes=[time],
            columns=rerun.Transform3D.columns(
                translation=positions[:, body], quaternion=np.roll(turns[:, body], -1, axis=1)
            ),
        )


def _entity(rerun: Any, *parts: str) -> str:
    """Return the path of an entity; what has a meaning in paths is escaped."""
    return rerun.new_entity_path(list(parts))


def _times(rerun: Any, seconds: Any) -> Any:
    return rerun.TimeColumn(TIMELINE, duration=seconds)


def _placed(rerun: Any, position: Any, turn: Any) -> Any:
    """Return a pose as rerun has it: quaternions are (x, y, z, w) there."""
    return rerun.Transform3D(
        translation=position, quaternion=rerun.Quaternion(xyzw=np.roll(turn, -1))
    )


def _body(model: mujoco.MjModel, body: int) -> str:
    return model.body(body).name or f"body_{body}"


def _poses(clip: Clip) -> tuple[Any, Any]:
    """Return positions (n, n_bodies, 3) [m] and orientations (n, n_bodies, 4) in the world."""
    data = mujoco.MjData(clip.model)
    positions = np.empty((len(clip.time), clip.model.nbody, 3))
    turns = np.empty((len(clip.time), clip.model.nbody, 4))
    for i, qpos in enumerate(clip.qpos):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(clip.model, data)
        positions[i], turns[i] = data.xpos, data.xquat
    return positions, turns

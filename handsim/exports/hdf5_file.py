"""Movements in one HDF5 file, a group each, in SI units and radians.

A group has ``time`` and a dataset for each quantity, whose attributes say columns, units and frame.
That of a simulated grasp has MuJoCo's own arrays and the model beside, in the group ``mujoco``, so
that nothing of a rollout is lost.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from handsim.exports.episode import Episode, Quantity
from handsim.exports.export_sources import Exported, episodes_of
from handsim.exports.libraries import library
from handsim.files import replacing
from handsim.grasping.rollout.record import Rollout

HDF5_SCHEMA = 1
RAW: dict[str, str] = {
    "qpos": "positions in the order of the model",
    "qvel": "velocities in the order of the model",
    "ctrl": "controls in the order of the model",
    "mocap_pos": "commanded position of the forearm, on an arm of the palm [m]",
    "mocap_quat": "commanded orientation of it, as quaternion (w, x, y, z)",
}
"""MuJoCo's own arrays of a rollout, and what they are."""


def write_hdf5(exported: Exported, path: Path) -> None:
    """Write movements as HDF5, as a whole or not at all.

    Parameters
    ----------
    exported
        A rollout, a recording, a posture sequence, or several. Groups are named as recordings are,
        as the tasks of rollouts, or as a mapping says; a second of the same name gets a number.
    path

    Raises
    ------
    MissingToolError
        If h5py is not installed.
    InputError
        If there is nothing to export.
    FileError
        If the file cannot be written.
    """
    h5py = library("h5py")
    episodes = episodes_of(exported)
    with replacing(Path(path)) as temporary:
        # Made in memory: h5py would tell of a full disk in words of its own, or not at all.
        with h5py.File("movements", "w", driver="core", backing_store=False) as file:
            _fill(file, episodes)
            file.flush()
            content = file.id.get_file_image()
        temporary.write_bytes(content)


def _fill(file: Any, episodes: tuple[Episode, ...]) -> None:
    file.attrs["kind"] = "handsim movements"
    file.attrs["schema"] = HDF5_SCHEMA
    for episode in episodes:
        _add(file.create_group(episode.name, track_order=True), episode)


def _add(group: Any, episode: Episode) -> None:
    said = {"kind": episode.kind, "task": episode.task, "sentence": episode.sentence}
    for name, value in {**said, **episode.facts}.items():
        plain = isinstance(value, str | bool | int | float)
        group.attrs[name] = value if plain else json.dumps(value, sort_keys=True)
    if episode.phases:
        group.attrs["phase_names"] = [name for name, _ in episode.phases]
        group.attrs["phase_starts_s"] = [start for _, start in episode.phases]
    group.create_dataset("time", data=episode.time).attrs["unit"] = "s"
    group["time"].make_scale("time")
    for quantity in episode.quantities:
        _add_quantity(group, quantity)
    if episode.rollout is not None:
        _add_raw(group.create_group("mujoco"), episode.rollout)


def _add_quantity(group: Any, quantity: Quantity) -> None:
    dataset = group.create_dataset(quantity.name, data=quantity.values)
    dataset.dims[0].attach_scale(group["time"])
    dataset.attrs["columns"] = list(quantity.columns)
    dataset.attrs["units"] = list(quantity.units)
    if len(set(quantity.units)) == 1:
        dataset.attrs["unit"] = quantity.units[0]
    dataset.attrs["description"] = quantity.what
    if quantity.frame:
        dataset.attrs["frame"] = quantity.frame


def _add_raw(group: Any, rollout: Rollout) -> None:
    for name, what in RAW.items():
        group.create_dataset(name, data=getattr(rollout, name)).attrs["description"] = what
    group["model_xml"] = rollout.model_xml
    for name, content in rollout.assets.items():
        group.create_dataset(f"assets/{name}", data=np.frombuffer(content, dtype=np.uint8))

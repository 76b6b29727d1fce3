"""One simulated grasp as a record: what was simulated, what happened, how it was judged.

The file holds all that is needed to draw or to judge the grasp again without simulating it: the
model as XML with its meshes, states, commands, contact loads, versions and the outcome.
"""

import platform
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from handsim.errors import FileError
from handsim.files import read_archive, write_archive
from handsim.joints import FINGERS
from handsim.simulation.conditions import Conditions
from handsim.simulation.trials import Outcome

if TYPE_CHECKING:
    import mujoco

Array = npt.NDArray[np.float64]

KIND = "rollout"
SCHEMA = 1
ASSET_PREFIX = "asset:"
CONTACT_PARTS: tuple[str, ...] = (*FINGERS, "palm")
"""Parts of the hand whose contact load on the object is kept, in column order."""


@dataclass(frozen=True)
class Phase:
    """A named stretch of a grasp that starts at ``start`` [s]."""

    name: str
    start: float


@dataclass(frozen=True)
class Rollout:
    """A simulated grasp.

    Attributes
    ----------
    task, driver
        Name of the task, and of what drove the hand.
    model_xml, assets
        The model, and the files it refers to by name.
    time : (n,) [s]
    qpos, qvel, ctrl : (n, nq), (n, nv), (n, nu)
        MuJoCo's arrays in the order of the model.
    mocap_pos, mocap_quat : (n, 3) [m], (n, 4)
        Commanded pose of the forearm.
    reading : (n, 22) [rad]
        What the data glove read.
    z : (n, n_components) [rad]
        Measured posture in the subspace; (n, 0) where the driver has none.
    contact_force : (n, 6) [N]
        Sum of normal forces on the object, per part of the hand (`CONTACT_PARTS`).
    penetration : (n,) [m]
        Deepest overlap of hand and object.
    phases
        In order of time.
    conditions, outcome
        What it was made with, and its judgement.
    """

    task: str
    driver: str
    model_xml: str
    assets: dict[str, bytes]
    time: Array
    qpos: Array
    qvel: Array
    ctrl: Array
    mocap_pos: Array
    mocap_quat: Array
    reading: Array
    z: Array
    contact_force: Array
    penetration: Array
    phases: tuple[Phase, ...]
    conditions: Conditions
    outcome: Outcome
    versions: dict[str, str] = field(default_factory=dict)

    def model(self) -> "mujoco.MjModel":
        """Compile the stored model."""
        import mujoco

        return mujoco.MjModel.from_xml_string(self.model_xml, self.assets)

    def phase_at(self, time: float) -> str:
        """Name of the phase at ``time`` [s]."""
        names = [phase.name for phase in self.phases if phase.start <= time + 1e-9]
        return names[-1] if names else ""


_ARRAYS = (
    "time",
    "qpos",
    "qvel",
    "ctrl",
    "mocap_pos",
    "mocap_quat",
    "reading",
    "z",
    "contact_force",
    "penetration",
)


def current_versions() -> dict[str, str]:
    """Versions and platform that bear on the numbers of a simulation."""
    return {
        "handsim": version("handsim"),
        "mujoco": version("mujoco"),
        "numpy": version("numpy"),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }


def write_rollout(rollout: Rollout, path: Path) -> None:
    """Write a rollout as ``.npz``, as a whole or not at all."""
    metadata: dict[str, Any] = {
        "task": rollout.task,
        "driver": rollout.driver,
        "model_xml": rollout.model_xml,
        "phases": [asdict(phase) for phase in rollout.phases],
        "conditions": asdict(rollout.conditions),
        "outcome": asdict(rollout.outcome),
        "versions": rollout.versions,
    }
    arrays: dict[str, npt.NDArray[Any]] = {name: getattr(rollout, name) for name in _ARRAYS}
    for name, content in rollout.assets.items():
        arrays[ASSET_PREFIX + name] = np.frombuffer(content, dtype=np.uint8)
    write_archive(path, KIND, SCHEMA, metadata, arrays)


def read_rollout(path: Path) -> Rollout:
    """Read a rollout.

    Raises
    ------
    FileError
        If the file is missing, damaged, foreign or of a newer schema.
    """
    metadata, arrays = read_archive(path, KIND, SCHEMA)
    try:
        conditions = dict(metadata["conditions"])
        conditions["object_offset"] = tuple(conditions["object_offset"])
        return Rollout(
            task=metadata["task"],
            driver=metadata["driver"],
            model_xml=metadata["model_xml"],
            assets={
                name.removeprefix(ASSET_PREFIX): content.tobytes()
                for name, content in arrays.items()
                if name.startswith(ASSET_PREFIX)
            },
            phases=tuple(Phase(**phase) for phase in metadata["phases"]),
            conditions=Conditions(**conditions),
            outcome=Outcome(**metadata["outcome"]),
            versions=metadata["versions"],
            **{name: arrays[name] for name in _ARRAYS},
        )
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"{path}: incomplete rollout ({error}); make it again") from error

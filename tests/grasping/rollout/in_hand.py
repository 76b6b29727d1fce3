"""Scenes in which hand and object are made to overlap here and there."""
# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np

from handsim.grasping.rollout.compiled_scene import Scene
from handsim.joints import LOWER, UPPER


def pushed_into(scene: Scene, seed: int) -> None:
    """Put the object into the hand, in some posture of it, and step."""
    model, data, generator = scene.hand.model, scene.hand.data, np.random.default_rng(seed)
    mujoco.mj_resetData(model, data)
    data.qpos[scene.hand.qpos_index] = generator.uniform(LOWER, UPPER)
    mujoco.mj_forward(model, data)
    palm = data.body("palm").xpos + generator.uniform(-0.06, 0.06, 3)
    free = int(model.joint("object_joint").qposadr[0])
    data.qpos[free : free + 3] = palm
    mujoco.mj_step(model, data)


def laid_onto_table(scene: Scene, depth: float) -> None:
    """Put the table at the hand's lowest point, ``depth`` [m] into it."""
    model, data = scene.hand.model, scene.hand.data
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    table = model.geom("table").id
    touching = (model.geom_contype | model.geom_conaffinity) != 0
    hand = model.body_rootid[model.geom_bodyid] == model.body("forearm").rootid[0]
    geoms = np.flatnonzero(touching & hand)
    fromto = np.empty(6)
    gaps = [
        mujoco.mj_geomDistance(model, data, geom, table, 10.0, fromto) for geom in geoms.tolist()
    ]
    model.geom_pos[table, 2] += min(gaps) + depth
    mujoco.mj_step(model, data)

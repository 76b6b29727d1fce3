"""A robot hand without the scene around it: files of benchmarks put one into a room with things."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import replace

import mujoco

from handsim.robot_hands.hand_frames import AttachedFrame, HandFrames
from handsim.robot_hands.reading.hand_file import HandFile
from handsim.silence import quiet_compile
from handsim.wording import number_of

_PLANE = mujoco.mjtGeom.mjGEOM_PLANE
_SITE, _BODY = mujoco.mjtObj.mjOBJ_SITE.value, mujoco.mjtObj.mjOBJ_BODY.value


def hand_alone(file: HandFile, frames: HandFrames) -> HandFile:
    """Return a file without what stands or lies beside the hand, and with a note of it.

    The hand is the tree of bodies that palm and fingertips are in. Where the palm is the world
    itself, only endless planes are left out.

    Parameters
    ----------
    file
        It is left as it is.
    frames
        Whose names need not be in the file.
    """
    model, spec = file.model, file.spec.copy()
    trees = {_tree_of(model, each) for each in (frames.palm, *frames.fingertips.values())}
    world, tree = spec.worldbody, trees.pop()
    if trees or not tree:
        beside = [geom for geom in world.geoms if geom.type == _PLANE]
    else:
        others = (body for body in world.bodies if body.name != tree)
        beside = [*others, *world.geoms, *world.sites]
    if not beside:
        return file
    what = number_of(len(beside), "thing beside the hand is", "things beside the hand are")
    said = f"{what} left out, the first '{beside[0].name}'"
    for part in (*beside, *world.lights, *world.cameras):
        spec.delete(part)
    return replace(file, spec=spec, model=quiet_compile(spec), notes=(*file.notes, said))


def _tree_of(model: mujoco.MjModel, frame: AttachedFrame) -> str:
    """Return the body that stands in the world and carries a frame; empty if it is the world."""
    site, body = (mujoco.mj_name2id(model, kind, frame.name) for kind in (_SITE, _BODY))
    at = model.site_bodyid[site] if site >= 0 else max(body, 0)
    root = int(model.body_rootid[at])
    return str(model.body(root).name) if root else ""

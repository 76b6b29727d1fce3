"""Gymnasium environments: grasps in contact physics that a policy commands, reading by reading.

``import handsim.environments`` registers ``handsim/Grasp-v0``; so does the name that says where it
is, ``gymnasium.make("handsim.environments:handsim/Grasp-v0")``. In: a task, a hand, a controller
and actions. Out: observations, rewards and the verdicts of `handsim grasp`. May import `grasping`
and `viewing`.
"""

from handsim.errors import MissingToolError

INSTALL = "pip install 'handsim[gym]'"
ID = "handsim/Grasp-v0"
"""Name of the environment at `gymnasium.make`."""

try:
    import gymnasium
except ImportError as error:
    raise MissingToolError(f"the environments need gymnasium; run: {INSTALL}") from error

if ID not in gymnasium.registry:
    gymnasium.register(
        ID,
        entry_point="handsim.environments.grasp_env:GraspEnv",
        vector_entry_point="handsim.environments.grasp_vector_env:GraspVectorEnv",
        disable_env_checker=True,  # it would look on at each step; `make(...)` can ask for it
    )

"""The solver settings and contact softness under which hand and objects were tried."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco

GRAVITY = 9.81
"""[m/s^2]"""
TIMESTEP = 0.002
"""[s]"""


CONTACT_SOLREF = (0.006, 1.0)
"""Time constant [s], three steps, and damping ratio of contacts."""


def set_physics(spec: mujoco.MjSpec) -> None:
    """Set the solver options under which the hand was tried; a scene needs them too."""
    spec.compiler.degree = False
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.iterations = 50
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.noslip_iterations = 2  # a pinched 100 g box creeps by 0.004, without 0.2 mm/s

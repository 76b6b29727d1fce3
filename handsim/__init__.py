"""handsim: human-like grasping learned from recordings, simulated in MuJoCo.

Recorded reach-to-grasp movements are reduced to a few principal components; there an obstacle
function is learned such that the navigation function built on it moves as the person did; its
gradient drives the 22 joints of a simulated hand.

Symbols
-------
==================  ============================================================================
``q``               posture, (22,) or (n, 22) [rad], in the order of `JOINT_NAMES`
``z``               the same in the subspace, (n_components,) [rad]
``q_goal, z_goal``  destination
``gamma_d``         attractive function, squared distance to the destination in its metric
``M``               metric of a destination, gamma_d = (z - z_goal)' M (z - z_goal); in the paper, I
``beta``            obstacle function, positive in free space
``chi``             ln(beta) / k where beta is learned through its logarithm
``phi``             navigation function gamma_d / (gamma_d^k + beta)^(1/k), Eq. (2) of the paper
``k``               its exponent, at least 2
``u``               velocity -grad phi, Eq. (1)
==================  ============================================================================

SI units and radians inside; degrees in CSV files and on the command line. Quaternions are
(w, x, y, z). The paper is I. F. Filippidis, K. J. Kyriakopoulos and P. K. Artemiadis, "Navigation
Functions Learning from Experiments: Application to Anthropomorphic Grasping".

Examples
--------
>>> import handsim
>>> recordings = handsim.read_recordings(handsim.data_folder("assets") / "experiments")
>>> controller = handsim.learn_controller(recordings).controller
>>> goal = controller.demonstration("cube-raise")
>>> controller.postures(goal.q_start, goal.q_goal).arrived
True
"""

import lazy_loader

# What is public stands in the stub beside this file; it is imported when it is asked for, since
# MuJoCo and scikit-learn take a second each.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

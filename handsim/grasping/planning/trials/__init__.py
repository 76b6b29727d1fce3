"""Brief runs of proposed grasps of own objects, by script and with a learned controller.

In: a task of raising an object by one grasp, and conditions. Out: what the runs cost. May import
the modules of `planning` and `grasping.rollout`.
"""

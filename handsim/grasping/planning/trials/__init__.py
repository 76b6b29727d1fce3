"""Grasps of own objects: laid out before the person, tried by script, planned for a controller.

In: an object that is in no table, and conditions. Out: the task of raising it by the grasp that was
chosen, and what grasps it so. May import the modules of `planning` and `grasping.rollout`.
"""

"""Grasps with robot hands: the learned movement, mapped to the actuators of a hand from a file.

Scene, run, plan and grasper; what is the same for a person's hand comes from the rooms beside it.
"""

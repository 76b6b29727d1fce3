"""How hard fingers press: the need of a grasp, and commands that hold with a force.

In: contacts, measured forces, where the hand is told to be. Out: the least force a side, joint
targets. May import `hand` and `joints`.
"""

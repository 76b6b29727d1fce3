"""How good a grasp is: protocols, the six-axis test, force closure, rates with their uncertainty.

In: rollouts. Out: verdicts and figures. May import `grasping.rollout` and `grasping.planning`.
"""

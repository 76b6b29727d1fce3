"""Many grasps: all combinations of tasks, controllers, hands and conditions, in one table.

In: a TOML file. Out: a CSV table that can be stopped and resumed, and rates. May import the other
rooms of `grasping`.
"""

"""One run in contact physics: glove, driver, squeeze, commands, sensing, and the record of it.

In: a compiled scene, a plan and a driver. Out: a `Rollout`. May import `grasping.plan` and
`grasping.conditions`, and nothing of planning.
"""

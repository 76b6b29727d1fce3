"""Runs in contact physics, one or several at once: glove, driver, squeeze, sensors and record.

In: a compiled scene, a plan and a driver. Out: a `Rollout`. May import `grasping.plan` and
`grasping.conditions`, and nothing of planning.
"""

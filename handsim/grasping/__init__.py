"""Grasps in contact physics, from plan to verdict.

`planning` finds where palm and fingers go, `rollout` runs it in MuJoCo, `judging` tests the grasp,
and `sweep` makes many of them into a table. In: a controller or the demonstrator, a task and
conditions. Out: a `Rollout` with its verdict. May import all rooms but `viewing`, `baseline` and
`cli`; of scikit-learn it sees nothing.
"""

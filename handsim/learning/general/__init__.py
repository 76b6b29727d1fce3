"""Navigation functions of paths of any kind: in 1 to 5 dimensions, in any unit.

In: paths. Out: a field that leads along them, proved for its destinations. May import `navigation`,
`learning.direction` and `learning.fit`.
"""

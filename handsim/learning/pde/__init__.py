"""The paper's learner: the obstacle as the solution of a semi-linear PDE, Eq. (8).

In: paths in the subspace, with times where velocities are to be measured. Out: a navigation
function. May import `navigation`, `learning.fit` and what it shares with `learning.direction`.
"""

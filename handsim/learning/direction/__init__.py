"""The direction learner: an obstacle, and a metric, that turn the flow along recorded paths.

In: paths in the subspace. Out: a navigation function, certified if asked. May import `navigation`
and `learning.fit`.
"""

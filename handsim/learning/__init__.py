"""From recordings to a controller.

In: a `RecordingSet`. Out: a `GraspController`, which holds the subspace and the navigation function
learned in it, and scores of how well it does what people did. May import `recordings` and
`navigation`; nothing of MuJoCo and of hands.
"""

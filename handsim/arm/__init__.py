"""The arm that carries the hand: sizes, joints, strength, the place of the elbow, the model.

In: the size of a hand (`HandSize`), from which the person's stature and arm follow, and poses of
the palm. Out: angles of arm and wrist, and a MuJoCo model. May import `hand` and the modules beside
the rooms. Only `mjcf`, `arm_file` and the model's parts import MuJoCo.
"""

"""A person chooses the posture on the controller's path, by any scalar signal.

In: a `GraspController`, whose demonstrations hold signals, and a signal over time: a distance to
the object, an envelope of muscle activity, a switch. Out: progress along the path from start to
destination, and the postures there. May import `learning` and `recordings`; nothing of MuJoCo and
of what is above.
"""

"""Other hands: postures of the human hand mapped to a robot hand.

In: an MJCF of the robot hand with the names of palm and fingertips, and postures. Out: joint
positions of the robot, and how well they match. May import `hand`.
"""

"""Movements over time: which part of a path is covered when, and velocities for a closed loop.

In: paths and durations. Out: progress over time, velocities at measured postures, posture
sequences. May import `navigation` and `learning.guide.curve`.
"""

"""Movements drawn frame by frame, and frames in files: videos, GIFs and contact sheets.

In: rollouts and posture sequences. Out: pictures as arrays, and ``.mp4``, ``.gif`` and ``.png``
files. May import `hand`, `grasping.rollout` and `viewing.opengl`.
"""

"""Movements as a LeRobot data set of codebase version v3.0.

In: episodes. Out: a folder with ``data/``, ``meta/`` and, where asked for, ``videos/``, which
`lerobot.datasets` reads as it is. Numbers are float32 there, as LeRobot has them. LeRobot itself is
not needed to write one.
"""

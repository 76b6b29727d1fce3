"""Proofs for one destination, or a small box of them, that see more than the descent condition.

In: a navigation function and destinations. Out: proved, or not decided. Part of `navigation`.
"""

"""The hand under its controller, pushed by whoever looks on: the loop answers and comes back.

In: a controller, and forces on fingers from a web page. Out: the simulated hand, and how far pushes
take it off its way. May import `hand`, `learning`, `grasping` and `viewing.film`.
"""

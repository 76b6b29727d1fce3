"""The subspace on the live page: a box with the ways of its controllers, and what moves in it.

In: controllers, recordings and the page's server. Out: where start, destination and hands are. May
import `learning`, `navigation`, `recordings` and `viewing.figures`.
"""

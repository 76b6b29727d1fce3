"""The counterparts of the paper's figures, as vector and pixel graphics.

In: a controller and the recordings that it was learned from. Out: matplotlib figures, written as
PNG and SVG. May import `recordings`, `navigation`, `learning` and `viewing.film`, which draws the
hand.
"""

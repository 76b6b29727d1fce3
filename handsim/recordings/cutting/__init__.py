"""Reaches found in continuous recordings: rest, reach, hold, return, over and over.

``motion`` is what moves, ``stops`` is where it stands still or turns, ``readings`` says which way
from stop to stop is a reach and how sure that is, ``events`` is where an object or another channel
moves, ``cut`` makes recordings of it, ``times`` reads times given by hand.
"""

"""The human hand as a body: sizes, skeleton, strength, postures, and its MuJoCo model.

In: hand length, breadth and side (`HandSize`). Out: a model of 22 hinges and 22 actuators. May
import nothing but the modules beside the rooms; it knows neither objects nor learning.
"""

"""Transport: how the palm gets to what is grasped, and the hand opens meanwhile.

In: recorded paths of the palm. Out: a navigation function in space whose flow moves the palm as the
person did, real obstacles in the same beta, and time laws of palm and hand that fit each other. May
import `navigation`, `learning.direction` and `learning.movement`; knows neither arms nor MuJoCo.
"""

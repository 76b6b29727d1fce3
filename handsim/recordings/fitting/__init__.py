"""From points seen on a hand to its size, its pose and its 22 joint angles.

In: points over time, (n, m, 3) [m], NaN where one is not seen, and which part of the hand each is
fixed to. Out: size of the hand, pose of the palm, angles in rad, and what is left over. Imports the
sizes, skeleton and kinematics of `hand`, in which there is no MuJoCo, and nothing else of it.
"""

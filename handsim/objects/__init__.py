"""Things that are grasped: the 13 objects of the paper's Table I, and users' own meshes.

In: a name, or a mesh file. Out: a `GraspObject` with masses, convex contact pieces and hinges, its
MuJoCo body, and proposals of where to take hold of it. May import nothing but the modules beside
the rooms.
"""

"""Mesh files: users' read, mended where that is safe, measured and set down; ours as they are.

In: a file, and what its user says of it. Out: closed bodies in metres, what was done to them, and
how they rest on a table. May import nothing but `objects.object` and the modules beside the rooms.
"""

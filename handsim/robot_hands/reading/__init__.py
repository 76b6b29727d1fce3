"""Files of robot hands read into memory, from the user's folders alone, and mended with notes.

In: an MJCF or URDF with its meshes. Out: a spec that compiles. MuJoCo opens no file itself.
"""

"""The choice of an OpenGL backend that renders on this machine, with or without a display.

In: the environment variable ``MUJOCO_GL`` and what is installed. Out: an open OpenGL context, or an
error that says what to install. May import nothing but the modules beside the rooms.
"""

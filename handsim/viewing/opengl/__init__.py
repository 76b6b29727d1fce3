"""The choice of an OpenGL backend that renders on this machine, with or without a display."""

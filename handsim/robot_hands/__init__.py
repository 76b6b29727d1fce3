"""Robot hands as users bring them: files read and mended, frames proposed, shown and corrected.

In: an MJCF or URDF with its meshes, and perhaps a TOML that names palm and fingertips. Out: a spec
that compiles, with its own link names, and where palm and fingertips are. May import `hand`.
"""

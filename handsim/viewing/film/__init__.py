"""Movements into frames, frames into video files, GIFs and contact sheets."""

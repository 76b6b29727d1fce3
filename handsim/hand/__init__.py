"""The body and the world: hand, objects, tasks, scenes."""

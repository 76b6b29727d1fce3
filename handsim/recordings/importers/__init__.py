"""Files of other layouts, one module a layout.

In: the files as they were published. Out: a `RecordingSet` cut to the reach-to-grasp phase.
"""

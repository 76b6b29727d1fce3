"""What people did: recordings of hand postures.

In: a folder of CSV files, or files of other layouts (`recordings.importers`). Out: a `RecordingSet`
of postures over time in the order of the 22 joints, in rad. May import the modules beside the rooms
(joints, types, files, errors) and, in `recordings.fitting` and `recordings.points`, the sizes,
skeleton and kinematics of the hand, which are free of MuJoCo.
"""

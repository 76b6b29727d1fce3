"""What people did: recordings of hand postures.

In: a folder of CSV files, or files of other layouts (`recordings.importers`). Out: a `RecordingSet`
of postures over time in the order of the 22 joints, in rad. May import nothing but the modules
beside the rooms (joints, types, files, errors); nothing of MuJoCo.
"""

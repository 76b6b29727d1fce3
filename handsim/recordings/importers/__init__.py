"""Files of other layouts, one module a layout.

In: files as they were recorded or published, and `ImportOptions`. Out: a `RecordingSet`; cutting is
`recordings.cutting`, but for West and Hogan's trials, which hold one reach each.
"""

"""What people look at: videos, pictures, figures, reports, live views, and the check of a machine.

In: rollouts, posture sequences, controllers and recordings. Out: files, pages and windows. May
import all rooms but `baseline` and `cli`.
"""

"""What people look at: video, pictures, figures, reports, and live views.

In: rollouts, posture sequences and controllers. Out: files and pages. May import all rooms but
`baseline` and `cli`.
"""

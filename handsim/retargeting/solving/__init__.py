"""The fit of a whole movement: what it leaves over, its steps, self-contact, and where it starts.

In: targets of all postures and a robot hand. Out: coordinates of all postures. Joints and commands
are made of them in the room above.
"""

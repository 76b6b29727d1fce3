"""What is done with objects: the 24 tasks of Table I, their scenes, and the rules of success.

In: a task and conditions. Out: a scene of table, object and hand, and a verdict on the traces of a
run. May import `hand` and `objects`.
"""

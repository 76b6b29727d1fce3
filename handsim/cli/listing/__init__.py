"""Lists of what there is (this machine's parts, tasks, objects, hands) and of how grasps went.

In: nothing. Out: tables, or JSON. They import no more than the data that they show, so that they
answer at once.
"""

"""Commands that list what there is: this machine's parts, tasks, objects and hands.

In: nothing. Out: tables, or JSON. They import no more than the data that they show, so that they
answer at once.
"""

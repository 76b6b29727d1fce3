"""`handsim recordings`: other people's files in, reaches cut out of them, a summary out.

In: arguments of the command line. Out: folders of recordings, pictures, tables and JSON. May import
whatever the command line may.
"""

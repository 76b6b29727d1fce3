"""`handsim export`: movements handed on to what people use.

In: files and folders of movements. Out: files and folders of other formats, a table or JSON. May
import whatever the command line may.
"""

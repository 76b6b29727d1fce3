"""Guides: a path predicted for each query, and a navigation function that leads along it.

In: what a controller keeps of its recordings, and a start, a destination and an object. Out: the
path and the timing that the person would likely have chosen, and a field that is proven to arrive,
with progress as a further coordinate where that pays. May import `navigation`.
"""

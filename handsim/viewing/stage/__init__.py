"""From where a movement is seen, and what stands and shines around it.

In: models and movements. Out: cameras, their ways, furniture and lights. May import `arm`.
"""

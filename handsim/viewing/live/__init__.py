"""Views that move while one looks at them: a web page, and MuJoCo's own window.

In: a controller and the plans of its grasps. Out: a page served to a browser, or a window on the
display. May import `hand`, `learning`, `tasks`, `grasping` and `viewing.film`.
"""

"""Views that move while one looks: a web page, and MuJoCo's own window."""

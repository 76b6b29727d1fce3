"""Numbers of things in messages: one recording, two recordings."""


def number_of(n: int, thing: str, things: str = "") -> str:
    """Return a number and what it is of, in the singular where there is one.

    Parameters
    ----------
    n
        How many there are.
    thing
        What one of them is called.
    things
        What several are called, where that is not the same with an s.
    """
    return f"{n} {thing if n == 1 else things or thing + 's'}"

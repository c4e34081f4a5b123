"""Numbers in messages."""


def counted(number: int, one: str, many: str = "") -> str:
    """A number with what it counts, in the plural where it is not 1.

    >>> counted(1, "point"), counted(1200, "point"), counted(0, "vertex"), counted(2, "edge has", "edges have")
    ('1 point', '1,200 points', '0 vertices', '2 edges have')
    """
    regular = f"{one.removesuffix('ex')}ices" if one.endswith("vertex") else f"{one}s"
    return f"{number:,} {one if number == 1 else many or regular}"

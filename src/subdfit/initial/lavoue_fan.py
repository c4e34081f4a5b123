"""Faces round a vertex inside a ring."""

from itertools import pairwise

Ring = list[int]


def fan(loop: Ring, centre: int, needed: set[int] | None = None) -> list[Ring]:
    """Faces round a vertex inside a ring: quads where the centre keeps three spokes, else triangles.

    Parameters
    ----------
    loop : vertices round the centre, counter-clockwise.
    centre : the vertex.
    needed : vertices of the ring that get a spoke in any case; between them every other one does.
    """
    n = len(loop)
    stops = [i for i, v in enumerate(loop) if v in (needed or set())] or [0]
    spokes = [i for a, b in pairwise([*stops, stops[0] + n]) for i in range(a, b, 2)]
    if len(spokes) < 3:
        spokes = list(range(n))
    turned = [*loop, *loop, *loop]
    return [[centre, *turned[a : b + 1]] for a, b in pairwise([*spokes, spokes[0] + n])]


def ring_sides(ring: Ring) -> list[tuple[int, int]]:
    """The sides of a ring, in its direction."""
    return list(zip(ring, [*ring[1:], ring[0]], strict=True))

"""Half-edges and rings of an oriented triangle mesh in flat arrays.

Half-edge ``h = 3 * face + slot`` runs from ``origin[h]`` to the origin of the next slot; ``twin[h]`` is the
half-edge running back, -1 on the boundary; ``sharp[h]`` is the sharpness of its edge, the same on both sides.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np

from subdfit.compiled import inlined_kernel, inner_kernel, kernel


@inlined_kernel
def following(h):
    """Next half-edge of the same triangle."""
    return h - 2 if h % 3 == 2 else h + 1


@inlined_kernel
def preceding(h):
    """Previous half-edge of the same triangle."""
    return h + 2 if h % 3 == 0 else h - 1


@kernel
def rings(origin, twin, sides, out, degree):
    """Fill `degree` (edges of each vertex) and `out` (a half-edge leaving it, on the boundary if one is)."""
    out[:] = -1
    degree[:] = 0
    for h in range(sides):
        v = origin[h]
        degree[v] += 1
        if twin[h] < 0:
            degree[origin[following(h)]] += 1
            out[v] = h
        elif out[v] < 0:
            out[v] = h


@kernel
def torn_vertex(origin, twin, out, degree, vertices):
    """First vertex whose triangles are not one fan, or -1."""
    for v in range(vertices):
        if out[v] < 0:
            continue
        first = np.int64(out[v])
        h = first
        seen = 1 if twin[first] < 0 else 0
        while True:
            seen += 1
            h = np.int64(twin[preceding(h)])
            if h < 0 or h == first:
                break
        if seen != degree[v]:
            return v
    return -1


@inner_kernel
def side_between(origin, twin, out, v, w):
    """Half-edge v to w, or w to v where only that exists; -1 when the vertices share no edge."""
    first = np.int64(out[v])
    h = first
    while h >= 0:
        if origin[following(h)] == w:
            return h
        last = preceding(h)
        h = np.int64(twin[last])
        if h < 0 and origin[last] == w:
            return last
        if h == first:
            break
    return np.int64(-1)


@inner_kernel
def hard(twin, sharp, h):
    """Whether an edge is part of a curve that must stay: boundary or crease."""
    return twin[h] < 0 or sharp[h] > 0.0


# Splits: the marked sides are bisected, each face follows by the number of its marked sides.

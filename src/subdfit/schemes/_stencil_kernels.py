"""Refinement without a matrix: new positions from vertices, their neighbours and the centroids of faces."""

import numpy as np

from subdfit.compiled import kernel


@kernel
def refined_points(  # type: ignore[no-untyped-def]
    face_offsets, face_vertices, following, twin, edge, sharpness, weights, ends, side, face_points, points
):
    """Apply the rules of `subdfit.schemes._stencils.Stencils` to points (n, 3).

    Returns
    -------
    ndarray
        (n + e, 3) or, with `face_points`, (n + e + f, 3): vertices, middles of edges, centroids of faces.
    """
    n, e, f = len(points), len(sharpness), len(face_offsets) - 1
    out = np.zeros((n + e + (f if face_points else 0), 3))
    for v in range(n):
        for d in range(3):
            out[v, d] = weights[v, 0] * points[v, d]
    for face in range(f):
        begin, end = face_offsets[face], face_offsets[face + 1]
        x = y = z = 0.0
        for h in range(begin, end):
            v = face_vertices[h]
            x, y, z = x + points[v, 0], y + points[v, 1], z + points[v, 2]
        share = 1.0 / (end - begin)
        x, y, z = x * share, y * share, z * share
        if face_points:
            out[n + e + face, 0], out[n + e + face, 1], out[n + e + face, 2] = x, y, z
        for h in range(begin, end):
            v, w = face_vertices[h], face_vertices[following[h]]
            s = sharpness[edge[h]]
            along = weights[v, 1]
            if s > 0.0:
                along += weights[v, 3]
            if s > 1.0:
                along += weights[v, 4]
            inner = weights[v, 2]
            out[v, 0] += along * points[w, 0] + inner * x
            out[v, 1] += along * points[w, 1] + inner * y
            out[v, 2] += along * points[w, 2] + inner * z
            if twin[h] < 0:
                back = weights[w, 3] + weights[w, 4]
                for d in range(3):
                    out[w, d] += back * points[v, d]
            crease = min(s, 1.0)
            smooth = 1.0 - crease
            at = n + edge[h]
            out[at, 0] += smooth * side * x
            out[at, 1] += smooth * side * y
            out[at, 2] += smooth * side * z
            if twin[h] < h:
                share = smooth * ends + crease * 0.5
                for d in range(3):
                    out[at, d] += share * (points[v, d] + points[w, d])
    return out

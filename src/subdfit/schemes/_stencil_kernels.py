"""Refinement without a matrix, and rows of vertex masks: vertices, their neighbours and the centroids of faces."""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel


@inlined_kernel
def along(weights, v, sharpness):  # type: ignore[no-untyped-def]
    """Weight that v gives to its neighbour along an edge."""
    total = weights[v, 1]
    if sharpness > 0.0:
        total += weights[v, 3]
    if sharpness > 1.0:
        total += weights[v, 4]
    return total


@kernel
def refined_points(  # type: ignore[no-untyped-def]
    face_offsets,
    face_vertices,
    following,
    twin,
    edge,
    sharpness,
    weights,
    has_centroid,
    sides,
    vertices_only,
    points,
    out,
):
    """Apply the rules of `subdfit.schemes._stencils.Stencils` to points (n, 3).

    `out`, which comes as zeros, gets the vertices (n, 3); unless these are all, middles of edges too, and the centroids
    of the c faces that have one, (n + e + c, 3).
    """
    n, e, f = len(points), len(sharpness), len(face_offsets) - 1
    row = n + e
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
        counts = 1.0 if has_centroid[face] else 0.0
        if has_centroid[face] and not vertices_only:
            out[row, 0], out[row, 1], out[row, 2] = x, y, z
            row += 1
        kind = 0 if end - begin == 3 else 1
        ends, side = sides[kind, 0], sides[kind, 1]
        for h in range(begin, end):
            v, w = face_vertices[h], face_vertices[following[h]]
            s = sharpness[edge[h]]
            near, inner = along(weights, v, s), counts * weights[v, 2]
            out[v, 0] += near * points[w, 0] + inner * x
            out[v, 1] += near * points[w, 1] + inner * y
            out[v, 2] += near * points[w, 2] + inner * z
            if twin[h] < 0:
                back = weights[w, 3] + weights[w, 4]
                for d in range(3):
                    out[w, d] += back * points[v, d]
            if vertices_only:
                continue
            crease = min(s, 1.0)
            smooth = 1.0 - crease
            at = n + edge[h]
            out[at, 0] += smooth * side * x
            out[at, 1] += smooth * side * y
            out[at, 2] += smooth * side * z
            share = smooth * ends + (crease * 0.5 if twin[h] < h else 0.0)
            for d in range(3):
                out[at, d] += share * (points[v, d] + points[w, d])


@inlined_kernel
def add_entry(columns, values, begin, end, column, value):  # type: ignore[no-untyped-def]
    """Add to a row that lies at ``begin`` to ``end``, its columns ascending; return its new end."""
    at = end
    while at > begin and columns[at - 1] >= column:
        at -= 1
    if at < end and columns[at] == column:
        values[at] += value
        return end
    for k in range(end, at, -1):
        columns[k], values[k] = columns[k - 1], values[k - 1]
    columns[at], values[at] = column, value
    return end + 1


@kernel
def mask_rows(face_offsets, face_vertices, edge_vertices, sharpness, weights, has_centroid):  # type: ignore[no-untyped-def]
    """Write the rows of vertex masks in CSR form, columns ascending, without zeros but on the diagonal.

    The columns of `weights` (n, 5) are those of `subdfit.schemes._stencils.Stencils.weights`.

    Returns
    -------
    offsets (n + 1,), columns : int32; values.
    """
    n, faces = len(weights), len(face_offsets) - 1
    room = np.ones(n + 1, np.int64)
    for e in range(len(sharpness)):
        for side in range(2):
            v = edge_vertices[e, side]
            if along(weights, v, sharpness[e]) != 0.0:
                room[v] += 1
    for f in range(faces):
        for h in range(face_offsets[f], face_offsets[f + 1]):
            if has_centroid[f] and weights[face_vertices[h], 2] != 0.0:
                room[face_vertices[h]] += face_offsets[f + 1] - face_offsets[f] - 1
    total = 0
    for v in range(n + 1):
        room[v], total = total, total + room[v]
    columns = np.empty(room[n], np.int32)
    values = np.empty(room[n])
    ends = room[:n].copy()
    for v in range(n):
        ends[v] = add_entry(columns, values, room[v], ends[v], v, weights[v, 0])
    for e in range(len(sharpness)):
        for side in range(2):
            v = edge_vertices[e, side]
            weight = along(weights, v, sharpness[e])
            if weight != 0.0:
                ends[v] = add_entry(columns, values, room[v], ends[v], np.int64(edge_vertices[e, 1 - side]), weight)
    for f in range(faces):
        begin, stop = face_offsets[f], face_offsets[f + 1]
        for h in range(begin, stop):
            v = face_vertices[h]
            if has_centroid[f] and weights[v, 2] != 0.0:
                share = weights[v, 2] / (stop - begin)
                for g in range(begin, stop):
                    ends[v] = add_entry(columns, values, room[v], ends[v], np.int64(face_vertices[g]), share)
    offsets = np.zeros(n + 1, np.int32)
    for v in range(n):
        begin, at = room[v], offsets[v]
        offsets[v + 1] = at + ends[v] - begin
        for k in range(ends[v] - begin):
            columns[at + k], values[at + k] = columns[begin + k], values[begin + k]
    return offsets, columns[: offsets[n]].copy(), values[: offsets[n]].copy()

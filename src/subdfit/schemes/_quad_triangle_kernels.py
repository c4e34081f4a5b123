"""Rings of vertices among triangles and quads, with mirror points."""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel


@inlined_kernel
def mirror(out, row, a, b, c):  # type: ignore[no-untyped-def]
    """Write the point a + b - c, the same way whichever of a and b comes first."""
    out[row, 0], out[row, 1], out[row, 2] = min(a, b), max(a, b), c


@kernel
def rings(  # type: ignore[no-untyped-def]
    half_edges,
    begin,
    sizes,
    total,
    face_offsets,
    face_vertices,
    following,
    preceding,
    face,
    twin,
    sharp_count,
    first,
    faces,
    position,
    regular,
):
    """Write the ring round the origin of each half-edge, counter-clockwise: neighbours, and far corners of quads.

    A ring begins with the end of the half-edge, or where the sector begins if sharp edges bound it. Regular corners
    have the whole ring all the same: beyond sharp edges stand mirror points, with which the smooth rules reproduce
    those of boundaries and creases.

    Parameters
    ----------
    half_edges, begin, sizes : (k,); begin is where each ring begins in the result, which has `total` rows.
    The others are arrays of a topology and its `Level`.

    Returns
    -------
    ndarray
        (total, 3) int32: vertices a, b, c for the point a + b - c; b and c are -1 for the vertex a.
    """
    out = np.full((total, 3), -1, np.int32)
    for k in range(len(half_edges)):
        h = half_edges[k]
        v = face_vertices[h]
        open_sector = sharp_count[v] > 1
        start = h if sharp_count[v] == 0 else first[h]
        at, size, turn = begin[k], sizes[k], 0
        quad = face_offsets[face[h] + 1] - face_offsets[face[h]] == 4
        if open_sector and regular[h]:
            turn = size - position[h] * (2 if quad else 1)
        g, last, i = start, start, 0
        for _ in range(faces[h]):
            end = following[g]
            out[at + (i + turn) % size, 0] = face_vertices[end]
            i += 1
            last = preceding[g]
            if following[end] != last:
                out[at + (i + turn) % size, 0] = face_vertices[following[end]]
                i += 1
            g = twin[last]
        if not open_sector:
            continue
        out[at + (i + turn) % size, 0] = face_vertices[last]
        if not regular[h]:
            continue
        near, far = face_vertices[following[start]], face_vertices[last]
        if quad:
            across = face_vertices[preceding[start]]
            beside_near = face_vertices[following[following[start]]]
            beside_far = face_vertices[preceding[last]]
            mirror(out, at + (i + 1 + turn) % size, far, far, beside_far)
            mirror(out, at + (i + 2 + turn) % size, v, v, across)
            mirror(out, at + (i + 3 + turn) % size, near, near, beside_near)
        else:
            mirror(out, at + (i + 1 + turn) % size, v, far, face_vertices[preceding[last]])
            mirror(out, at + (i + 2 + turn) % size, v, near, face_vertices[preceding[start]])
    return out


@kernel
def larger_round(face_offsets, face_vertices, vertex_count, corners):  # type: ignore[no-untyped-def]
    """Count the faces round each vertex that have more corners than `corners`; int32 (n,)."""
    count = np.zeros(vertex_count, np.int32)
    for f in range(len(face_offsets) - 1):
        if face_offsets[f + 1] - face_offsets[f] > corners:
            for h in range(face_offsets[f], face_offsets[f + 1]):
                count[face_vertices[h]] += 1
    return count
